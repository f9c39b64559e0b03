//! Curves as SVG, all in one style.

use std::error::Error;
use std::ops::Range;

use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Pixels of one chart.
const SIZE: (u32, u32) = (560, 380);

/// Colours that are told apart in print and by most eyes (Okabe and Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By factors; points that are not positive are left out.
    Log,
}

/// An axis.
#[derive(Debug, Clone, Copy)]
pub struct Axis<'a> {
    /// What it shows, with the unit.
    pub label: &'a str,
    /// How it is divided.
    pub scale: Scale,
}

impl<'a> Axis<'a> {
    /// Evenly divided.
    pub fn linear(label: &'a str) -> Self {
        let scale = Scale::Linear;
        Self { label, scale }
    }

    /// Divided by factors.
    pub fn log(label: &'a str) -> Self {
        let scale = Scale::Log;
        Self { label, scale }
    }
}

/// Points joined by lines.
#[derive(Debug, Clone)]
pub struct Curve {
    /// For the legend.
    pub name: String,
    /// In order.
    pub points: Vec<(f64, f64)>,
}

/// Curves over one pair of axes.
#[derive(Debug, Clone)]
pub struct Chart<'a> {
    /// Above it.
    pub title: &'a str,
    /// Below it.
    pub x: Axis<'a>,
    /// Left of it.
    pub y: Axis<'a>,
    /// One colour each.
    pub curves: Vec<Curve>,
}

/// The charts, two side by side.
///
/// # Errors
/// A chart without a point.
pub fn svg(charts: &[Chart<'_>]) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let columns = charts.len().clamp(1, 2);
        let rows = charts.len().div_ceil(columns).max(1);
        let size = (SIZE.0 * columns as u32, SIZE.1 * rows as u32);
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE)?;
        for (chart, area) in charts.iter().zip(area.split_evenly((rows, columns))) {
            draw(chart, &area).map_err(|e| format!("{}: {e}", chart.title))?;
        }
        area.present()?;
    }
    Ok(text)
}

type Area<'t> = DrawingArea<SVGBackend<'t>, plotters::coord::Shift>;

fn draw(chart: &Chart<'_>, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let (x, mut y) = (
        range(chart, chart.x.scale, |p| p.0)?,
        range(chart, chart.y.scale, |p| p.1)?,
    );
    // Room for the legend above the curves, a row of 16 of the plot's 290 pixels for each.
    let share = if chart.curves.len() > 1 {
        (16.0 * chart.curves.len() as f64 + 14.0) / 290.0
    } else {
        0.0
    };
    y.end = match chart.y.scale {
        Scale::Linear => y.start + (y.end - y.start) / (1.0 - share),
        Scale::Log => y.start * (y.end / y.start).powf(1.0 / (1.0 - share)),
    };
    match (chart.x.scale, chart.y.scale) {
        (Scale::Linear, Scale::Linear) => on(chart, area, x, y),
        (Scale::Linear, Scale::Log) => on(chart, area, x, y.log_scale()),
        (Scale::Log, Scale::Linear) => on(chart, area, x.log_scale(), y),
        (Scale::Log, Scale::Log) => on(chart, area, x.log_scale(), y.log_scale()),
    }
}

/// What is drawn of a curve.
fn points<'c>(chart: &'c Chart<'_>, curve: &'c Curve) -> impl Iterator<Item = (f64, f64)> + 'c {
    let fits = |scale, x: f64| x.is_finite() && (scale == Scale::Linear || x > 0.0);
    let all = curve.points.iter().copied();
    all.filter(move |p| fits(chart.x.scale, p.0) && fits(chart.y.scale, p.1))
}

/// From the least to the largest, with some room.
fn range(
    chart: &Chart<'_>,
    scale: Scale,
    of: impl Fn((f64, f64)) -> f64,
) -> Result<Range<f64>, Box<dyn Error>> {
    let all = chart
        .curves
        .iter()
        .flat_map(|curve| points(chart, curve))
        .map(of);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if low > high {
        return Err("no point to draw".into());
    }
    Ok(match scale {
        Scale::Log => low / 1.2..high * 1.2,
        Scale::Linear => {
            let room = 0.04 * (high - low).max(1e-9);
            low - room..high + room
        }
    })
}

fn on<X, Y>(chart: &Chart<'_>, area: &Area<'_>, x: X, y: Y) -> Result<(), Box<dyn Error>>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut built = ChartBuilder::on(area)
        .caption(chart.title, ("sans-serif", 16))
        .margin(10)
        .margin_right(18)
        .x_label_area_size(42)
        .y_label_area_size(62)
        .build_cartesian_2d(x, y)?;
    built
        .configure_mesh()
        .x_desc(chart.x.label)
        .y_desc(chart.y.label)
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .label_style(("sans-serif", 12))
        .axis_desc_style(("sans-serif", 13))
        .light_line_style(RGBColor(240, 240, 240))
        .bold_line_style(RGBColor(225, 225, 225))
        .draw()?;
    for (curve, colour) in chart.curves.iter().zip(COLOURS.into_iter().cycle()) {
        let drawn: Vec<(f64, f64)> = points(chart, curve).collect();
        let few = drawn.len() <= 40;
        built
            .draw_series(LineSeries::new(drawn.clone(), colour.stroke_width(2)))?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        if few {
            let marks = drawn
                .into_iter()
                .map(|p| Circle::new(p, 3, colour.filled()));
            built.draw_series(marks)?;
        }
    }
    if chart.curves.len() > 1 {
        built
            .configure_series_labels()
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .label_font(TextStyle::from(("sans-serif", 12)).pos(Pos::new(HPos::Left, VPos::Center)))
            .position(SeriesLabelPosition::UpperRight)
            .draw()?;
    }
    Ok(())
}

/// A number on an axis: plain from a thousandth to a hundred thousand, else with its power of ten.
fn tick(x: f64) -> String {
    let size = x.abs();
    if size < 1e-12 {
        return "0".to_string();
    }
    if !(1e-3..1e5).contains(&size) {
        let text = format!("{x:.2e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}·10^{power}", trimmed(digits));
    }
    trimmed(&format!("{x:.4}")).to_string()
}

/// Without zeros behind the point.
fn trimmed(digits: &str) -> &str {
    digits.trim_end_matches('0').trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::{Axis, Chart, Curve, svg, tick};

    #[test]
    fn curves_are_drawn_and_named() {
        let curve = |name: &str, scale: f64| Curve {
            name: name.to_string(),
            points: (1..9)
                .map(|i| (f64::from(i), scale * f64::from(i)))
                .collect(),
        };
        let chart = Chart {
            title: "growth",
            x: Axis::log("triangles"),
            y: Axis::log("µs"),
            curves: vec![curve("first", 1.0), curve("second", 2.0)],
        };
        let text = svg(&[chart.clone(), chart]).expect("points");
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        for part in ["growth", "triangles", "µs", "first", "second"] {
            assert_eq!(text.matches(part).count(), 2, "{part}");
        }
    }

    #[test]
    fn what_has_no_point_is_refused() {
        let chart = Chart {
            title: "nothing",
            x: Axis::log("x"),
            y: Axis::linear("y"),
            curves: vec![Curve {
                name: "below zero".to_string(),
                points: vec![(-1.0, 2.0)],
            }],
        };
        let error = svg(&[chart]).expect_err("no point").to_string();
        assert_eq!(error, "nothing: no point to draw");
    }

    #[test]
    fn ticks_are_short() {
        let texts = [0.0, 0.25, 1000.0, 1e6, 2e-5, 1.5e5].map(tick);
        let expected = ["0", "0.25", "1000", "1·10^6", "2·10^-5", "1.5·10^5"];
        assert_eq!(texts, expected);
    }
}
