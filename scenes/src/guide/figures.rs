//! Which figures are drawn over which.

use std::error::Error;

use serde_json::Value;

use super::Source;
use crate::report::{Cell, Table};
use bdtree_measure::plot::{Axis, Line, Plot};

type Plots = Result<Vec<Plot>, Box<dyn Error>>;
type Points = Vec<(f64, f64)>;

/// A line for every asset.
fn lines(
    sources: &[Source],
    points: impl Fn(&Source) -> Result<Points, Box<dyn Error>>,
) -> Result<Vec<Line>, Box<dyn Error>> {
    let all = sources.iter().map(|source| {
        Ok(Line {
            name: source.name.clone(),
            points: points(source)?,
        })
    });
    all.collect()
}

/// How the values of a curve are shown.
enum As {
    Given,
    Percent,
    /// Over the value at this x.
    Over(f64),
    /// Over the value at the largest x.
    OverLast,
}

impl As {
    fn show(&self, points: Points) -> Points {
        let at = |x: f64| points.iter().find(|p| p.0 == x).map_or(f64::NAN, |p| p.1);
        let (times, over) = match self {
            Self::Given => (1.0, 1.0),
            Self::Percent => (100.0, 1.0),
            Self::Over(x) => (1.0, at(*x)),
            Self::OverLast => (1.0, at(points.iter().map(|p| p.0).fold(0.0, f64::max))),
        };
        let shown = points.iter().map(|(x, y)| (*x, times * y / over));
        shown.collect()
    }
}

/// Plots over one axis of what the objects of a list have, each with its title, axis, pointer and how it is shown.
fn plots(
    sources: &[Source],
    [list, x]: [&str; 2],
    (axis, times): (Axis, f64),
    plots: &[(&str, Axis, &str, As)],
) -> Plots {
    let plots = plots.iter().map(|(title, own, y, shown)| {
        let lines = lines(sources, |source| {
            let points = shown.show(source.points(list, x, y)?);
            Ok(points.into_iter().map(|(x, y)| (times * x, y)).collect())
        });
        Ok(Plot::new(title, &axis, own, lines?))
    });
    plots.collect()
}

/// What fewer modes cost and save.
pub(super) fn modes(reports: &[Source]) -> Plots {
    let error = "Largest error of a vertex, against all modes";
    let time = "Time of balls, rays and pairs together";
    let [bytes, all] = ["over those with all modes", "over that with all modes"].map(Axis::linear);
    plots(
        reports,
        ["/modes", "/modes"],
        (Axis::linear("modes kept"), 1.0),
        &[
            (
                error,
                Axis::log("% of the diagonal"),
                "/error_max_rel",
                As::Percent,
            ),
            ("Bytes of the file", bytes, "/bytes", As::OverLast),
            (time, all, "/time_rel", As::Given),
            (
                "Nodes that a ball visits",
                Axis::linear("nodes"),
                "/ball_visits",
                As::Given,
            ),
        ],
    )
}

/// What leaves of other sizes cost and save.
pub(super) fn leaves(advice: &[Source]) -> Plots {
    let time = "Time of balls, rays and pairs together";
    let [bytes, all] =
        ["over those with leaves of 4", "over that with leaves of 4"].map(Axis::linear);
    plots(
        advice,
        ["/leaves", "/leaf_size"],
        (Axis::doublings("most triangles of a leaf"), 1.0),
        &[
            (time, all, "/time_rel", As::Over(4.0)),
            ("Bytes of the file", bytes, "/bytes", As::Over(4.0)),
        ],
    )
}

/// What stopping at a level costs and saves.
pub(super) fn depth(reports: &[Source]) -> Plots {
    let [touched, diagonal, micros] =
        ["over what is touched", "% of the diagonal", "µs"].map(Axis::log);
    let [area, error] = [
        "Area that is reported and not touched",
        "Error of the penetration depth",
    ];
    plots(
        reports,
        ["/depth", "/level"],
        (Axis::linear("level at which a ball stops"), 1.0),
        &[
            (area, touched, "/extra_area_rel", As::Given),
            (error, diagonal, "/penetration_error_rel", As::Percent),
            ("Time of a ball", micros, "/ball_micros", As::Given),
        ],
    )
}

/// The curve of a question in the comparison with deforming and refitting.
fn asked<'s>(source: &'s Source, question: &str) -> Result<&'s Value, Box<dyn Error>> {
    let mut all = source.list("/refit/curves")?.iter();
    let found = all.find(|curve| curve["question"] == question);
    Ok(found.ok_or_else(|| format!("{}: no curve of {question}", source.path.display()))?)
}

/// Where deforming and refitting is faster.
pub(super) fn refit(reports: &[Source]) -> Plots {
    let times = Axis::log("deform + refit over bdtree");
    let plots = [
        ("ray", "Rays", "rays per step"),
        ("ball", "Balls of 1 % of the diagonal", "balls per step"),
        (
            "pair",
            "Two instances that touch",
            "touching pairs of triangles",
        ),
    ];
    let plots = plots.map(|(question, title, amount)| {
        let lines = lines(reports, |source| {
            let points = asked(source, question)?["points"].as_array();
            let both = |point: &Value| Some((point["amount"].as_f64()?, point["ratio"].as_f64()?));
            Ok(points.into_iter().flatten().filter_map(both).collect())
        });
        Ok(Plot::new(title, &Axis::log(amount), &times, lines?))
    });
    plots.into_iter().collect()
}

/// The break-evens of [`refit`].
pub(super) fn break_even(reports: &[Source]) -> Result<Table, Box<dyn Error>> {
    let title = "From where on deforming and refitting is faster, per step";
    let columns = ["asset", "triangles", "rays", "balls", "touching pairs"];
    let mut table = Table::new("break-even", title, &columns);
    for source in reports {
        let mut row: Vec<Cell> = vec![source.name.as_str().into()];
        let triangles = source
            .value
            .pointer("/asset/triangles")
            .and_then(Value::as_u64);
        row.push(triangles.map_or(Cell::None, |count| Cell::Text(count.to_string())));
        for question in ["ray", "ball", "pair"] {
            let curve = asked(source, question)?;
            let text = from_where(curve).ok_or_else(|| {
                let path = source.path.display();
                format!("{path}: the curve of {question} does not say who is ahead")
            })?;
            row.push(Cell::Text(text));
        }
        table.rows.push(row);
    }
    Ok(table)
}

/// From where on deforming and refitting is faster, as the curve itself says (docs/reference/report.md); `None` where it
/// does not.
fn from_where(curve: &Value) -> Option<String> {
    let whole = |name: &str| Some(format!("{:.0}", curve[name].as_f64()?));
    Some(match (curve["ahead"].as_str()?, curve["above"].as_str()) {
        ("bdtree", _) => {
            let points = curve["points"].as_array()?.iter();
            let amounts = points.filter_map(|point| point["amount"].as_f64());
            format!("not up to {:.0}", amounts.fold(0.0, f64::max))
        }
        ("refit", _) => "at every number".to_string(),
        ("crosses", Some("refit")) => whole("break_even")?,
        ("crosses", _) => format!("up to {}", whole("break_even")?),
        ("close", _) => "unsure".to_string(),
        (_, None) => format!("unsure above {}", whole("from")?),
        _ => format!("unsure from {} to {}", whole("from")?, whole("to")?),
    })
}
