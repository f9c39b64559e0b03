//! What fewer modes cost and save: the builder's own measurements (`bdtree-build --advise`), as rows.

use bdtree_build::advise::choose::{Goal, advise};
use bdtree_build::advise::curve::{POINTS_MAX, Point};
use bdtree_build::advise::errors::Over;
use bdtree_build::advise::subject::{Subject, kept_fields};
use bdtree_build::advise::works::Work;
use bdtree_build::progress::Progress;
use bdtree_format::Metadata;
use bdtree_runtime::Asset;

use super::content::{Advice, ModesAdvised, ModesRow};
use super::made;
use crate::MeasureError;

/// Meshes of more triangles are baked less often, and measured at fewer samples.
const LARGE_TRIANGLES: usize = 50_000;

/// Fewer modes.
pub(super) struct Modes {
    /// By rising number of modes.
    pub(super) rows: Vec<ModesRow>,
    /// What they advise.
    pub(super) advice: Vec<Advice>,
    /// Which q errors are taken over, in words; `None` without modes.
    pub(super) over: Option<String>,
    /// The advised modes where they are not the first ones, as those of the rows are.
    pub(super) advised: Option<ModesAdvised>,
    /// Options of `bdtree-build` that follow it; `None` where the file is as advised.
    pub(super) options: Option<Vec<String>>,
    /// Samples of visits and times.
    pub(super) samples: usize,
}

/// Stages of the advice and of its bakes, in words for whoever waits for a report.
struct Parts<'a>(&'a dyn Progress);

impl Progress for Parts<'_> {
    fn stage(&self, name: &str, steps: Option<u64>) {
        match name {
            "leaf sizes" | "fewer modes" => self.0.stage(&format!("measuring {name}"), steps),
            // Stages of a bake.
            _ => self.0.stage("baking for comparison", steps),
        }
    }

    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }
}

/// Bakes with fewer modes and asks; where bones alone move the asset, with other leaves only.
pub(super) fn modes(asset: &Asset<'_>, progress: &dyn Progress) -> Result<Modes, MeasureError> {
    let subject = Subject::of_asset(asset)?;
    // That which errors are relative to: before bones carry the vertices.
    let diagonal = subject.mesh.diagonal();
    let is_large = asset.triangle_count() > LARGE_TRIANGLES;
    let mut goal = Goal {
        curve_points: match (asset.mode_count(), is_large) {
            (0, _) => 0,
            (_, true) => POINTS_MAX / 3,
            (_, false) => POINTS_MAX,
        },
        // The report measures that itself, beside deform + refit.
        refines: false,
        ..Goal::default()
    };
    if is_large {
        goal.samples /= 4;
    }
    let kind = Metadata::from_bytes(asset.metadata()).map_or(String::new(), |m| m.basis);
    goal.subset = kept_fields(&kind, &subject.mesh, &subject.basis, goal.max_error_rel);
    let advice = advise(&subject, &goal, &Parts(progress))?;
    let sentences = advice.sentences().into_iter().map(|text| Advice {
        topic: "modes".to_string(),
        text,
    });
    let all = asset.mode_count();
    let rows = advice.curve.iter().map(|point| row(point, all, diagonal));
    let mut over = match subject.errors.over {
        Over::Source | Over::Frames => format!("all {} frames", advice.frames),
        Over::Ranges => "every q within ± q_range, as an upper bound".to_string(),
    };
    if asset.has_skin() {
        over += ", before bones carry the vertices";
    }
    Ok(Modes {
        rows: rows.collect(),
        advice: sentences.collect(),
        advised: (!advice.takes_first).then(|| ModesAdvised {
            modes: advice.chosen.modes.clone(),
            error_max_rel: advice.error_rel,
        }),
        options: made::options(&advice),
        over: (asset.mode_count() > 0).then_some(over),
        samples: advice.samples.1,
    })
}

fn row(point: &Point, all: usize, diagonal: f64) -> ModesRow {
    // All points of the curve keep the first modes, of which all errors are known.
    let [max, rms] = point
        .error
        .map_or([f64::NAN; 2], |error| [error.max_rel, error.rms_rel]);
    let micros = |work: Work| 1e6 * work.seconds;
    let visits = |work: Work| work.nodes_visited as f64 / work.questions.max(1) as f64;
    let measured = point.measured;
    ModesRow {
        modes: point.modes.len(),
        error_max: max * diagonal,
        error_rms: rms * diagonal,
        error_max_rel: max,
        error_rms_rel: rms,
        bytes: point.bytes as u64,
        ball_visits: visits(measured.ball),
        ray_visits: visits(measured.ray),
        pair_visits: visits(measured.pair),
        ball_micros: micros(measured.ball),
        ray_micros: micros(measured.ray),
        pair_micros: micros(measured.pair),
        // The asset beside itself: what differs is noise.
        time_rel: match point.modes.len() == all {
            true => 1.0,
            false => point.time_rel,
        },
    }
}
