//! An asset baked again with fewer modes or other leaves, and measured beside itself with all.

use std::borrow::Cow;

use bdtree_runtime::Model;
use serde::Serialize;

use super::AdviceError;
use super::errors::Over;
use super::samples::Samples;
use super::subject::Subject;
use super::works::{Contender, Measured, Refining, Works};
use crate::basis::BasisError;
use crate::basis::dropped::{error_of, select};
use crate::error::BakeError;
use crate::pipeline::{BakeSettings, Provenance, bake_fields, bake_skinned, default_leaf_size};
use crate::progress::{Progress, Silent};

/// Numbers of modes that a curve has at most.
pub const POINTS_MAX: usize = 12;

/// The least and the most rounds of a timing.
const ROUNDS: (usize, usize) = (5, 24);

/// What a setting is: modes that are kept (ascending, each below M), and most triangles in a leaf lane.
pub type Setting<'s> = (&'s [usize], usize);

/// One setting, baked and measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// The modes that are kept, by their numbers among all, ascending.
    pub modes: Vec<usize>,
    /// Most triangles in a leaf lane.
    pub leaf_size: usize,
    /// What these modes leave out ([`super::errors::Errors`]); `None` where the modes are not the first ones and
    /// nobody measured them.
    #[serde(rename = "error_rel")]
    pub error: Option<BasisError>,
    /// Length of the file, if its bake has the subject's warnings.
    pub bytes: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// What the works found and visited, and how long they took.
    #[serde(rename = "works")]
    pub measured: Measured,
    /// Time over that of the asset with all modes, in the same run ([`Measured::time_over`]).
    pub time_rel: f64,
}

impl Point {
    /// Share of the nodes that a ball of the works visits.
    pub fn ball_visits_share(&self) -> f64 {
        let ball = self.measured.ball;
        ball.nodes_visited as f64 / (ball.questions.max(1) * self.nodes.max(1) as u64) as f64
    }
}

/// The asset with all its modes, ready to be compared with.
pub struct Bench<'s> {
    subject: &'s Subject,
    file: Model,
    nodes: usize,
    /// The poses in which it is measured.
    pub samples: Samples,
    works: Works,
    rounds: usize,
}

impl<'s> Bench<'s> {
    /// Bakes the asset with all modes and makes its samples, at most `samples`, and questions. Timing one setting
    /// beside others takes about `seconds`, or five rounds of all questions if that is more.
    ///
    /// # Errors
    /// What the bake refuses, and what the file that it makes refuses.
    pub fn new(
        subject: &'s Subject,
        samples: usize,
        seconds: f64,
        progress: &dyn Progress,
    ) -> Result<Self, AdviceError> {
        let (file, nodes) = baked(subject, None, &subject.settings, progress)?;
        let asset = file.asset();
        let samples = Samples::of(asset, samples)?;
        let works = Works::new(asset, &samples)?;
        let contender = Contender {
            asset,
            samples: &samples,
        };
        let once = works.measure(&[contender], 1)?;
        let round: f64 = once
            .iter()
            .flat_map(Measured::works)
            .map(|(_, work)| (work.seconds * work.questions as f64).max(1e-3))
            .sum();
        let rounds = ((seconds / round) as usize).clamp(ROUNDS.0, ROUNDS.1);
        Ok(Self {
            subject,
            nodes,
            samples,
            works,
            rounds,
            file,
        })
    }

    /// The asset as it is and with each of `settings`, all measured in turn. Advances by two steps for each of them.
    ///
    /// # Errors
    /// What the bakes and queries refuse.
    pub fn points(
        &self,
        settings: &[Setting<'_>],
        progress: &dyn Progress,
    ) -> Result<(Point, Vec<Point>), AdviceError> {
        let mut files = Vec::with_capacity(settings.len());
        for &(modes, leaf_size) in settings {
            let settings = BakeSettings {
                leaf_size: Some(leaf_size),
                ..self.subject.settings.clone()
            };
            // One stage for all of them, not those of each bake.
            files.push(baked(self.subject, Some(modes), &settings, &Silent)?);
            progress.advance(1);
        }
        let whole: Vec<usize> = (0..self.subject.basis.mode_count()).collect();
        let mut all = vec![Contestant {
            file: &self.file,
            nodes: self.nodes,
            setting: (&whole, self.leaf_size()),
        }];
        all.extend(
            files
                .iter()
                .zip(settings)
                .map(|((file, nodes), &setting)| Contestant {
                    file,
                    nodes: *nodes,
                    setting,
                }),
        );
        let mut points = self.compare(&all)?.into_iter();
        progress.advance(settings.len() as u64);
        let whole = points.next().ok_or(AdviceError::NothingMeasured)?;
        Ok((whole, points.collect()))
    }

    /// Whether refined poses pay with a setting.
    ///
    /// # Errors
    /// What the bake and queries refuse.
    pub fn refining(&self, (modes, leaf_size): Setting<'_>) -> Result<Refining, AdviceError> {
        let settings = BakeSettings {
            leaf_size: Some(leaf_size),
            ..self.subject.settings.clone()
        };
        let (file, _) = baked(self.subject, Some(modes), &settings, &Silent)?;
        let samples = self.samples.select(modes);
        let refining = self.works.refining(Contender {
            asset: file.asset(),
            samples: &samples,
        });
        Ok(refining?)
    }

    /// The leaf size of the asset as it is.
    pub fn leaf_size(&self) -> usize {
        let own = self.subject.settings.leaf_size;
        own.unwrap_or_else(|| default_leaf_size(self.subject.mesh.triangles.len()))
    }

    /// Measures them in turn; times are over those of the first.
    fn compare(&self, all: &[Contestant<'_>]) -> Result<Vec<Point>, AdviceError> {
        let samples: Vec<Samples> = all
            .iter()
            .map(|one| self.samples.select(one.setting.0))
            .collect();
        let contenders: Vec<Contender<'_>> = all
            .iter()
            .zip(&samples)
            .map(|(one, samples)| Contender {
                asset: one.file.asset(),
                samples,
            })
            .collect();
        let measured = self.works.measure(&contenders, self.rounds)?;
        let first = measured.first().copied().unwrap_or_default();
        let point = |(one, measured): (&Contestant<'_>, Measured)| Point {
            modes: one.setting.0.to_vec(),
            leaf_size: one.setting.1,
            error: self.error(one.setting.0),
            bytes: one.file.asset().bytes().len(),
            nodes: one.nodes,
            measured,
            time_rel: measured.time_over(&first),
        };
        Ok(all.iter().zip(measured).map(point).collect())
    }

    fn error(&self, modes: &[usize]) -> Option<BasisError> {
        let are_first = modes.iter().enumerate().all(|(k, mode)| k == *mode);
        let errors = &self.subject.errors.of_first;
        errors.get(modes.len()).copied().filter(|_| are_first)
    }
}

/// A file that was baked, to be measured.
struct Contestant<'f> {
    file: &'f Model,
    nodes: usize,
    setting: Setting<'f>,
}

/// The file with `modes` (`None`: all) and its number of nodes.
fn baked(
    subject: &Subject,
    modes: Option<&[usize]>,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<(Model, usize), AdviceError> {
    let fewer;
    let mut skin = Cow::Borrowed(&subject.skin);
    let basis = match modes {
        Some(modes) if modes.len() < subject.basis.mode_count() => {
            fewer = select(&subject.basis, modes);
            if let Some(skin) = skin.to_mut() {
                // Clips move what is left.
                skin.keep_targets(modes);
            }
            &fewer
        }
        _ => &subject.basis,
    };
    let provenance = provenance(subject, modes, settings)?;
    let mesh = &subject.mesh;
    let baked = match skin.as_ref() {
        Some(skin) => bake_skinned(mesh, basis, skin, settings, &provenance, progress)?,
        None => bake_fields(mesh, basis, settings, &provenance, progress)?,
    };
    Ok((Model::from_bytes(&baked.bytes)?, baked.report.nodes))
}

/// What the metadata of the file with `modes` say, so that it is as long as that of a bake which is asked for them. Only
/// warnings may be others: here they are those of the subject.
fn provenance(
    subject: &Subject,
    modes: Option<&[usize]>,
    settings: &BakeSettings,
) -> Result<Provenance, BakeError> {
    let (mesh, basis) = (&subject.mesh, &subject.basis);
    let mut own = subject.provenance.clone();
    let all = basis.mode_count();
    let count = modes.map_or(all, <[usize]>::len);
    let stated = [
        ("modes", count),
        ("leaf-size", settings.leaf_size_for(mesh)),
    ];
    for (name, value) in stated {
        if own.settings.contains_key(name) {
            own.set(name, value);
        }
    }
    let are_fields = matches!(own.kind.as_str(), "given" | "morph");
    match modes {
        Some(modes) if count < all && are_fields => {
            own.error = Some(error_of(mesh, basis, modes)?);
        }
        _ if subject.errors.over == Over::Source => {
            own.error = subject.errors.of_first.get(count).copied();
        }
        _ => {}
    }
    Ok(own)
}

/// At most `most` numbers of modes from 1 to `all`: powers of two and halves between, `all`, and `wanted`.
pub fn counts(all: usize, wanted: usize, most: usize) -> Vec<usize> {
    let steps = (0..usize::BITS - 1).flat_map(|e| [1 << e, 3 << e]);
    let mut counts: Vec<usize> = steps.filter(|&k| k < all && k != wanted).collect();
    counts.sort_unstable();
    // Thinned out evenly.
    let (room, len) = (most.saturating_sub(2), counts.len());
    if len > room {
        let place = |i: usize| (i * len + len / 2) / room;
        counts = (0..room).map(|i| counts[place(i)]).collect();
    }
    counts.extend([all, wanted]);
    counts.sort_unstable();
    counts.dedup();
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_hold_all_and_what_is_wanted() {
        assert_eq!(counts(0, 0, 12), [0]);
        assert_eq!(counts(1, 0, 12), [0, 1]);
        assert_eq!(counts(10, 5, 12), [1, 2, 3, 4, 5, 6, 8, 10]);
        for (all, wanted) in [(512, 100), (512, 512), (33, 7), (40, 0)] {
            for most in [2, 3, 6, 12] {
                let counts = counts(all, wanted, most);
                assert!(counts.len() <= most, "{counts:?}");
                assert!(counts.contains(&all) && counts.contains(&wanted));
                assert!(counts.windows(2).all(|pair| pair[0] < pair[1]));
            }
        }
    }
}
