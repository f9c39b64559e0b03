//! Which figures are drawn over which.

use std::error::Error;

use serde_json::Value;

use super::Source;
use crate::plot::{Axis, Chart, Curve};
use crate::report::{Cell, Table};

type Charts = Result<Vec<Chart<'static>>, Box<dyn Error>>;
type Points = Vec<(f64, f64)>;

/// A curve for every asset.
fn curves(
    sources: &[Source],
    points: impl Fn(&Source) -> Result<Points, Box<dyn Error>>,
) -> Result<Vec<Curve>, Box<dyn Error>> {
    let all = sources.iter().map(|source| {
        Ok(Curve {
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
pub(super) fn modes(reports: &[Source]) -> Charts {
    let kept = Axis::linear("modes kept");
    Ok(vec![
        Chart {
            title: "Largest error of a vertex, against all modes",
            x: kept,
            y: Axis::log("% of the diagonal"),
            curves: curves(reports, |source| {
                Ok(percent(source.points(
                    "/modes",
                    "/modes",
                    "/error_max_rel",
                )?))
            })?,
        },
        Chart {
            title: "Bytes of the file",
            x: kept,
            y: Axis::linear("over those with all modes"),
            curves: curves(reports, |source| {
                let points = source.points("/modes", "/modes", "/bytes")?;
                let most = points.iter().map(|p| p.0).fold(0.0, f64::max);
                Ok(relative(points, |p| p.0 == most))
            })?,
        },
        Chart {
            title: "Time of balls, rays and pairs together",
            x: kept,
            y: Axis::linear("over that with all modes"),
            curves: curves(reports, |source| {
                source.points("/modes", "/modes", "/time_rel")
            })?,
        },
        Chart {
            title: "Nodes that a ball visits",
            x: kept,
            y: Axis::linear("nodes"),
            curves: curves(reports, |source| {
                source.points("/modes", "/modes", "/ball_visits")
            })?,
        },
    ])
}

/// What leaves of other sizes cost and save.
pub(super) fn leaves(advice: &[Source]) -> Charts {
    let size = Axis::log("most triangles of a leaf lane");
    let is_default = |p: &(f64, f64)| p.0 == 4.0;
    let of = |y: &'static str| {
        curves(advice, move |source| {
            let points = source.points("/leaves", "/leaf_size", y)?;
            Ok(relative(points, is_default))
        })
    };
    Ok(vec![
        Chart {
            title: "Time of balls, rays and pairs together",
            x: size,
            y: Axis::linear("over that with leaves of 4"),
            curves: of("/time_rel")?,
        },
        Chart {
            title: "Bytes of the file",
            x: size,
            y: Axis::linear("over those with leaves of 4"),
            curves: of("/bytes")?,
        },
    ])
}

/// What stopping at a level costs and saves.
pub(super) fn depth(reports: &[Source]) -> Charts {
    let level = Axis::linear("level at which a ball stops");
    let of = |y: &'static str| curves(reports, move |source| source.points("/depth", "/level", y));
    Ok(vec![
        Chart {
            title: "Area that is reported and not touched",
            x: level,
            y: Axis::log("over what is touched"),
            curves: of("/extra_area_rel")?,
        },
        Chart {
            title: "Error of the penetration depth",
            x: level,
            y: Axis::log("% of the diagonal"),
            curves: curves(reports, |source| {
                Ok(percent(source.points(
                    "/depth",
                    "/level",
                    "/penetration_error_rel",
                )?))
            })?,
        },
        Chart {
            title: "Time of a ball",
            x: level,
            y: Axis::log("µs"),
            curves: of("/ball_micros")?,
        },
    ])
}

/// What leaving modes out of node bounds costs and saves.
pub(super) fn tolerance(reports: &[Source]) -> Charts {
    let share = Axis::log("tolerance, % of the diagonal");
    let of = |y: &'static str| {
        curves(reports, move |source| {
            let points = source.points("/tolerance", "/tolerance_rel", y)?;
            let points = relative(points, |p| p.0 == 0.0);
            Ok(points.into_iter().map(|(x, y)| (100.0 * x, y)).collect())
        })
    };
    Ok(vec![
        Chart {
            title: "Modes left in node bounds",
            x: share,
            y: Axis::linear("over those without a tolerance"),
            curves: of("/active_modes")?,
        },
        Chart {
            title: "Time of 16 balls and 16 rays, the pose included",
            x: share,
            y: Axis::linear("over that without a tolerance"),
            curves: of("/micros")?,
        },
    ])
}

/// The curve of a question in the contest with deforming and refitting.
fn asked<'s>(source: &'s Source, question: &str) -> Result<&'s Value, Box<dyn Error>> {
    let mut all = source.list("/refit/curves")?.iter();
    let found = all.find(|curve| curve["question"] == question);
    Ok(found.ok_or_else(|| format!("{}: no curve of {question}", source.path.display()))?)
}

/// Where deforming and refitting is faster.
pub(super) fn refit(reports: &[Source]) -> Charts {
    let of = |question: &'static str| {
        curves(reports, move |source| {
            let points = asked(source, question)?["points"].as_array();
            let both = |point: &Value| Some((point["amount"].as_f64()?, point["ratio"].as_f64()?));
            Ok(points.into_iter().flatten().filter_map(both).collect())
        })
    };
    let times = Axis::log("deform + refit over ours");
    Ok(vec![
        Chart {
            title: "Rays",
            x: Axis::log("rays per step"),
            y: times,
            curves: of("ray")?,
        },
        Chart {
            title: "Balls of 1 % of the diagonal",
            x: Axis::log("balls per step"),
            y: times,
            curves: of("ball")?,
        },
        Chart {
            title: "Two instances that touch",
            x: Axis::log("touching pairs of triangles"),
            y: times,
            curves: of("pair")?,
        },
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
