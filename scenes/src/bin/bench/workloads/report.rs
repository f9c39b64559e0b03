//! The figures as a table and as JSON.

use serde_json::{Value, json};

use bdtree_measure::turns::{PARTS, Role, Row, TOTAL};

/// A workload's result.
pub(crate) struct Work {
    pub(crate) name: String,
    /// Times faster than the fastest peer: must, aim.
    pub(crate) goals: Option<[f64; 2]>,
    pub(crate) rows: Vec<Row>,
}

/// By medians, by floors.
type Pair = [f64; 2];

fn totals(row: &Row) -> Pair {
    [row.median[TOTAL], row.floor[TOTAL]]
}

impl Work {
    fn row(&self, role: Role) -> Option<&Row> {
        self.rows.iter().find(|row| row.role == role)
    }

    /// How many times the product's time the fastest of a role takes, and who that is by medians.
    fn ratio(&self, role: Role) -> Option<(Pair, &str)> {
        let ours = totals(self.row(Role::Ours)?);
        let them = || self.rows.iter().filter(|row| row.role == role);
        let least = |k: usize| them().map(|row| totals(row)[k]).min_by(f64::total_cmp);
        let who = them().min_by(|a, b| a.median[TOTAL].total_cmp(&b.median[TOTAL]))?;
        Some(([least(0)? / ours[0], least(1)? / ours[1]], &who.name))
    }

    /// A row's time over that of the body without modes: in total, and per contact.
    fn over_rigid(&self, row: &Row) -> Option<(Pair, Pair)> {
        let rigid = self.row(Role::Rigid)?;
        let (a, b) = (totals(row), totals(rigid));
        let share = rigid.found as f64 / row.found as f64;
        let total = [a[0] / b[0], a[1] / b[1]];
        Some((total, total.map(|x| x * share)))
    }

    /// The product in all its settings but the rigid one.
    fn own(&self) -> impl Iterator<Item = &Row> {
        let own = [Role::Ours, Role::Variant];
        self.rows.iter().filter(move |row| own.contains(&row.role))
    }

    pub(crate) fn json(&self) -> Value {
        let ratio = |role| {
            self.ratio(role)
                .map(|(r, who)| json!({"median": r[0], "floor": r[1], "to": who}))
        };
        let over_rigid = |row: &Row| {
            let (total, each) = self.over_rigid(row)?;
            Some(json!({"name": row.name, "total": total, "per_found": each}))
        };
        let own: Vec<Value> = self.own().filter_map(over_rigid).collect();
        json!({
            "work": self.name,
            "must": self.goals.map(|g| g[0]), "aim": self.goals.map(|g| g[1]),
            "fastest_peer_over_ours": ratio(Role::Peer),
            "baseline_over_ours": ratio(Role::Baseline),
            "over_rigid": own,
            "contenders": self.rows.iter().map(Row::json).collect::<Vec<_>>(),
        })
    }

    pub(crate) fn print(&self) {
        println!("\n{}", self.name);
        let names = self.rows.iter().map(|row| row.name.len());
        let width = names.max().unwrap_or(0).max(14);
        print!("  {:<width$}", "µs per frame");
        for part in PARTS {
            print!("{part:>21}");
        }
        println!(
            "{:>10}{:>9}{:>11}{:>11}",
            "found", "to ours", "visits", "updates"
        );
        let ours = self
            .row(Role::Ours)
            .map_or(f64::NAN, |row| row.median[TOTAL]);
        for row in &self.rows {
            print!("  {:<width$}", row.name);
            for k in 0..PARTS.len() {
                let (median, floor) = (1e6 * row.median[k], 1e6 * row.floor[k]);
                if median == 0.0 {
                    print!("{:>21}", "-");
                } else {
                    print!("{:>21}", format!("{} ({})", short(median), short(floor)));
                }
            }
            print!("{:>10}{:>9}", row.found, short(row.median[TOTAL] / ours));
            for count in [row.nodes.visited, row.nodes.updated] {
                if row.nodes.visited == 0 {
                    print!("{:>11}", "-");
                } else {
                    print!("{:>11}", short(count as f64 / row.frames as f64));
                }
            }
            println!();
        }
        if let Some(([median, floor], who)) = self.ratio(Role::Peer) {
            print!(
                "  fastest peer ({who}) to ours: {} (floors {})",
                short(median),
                short(floor)
            );
            if let Some([must, aim]) = self.goals {
                print!("; must {must}, aim {aim}");
            }
            println!();
        }
        for row in self.own() {
            let Some((total, each)) = self.over_rigid(row) else {
                continue;
            };
            println!(
                "  {} to rigid: {} (floors {}), per contact {} ({})",
                row.name,
                short(total[0]),
                short(total[1]),
                short(each[0]),
                short(each[1])
            );
        }
    }
}

/// Three digits.
pub(crate) fn short(x: f64) -> String {
    let digits = match x.abs() {
        a if a >= 100.0 => 0,
        a if a >= 10.0 => 1,
        a if a >= 1.0 => 2,
        _ => 3,
    };
    format!("{x:.digits$}")
}
