//! All measurements, in order.

use std::ops::ControlFlow;
use std::time::Instant;

use bdtree_baselines::machine;
use bdtree_build::advise::samples::{SAMPLES, Samples, Source};
use bdtree_build::advise::works::BALL_RADIUS_REL;
use bdtree_runtime::Asset;

use super::content::{self, Content, Facts, Machine, Margin, Parts, Seconds};
use super::sample::{SMALL_BALL, Sample};
use super::{REPETITIONS, advice, contest, depth, modes, problem, sections, tightness, tolerance};
use crate::AssetFile;
use crate::error::ToolError;
use crate::info::Info;
use crate::stress;

/// Meshes of more triangles get fewer samples of what looks at all vertices.
const LARGE_TRIANGLES: usize = 100_000;

/// Directions of q that tightness is measured along.
const DIRECTIONS: usize = 8;

/// Nodes at a q of which margins are tried; fewer for large meshes, whose nodes have many vertices.
const MARGIN_CASES: u64 = 100_000;

/// Measures an asset; `verify`: checksums are checked too.
///
/// # Errors
/// The first rule of the format that the file breaks.
pub fn measure(file: &AssetFile, verify: bool) -> Result<Content, ToolError> {
    // What the parts complain of is the file's.
    content(file, verify).map_err(|error| match error {
        ToolError::Input(lines) => {
            let path = file.path().display();
            ToolError::Input(lines.iter().map(|l| format!("{path}: {l}")).collect())
        }
        other => other,
    })
}

fn content(file: &AssetFile, verify: bool) -> Result<Content, ToolError> {
    let mut seconds = Clockwork::default();
    let asset = file.checked_asset(verify)?;
    // Measuring follows every record, so all of them are checked, unless that is refused.
    let mut broken = None;
    if verify {
        asset.verify(&mut |error| {
            broken = Some(error);
            ControlFlow::Break(())
        });
    }
    if let Some(error) = broken {
        return Err(file.error(error));
    }
    let info = Info::of(file)?;
    seconds.lap("check");
    let bounds = bounds(&asset);
    let diagonal = length([0, 1, 2].map(|k| bounds[1][k] - bounds[0][k]));
    let samples = Samples::of(&asset, SAMPLES);
    let mut missing = missing(&asset, &samples);
    let described = described(&asset, &samples, diagonal)?;
    let asked = Sample::all(&asset, &samples, bounds)?;
    let few = few(&asked, &asset);
    let (depth_whole, depth) = depth::depth(&asset, few, diagonal)?;
    let mut content = Content {
        file: name(file),
        asset: Facts {
            vertices: info.vertices,
            triangles: info.triangles,
            modes: info.modes,
            nodes: info.nodes,
            depth: info.depth,
            frames: info.frames,
            bytes: info.bytes,
            diagonal,
            basis_error_rel: info.basis_error_rel.map(|e| e.max),
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
        depth_whole,
        depth,
        tolerance: Vec::new(),
        tightness: Vec::new(),
        margin: None,
        refit: None,
        sections: sections::sections(&asset),
        unneeded: sections::unneeded(&asset),
        seconds: Vec::new(),
    };
    content.samples.of_parts.depth = few.len();
    seconds.lap("depth");
    if samples.source() != Source::Rest {
        let found = modes::modes(&asset, diagonal)?;
        content.modes = found.rows;
        content.modes_over = Some(found.over);
        content.advice.extend(found.advice);
        seconds.lap("modes");
        content.tolerance = tolerance::tolerance(&asset, &asked, diagonal)?;
        seconds.lap("tolerance");
        let step = samples.len().div_ceil(DIRECTIONS).max(1);
        let directions: Vec<Vec<f32>> = (0..samples.len())
            .step_by(step)
            .map(|k| samples.q(k).to_vec())
            .collect();
        content.tightness = tightness::tightness(&asset, &directions, diagonal)?;
        seconds.lap("tightness");
        content.samples.of_parts = Parts {
            modes: found.samples,
            depth: few.len(),
            tolerance: asked.len(),
            tightness: directions.len(),
            refit: contest::steps(&asked).count(),
        };
        content.refit = Some(contest::contest(&asset, &asked)?);
        seconds.lap("refit");
        content.margin = Some(margin(&asset)?);
        seconds.lap("margins");
    }
    content.missing.append(&mut missing);
    content.advice.extend(advice::advice(&content));
    content.seconds = seconds.laps;
    Ok(content)
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

fn margin(asset: &Asset<'_>) -> Result<Margin, ToolError> {
    let large = (asset.triangle_count() / LARGE_TRIANGLES) as u64;
    let options = stress::Options {
        cases: MARGIN_CASES / (1 + 4 * large),
        seed: 0,
    };
    let report = stress::run(asset, options, &|_| ()).map_err(problem)?;
    let certainty = stress::certainty(asset, options.seed).map_err(problem)?;
    let tightest = report.tightest.as_ref();
    Ok(Margin {
        cases: report.cases,
        violations: report.violations.len(),
        least: tightest
            .map(stress::Tight::margin)
            .filter(|m| m.is_finite()),
        certainty_rel: Some(certainty).filter(|c| c.is_finite()),
    })
}

/// What a report cannot say of the asset.
fn missing(asset: &Asset<'_>, samples: &Samples) -> Vec<String> {
    let mut missing = Vec::new();
    if asset.mode_count() == 0 {
        missing.push(
            "The asset is rigid: it has no modes, so there is nothing to say of modes, tolerance, tightness, \
             refitting and margins."
                .to_string(),
        );
    } else if samples.source() == Source::Rest {
        missing.push(
            "No mode moves anything within its q_range, and there is no animation: nothing to say of modes, \
             tolerance, tightness, refitting and margins."
                .to_string(),
        );
    } else if !samples.still().is_empty() {
        let numbers: Vec<String> = samples.still().iter().map(usize::to_string).collect();
        missing.push(format!(
            "Modes {} move nothing within their q_range: what they do beyond it is not in this report.",
            numbers.join(", ")
        ));
    }
    if samples.source() == Source::Ranges {
        let none = match asset.frame_count() {
            0 => "The asset has no animation",
            _ => "The asset's animation moves nothing",
        };
        missing.push(format!(
            "{none}: samples are mixtures within ± q_range, which may be more or less than \
             what a scene does."
        ));
    }
    missing
}

fn described(
    asset: &Asset<'_>,
    samples: &Samples,
    diagonal: f64,
) -> Result<content::Samples, ToolError> {
    let mut most = 0.0_f64;
    for k in 0..samples.len() {
        let far = tightness::farthest(asset, samples.q(k)).map_err(problem)?;
        most = most.max(far * asset.unit());
    }
    let count = samples.len();
    let source = match samples.source() {
        Source::Frames => format!("{count} frames of the animation"),
        Source::Ranges => format!("{count} mixtures of all modes within ± q_range"),
        Source::Rest => "the rest pose".to_string(),
    };
    Ok(content::Samples {
        count,
        source,
        displacement_max_rel: if diagonal > 0.0 { most / diagonal } else { 0.0 },
        of_parts: Parts::default(),
        balls: content::Balls {
            large_rel: BALL_RADIUS_REL,
            small_rel: SMALL_BALL * BALL_RADIUS_REL,
        },
    })
}

fn name(file: &AssetFile) -> String {
    let path = file.path();
    let name = path.file_name().unwrap_or(path.as_os_str());
    crate::output::printable(&name.to_string_lossy())
}

/// The box of the vertices that triangles use, at rest (mesh units).
fn bounds(asset: &Asset<'_>) -> [[f64; 3]; 2] {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    let corners = asset.triangles().iter().flat_map(|t| t.corners);
    for p in corners.filter_map(|v| asset.positions().get(v as usize)) {
        for k in 0..3 {
            let x = asset.origin()[k] + asset.unit() * f64::from(p[k]);
            low[k] = low[k].min(x);
            high[k] = high[k].max(x);
        }
    }
    [low, high]
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Times of parts.
struct Clockwork {
    last: Instant,
    laps: Vec<Seconds>,
}

impl Default for Clockwork {
    fn default() -> Self {
        Self {
            last: Instant::now(),
            laps: Vec::new(),
        }
    }
}

impl Clockwork {
    /// Ends a part.
    fn lap(&mut self, part: &str) {
        self.laps.push(Seconds {
            part: part.to_string(),
            seconds: self.last.elapsed().as_secs_f64(),
        });
        self.last = Instant::now();
    }
}
