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

/// y over the y of the point at which `is_whole` holds.
fn relative(points: Points, is_whole: impl Fn(&(f64, f64)) -> bool) -> Points {
    let whole = points
        .iter()
        .find(|p| is_whole(p))
        .map_or(f64::NAN, |p| p.1);
    points.into_iter().map(|(x, y)| (x, y / whole)).collect()
}

/// In per cent.
fn percent(points: Points) -> Points {
    points.into_iter().map(|(x, y)| (x, 100.0 * y)).collect()
}

/// What fewer modes cost and save.
pub(super) fn modes(reports: &[Source]) -> Plots {
    let kept = Axis::linear("modes kept");
    Ok(vec![
        Plot::new(
            "Largest error of a vertex, against all modes",
            &kept,
            &Axis::log("% of the diagonal"),
            lines(reports, |source| {
                Ok(percent(source.points(
                    "/modes",
                    "/modes",
                    "/error_max_rel",
                )?))
            })?,
        ),
        Plot::new(
            "Bytes of the file",
            &kept,
            &Axis::linear("over those with all modes"),
            lines(reports, |source| {
                let points = source.points("/modes", "/modes", "/bytes")?;
                let most = points.iter().map(|p| p.0).fold(0.0, f64::max);
                Ok(relative(points, |p| p.0 == most))
            })?,
        ),
        Plot::new(
            "Time of balls, rays and pairs together",
            &kept,
            &Axis::linear("over that with all modes"),
            lines(reports, |source| {
                source.points("/modes", "/modes", "/time_rel")
            })?,
        ),
        Plot::new(
            "Nodes that a ball visits",
            &kept,
            &Axis::linear("nodes"),
            lines(reports, |source| {
                source.points("/modes", "/modes", "/ball_visits")
            })?,
        ),
    ])
}

/// What leaves of other sizes cost and save.
pub(super) fn leaves(advice: &[Source]) -> Plots {
    let size = Axis::log("most triangles of a leaf lane");
    let is_default = |p: &(f64, f64)| p.0 == 4.0;
    let of = |y: &'static str| {
        lines(advice, move |source| {
            let points = source.points("/leaves", "/leaf_size", y)?;
            Ok(relative(points, is_default))
        })
    };
    Ok(vec![
        Plot::new(
            "Time of balls, rays and pairs together",
            &size,
            &Axis::linear("over that with leaves of 4"),
            of("/time_rel")?,
        ),
        Plot::new(
            "Bytes of the file",
            &size,
            &Axis::linear("over those with leaves of 4"),
            of("/bytes")?,
        ),
    ])
}

/// What stopping at a level costs and saves.
pub(super) fn depth(reports: &[Source]) -> Plots {
    let level = Axis::linear("level at which a ball stops");
    let of = |y: &'static str| lines(reports, move |source| source.points("/depth", "/level", y));
    Ok(vec![
        Plot::new(
            "Area that is reported and not touched",
            &level,
            &Axis::log("over what is touched"),
            of("/extra_area_rel")?,
        ),
        Plot::new(
            "Error of the penetration depth",
            &level,
            &Axis::log("% of the diagonal"),
            lines(reports, |source| {
                Ok(percent(source.points(
                    "/depth",
                    "/level",
                    "/penetration_error_rel",
                )?))
            })?,
        ),
        Plot::new(
            "Time of a ball",
            &level,
            &Axis::log("µs"),
            of("/ball_micros")?,
        ),
    ])
}

/// What leaving modes out of node bounds costs and saves.
pub(super) fn tolerance(reports: &[Source]) -> Plots {
    let share = Axis::log("tolerance, % of the diagonal");
    let of = |y: &'static str| {
        lines(reports, move |source| {
            let points = source.points("/tolerance", "/tolerance_rel", y)?;
            let points = relative(points, |p| p.0 == 0.0);
            Ok(points.into_iter().map(|(x, y)| (100.0 * x, y)).collect())
        })
    };
    Ok(vec![
        Plot::new(
            "Modes left in node bounds",
            &share,
            &Axis::linear("over those without a tolerance"),
            of("/active_modes")?,
        ),
        Plot::new(
            "Time of 16 balls and 16 rays, the pose included",
            &share,
            &Axis::linear("over that without a tolerance"),
            of("/micros")?,
        ),
    ])
}

/// The curve of a question in the comparison with deforming and refitting.
fn asked<'s>(source: &'s Source, question: &str) -> Result<&'s Value, Box<dyn Error>> {
    let mut all = source.list("/refit/curves")?.iter();
    let found = all.find(|curve| curve["question"] == question);
    Ok(found.ok_or_else(|| format!("{}: no curve of {question}", source.path.display()))?)
}

/// Where deforming and refitting is faster.
pub(super) fn refit(reports: &[Source]) -> Plots {
    let of = |question: &'static str| {
        lines(reports, move |source| {
            let points = asked(source, question)?["points"].as_array();
            let both = |point: &Value| Some((point["amount"].as_f64()?, point["ratio"].as_f64()?));
            Ok(points.into_iter().flatten().filter_map(both).collect())
        })
    };
    let times = Axis::log("deform + refit over ours");
    Ok(vec![
        Plot::new("Rays", &Axis::log("rays per step"), &times, of("ray")?),
        Plot::new(
            "Balls of 1 % of the diagonal",
            &Axis::log("balls per step"),
            &times,
            of("ball")?,
        ),
        Plot::new(
            "Two instances that touch",
            &Axis::log("touching pairs of triangles"),
            &times,
            of("pair")?,
        ),
    ])
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
            let most = curve["points"].as_array().into_iter().flatten();
            let most = most
                .filter_map(|p| p["amount"].as_f64())
                .fold(0.0, f64::max);
            row.push(Cell::Text(match curve["break_even"].as_f64() {
                Some(amount) => format!("{amount:.0}"),
                None => format!("not up to {most:.0}"),
            }));
        }
        table.rows.push(row);
    }
    Ok(table)
}
