//! Plots as SVG: for a page, whose style sheet gives the names of colours other values in the dark, and several
//! of them as one picture ([`sheet`]).

mod axis;
mod sheet;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

pub use axis::Axis;
pub use sheet::sheet;

/// Width and height, about those on a phone, so that text is as large there as it is here.
const SIZE: (u32, u32) = (360, 270);

/// Around a plot. At the top and on the right half of the label at the end of an axis stands beyond it.
const MARGIN: u32 = 4;
const TOP: u32 = 10;
const RIGHT: u32 = 16;

/// Left of a plot and below it, for numbers and the names of axes.
const LABELS: [u32; 2] = [66, 46];

/// Room for the names of the axes, whose middles are those of the axes: they may go on beyond these up to the edges of the
/// plot, but for a little.
const NAME_ROOM: [u32; 2] = [
    SIZE.0 - LABELS[0] - MARGIN + RIGHT - 8,
    SIZE.1 - LABELS[1] - MARGIN + TOP - 8,
];

/// The size of the names of axes, and that of the numbers there.
const NAME_SIZE: f64 = 17.0;
const NUMBER_SIZE: f64 = 16.0;

/// Width of a character, on average, over the size of a text: plotters writes four fifths of it, and in wide fonts
/// characters take 0.55 of that.
const CHARACTER: f64 = 0.55 / 1.24;

/// Names of the series' colours: the style sheet turns them into colours that suit the page.
const SERIES: [RGBColor; 7] = [
    name(1),
    name(2),
    name(3),
    name(4),
    name(7),
    name(8),
    name(9),
];
/// How the series' lines are dashed (SVG's `stroke-dasharray`), so that an earlier line is seen through the gaps of one that
/// lies on it; none of the first.
const DASHES: [&[u32]; SERIES.len()] = [
    &[],
    &[9, 4],
    &[4, 4],
    &[14, 5],
    &[7, 3, 2, 3],
    &[2, 3],
    &[18, 6],
];
const INK: RGBColor = name(5);
const GRID: RGBColor = name(6);

/// The most numbers below a plot.
const X_LABELS: usize = 4;

/// Lines of more points have no marks at them.
const MARKED_MAX: usize = 40;

const fn name(k: u8) -> RGBColor {
    RGBColor(k, k, k)
}

/// The names above as CSS: attribute, value and the variable that replaces it.
pub fn style() -> String {
    let series = (1..).zip(SERIES);
    let series = series.map(|(k, colour)| (format!("series-{k}"), colour));
    let others = [("ink", INK), ("grid", GRID)].map(|(name, colour)| (name.to_string(), colour));
    let rule = |(name, colour): (String, RGBColor)| {
        let hex = hex(colour);
        format!(
            "svg [fill=\"{hex}\"]{{fill:var(--{name})}}svg [stroke=\"{hex}\"]{{stroke:var(--{name})}}\n"
        )
    };
    series.chain(others).map(rule).collect()
}

/// As SVG writes it.
fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Text with what HTML and SVG read as their own escaped.
pub(crate) fn escaped(text: &str) -> String {
    [
        ('&', "&amp;"),
        ('<', "&lt;"),
        ('>', "&gt;"),
        ('"', "&quot;"),
    ]
    .into_iter()
    .fold(text.to_string(), |text, (c, name)| text.replace(c, name))
}

/// Of a line, in order.
type Points = Vec<(f64, f64)>;

/// One line of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// For the legend.
    pub name: String,
    /// In order.
    pub points: Points,
}

/// Lines over one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// Below it.
    pub x: Axis,
    /// Left of it.
    pub y: Axis,
    /// One colour each.
    pub lines: Vec<Line>,
    /// What is to be seen besides.
    pub mark: Option<Mark>,
}

/// A shaded stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// For the legend.
    pub name: String,
    /// From and to, on the axis x.
    pub ends: [f64; 2],
}

impl Plot {
    /// Lines over one pair of axes.
    pub fn new(title: &str, x: &Axis, y: &Axis, lines: Vec<Line>) -> Self {
        Self {
            title: title.to_string(),
            x: x.clone(),
            y: y.clone(),
            lines,
            mark: None,
        }
    }

    /// The lines' names with the numbers of their colours (`--series-1` …); none of a single line.
    pub fn keys(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = if self.lines.len() > 1 {
            &self.lines[..]
        } else {
            &[]
        };
        let names = lines.iter().map(|line| line.name.as_str());
        (0..).map(|k| k % SERIES.len() + 1).zip(names)
    }

    /// The plot as an SVG element; `None` where there is nothing to show: fewer than two points in all.
    pub fn svg(&self) -> Option<String> {
        let finite = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let all = || self.lines.iter().flat_map(|l| &l.points).filter(finite);
        let x_is_log = self.x.counts_in_powers(all().map(|p| p.0));
        let y_is_log = self.y.counts_in_powers(all().map(|p| p.1));
        // Zero has no place among powers of ten: the axis says so.
        let has_place = |p: &&(f64, f64)| (!x_is_log || p.0 > 0.0) && (!y_is_log || p.1 > 0.0);
        let names = [
            self.x.name(x_is_log && all().any(|p| p.0 <= 0.0)),
            self.y.name(y_is_log && all().any(|p| p.1 <= 0.0)),
        ];
        let lines = self.lines.iter().map(|line| {
            let shown = line.points.iter().filter(finite).filter(has_place);
            shown.copied().collect()
        });
        let lines: Vec<Points> = lines.collect();
        let shown = || lines.iter().flatten();
        if shown().count() < 2 {
            return None;
        }
        let x = self.x.range(shown().map(|p| p.0), x_is_log);
        let y = self.y.range(shown().map(|p| p.1), y_is_log);
        let mark = self.mark.as_ref().map(|mark| {
            let ends = mark.ends.map(|end| end.clamp(x.start, x.end));
            (ends, [y.start, y.end])
        });
        let names = [(&names[0], Digits::of(&x)), (&names[1], Digits::of(&y))];
        let powers = |x: std::ops::Range<f64>| {
            let marks = self.x.powers(&x, X_LABELS);
            x.log_scale().with_key_points(marks)
        };
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let drawn = match (x_is_log, y_is_log) {
            (false, false) => draw(&area, x, y, &names, &lines, mark),
            (true, false) => draw(&area, powers(x), y, &names, &lines, mark),
            (false, true) => draw(&area, x, y.log_scale(), &names, &lines, mark),
            (true, true) => draw(&area, powers(x), y.log_scale(), &names, &lines, mark),
        };
        // Writing to a string does not fail.
        drawn.ok()?;
        drop(area);
        // The upper half of a number at an axis' end may stand above the plot.
        let text = text.replacen("<svg ", "<svg overflow=\"visible\" ", 1);
        Some(dashed(text))
    }
}

/// Lines with the dashes of their series.
fn dashed(mut svg: String) -> String {
    for (colour, dashes) in SERIES.iter().zip(DASHES) {
        if !dashes.is_empty() {
            let stroke = format!(
                "<polyline fill=\"none\" opacity=\"1\" stroke=\"{}\"",
                hex(*colour)
            );
            svg = svg.replace(&stroke, &format!("{stroke}{}", dash_attribute(dashes)));
        }
    }
    svg
}

/// As SVG writes it; nothing of an undashed line.
fn dash_attribute(dashes: &[u32]) -> String {
    match dashes {
        [] => String::new(),
        dashes => {
            let lengths: Vec<String> = dashes.iter().map(u32::to_string).collect();
            format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
        }
    }
}

/// The same as a CSS background of a line's key; `series` counts from 1.
pub(crate) fn key_background(series: usize) -> String {
    let colour = format!("var(--series-{series})");
    let mut at = 0;
    let mut stops = Vec::new();
    for (k, length) in DASHES[series - 1].iter().enumerate() {
        let shown = if k % 2 == 0 { &colour } else { "transparent" };
        stops.push(format!("{shown} {at}px {}px", at + length));
        at += length;
    }
    match stops.is_empty() {
        true => colour,
        false => format!("repeating-linear-gradient(90deg,{})", stops.join(",")),
    }
}

/// The size of the name of an axis that has so much room.
fn name_size(name: &str, room: u32) -> f64 {
    let widest = name.chars().count() as f64 * CHARACTER;
    NAME_SIZE.min(f64::from(room) / widest.max(1.0))
}

fn draw<'a, X, Y>(
    area: &DrawingArea<SVGBackend<'a>, Shift>,
    x: X,
    y: Y,
    &[(x_name, x_digits), (y_name, y_digits)]: &[(&String, Digits); 2],
    lines: &[Points],
    mark: Option<([f64; 2], [f64; 2])>,
) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let font = |size: f64| ("sans-serif", size).into_font().color(&INK);
    let mut chart = ChartBuilder::on(area)
        .margin(MARGIN)
        .margin_top(TOP)
        .margin_right(RIGHT)
        .x_label_area_size(LABELS[1])
        .y_label_area_size(LABELS[0])
        .build_cartesian_2d(x, y)?;
    // One size for both: that of the longer name.
    let name = name_size(x_name, NAME_ROOM[0]).min(name_size(y_name, NAME_ROOM[1]));
    chart
        .configure_mesh()
        .x_desc(x_name.as_str())
        .y_desc(y_name.as_str())
        .x_labels(X_LABELS)
        .y_labels(5)
        .max_light_lines(0)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(font(NUMBER_SIZE))
        .axis_desc_style(font(name))
        .x_label_formatter(&|x| x_digits.short(*x))
        .y_label_formatter(&|y| y_digits.short(*y))
        .draw()?;
    if let Some(([from, to], [low, high])) = mark {
        let stretch = Rectangle::new([(from, low), (to, high)], GRID.filled());
        chart.draw_series([stretch])?;
    }
    for (line, colour) in lines.iter().zip(SERIES.iter().cycle()) {
        let style = colour.stroke_width(2);
        let points = if line.len() > MARKED_MAX { 0 } else { 3 };
        let series = LineSeries::new(line.iter().copied(), style).point_size(points);
        chart.draw_series(series)?;
    }
    area.present()
}

/// How the marks of an axis are written: all of them in one way.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Digits {
    /// In full.
    Plain,
    /// From a thousand on, and up to a thousandth, as powers of ten: marks in full would be too wide.
    Powers,
}

impl Digits {
    /// Of an axis from the start to the end of a range.
    fn of(range: &std::ops::Range<f64>) -> Self {
        let size = |x: f64| x.abs();
        let has_small = range.start > 0.0 && range.start < 1e-3;
        if has_small || size(range.start).max(size(range.end)) >= 1e5 {
            Self::Powers
        } else {
            Self::Plain
        }
    }

    /// A number with few digits, for marks on axes.
    fn short(self, x: f64) -> String {
        let size = x.abs();
        let in_full = match self {
            Self::Plain => 1e-3..1e5,
            Self::Powers => 2e-3..1e3,
        };
        if x == 0.0 {
            "0".to_string()
        } else if in_full.contains(&size) {
            let text = format!("{x:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            format!("{x:.0e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Digits, Line, Plot, key_background, style};

    #[test]
    fn what_cannot_be_shown_is_left_out_and_nothing_is_drawn_of_nothing() {
        let plot = |points: &[(f64, f64)]| Plot {
            mark: None,
            title: String::new(),
            x: Axis::log("x"),
            y: Axis::linear("y"),
            lines: vec![Line {
                name: "a".to_string(),
                points: points.to_vec(),
            }],
        };
        assert_eq!(plot(&[]).svg(), None);
        assert_eq!(plot(&[(0.0, 1.0), (1.0, f64::NAN)]).svg(), None);
        assert_eq!(plot(&[(1.0, 1.0)]).keys().count(), 0);
        let text = plot(&[(1.0, 1.0), (10.0, 2.0)]).svg().expect("a plot");
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        // Every colour is one that the style sheet knows.
        for part in text
            .split("fill=\"#")
            .chain(text.split("stroke=\"#"))
            .skip(1)
        {
            let hex: String = part.chars().take(6).collect();
            if hex.chars().all(|c| c.is_ascii_hexdigit()) {
                assert!(style().contains(&hex), "{hex} in {part:.60}");
            }
        }
    }

    /// Among powers of ten zero has no place, which the axis says; even axes show it.
    #[test]
    fn zero_is_shown_or_said_to_be_left_out() {
        let text = |points: &[(f64, f64)]| {
            let plot = Plot {
                mark: None,
                title: String::new(),
                x: Axis::linear("level"),
                y: Axis::log("error"),
                lines: vec![Line {
                    name: "a".to_string(),
                    points: points.to_vec(),
                }],
            };
            plot.svg().expect("a plot")
        };
        let marks = |text: &str| text.matches("<circle").count();
        let log = text(&[(0.0, 1.0), (1.0, 0.01), (2.0, 0.0)]);
        assert!(log.contains("error (0 not shown)"), "{log}");
        let even = text(&[(0.0, 1.0), (1.0, 0.5), (2.0, 0.0)]);
        assert!(!even.contains("not shown"), "{even}");
        assert_eq!((marks(&log), marks(&even)), (2, 3));
    }

    /// The longest names that there are, and longer ones: each is within the picture.
    #[test]
    fn names_of_axes_fit_beside_the_plot() {
        for (x, y) in [
            ("level", "µs"),
            ("touching pairs of triangles", "over what is touched"),
            ("level at which a ball stops", "deform + refit over bdtree"),
        ] {
            let points: Vec<_> = (0..3).map(|k| (f64::from(k), 1e3 * f64::from(k))).collect();
            let line = |name: &str, more: &[(f64, f64)]| Line {
                name: name.to_string(),
                points: [&points[..], more].concat(),
            };
            let lines = vec![line("a", &[(1e4, 1e-3)])];
            let svg = Plot::new("", &Axis::log(x), &Axis::log(y), lines)
                .svg()
                .expect("a plot");
            for (name, room) in [(x, 306.0), (y, 230.0)] {
                let name = format!("{name} (0 not shown)");
                let before = svg.split(&name).next().expect("a beginning");
                let size = before
                    .rsplit("font-size=\"")
                    .next()
                    .and_then(|s| s.split('"').next());
                let size: f64 = size.expect("a size").parse().expect("a number");
                assert!(
                    0.55 * size * name.chars().count() as f64 <= room,
                    "{name}: {size}"
                );
                assert!((10.0..14.0).contains(&size), "{name}: {size}");
            }
        }
    }

    /// A line that lies on another leaves some of it to be seen.
    #[test]
    fn all_lines_but_the_first_have_gaps_of_their_own() {
        let points = [(0.0, 1.0), (1.0, 2.0)];
        let names = ["a", "b", "c", "d", "e", "f", "g"];
        let lines = names.map(|name| Line {
            name: name.to_string(),
            points: points.to_vec(),
        });
        let plot = Plot::new("", &Axis::linear("x"), &Axis::linear("y"), lines.to_vec());
        let svg = plot.svg().expect("a plot");
        let is_line =
            |line: &&str| line.starts_with("<polyline") && line.contains("stroke-width=\"2\"");
        let drawn = svg.lines().filter(is_line);
        let dashes: Vec<&str> = drawn
            .map(|line| {
                line.split("stroke-dasharray=\"")
                    .nth(1)
                    .map_or("", |s| s.split('"').next().unwrap_or(""))
            })
            .collect();
        assert_eq!((dashes.len(), dashes[0]), (7, ""), "{svg}");
        for (k, own) in dashes.iter().enumerate().skip(1) {
            assert!(!own.is_empty() && !dashes[..k].contains(own), "{dashes:?}");
        }
        // Keys are dashed as lines are.
        assert_eq!(dashes[1], "9 4");
        let gaps = "var(--series-2) 0px 9px,transparent 9px 13px";
        assert_eq!(
            key_background(2),
            format!("repeating-linear-gradient(90deg,{gaps})")
        );
        assert_eq!(key_background(1), "var(--series-1)");
    }

    /// Two marks of one axis never read 10000 and 1e5.
    #[test]
    fn marks_are_short_and_of_one_kind() {
        let marks = |range, marks: [f64; 4]| {
            let digits = Digits::of(&range);
            marks.map(|x| digits.short(x))
        };
        let plain = marks(0.0..2e4, [0.0, 0.25, 10.0, 1e4]);
        assert_eq!(plain, ["0", "0.25", "10", "10000"]);
        let large = marks(1.0..2e5, [1.0, 100.0, 1e4, 1e5]);
        assert_eq!(large, ["1", "100", "1e4", "1e5"]);
        let small = marks(1e-6..2.0, [1e-6, 1e-3, 0.01, 1.0]);
        assert_eq!(small, ["1e-6", "1e-3", "0.01", "1"]);
    }
}
