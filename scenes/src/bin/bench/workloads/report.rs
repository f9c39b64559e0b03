//! The figures of all works as tables.

use bdtree_measure::table::Cell;
use bdtree_measure::turns::{PARTS, Row};
use bdtree_scenes::report;

use crate::prelude::*;

/// A workload's result.
pub(crate) struct Work {
    pub(crate) name: String,
    /// Times faster than the fastest peer: must, aim.
    pub(crate) goals: [f64; 2],
    pub(crate) rows: Vec<Row>,
}

/// By medians, by floors.
fn totals(row: &Row) -> [f64; 2] {
    [row.median[TOTAL], row.floor[TOTAL]]
}

impl Work {
    fn of(&self, role: Role) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.role == role)
    }

    /// Everybody's µs per frame, by medians and floors, and counts.
    fn contenders(&self) -> impl Iterator<Item = report::Row> {
        let ours = self.of(Role::Ours).next();
        let ours = ours.map_or(f64::NAN, |row| row.median[TOTAL]);
        self.rows.iter().map(move |row| {
            let mut cells = row! {"work" => self.name.as_str(), "contender" => row.name.as_str()};
            let time = |seconds: f64| match seconds {
                0.0 => Cell::None,
                _ => Cell::from(1e6 * seconds),
            };
            for (k, part) in PARTS.iter().enumerate() {
                cells.extend(row! {
                    *part => time(row.median[k]), format!("{part}, floor") => time(row.floor[k]),
                });
            }
            cells.extend(row! {"found" => row.found, "to ours" => row.median[TOTAL] / ours});
            let each = |count: u64| count as f64 / row.frames as f64;
            if row.nodes.visited > 0 {
                cells.extend(row! {
                    "visits" => each(row.nodes.visited), "updates" => each(row.nodes.updated),
                });
            }
            cells
        })
    }

    /// How many times the product's time the fastest of the peers and of the baselines take.
    fn ratios(&self) -> impl Iterator<Item = report::Row> {
        let ours = self.of(Role::Ours).next().map(totals);
        let of = move |(what, role): (&str, Role)| {
            let [median, floor] = ours?;
            let who = self
                .of(role)
                .min_by(|a, b| a.median[TOTAL].total_cmp(&b.median[TOTAL]))?;
            let least = self
                .of(role)
                .map(|row| row.floor[TOTAL])
                .fold(f64::INFINITY, f64::min);
            let mut cells = row! {
                "work" => self.name.as_str(), "fastest" => what, "who" => who.name.as_str(),
                "to ours" => who.median[TOTAL] / median, "floors" => least / floor,
            };
            if role == Role::Peer {
                let [must, aim] = self.goals;
                cells.extend(row! {"must" => must, "aim" => aim});
            }
            Some(cells)
        };
        [("peer", Role::Peer), ("baseline", Role::Baseline)]
            .into_iter()
            .filter_map(of)
    }

    /// The product's settings over the body without modes: in total, and per contact.
    fn over_rigid(&self) -> impl Iterator<Item = report::Row> {
        let own = self.of(Role::Ours).chain(self.of(Role::Variant));
        own.filter_map(|row| {
            let rigid = self.of(Role::Rigid).next()?;
            let (a, b) = (totals(row), totals(rigid));
            let share = rigid.found as f64 / row.found as f64;
            let [median, floor] = [a[0] / b[0], a[1] / b[1]];
            Some(row! {
                "work" => self.name.as_str(), "setting" => row.name.as_str(),
                "to rigid" => median, "floors" => floor,
                "per contact" => median * share, "per contact, floors" => floor * share,
            })
        })
    }
}

/// The figures of all works.
pub(crate) fn tables(works: &[Work]) -> Vec<Table> {
    let rows = |of: fn(&Work) -> Vec<report::Row>| -> Vec<report::Row> {
        works.iter().flat_map(of).collect()
    };
    let contenders = rows(|work| work.contenders().collect());
    let ratios = rows(|work| work.ratios().collect());
    let over_rigid = rows(|work| work.over_rigid().collect());
    let mut tables = vec![
        table(
            "contenders",
            "µs and counts per frame; found in all",
            &contenders,
        ),
        table("ratios", "The fastest of the others to ours", &ratios),
        table("over_rigid", "Ours to the body without modes", &over_rigid),
    ];
    // The product alone is compared with nothing.
    tables.retain(|table| !table.rows.is_empty());
    tables
}
