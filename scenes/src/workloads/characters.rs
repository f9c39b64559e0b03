//! W5: a character of sixty bones that all turn, asked with one ball, one ray or many rays at its skin per frame.

use std::error::Error;
use std::path::Path;

use bdtree_build::pipeline::bake;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::models;
use bdtree_measure::Body;
use bdtree_runtime::math::{add_scaled, norm, sub};
use bdtree_runtime::{
    BoneMap, BoneMatrices, JointMatrix, Model, SkeletonPose, Transform, TriangleId, VertexId,
};

use super::random::Stream;

/// Frames of the clip, evenly spread over it.
pub const FRAMES: usize = 40;

/// The two characters: name, and rings and sides of each of its five limbs.
pub const SIZES: [(&str, [usize; 2]); 2] =
    [("character5k", [50, 10]), ("character100k", [250, 40])];

/// Rays of a frame that asks many; more repeat them.
const RAYS: usize = 4096;

/// Radius of balls over the diagonal of the character's box: a fingertip.
const BALL: f64 = 0.003;

/// What a frame asks, in the coordinates of one contender.
#[derive(Debug, Clone, Copy)]
pub struct Question<T> {
    /// Center and radius.
    pub ball: ([f64; 3], f64),
    /// Origin and unit direction.
    pub ray: [[T; 3]; 2],
}

/// A ray's origin and unit direction, in mesh and in stored coordinates.
type TwoRays = ([[f64; 3]; 2], [[f32; 3]; 2]);

/// A frame of the clip.
#[derive(Debug, Clone)]
pub struct Frame {
    /// One per mode.
    pub q: Vec<f32>,
    /// Joints as the skeleton has them.
    pub joints: Vec<JointMatrix>,
    /// Maps of the bones as contenders take them.
    pub maps: Vec<BoneMap>,
    /// In mesh coordinates.
    pub ours: Question<f64>,
    /// In stored coordinates, those of [`Body::of_asset`].
    pub stored: Question<f32>,
    /// Many of them.
    rays: Vec<TwoRays>,
}

impl Frame {
    /// So many rays, in mesh coordinates.
    pub fn rays(&self, count: usize) -> impl ExactSizeIterator<Item = [[f64; 3]; 2]> + '_ {
        (0..count).map(|i| self.rays[i % RAYS].0)
    }

    /// The same in stored coordinates.
    pub fn stored_rays(&self, count: usize) -> impl Iterator<Item = [[f32; 3]; 2]> + '_ {
        (0..count).map(|i| self.rays[i % RAYS].1)
    }
}

/// A baked character and what it is asked.
#[derive(Debug)]
pub struct Character {
    /// The product's.
    pub model: Model,
    /// The others'.
    pub body: Body,
    /// Frame after frame.
    pub frames: Vec<Frame>,
}

/// The workload on a character of [`SIZES`].
///
/// # Errors
/// A character that cannot be baked, a folder that cannot be written.
pub fn character(name: &str, [rings, sides]: [usize; 2]) -> Result<Character, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/workloads");
    std::fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{name}.glb"));
    models::write(&path, &models::gltf::character(rings, sides))?;
    let recipe = Recipe::of_surface(&path, Motion::Rigid);
    let model = Model::from_bytes(&bake(&recipe, &Silent)?.bytes)?;
    let body = Body::of_asset(model.asset())?;
    let frames = frames(&model)?;
    Ok(Character {
        model,
        body,
        frames,
    })
}

fn frames(model: &Model) -> Result<Vec<Frame>, Box<dyn Error>> {
    let asset = model.asset();
    let skeleton = asset.skeleton().ok_or("a character without bones")?;
    let clip = skeleton.clips().next().ok_or("a character without clips")?;
    let mut stream = Stream::new(11);
    let (mut player, mut memory) = (SkeletonPose::new(model)?, vec![0.0; asset.pose_len()]);
    let (unit, origin) = (asset.unit(), asset.origin());
    let mut frames = Vec::new();
    for k in 0..FRAMES {
        player.play(0, clip.duration_s() * k as f64 / FRAMES as f64)?;
        let bones = BoneMatrices::Joints(player.joints());
        let pose = asset.pose_with_bones(player.q(), bones, Transform::IDENTITY, &mut memory)?;
        let aabb = pose.aabb()?;
        let diagonal = norm(sub(aabb.max, aabb.min));
        let stored = |p: [f64; 3]| [0, 1, 2].map(|c| (p[c] - origin[c]) / unit);
        let there = |p: [f64; 3]| [0, 1, 2].map(|c| origin[c] + unit * p[c]);
        let on_skin = |stream: &mut Stream| {
            let vertex = VertexId((stream.bits() % asset.vertex_count() as u64) as u32);
            pose.deformed(vertex)
        };
        // From two diagonals away. Both contenders get the numbers that are left in f32.
        let ray_to = |to: [f64; 3], from: [f64; 3]| -> TwoRays {
            let start = add_scaled(to, -2.0 * diagonal, from);
            let start = stored(start).map(|x| f64::from(x as f32));
            let direction = from.map(|x| x as f32);
            (
                [there(start), direction.map(f64::from)],
                [start.map(|x| x as f32), direction],
            )
        };
        let at = on_skin(&mut stream)?;
        let radius = BALL * diagonal;
        let center = add_scaled(at, 0.5 * radius, stream.direction());
        let (ray, stored_ray) = ray_to(at, stream.direction());
        // Apart, so that the single questions are those of earlier measurements.
        let mut many = Stream::new(1000 + k as u64);
        let rays = (0..RAYS).map(|_| {
            // At middles of triangles: at vertices libraries of less precision miss some.
            let triangle = TriangleId((many.bits() % asset.triangle_count() as u64) as u32);
            let [a, b, c] = pose.deformed_triangle(triangle)?;
            let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            Ok(ray_to(middle, many.direction()))
        });
        frames.push(Frame {
            q: player.q().to_vec(),
            joints: player.joints().to_vec(),
            maps: pose.bone_maps().to_vec(),
            ours: Question {
                ball: (center, radius),
                ray,
            },
            stored: Question {
                ball: (stored(center), radius / unit),
                ray: stored_ray,
            },
            rays: rays.collect::<Result<_, Box<dyn Error>>>()?,
        });
    }
    Ok(frames)
}
