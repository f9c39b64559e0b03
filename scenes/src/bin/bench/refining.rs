//! How often a step must ask until refining its pose pays, and what a step cache that decides by itself costs beside the
//! better of both ways.

use std::fs;
use std::path::PathBuf;

use bdtree_build::advise::samples::{SAMPLES, Samples};
use bdtree_measure::MeasureError;
use bdtree_measure::plot::{Axis, Line, Plot, sheet};
use bdtree_measure::sample::{HERE, SMALL_BALL, Sample, bounds_at_rest};
use bdtree_measure::turns::{self, Rounds, Turns};
use bdtree_runtime::{
    Ball, CacheSize, PairContact, Query, QueryError, Ray, RefinedPose, StepCache,
};
use bdtree_scenes::contenders::assets::baked;
use bdtree_scenes::workloads::{characters, rays};

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Assets to ask [default: W3's bodies and W5's characters]
    #[arg(value_name = "FILE.bdt")]
    files: Vec<PathBuf>,
    /// Questions per step; of pairs, as many as it takes at most
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1,8,64,256,1024,4096,16384,100000"
    )]
    counts: Vec<usize>,
    /// Most steps of each run
    #[arg(long, default_value_t = 30)]
    steps: usize,
    /// Most questions of a run, of which pairs count as a hundred: with more, it has fewer steps, but at least three
    #[arg(long, default_value_t = 100_000)]
    questions: usize,
    /// Only questions whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Ask about this share of the surface alone, about one point, with rays from one place
    #[arg(long, value_name = "SHARE", value_parser = share)]
    near: Option<f64>,
    /// Where a plot of the curves goes
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

/// What a step asks, near the surface of a body and along rays towards it.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    IsTouched,
    Contacts,
    Project,
    CastRay,
    Pair,
}

const KINDS: [(&str, Kind); 5] = [
    ("intersects, small ball", Kind::IsTouched),
    ("contacts, small ball", Kind::Contacts),
    ("project_point", Kind::Project),
    ("cast_ray", Kind::CastRay),
    ("contacts of a pair", Kind::Pair),
];

/// Pairs of a step: some hundreds of neighbours are more than bodies have.
const PAIRS_MAX: usize = 256;

/// A pair's part of a run's questions.
const OF_PAIR: usize = 100;

/// How far from the surface balls and points are, of the way to where rays begin: most balls are touched.
const NEAR: f64 = 0.01;

/// Points near the surface from which those about one of them are taken.
const POOL: usize = 32_768;

fn share(text: &str) -> std::result::Result<f64, String> {
    match text.parse() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err("not above 0 and at most 1".into()),
    }
}

/// An asset and the poses in which it is asked.
struct Body {
    name: String,
    model: Model,
    samples: Vec<Sample>,
    /// For each of them the points that are asked about, if these are not all over it.
    near: Option<Vec<Vec<[f64; 3]>>>,
}

impl Body {
    fn new(name: String, model: Model, share: Option<f64>) -> Result<Self> {
        let asset = model.asset();
        let samples = Samples::of(asset, SAMPLES)?;
        let samples = Sample::all(asset, &samples, bounds_at_rest(asset)?)?;
        let near = share.map(|share| samples.iter().map(|sample| near(sample, share)).collect());
        Ok(Self {
            name,
            model,
            samples,
            near,
        })
    }
}

/// This share of the points near the surface: those nearest to the first one.
fn near(sample: &Sample, share: f64) -> Vec<[f64; 3]> {
    let mut points: Vec<[f64; 3]> = sample.points(POOL, NEAR).collect();
    let from = points[0];
    let far = |point: &[f64; 3]| -> f64 { (0..3).map(|k| (point[k] - from[k]).powi(2)).sum() };
    let mut distances: Vec<f64> = points.iter().map(far).collect();
    distances.sort_by(f64::total_cmp);
    let most = distances[(share * (POOL - 1) as f64) as usize];
    points.retain(|point| far(point) <= most);
    points
}

fn bodies(files: &[PathBuf], share: Option<f64>) -> Result<Vec<Body>> {
    let mut bodies = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let model = Model::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
        bodies.push(Body::new(name.into_owned(), model, share)?);
    }
    if files.is_empty() {
        for (name, n) in rays::SIZES {
            let model = baked(&rays::rays(name, n).body)?;
            bodies.push(Body::new(name.into(), model, share)?);
        }
        for (name, size) in characters::SIZES {
            let character = characters::character(name, size)?;
            bodies.push(Body::new(name.into(), character.model, share)?);
        }
    }
    Ok(bodies)
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let (mut all, mut curves) = (Vec::new(), Vec::new());
    for body in bodies(&arguments.files, arguments.near)? {
        for (question, kind) in KINDS {
            if !question.contains(&arguments.only) {
                continue;
            }
            let mut points = Vec::new();
            for &count in &arguments.counts {
                if kind == Kind::Pair && count > PAIRS_MAX {
                    continue;
                }
                let each = if kind == Kind::Pair { OF_PAIR } else { 1 };
                let steps = arguments.questions / (each * count.max(1));
                let steps = steps.clamp(3, arguments.steps.max(3));
                let run = Run {
                    body: &body,
                    kind,
                    count,
                    steps,
                };
                let about = row! {"body" => body.name.as_str(), "triangles" => body.model.asset().triangle_count(),
                "question" => question, "per step" => count};
                // One after the other: what refines every pose empties the near caches of those who do not.
                let of_run = Rounds {
                    repeats: rounds,
                    turns: Turns::Contender,
                    with: &[],
                };
                let measured = turns::compare(run.entries(), &[0], of_run)?;
                // The least of each: a burst of other work falls on the turns of one.
                let of = |k: usize| measured[k].floor[TOTAL];
                let better = of(0).min(of(1));
                points.push((count as f64, of(2) / better));
                for row in &measured {
                    let mut cells = about.clone();
                    cells.extend(row! {
                        "contender" => row.name.as_str(),
                        "µs per step" => 1e6 * row.median[TOTAL] / steps as f64,
                        "floor" => 1e6 * row.floor[TOTAL] / steps as f64,
                        "floor to the better's" => row.floor[TOTAL] / better,
                    });
                    all.push(cells);
                }
            }
            curves.push(Curve {
                question,
                body: body.name.clone(),
                points,
            });
        }
    }
    if let Some(path) = &arguments.plot {
        fs::write(path, picture(&curves)?).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    let title = "Steps that ask alike; preparing included";
    Ok(vec![table("refining", title, &all)])
}

/// How much longer a body's steps take by themselves than in the better way, over the questions per step.
struct Curve {
    question: &'static str,
    body: String,
    points: Vec<(f64, f64)>,
}

/// Lines of a plot that can be told from each other.
const LINES_MAX: usize = 6;

/// A plot for each question, a line for each body; a second one beside it where there are too many.
fn picture(curves: &[Curve]) -> Result<String> {
    let mut plots = Vec::new();
    for (title, _) in KINDS {
        let its: Vec<&Curve> = curves.iter().filter(|c| c.question == title).collect();
        for part in its.chunks(LINES_MAX) {
            let line = |curve: &&Curve| Line {
                name: curve.body.clone(),
                points: curve.points.clone(),
            };
            plots.push(Plot {
                title: title.into(),
                x: Axis::log("questions per step"),
                y: Axis::from("time to the better way's", 0.5).to(1.5),
                lines: part.iter().map(line).collect(),
                mark: None,
            });
        }
    }
    Ok(sheet(&plots)?)
}

/// Who decides whether poses are refined.
#[derive(Clone, Copy)]
enum Way {
    Never,
    Always,
    ByItself,
}

/// Steps that ask so many questions each.
struct Run<'a> {
    body: &'a Body,
    kind: Kind,
    count: usize,
    steps: usize,
}

/// What questions are asked in.
struct Own {
    workspace: Workspace<'static>,
    refined: RefinedPose<'static>,
    /// They keep nothing: beginning a step with one takes some microseconds, and that is what all pay.
    caches: [StepCache<'static>; 2],
    found: Vec<Contact>,
    touching: Vec<PairContact>,
}

impl Run<'_> {
    fn entries(&self) -> Vec<Entry<'_>> {
        let ways = [
            ("spheres", Way::Never),
            ("refined", Way::Always),
            ("refined by itself", Way::ByItself),
        ];
        ways.map(|(name, way)| self.entry(name, way)).into()
    }

    fn entry(&self, name: &'static str, way: Way) -> Entry<'_> {
        let cache = || match way {
            Way::ByItself => StepCache::new(CacheSize::NONE).refining(RefinedPose::new()),
            Way::Never | Way::Always => StepCache::new(CacheSize::NONE),
        };
        let mut own = Own {
            workspace: Workspace::new(),
            refined: RefinedPose::new(),
            caches: [cache(), cache()],
            found: Vec::new(),
            touching: Vec::new(),
        };
        Entry::new(name, Role::Ours, Counts::Same, move |_| {
            frame(|| {
                let mut answer = Answer::default();
                let samples = self.body.samples.iter().enumerate().cycle();
                for (number, sample) in samples.take(self.steps) {
                    match self.kind {
                        Kind::Pair => self.pairs(sample, way, &mut own, &mut answer)?,
                        _ => self.step((number, sample), way, &mut own, &mut answer)?,
                    }
                }
                Ok(answer)
            })
        })
    }

    /// A step of questions at one body.
    fn step(
        &self,
        (number, sample): (usize, &Sample),
        way: Way,
        own: &mut Own,
        answer: &mut Answer,
    ) -> std::result::Result<(), MeasureError> {
        let asset = self.body.model.asset();
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = sample.pose(asset, HERE, &mut memory)?;
        let near = self.body.near.as_ref().map(|near| &near[number]);
        let near = near.map(|points| points.iter().cycle().take(self.count));
        let [cache, _] = &mut own.caches;
        cache.start(&pose);
        let mut query = pose.query(&mut own.workspace).cached(cache);
        if let Way::Always = way {
            own.refined.prepare(&pose)?;
            query = query.refined(&own.refined);
        }
        if self.kind == Kind::CastRay {
            let rays: Vec<Ray> = match near {
                Some(near) => {
                    let from = sample.rays(1).next().map_or([0.0; 3], |[origin, _]| origin);
                    near.map(|to| Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k])))
                        .collect()
                }
                None => (sample.rays(self.count))
                    .map(|[origin, direction]| Ray::new(origin, direction))
                    .collect(),
            };
            for ray in rays {
                let hit = query.cast_ray(&ray)?;
                answer.found += u64::from(hit.is_some());
                answer.nodes.add(query.stats());
            }
            return Ok(());
        }
        let radius = SMALL_BALL * sample.ball.1;
        let points: Vec<[f64; 3]> = match near {
            Some(near) => near.copied().collect(),
            None => sample.points(self.count, NEAR).collect(),
        };
        for point in points {
            answer.found += self.at(point, radius, &mut query, &mut own.found)?;
            answer.nodes.add(query.stats());
        }
        Ok(())
    }

    /// A question about a point.
    fn at(
        &self,
        point: [f64; 3],
        radius: f64,
        query: &mut Query<'_, '_>,
        found: &mut Vec<Contact>,
    ) -> std::result::Result<u64, QueryError> {
        Ok(match self.kind {
            Kind::IsTouched => u64::from(query.intersects(Ball::new(point, radius))?),
            Kind::Contacts => {
                found.clear();
                query.contacts(Ball::new(point, radius), found)?;
                found.len() as u64
            }
            _ => u64::from(query.project_point(point, f64::INFINITY)?.is_some()),
        })
    }

    /// A step of pairs of a body and others like it around it.
    fn pairs(
        &self,
        sample: &Sample,
        way: Way,
        own: &mut Own,
        answer: &mut Answer,
    ) -> std::result::Result<(), MeasureError> {
        let asset = self.body.model.asset();
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = sample.pose(asset, HERE, &mut memory)?;
        if let Way::Always = way {
            own.refined.prepare(&pose)?; // that of all, wherever they are
        }
        let [first, second] = &mut own.caches;
        first.start(&pose);
        second.start(&pose);
        let mut memory = vec![0.0; asset.pose_len()];
        for place in sample.places.iter().cycle().take(self.count) {
            let other = sample.pose(asset, *place, &mut memory)?;
            let mut others = Workspace::new();
            let mut query = pose.query(&mut own.workspace).cached(first);
            let mut other = other.query(&mut others).cached(second);
            if let Way::Always = way {
                query = query.refined(&own.refined);
                other = other.refined(&own.refined);
            }
            let mut query = query.against(other);
            own.touching.clear();
            query.contacts(0.0, &mut own.touching)?;
            answer.found += own.touching.len() as u64;
            answer.nodes.add(query.stats());
        }
        Ok(())
    }
}
