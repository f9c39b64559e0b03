//! Several plots as one picture that needs no style sheet.

use plotters::style::RGBColor;

use super::{DASHES, GRID, INK, Plot, SERIES, SIZE, dash_attribute, escaped, hex};

/// Colours that are told apart in print and by most eyes (Okabe and Ito 2008), by series.
const COLOURS: [&str; SERIES.len()] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000",
];

/// Of axes and of the grid.
const INK_AND_GRID: [(RGBColor, &str); 2] = [(INK, "#202020"), (GRID, "#E1E1E1")];

/// Around each plot, and the height of a line of text.
const MARGIN: u32 = 12;
const LINE: u32 = 18;

/// Plots in two columns, each below its title and the names of its lines.
///
/// # Errors
/// A plot that has fewer than two points to show, with its title.
pub fn sheet(plots: &[Plot]) -> Result<String, String> {
    let columns = plots.len().clamp(1, 2) as u32;
    // All plots begin at the same height: below the longest legend.
    let lines = plots.iter().map(|plot| plot.keys().count() as u32).max();
    let head = MARGIN + LINE * (1 + lines.unwrap_or(0));
    let cell = [SIZE.0 + 2 * MARGIN, head + SIZE.1 + MARGIN];
    let rows = (plots.len() as u32).div_ceil(columns);
    let size = [cell[0] * columns, cell[1] * rows];
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n",
        size[0], size[1]
    );
    for (k, plot) in (0..).zip(plots) {
        let nothing = || format!("{}: fewer than two points to draw", plot.title);
        let [x, y] = [k % columns * cell[0] + MARGIN, k / columns * cell[1]];
        text += &format!(
            "<g transform=\"translate({x} {y})\"><text y=\"{}\" font-weight=\"bold\">{}</text>\n",
            MARGIN + LINE / 2,
            escaped(&plot.title)
        );
        for (row, (series, name)) in (1..).zip(plot.keys()) {
            // The middle of lower-case letters, whose feet stand on the baseline below.
            let middle = MARGIN + LINE * row + LINE / 4;
            text += &format!(
                "<path d=\"M0 {middle}h32\" stroke=\"{}\"{} stroke-width=\"3\"/><text x=\"38\" y=\"{}\">{}</text>\n",
                COLOURS[series - 1],
                dash_attribute(DASHES[series - 1]),
                middle + LINE / 4,
                escaped(name)
            );
        }
        let drawn = plot.svg().ok_or_else(nothing)?;
        text += &format!(
            "<g transform=\"translate(0 {head})\">{}</g></g>\n",
            coloured(drawn)
        );
    }
    Ok(text + "</svg>\n")
}

/// Colours for their names.
fn coloured(mut svg: String) -> String {
    let names = SERIES.into_iter().zip(COLOURS).chain(INK_AND_GRID);
    for (name, colour) in names {
        svg = svg.replace(&hex(name), colour);
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Line};
    use super::{Plot, sheet};

    fn plot(title: &str, points: &[(f64, f64)]) -> Plot {
        let lines = ["first & second", "third"].map(|name| Line {
            name: name.to_string(),
            points: points.to_vec(),
        });
        Plot::new(
            title,
            &Axis::log("triangles"),
            &Axis::linear("µs"),
            lines.to_vec(),
        )
    }

    #[test]
    fn plots_are_drawn_and_named() {
        let points: Vec<_> = (1..9).map(|i| (f64::from(i), f64::from(i * i))).collect();
        let text = sheet(&[plot("one", &points), plot("two", &points)]).expect("points");
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        for part in ["triangles", "µs", "first &amp; second", "third"] {
            assert_eq!(text.matches(part).count(), 2, "{part}");
        }
        assert!(text.contains(">one<") && text.contains(">two<"));
        // In each plot the second name has the dashes of the second line.
        assert_eq!(text.matches("stroke-dasharray=\"9 4\"").count(), 4);
        // No colour is left a name.
        for name in 1..10 {
            assert!(!text.contains(&format!("#0{name}0{name}0{name}")), "{name}");
        }
    }

    #[test]
    fn what_has_no_points_is_refused() {
        let error = sheet(&[plot("nothing", &[(-1.0, f64::NAN)])]);
        assert_eq!(
            error,
            Err("nothing: fewer than two points to draw".to_string())
        );
    }
}
