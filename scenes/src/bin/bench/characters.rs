//! Characters: spheres and boxes beside the smallest possible ones over all frames of all clips, and what a pose costs.

use std::path::PathBuf;

use bdtree_build::wrap::ball::smallest_ball;
use bdtree_measure::report::lanes;
use bdtree_runtime::{BoneMatrices, Instance, JointMatrix, Skeleton, SkeletonPose, VertexId};

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Baked characters (.bdt files with skins and clips)
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Frames per clip, spread evenly over its time
    #[arg(long, default_value_t = 20)]
    frames: u32,
    /// Instances whose poses and boxes are timed together
    #[arg(long, default_value_t = 100)]
    instances: usize,
}

/// q and joints of one frame.
struct Frame {
    q: Vec<f32>,
    joints: Vec<JointMatrix>,
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let (mut bounds, mut levels, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for path in &arguments.files {
        let model = Model::load(path)?;
        let stem = path.file_stem().unwrap_or_default();
        let name = stem.to_string_lossy();
        let skeleton = model.asset().skeleton();
        let skeleton = skeleton.ok_or_else(|| format!("{}: no skin", path.display()))?;
        let frames = frames(&model, &skeleton, arguments.frames)?;
        let (all, of_levels) = tightness(model.asset(), &frames)?;
        let boxes = boxes(model.asset(), &frames)?;
        bounds.push(row! {
            "character" => &*name, "triangles" => model.asset().triangle_count(), "bones" => model.asset().bone_count(),
            "modes" => model.asset().mode_count(), "frames" => frames.len(),
            "R'/R_opt, mean" => all.mean(), "max" => all.max,
            "box over exact" => boxes.exact, "box per bone over exact" => boxes.per_bone,
        });
        levels.extend(of_levels.iter().enumerate().map(|(level, ratios)| {
            row! {"character" => &*name, "level" => level, "R'/R_opt, mean" => ratios.mean(), "max" => ratios.max}
        }));
        times.push(time(&name, &model, &frames, arguments.instances, rounds)?);
    }
    Ok(vec![
        table(
            "bounds",
            "Bounds over the smallest possible ones: radii of all spheres, volumes of boxes; means over the frames",
            &bounds,
        ),
        table("levels", "Radii by level", &levels),
        table(
            "times",
            "Poses and conservative boxes, medians on one thread",
            &times,
        ),
    ])
}

/// The frames of all clips.
fn frames(model: &Model, skeleton: &Skeleton<'_>, count: u32) -> Result<Vec<Frame>> {
    let mut pose = SkeletonPose::new(model)?;
    let mut frames = Vec::new();
    for (index, clip) in skeleton.clips().enumerate() {
        for k in 0..count {
            pose.play(
                index,
                clip.duration_s() * f64::from(k) / f64::from(count.max(2) - 1),
            )?;
            frames.push(Frame {
                q: pose.q().to_vec(),
                joints: pose.joints().to_vec(),
            });
        }
    }
    if frames.is_empty() {
        return Err("no clips".into());
    }
    Ok(frames)
}

#[derive(Clone, Default)]
struct Ratios {
    sum: f64,
    count: f64,
    max: f64,
}

impl Ratios {
    fn add(&mut self, ratio: f64) {
        self.sum += ratio;
        self.count += 1.0;
        self.max = self.max.max(ratio);
    }

    fn mean(&self) -> f64 {
        self.sum / self.count
    }
}

/// Radii over those of the smallest balls of all lanes, and the same by level.
fn tightness(asset: &Asset<'_>, frames: &[Frame]) -> Result<(Ratios, Vec<Ratios>)> {
    let mut all = Ratios::default();
    let mut levels = vec![Ratios::default(); asset.depth()];
    let mut lanes_of = Vec::new();
    for level in 0..asset.depth() {
        for (node, lane) in lanes::of_level(asset, level) {
            lanes_of.push((level, node, lane, lanes::vertices(asset, node, lane)));
        }
    }
    let mut memory = vec![0.0; asset.pose_len()];
    let mut points = Vec::new();
    for frame in frames {
        let bones = BoneMatrices::Joints(&frame.joints);
        let pose = asset.pose_with_bones(&frame.q, bones, Transform::IDENTITY, &mut memory)?;
        let vertices = 0..asset.vertex_count() as u32;
        let deformed = vertices.map(|v| Ok(pose.deformed_stored(VertexId(v))?.map(f64::from)));
        let deformed: Vec<[f64; 3]> = deformed.collect::<Result<_>>()?;
        let whole = smallest_ball(&deformed).radius * asset.unit();
        for (level, node, lane, vertices) in &lanes_of {
            points.clear();
            points.extend(vertices.iter().map(|v| deformed[*v as usize]));
            if let Some([ratio, _]) = lanes::tightness(&pose, *node, *lane, &points, whole)? {
                all.add(ratio);
                levels[*level].add(ratio);
            }
        }
    }
    Ok((all, levels))
}

/// Volumes over the exact box's, means over frames.
struct Boxes {
    exact: f64,
    /// Of the box around the carried corners of each bone's box at rest, displacements left out: what engines that keep
    /// a box per joint have.
    per_bone: f64,
}

fn boxes(asset: &Asset<'_>, frames: &[Frame]) -> Result<Boxes> {
    let mut memory = vec![0.0; asset.pose_len()];
    let (mut own, mut engines) = (0.0, 0.0);
    for frame in frames {
        let bones = BoneMatrices::Joints(&frame.joints);
        let pose = asset.pose_with_bones(&frame.q, bones, Transform::IDENTITY, &mut memory)?;
        let mut exact = Extent::EMPTY;
        for v in 0..asset.vertex_count() as u32 {
            exact.add(pose.deformed(VertexId(v))?);
        }
        let conservative = pose.aabb()?;
        let found = Extent([conservative.min, conservative.max]);
        let exact = exact.volume();
        own += found.volume() / exact;
        engines += per_bone(asset, &pose).volume() / exact;
    }
    let count = frames.len() as f64;
    Ok(Boxes {
        exact: own / count,
        per_bone: engines / count,
    })
}

/// The boxes of rest positions that bones move, carried (mesh units).
fn per_bone(asset: &Asset<'_>, pose: &Pose<'_>) -> Extent {
    let (unit, origin) = (asset.unit(), asset.origin());
    let mut all = Extent::EMPTY;
    for (record, map) in asset.bones().iter().zip(pose.bone_maps()) {
        let ends = [
            record.low.map(|x| f64::from(x.get())),
            record.high.map(|x| f64::from(x.get())),
        ];
        if ends[0][0] > ends[1][0] {
            continue; // it moves nothing
        }
        for corner in 0..8 {
            let at = [0, 1, 2].map(|k| ends[corner >> k & 1][k]);
            all.add([0, 1, 2].map(|r| {
                let [x, y, z, t] = map.rows()[r].map(f64::from);
                origin[r] + unit * (x * at[0] + y * at[1] + z * at[2] + t)
            }));
        }
    }
    all
}

/// Least and largest coordinates.
struct Extent([[f64; 3]; 2]);

impl Extent {
    const EMPTY: Self = Self([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);

    fn add(&mut self, p: [f64; 3]) {
        for k in 0..3 {
            self.0[0][k] = self.0[0][k].min(p[k]);
            self.0[1][k] = self.0[1][k].max(p[k]);
        }
    }

    fn volume(&self) -> f64 {
        (0..3).map(|k| self.0[1][k] - self.0[0][k]).product()
    }
}

/// What it takes to bring many instances to a frame each, and then to have their boxes.
fn time(
    name: &str,
    model: &Model,
    frames: &[Frame],
    instances: usize,
    rounds: usize,
) -> Result<Row> {
    let mut all = (0..instances)
        .map(|_| Ok(Instance::new(model)?))
        .collect::<Result<Vec<_>>>()?;
    let (mut poses, mut boxes, mut both) = (Vec::new(), Vec::new(), Vec::new());
    for round in 0..rounds {
        let start = Instant::now();
        for (k, instance) in all.iter_mut().enumerate() {
            let frame = &frames[(7 * k + round) % frames.len()];
            let bones = BoneMatrices::Joints(&frame.joints);
            instance.set_pose_with_bones(&frame.q, bones, Transform::IDENTITY)?;
        }
        let posed = start.elapsed().as_secs_f64();
        for instance in &all {
            black_box(instance.aabb()?);
        }
        let whole = start.elapsed().as_secs_f64();
        poses.push(posed);
        boxes.push(whole - posed);
        both.push(whole);
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let per_bone = 1e9 / (instances * model.asset().bone_count()) as f64;
    Ok(row! {
        "character" => name, "instances" => instances, "bones" => model.asset().bone_count(),
        "modes" => model.asset().mode_count(),
        "pose, ns per bone" => median(&mut poses) * per_bone, "box, ns per bone" => median(&mut boxes) * per_bone,
        "poses and boxes, ms" => median(&mut both) * 1e3,
    })
}
