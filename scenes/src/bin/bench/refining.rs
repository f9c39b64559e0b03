//! How often a step must ask until refining its pose pays, and what a step cache that decides by itself costs beside the
//! better of both ways.

use bdtree_measure::turns::{self, Rounds, Turns};
use bdtree_runtime::{Ball, CacheSize, Query, QueryError, Ray, RefinedPose, StepCache};
use bdtree_scenes::contenders::assets::baked;
use bdtree_scenes::workloads::rays::{self, Rays};

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Questions per step
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1,16,128,256,512,1024,2048,4096,16384"
    )]
    counts: Vec<usize>,
    /// Steps of each run
    #[arg(long, default_value_t = 30)]
    steps: usize,
}

/// Most questions of a run: with more, it has fewer steps, but at least three.
const QUESTIONS: usize = 100_000;

/// What a step asks, at points about the body and along rays towards it.
#[derive(Clone, Copy)]
enum Kind {
    IsTouched,
    Contacts,
    Project,
    CastRay,
}

const KINDS: [(&str, Kind); 4] = [
    ("ball of radius 0.02: intersects", Kind::IsTouched),
    ("ball of radius 0.05: contacts", Kind::Contacts),
    ("project_point", Kind::Project),
    ("cast_ray", Kind::CastRay),
];

/// Points from 0.34 of the way to where rays begin: at the surface, more or less.
const NEAR: f64 = 0.34;

impl Kind {
    fn ask(
        self,
        query: &mut Query<'_, '_>,
        [origin, direction]: [[f64; 3]; 2],
        found: &mut Vec<Contact>,
    ) -> std::result::Result<u64, QueryError> {
        let point = origin.map(|x| NEAR * x);
        Ok(match self {
            Self::IsTouched => u64::from(query.intersects(Ball::new(point, 0.02))?),
            Self::Contacts => {
                found.clear();
                query.contacts(Ball::new(point, 0.05), found)?;
                found.len() as u64
            }
            Self::Project => u64::from(query.project_point(point, f64::INFINITY)?.is_some()),
            Self::CastRay => u64::from(query.cast_ray(&Ray::new(origin, direction))?.is_some()),
        })
    }
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let mut all = Vec::new();
    for (name, n) in rays::SIZES {
        let work = rays::rays(name, n);
        let model = baked(&work.body)?;
        for (question, kind) in KINDS {
            for &count in &arguments.counts {
                let steps = (QUESTIONS / count.max(1)).clamp(3, arguments.steps.max(3));
                let run = Run {
                    asset: *model.asset(),
                    work: &work,
                    kind,
                    count,
                    steps,
                };
                let about = row! {"body" => name, "question" => question, "per step" => count};
                // One after the other: what refines every pose empties the near caches of those who do not.
                let of_run = Rounds {
                    repeats: rounds,
                    turns: Turns::Contender,
                    with: &[],
                };
                let measured = turns::compare(run.entries(), &[0], of_run)?;
                let of = |k: usize| measured[k].median[TOTAL];
                let better = of(0).min(of(1));
                for row in &measured {
                    let mut cells = about.clone();
                    cells.extend(row! {
                        "contender" => row.name.as_str(),
                        "µs per step" => 1e6 * row.median[TOTAL] / steps as f64,
                        "floor" => 1e6 * row.floor[TOTAL] / steps as f64,
                        "to the better of the first two" => row.median[TOTAL] / better,
                    });
                    all.push(cells);
                }
            }
        }
    }
    let title = "W3's bodies: steps that ask alike; preparing included";
    Ok(vec![table("refining", title, &all)])
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
    asset: Asset<'a>,
    work: &'a Rays,
    kind: Kind,
    count: usize,
    steps: usize,
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
        let (mut workspace, mut refined) = (Workspace::new(), RefinedPose::new());
        // All have a cache that keeps nothing: beginning a step with one takes some microseconds.
        let mut cache = StepCache::new(CacheSize::NONE);
        if let Way::ByItself = way {
            cache = cache.refining(RefinedPose::new());
        }
        let mut memory = vec![0.0; self.asset.pose_len()];
        let mut found = Vec::new();
        Entry::new(name, Role::Ours, Counts::Same, move |_| {
            frame(|| {
                let mut answer = Answer::default();
                for step in 0..self.steps {
                    let q = self.work.q(step % rays::FRAMES);
                    let pose = self.asset.pose(q, Transform::IDENTITY, &mut memory)?;
                    cache.start(&pose);
                    let mut query = pose.query(&mut workspace).cached(&mut cache);
                    if let Way::Always = way {
                        refined.prepare(&pose)?;
                        query = query.refined(&refined);
                    }
                    for ray in self.work.wide(step, self.count) {
                        answer.found += self.kind.ask(&mut query, ray, &mut found)?;
                        answer.nodes.add(query.stats());
                    }
                }
                Ok(answer)
            })
        })
    }
}
