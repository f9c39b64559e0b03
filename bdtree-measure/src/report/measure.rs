//! All measurements, in order.

use std::time::Instant;

use crate::MeasureError;
use crate::machine;
use crate::vector::distance;
use bdtree_build::advise::AdviceError;
use bdtree_build::advise::samples::{SAMPLES, Samples, Source};
use bdtree_build::advise::works::{BALL_RADIUS_REL, at_rest};
use bdtree_build::progress::Progress;
use bdtree_runtime::{Asset, FormatError, VertexId};

use super::content::{self, Content, Facts, Machine, Margin, Parts, Seconds};
use super::{
    REPETITIONS, advice, comparison, depth, made, modes, poses, sections, tightness, verdict,
};
use crate::sample::{HERE, SMALL_BALL, Sample, bounds_at_rest};

/// Meshes of more triangles get fewer samples of what looks at all vertices.
const LARGE_TRIANGLES: usize = 100_000;

/// Samples that tightness is measured at.
const DIRECTIONS: usize = 8;

/// Nodes at a q of which margins are tried; fewer for large meshes, whose nodes have many vertices.
const MARGIN_CASES: u64 = 100_000;

/// Tries so many nodes of an asset; tells how many it has tried since it last told.
pub type Margins<'a> =
    dyn Fn(&Asset<'_>, u64, &(dyn Fn(u64) + Sync)) -> Result<Margin, FormatError> + 'a;

/// What is known of an asset besides its bytes.
pub struct Subject<'a> {
    /// The file's name, as the report shows it.
    pub name: String,
    /// The path of its source, where it is known.
    pub input: Option<String>,
    /// Where a bake as advised goes.
    pub advised: String,
    /// Largest error of the basis against its source over the diagonal; `None` where there is no source.
    pub basis_error_rel: Option<f64>,
    /// The day, UTC, as 2026-01-31.
    pub date: String,
    /// Seconds that checking the file took.
    pub check_seconds: f64,
    /// Tries so many nodes at q that are made to break their bounds.
    pub margin: &'a Margins<'a>,
}

/// Measures an asset whose records were checked: measuring follows every one of them.
///
/// # Errors
/// The first rule of the format that the asset breaks, a bake with fewer modes that is refused.
pub fn measure(
    asset: &Asset<'_>,
    subject: &Subject<'_>,
    progress: &(dyn Progress + Sync),
) -> Result<Content, MeasureError> {
    let mut seconds = Clockwork::new(subject.check_seconds);
    let bounds = bounds_at_rest(asset)?;
    let diagonal = distance(bounds[1], bounds[0]);
    let samples = Samples::of(asset, SAMPLES)?;
    let mut missing = poses::missing(asset, &samples);
    let asked = Sample::all(asset, &samples, bounds)?;
    let described = described(asset, &samples, &asked, diagonal)?;
    let few = few(&asked, asset);
    let (depth_whole, depth) = depth::depth(asset, few, diagonal, progress)?;
    let mut content = Content {
        file: subject.name.clone(),
        date: subject.date.clone(),
        made: made::made(asset),
        verdict: Vec::new(),
        asset: Facts {
            vertices: asset.vertex_count(),
            triangles: asset.triangle_count(),
            modes: asset.mode_count(),
            nodes: asset.node_count(),
            depth: asset.depth(),
            frames: Some(asset.frame_count()).filter(|count| *count > 0),
            skin: skin(asset),
            bytes: asset.header().file_bytes.get(),
            size: [0, 1, 2].map(|k| bounds[1][k] - bounds[0][k]),
            diagonal,
            basis_error_rel: subject.basis_error_rel,
        },
        machine: Machine {
            processor: machine::processor(),
            kernel: format!("{:?}", asset.kernel()),
            repetitions: REPETITIONS,
        },
        samples: described,
        missing: Vec::new(),
        advice: Vec::new(),
        modes: Vec::new(),
        modes_over: None,
        modes_advised: None,
        depth_whole,
        depth,
        tightness: Vec::new(),
        margin: None,
        refit: None,
        sections: sections::sections(asset),
        unneeded: sections::unneeded(asset),
        seconds: Vec::new(),
    };
    content.samples.of_parts.depth = few.len();
    seconds.lap("depth");
    let moves = samples.source != Source::Rest || asset.has_skin();
    if moves {
        match modes::modes(asset, progress) {
            Ok(found) => take_modes(&mut content, found, subject),
            // Skins may be sound and yet none that a bake makes: with channels that share their keys, say.
            Err(MeasureError::Advice(AdviceError::Bake(error))) if asset.has_skin() => {
                missing.push(format!(
                    "Fewer modes and other leaves are not measured: {error}."
                ));
            }
            Err(error) => return Err(error),
        }
        seconds.lap("modes");
    }
    if moves {
        let step = samples.count.div_ceil(DIRECTIONS).max(1);
        let directions: Vec<&Sample> = asked.iter().step_by(step).collect();
        content.tightness = tightness::tightness(asset, &directions, diagonal, progress)?;
        seconds.lap("tightness");
        content.samples.of_parts.tightness = directions.len();
        content.samples.of_parts.refit = comparison::steps(&asked).count();
        content.refit = Some(comparison::compare(asset, &asked, progress)?);
        seconds.lap("refit");
        let cases = margin_cases(asset);
        progress.stage("measuring margins", Some(cases));
        let told = |cases| progress.advance(cases);
        content.margin = Some((subject.margin)(asset, cases, &told)?);
        seconds.lap("margins");
    }
    content.missing.append(&mut missing);
    content.advice.extend(advice::advice(&content));
    content.verdict = verdict::verdict(&content);
    content.seconds = seconds.laps;
    Ok(content)
}

/// What was measured of fewer modes.
fn take_modes(content: &mut Content, found: modes::Modes, subject: &Subject<'_>) {
    content.samples.of_parts.modes = found.samples;
    content.modes = found.rows;
    content.modes_over = found.over;
    content.modes_advised = found.advised;
    content.advice.extend(found.advice);
    let options = found.options.unwrap_or_default();
    let is_as_advised = made::has(&content.made, &options);
    content.made.is_as_advised = Some(is_as_advised);
    if !is_as_advised {
        let (input, output) = (subject.input.as_deref(), &subject.advised);
        content.made.command = made::command(&content.made, &options, input, output);
    }
}

/// Fewer of them for large meshes.
fn few<'a>(samples: &'a [Sample], asset: &Asset<'_>) -> &'a [Sample] {
    let most = if asset.triangle_count() > LARGE_TRIANGLES {
        6
    } else {
        samples.len()
    };
    &samples[..most.min(samples.len())]
}

fn margin_cases(asset: &Asset<'_>) -> u64 {
    let large = (asset.triangle_count() / LARGE_TRIANGLES) as u64;
    MARGIN_CASES / (1 + 4 * large)
}

fn skin(asset: &Asset<'_>) -> Option<content::Skin> {
    let (record, skeleton) = (asset.skin_record()?, asset.skeleton()?);
    Some(content::Skin {
        joints: asset.joint_count(),
        bones: asset.bone_count(),
        clips: skeleton.clip_count(),
        influences_max: record.influences_max as usize,
    })
}

fn described(
    asset: &Asset<'_>,
    samples: &Samples,
    asked: &[Sample],
    diagonal: f64,
) -> Result<content::Samples, MeasureError> {
    let mut most = 0.0_f64;
    for sample in asked {
        let far = match asset.has_skin() {
            true => carried_farthest(asset, sample)?,
            false => tightness::farthest(asset, &sample.q)?,
        };
        most = most.max(far * asset.unit());
    }
    Ok(content::Samples {
        count: samples.count,
        source: poses::source(asset, samples),
        displacement_max_rel: if diagonal > 0.0 { most / diagonal } else { 0.0 },
        of_parts: Parts::default(),
        balls: content::Balls {
            large_rel: BALL_RADIUS_REL,
            small_rel: SMALL_BALL * BALL_RADIUS_REL,
        },
    })
}

/// How far fields and bones move a vertex from where it rests, at most (stored units).
fn carried_farthest(asset: &Asset<'_>, sample: &Sample) -> Result<f64, MeasureError> {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = sample.pose(asset, HERE, &mut memory)?;
    let mut most = 0.0_f64;
    for (vertex, rest) in (0..).map(VertexId).zip(at_rest(asset)?.iter()) {
        let [p, rest] = [pose.deformed_stored(vertex)?, *rest].map(|p| p.map(f64::from));
        most = most.max(distance(p, rest));
    }
    Ok(most)
}

/// Times of parts.
struct Clockwork {
    last: Instant,
    laps: Vec<Seconds>,
}

impl Clockwork {
    /// After the check, which took so many seconds.
    fn new(check: f64) -> Self {
        Self {
            last: Instant::now(),
            laps: vec![Seconds {
                part: "check".to_string(),
                seconds: check,
            }],
        }
    }

    /// Ends a part.
    fn lap(&mut self, part: &str) {
        self.laps.push(Seconds {
            part: part.to_string(),
            seconds: self.last.elapsed().as_secs_f64(),
        });
        self.last = Instant::now();
    }
}
