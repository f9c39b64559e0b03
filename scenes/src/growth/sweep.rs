//! The ball query beside deforming and refitting, over modes, displacement, balls a step and radius: where
//! refitting begins to win (P53).

use std::error::Error;

use bdtree_measure::comparison::AMOUNTS;
use serde_json::{Value, json};

use super::step::{Contenders, Crossing, Point};
use crate::contenders::assets::baked;
use crate::report::{Cell, Column, Table};
use crate::workloads::bodies::blob_with;
use bdtree_measure::plot::{Axis, Line, Plot};

/// What varies.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Setting {
    modes: usize,
    /// Largest displacement of a vertex over the diagonal of the box.
    displacement: f64,
    radius: f32,
    /// Each step.
    balls: usize,
}

const USUAL: Setting = Setting {
    modes: 10,
    displacement: 0.1,
    radius: 0.05,
    balls: 1,
};

/// A row: what varies, how it went, and where refitting would win there.
struct Row {
    x: f64,
    point: Point,
    /// None where balls vary: these rows are the crossing's curve themselves.
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
    const SHARES: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
    let modes = [1, 2, 4, 8, 16, 32, 64].map(|modes| (modes as f64, Setting { modes, ..USUAL }));
    let ways = SHARES.map(|displacement| {
        let setting = Setting {
            displacement,
            ..USUAL
        };
        (displacement, setting)
    });
    let radii = SHARES.map(|radius| {
        let radius = radius as f32;
        (f64::from(radius), Setting { radius, ..USUAL })
    });
    let balls = AMOUNTS.map(|balls| (balls as f64, Setting { balls, ..USUAL }));
    // Faces of the icosahedron are split into n² triangles.
    let n = (f64::from(triangles) / 20.0).sqrt().round() as usize;
    let way = "largest displacement / diagonal";
    let sweeps = [
        ("modes", "modes", &modes[..]),
        ("displacement", way, &ways),
        ("contacts", "radius of the ball, mesh units", &radii),
        ("balls", "balls a step", &balls),
    ];
    let sweeps = sweeps.into_iter().map(|(key, what, settings)| {
        let rows = settings.iter().map(|(x, setting)| {
            let body = blob_with("blob", n, setting.modes, 3);
            let model = baked(&body)?;
            let Setting {
                displacement,
                radius,
                balls,
                ..
            } = *setting;
            let mut contenders = Contenders::new(*model.asset(), &body, displacement, radius);
            let point = contenders.measure(balls, 1, repeats)?;
            let crossing = (key != "balls").then(|| contenders.crossing(repeats));
            Ok(Row {
                x: *x,
                point,
                crossing: crossing.transpose()?,
            })
        });
        Ok(Sweep {
            key,
            what,
            triangles: 20 * n * n,
            rows: rows.collect::<Result<_, Box<dyn Error>>>()?,
        })
    });
    sweeps.collect()
}

impl Row {
    /// Ours; theirs until the tree is refitted, and their queries.
    fn micros(&self) -> [f64; 3] {
        self.point.seconds.map(|s| 1e6 * s)
    }
}

impl Sweep {
    pub(super) fn json(&self) -> Value {
        let row = |row: &Row| {
            let [ours, update, query] = row.micros();
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
        // What all share stands at the first.
        let title = match self.key {
            "modes" => format!(
                "Over {}: {} triangles, else 10 modes, displacement 10 %, one ball of radius 0.05 a step. Break-even: \
                 balls a step from which on refitting is ahead, asked at 1, 4, 16 … 4096 a step. From 4 balls a step \
                 on ours has a StepCache; times from 0.9 to 1.1 are noise.",
                self.what, self.triangles
            ),
            _ => format!("Over {}, else as over modes.", self.what),
        };
        let columns: [Column<'_, Row>; 8] = [
            (self.what, &|row| counted(row.x)),
            ("contacts a step", &|row| row.point.contacts.into()),
            ("nodes visited", &|row| row.point.nodes.into()),
            ("ours, µs", &|row| row.micros()[0].into()),
            ("deform + refit, µs", &|row| row.micros()[1].into()),
            ("their queries, µs", &|row| row.micros()[2].into()),
            ("times faster", &|row| row.point.times().into()),
            ("break-even, balls a step", &|row| {
                row.crossing
                    .map_or(Cell::None, |crossing| crossing.text().into())
            }),
        ];
        let shown = if self.has_crossings() { 8 } else { 7 };
        Table::of(self.key, title, &self.rows, &columns[..shown])
    }

    pub(super) fn chart(&self) -> Plot {
        let line = |name: &str, of: fn([f64; 3]) -> f64| Line {
            name: name.to_string(),
            points: self.rows.iter().map(|r| (r.x, of(r.micros()))).collect(),
        };
        let lines = vec![
            line("ours", |[ours, ..]| ours),
            line("deform + refit + query", |[_, update, query]| {
                update + query
            }),
            line("their queries alone", |[.., query]| query),
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
