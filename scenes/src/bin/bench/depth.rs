//! Bounded depth: what stopping at a level costs and how far its spheres are off, for wrapped and
//! for nested spheres.

use bdtree_format::LANES;
use bdtree_measure::turns::{self, Counts, Entry, Role, TOTAL};
use bdtree_runtime::bound::Spheres;
use bdtree_runtime::{Ball, PairContact, Proxy, VertexId};

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: Scene,
    /// Frames, each with its own q
    #[arg(long, default_value_t = 40)]
    frames: usize,
    /// Radius of the ball over the diagonal of the box
    #[arg(long, default_value_t = 0.03)]
    radius: f64,
    /// Largest displacement over the diagonal of the box
    #[arg(long, default_value_t = 0.08)]
    displacement: f64,
}

/// A ball that reaches into the surface, and a second body that does.
struct Frame {
    q: [Vec<f32>; 2],
    center: [f64; 3],
    place: Transform,
}

fn frames(asset: &Asset<'_>, arguments: &Arguments) -> Result<Vec<Frame>> {
    let mut rng = poses::rng(arguments.scene.seed);
    let diagonal = poses::diagonal(asset) * asset.unit();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut all = Vec::with_capacity(arguments.frames);
    for _ in 0..arguments.frames {
        let q = [(); 2].map(|()| {
            let share = arguments.displacement * rng.random_range(0.5..1.0);
            poses::random_q(asset, share, &mut rng)
        });
        let pose = asset.pose(&q[0], Transform::IDENTITY, &mut memory)?;
        let vertex = VertexId(rng.random_range(0..asset.vertex_count() as u32));
        let near = arguments.radius * diagonal;
        let center = pose.deformed(vertex)?;
        let center = center.map(|c| c + near * rng.random_range(-0.4..0.4));
        // About as far apart as the bodies are wide, so that they graze or overlap a little.
        let [x, y, z, _] = poses::random_transform(0.0, &mut rng).rotation;
        let apart = diagonal * rng.random_range(0.5..0.56) / distance([x, y, z], [0.0; 3]);
        let place = Transform {
            translation: [x, y, z].map(|c| apart * c),
            scale: 1.0,
            ..poses::random_transform(0.0, &mut rng)
        };
        all.push(Frame { q, center, place });
    }
    Ok(all)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// What is asked at every level: a ball, or else a second body.
struct Question<'a> {
    asset: &'a Asset<'a>,
    frames: &'a [Frame],
    is_ball: bool,
    radius: f64,
}

/// What was found, and the memory that it took.
#[derive(Default)]
struct Walk {
    workspace: Workspace<'static>,
    contacts: Vec<Contact>,
    pairs: Vec<PairContact>,
    proxies: [Vec<Proxy>; 2],
}

impl Question<'_> {
    /// Asks in a frame, down to a level or to the leaves; poses are made before the clock starts.
    fn ask(&self, walk: &mut Walk, level: Option<usize>, frame_index: usize) -> turns::Frame {
        let asked = &self.frames[frame_index];
        let mut memory = [(); 2].map(|()| vec![0.0; self.asset.pose_len()]);
        let [one, two] = &mut memory;
        let a = self.asset.pose(&asked.q[0], Transform::IDENTITY, one);
        let b = self.asset.pose(&asked.q[1], asked.place, two);
        let (a, b) = (a.expect("q within limits"), b.expect("q within limits"));
        let [first, second] = &mut walk.proxies;
        walk.contacts.clear();
        walk.pairs.clear();
        first.clear();
        second.clear();
        frame(|| {
            if self.is_ball {
                let mut query = a.query(&mut walk.workspace);
                if let Some(level) = level {
                    query = query.max_level(level, first);
                }
                let ball = Ball::new(asked.center, self.radius);
                query.contacts(ball, &mut walk.contacts)?;
            } else {
                let mut query = a.against(&b, &mut walk.workspace);
                if let Some(level) = level {
                    query = query.max_level1(level, first).max_level2(level, second);
                }
                query.contacts(0.0, &mut walk.pairs)?;
            }
            let mut answer = Answer::default();
            answer.nodes.add(walk.workspace.stats());
            answer.found = (walk.contacts.len() + walk.pairs.len()) as u64;
            Ok(answer)
        })
    }

    /// How far a walk is off one to the leaves: of a ball the deepest penetration; of two bodies each place where two
    /// spheres would be taken to touch, from the nearest contact.
    fn errors(&self, walk: &Walk, exact: &Walk, center: [f64; 3]) -> Vec<f64> {
        let [first, second] = &walk.proxies;
        if self.is_ball {
            let depth = |all: &[Contact]| all.iter().map(|c| -c.distance).fold(0.0, f64::max);
            let reach = |p: &Proxy| self.radius + p.radius - distance(p.center, center);
            let spheres = first.iter().map(reach).fold(0.0, f64::max);
            return vec![(depth(&walk.contacts).max(spheres) - depth(&exact.contacts)).abs()];
        }
        let off = |(p, q): (&Proxy, &Proxy)| {
            let share = p.radius / (p.radius + q.radius);
            let point = [0, 1, 2].map(|k| p.center[k] + share * (q.center[k] - p.center[k]));
            let near = exact.pairs.iter().map(|c| distance(c.point1, point));
            near.fold(f64::INFINITY, f64::min)
        };
        first.iter().zip(second).map(off).collect()
    }

    /// A row for each level and for none; means over the frames.
    fn rows(&self, name: &str, rounds: usize) -> Result<Vec<Row>> {
        let diagonal = poses::diagonal(self.asset) * self.asset.unit();
        let levels = || (0..self.asset.depth()).map(Some).chain([None]);
        let entries = levels().map(|level| {
            let mut walk = Walk::default();
            let ask = move |i: usize| self.ask(&mut walk, level, i);
            Entry::new(name, Role::Ours, Counts::Other, ask)
        });
        let measured = compare(entries.collect(), self.frames.len(), rounds)?;
        let (mut walk, mut exact) = (Walk::default(), Walk::default());
        let row = |(level, measured): (Option<usize>, turns::Row)| {
            let (mut errors, mut proxies, mut false_frames) = (Vec::new(), 0, 0_usize);
            for (i, asked) in self.frames.iter().enumerate() {
                let found = self.ask(&mut exact, None, i).found;
                self.ask(&mut walk, level, i);
                proxies += walk.proxies[0].len();
                if found > 0 {
                    errors.extend(self.errors(&walk, &exact, asked.center));
                } else {
                    false_frames += usize::from(!walk.proxies[0].is_empty());
                }
            }
            let each = |count: u64| count as f64 / self.frames.len() as f64;
            let count = errors.len().max(1) as f64;
            row! {
                "of" => name, "level" => level.map_or("none".to_string(), |level| level.to_string()),
                "µs" => measured.median[TOTAL] * 1e6,
                "nodes" => each(measured.nodes.visited), "exact" => each(measured.found),
                "spheres" => each(proxies as u64),
                "error over the diagonal, mean" => errors.iter().sum::<f64>() / diagonal / count,
                "most" => errors.iter().copied().fold(0.0, f64::max) / diagonal,
                "false frames" => false_frames,
            }
        };
        Ok(levels().zip(measured).map(row).collect())
    }
}

/// Of lanes that lead to a node, the share of which a sphere below sticks out by more than rounding,
/// how far at most over the lane's radius, and the mean radius over the diagonal.
fn sticking_out(asset: &Asset<'_>, q: &[f32]) -> Result<[f64; 3]> {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
    let (mut lanes, mut out, mut most, mut radii) = (0.0, 0.0, 0.0_f64, 0.0);
    let at = |s: &Spheres, k: usize| s.center.map(|row| f64::from(row[k]));
    for (i, node) in (0..).zip(asset.nodes()) {
        let outer = pose.node_spheres(i)?;
        let inner_lanes = (0..LANES).filter(|k| node.inner_mask >> k & 1 == 1);
        for (child, lane) in (node.first_child..).zip(inner_lanes) {
            let below = &asset.nodes()[child as usize];
            let inner = pose.node_spheres(child)?;
            let radius = f64::from(outer.radius[lane]);
            let mut excess = 0.0_f64;
            for k in (0..LANES).filter(|k| (below.inner_mask | below.leaf_mask) >> k & 1 == 1) {
                let reach = distance(at(&inner, k), at(&outer, lane)) + f64::from(inner.radius[k]);
                excess = excess.max(reach / radius - 1.0);
            }
            lanes += 1.0;
            radii += radius / poses::diagonal(asset);
            out += f64::from(excess > 1e-3);
            most = most.max(excess);
        }
    }
    Ok([out / lanes, most, radii / lanes])
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let (mesh, basis) = arguments.scene.load()?;
    let (mut trees, mut walks) = (Vec::new(), Vec::new());
    for nested in [false, true] {
        let baked = arguments.scene.bake(&mesh, &basis, nested)?;
        let model = Model::from_bytes(&baked.bytes)?;
        let asset = model.asset();
        let frames = frames(asset, arguments)?;
        let kind = if nested { "nested" } else { "wrapped" };
        let rest = vec![0.0; asset.mode_count()];
        for (name, q) in [("at rest", &rest), ("under q", &frames[0].q[0])] {
            let [share, most, radius] = sticking_out(asset, q)?;
            trees.push(row! {
                "tree" => kind, "triangles" => asset.triangle_count(), "levels" => asset.depth(), "at" => name,
                "share of lanes" => share, "by at most, R" => most, "mean radius over the diagonal" => radius,
            });
        }
        for (name, is_ball) in [("ball", true), ("pair", false)] {
            let question = Question {
                asset,
                frames: &frames,
                is_ball,
                radius: arguments.radius * poses::diagonal(asset) * asset.unit(),
            };
            walks.extend(question.rows(&format!("{kind}, {name}"), rounds)?);
        }
    }
    Ok(vec![
        table("trees", "Lanes of which a sphere below sticks out", &trees),
        table("levels", "Walks that stop at a level", &walks),
    ])
}
