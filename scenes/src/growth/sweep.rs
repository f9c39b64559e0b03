//! The ball query beside deforming and refitting, over modes, displacement, balls a step and radius: where
//! refitting begins to win (P53).

use std::error::Error;

use bdtree_measure::comparison::AMOUNTS;
use serde_json::{Value, json};

use super::step::{Contenders, Crossing, Point};
use crate::contenders::assets::baked;
use crate::report::{Cell, Table};
use crate::workloads::bodies::blob_with;
use bdtree_measure::plot::{Axis, Line, Plot};

/// What varies.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Setting {
    modes: usize,
    /// Largest displacement of a vertex over the diagonal of the box.
    displacement: f64,
    radius: f32,
}

const USUAL: Setting = Setting {
    modes: 10,
    displacement: 0.1,
    radius: 0.05,
};

/// A row: what varies, how it went, and where refitting would win there.
struct Row {
    x: f64,
    point: Point,
    crossing: Option<Crossing>,
}

/// One thing varied, the others as usual.
pub(super) struct Sweep {
    key: &'static str,
    what: &'static str,
    triangles: usize,
    rows: Vec<Row>,
}

/// Modes, displacement, balls a step and radius, on a body of about this many triangles.
pub(super) fn all(triangles: u32, repeats: usize) -> Result<Vec<Sweep>, Box<dyn Error>> {
    let modes = [1, 2, 4, 8, 16, 32, 64].map(|modes| (modes as f64, Setting { modes, ..USUAL }));
    let shares = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].map(|displacement| {
        let setting = Setting {
            displacement,
            ..USUAL
        };
        (displacement, setting)
    });
    let radii = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5]
        .map(|radius| (f64::from(radius), Setting { radius, ..USUAL }));
    // Faces of the icosahedron are split into n² triangles.
    let n = (f64::from(triangles) / 20.0).sqrt().round() as usize;
    let sweep = |key, what, rows| Sweep {
        key,
        what,
        triangles: 20 * n * n,
        rows,
    };
    let way = "farthest vertex's way over the diagonal";
    Ok(vec![
        sweep("modes", "modes", settings(n, &modes, repeats)?),
        sweep("displacement", way, settings(n, &shares, repeats)?),
        sweep(
            "contacts",
            "radius of the ball",
            settings(n, &radii, repeats)?,
        ),
        sweep("balls", "balls a step", balls(n, repeats)?),
    ])
}

/// One ball a step at each setting, and as many as it takes.
fn settings(
    n: usize,
    settings: &[(f64, Setting)],
    repeats: usize,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut rows = Vec::new();
    for (x, setting) in settings {
        with_contenders(n, setting, |contenders| {
            rows.push(Row {
                x: *x,
                point: contenders.measure(1, 1, repeats)?,
                crossing: Some(contenders.crossing(repeats)?),
            });
            Ok(())
        })?;
    }
    Ok(rows)
}

/// Balls a step at the usual setting: rows that are the crossing's curve themselves.
fn balls(n: usize, repeats: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut rows = Vec::new();
    with_contenders(n, &USUAL, |contenders| {
        for balls in AMOUNTS {
            rows.push(Row {
                x: balls as f64,
                point: contenders.measure(balls, 1, repeats)?,
                crossing: None,
            });
        }
        Ok(())
    })?;
    Ok(rows)
}

fn with_contenders(
    n: usize,
    setting: &Setting,
    measure: impl FnOnce(&mut Contenders<'_>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let body = blob_with("blob", n, setting.modes, 3);
    let model = baked(&body)?;
    let Setting {
        displacement,
        radius,
        ..
    } = *setting;
    let mut contenders = Contenders::new(*model.asset(), &body, displacement, radius);
    measure(&mut contenders)
}

impl Sweep {
    pub(super) fn json(&self) -> Value {
        let row = |row: &Row| {
            let [ours, update, query] = row.point.seconds.map(|s| 1e6 * s);
            let mut times = json!({"ours_us": ours, "update_us": update, "query_us": query,
                "speedup": row.point.times()});
            if let Some(crossing) = &row.crossing {
                times["crossing"] = crossing.json();
            }
            json!({"x": row.x, "contacts": row.point.contacts, "nodes": row.point.nodes, "times": times})
        };
        json!({"over": self.what, "triangles": self.triangles,
            "rows": self.rows.iter().map(row).collect::<Vec<Value>>()})
    }

    /// Whether rows say from how many balls a step on refitting is ahead.
    fn has_crossings(&self) -> bool {
        self.rows.iter().any(|row| row.crossing.is_some())
    }

    pub(super) fn table(&self) -> Table {
        let more = if self.has_crossings() {
            "one ball of radius 0.05 a step. Break-even: balls a step from which on refitting is ahead, asked at 1, 4, \
             16 … 4096 a step"
        } else {
            "balls of radius 0.05"
        };
        let title = format!(
            "Over {}: {} triangles, else 10 modes, displacement 10 %, {more}. From 4 balls a step on ours has a \
             StepCache; times from 0.9 to 1.1 are noise.",
            self.what, self.triangles
        );
        let mut columns = vec![
            self.what,
            "contacts a step",
            "nodes visited",
            "ours, µs",
            "deform + refit, µs",
            "their queries, µs",
            "times faster",
        ];
        if self.has_crossings() {
            columns.push("break-even, balls a step");
        }
        let mut table = Table::new(self.key, title, &columns);
        for row in &self.rows {
            let [ours, update, query] = row.point.seconds.map(|s| 1e6 * s);
            let mut cells: Vec<Cell> = vec![
                counted(row.x),
                row.point.contacts.into(),
                row.point.nodes.into(),
                ours.into(),
                update.into(),
                query.into(),
                row.point.times().into(),
            ];
            cells.extend(row.crossing.map(|crossing| crossing.text().into()));
            table.rows.push(cells);
        }
        table
    }

    pub(super) fn chart(&self) -> Plot {
        let line = |name: &str, of: &dyn Fn(&Point) -> f64| Line {
            name: name.to_string(),
            points: self.rows.iter().map(|r| (r.x, of(&r.point))).collect(),
        };
        let lines = vec![
            line("ours", &|p| 1e6 * p.seconds[0]),
            line("deform + refit + query", &|p| {
                1e6 * (p.seconds[1] + p.seconds[2])
            }),
            line("their queries alone", &|p| 1e6 * p.seconds[2]),
        ];
        Plot::new(
            self.what,
            &Axis::log(self.what),
            &Axis::log("µs a step"),
            lines,
        )
    }
}

/// Numbers of things as such.
fn counted(x: f64) -> Cell {
    if x.fract() == 0.0 {
        Cell::Count(x as u64)
    } else {
        Cell::Number(x)
    }
}
