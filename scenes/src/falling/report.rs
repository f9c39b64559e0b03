//! The figures of a run.

use bdtree_dynamics::LevelSpheres;
use serde_json::{Value, json};

use super::run::Run;
use super::{About, Scene};
use crate::report::{Report, table};
use crate::row;

impl<S: Scene> Run<S> {
    pub(super) fn report(&self, failure: Option<String>, drawn: Value, own: Value) -> Report {
        let (scene, log) = (&self.scene, &self.log);
        let About {
            settings,
            spheres,
            table: mut about,
        } = scene.about();
        let threads = usize::from(self.options.threads);
        let (mut totals, updates, times) = (log.totals(), log.updates(), log.times());
        let (own_totals, own_found) = scene.totals(log);
        let (own_times, own_took) = scene.times(log);
        if let (Value::Object(totals), Value::Object(own)) = (&mut totals, own_totals) {
            totals.extend(own);
        }
        let number =
            |of: &Value, at: &str| of.pointer(at).and_then(Value::as_f64).unwrap_or(f64::NAN);
        about.extend(row! {
            "number" => scene.fallen(), "steps" => scene.world().steps(), "threads" => threads,
        });
        about.extend(cells(scene.spheres()));
        let mut found = row! {
            "events" => number(&totals, "/events/sum"), "per step" => number(&totals, "/events/mean"),
            "updated of all spheres, mean" => number(&updates, "/share/mean"),
            "most" => number(&updates, "/share/most"),
            "deepest, of the radius" => number(&totals, "/penetration_share"),
            "overlaps checked" => number(&totals, "/overlaps"), "missed" => number(&totals, "/missed"),
            "extra" => number(&totals, "/extra"),
        };
        found.extend(own_found);
        let mut took = row! {
            "s per step, mean" => number(&times, "/seconds_per_step"),
            "median" => number(&times, "/median_seconds_per_step"),
            "most" => number(&times, "/most_seconds_per_step"),
            "all, s" => number(&times, "/seconds"),
            "events per s" => number(&times, "/events_per_second"),
            "µs per event" => number(&times, "/microseconds_per_event"),
        };
        took.extend(own_took);
        let world = scene.world().options();
        let mut all_settings = json!({"bodies": scene.count(), "steps": self.steps,
            "seed": self.options.seed, "step_s": world.step_s, "stiffness": world.law.stiffness,
            "damping_ratio": world.law.damping_ratio, "friction": world.law.friction});
        if let (Value::Object(all), Value::Object(own)) = (&mut all_settings, settings) {
            all.extend(own);
        }
        let value = json!({
            "settings": all_settings, "spheres": spheres, "end": scene.world().steps(),
            "failure": failure, "totals": totals, "pictures": drawn, "updated_picture": own,
            // Of the machine and of the threads.
            "times": {"threads": threads, "steps": times, "phases": own_times, "updates": updates,
                "load": self.loads, "memory_bytes": self.memory_bytes},
        });
        Report {
            name: S::NAME,
            value,
            tables: vec![
                table("bodies", "Bodies", &[about]),
                table("contacts", "Contacts", &[found]),
                table("times", "Times", &[took]),
            ],
            pictures: Vec::new(),
        }
    }
}

/// Number and radii of contact spheres, as cells of a table.
fn cells(spheres: &LevelSpheres) -> crate::report::Row {
    let radii = spheres.radii();
    row! {
        "level" => spheres.level, "contact spheres each" => radii.len(),
        "mean radius, m" => mean(radii), "largest, m" => largest(radii),
    }
}

/// The same for the report, with the nodes of a body's tree and those of them down to the level.
pub(crate) fn told(spheres: &LevelSpheres, [nodes, to_level]: [usize; 2]) -> Value {
    let radii = spheres.radii();
    json!({"level": spheres.level, "count": radii.len(), "mean_radius_m": mean(radii),
        "largest_radius_m": largest(radii), "nodes": nodes, "nodes_to_level": to_level,
        "modes": spheres.mode_count()})
}

fn mean(radii: &[f64]) -> f64 {
    radii.iter().sum::<f64>() / radii.len() as f64
}

fn largest(radii: &[f64]) -> f64 {
    radii.iter().copied().fold(0.0, f64::max)
}
