//! W5: a character of sixty bones that all turn, asked with one ball or one ray at its skin per frame.

use std::error::Error;
use std::path::Path;

use bdtree_build::pipeline::bake;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::models;
use bdtree_measure::Body;
use bdtree_runtime::math::{add_scaled, norm, sub};
use bdtree_runtime::{
    BoneMap, BoneMatrices, JointMatrix, Model, SkeletonPose, Transform, VertexId,
};

use super::random::Stream;

/// Frames of the clip, evenly spread over it.
pub const FRAMES: usize = 40;

/// The two characters: name, and rings and sides of each of its five limbs.
pub const SIZES: [(&str, [usize; 2]); 2] =
    [("character5k", [50, 10]), ("character100k", [250, 40])];

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
        let vertex = VertexId((stream.bits() % asset.vertex_count() as u64) as u32);
        let on_skin = pose.deformed(vertex)?;
        let radius = BALL * diagonal;
        let center = add_scaled(on_skin, 0.5 * radius, stream.direction());
        let from = stream.direction();
        // Both contenders get the numbers that are left in f32.
        let start = [0, 1, 2].map(|c| {
            f64::from(((on_skin[c] - origin[c] - 2.0 * diagonal * from[c]) / unit) as f32)
        });
        let direction = from.map(|x| x as f32);
        let stored = |p: [f64; 3]| [0, 1, 2].map(|c| (p[c] - origin[c]) / unit);
        let there = |p: [f64; 3]| [0, 1, 2].map(|c| origin[c] + unit * p[c]);
        frames.push(Frame {
            q: player.q().to_vec(),
            joints: player.joints().to_vec(),
            maps: pose.bone_maps().to_vec(),
            ours: Question {
                ball: (center, radius),
                ray: [there(start), direction.map(f64::from)],
            },
            stored: Question {
                ball: (stored(center), radius / unit),
                ray: [start.map(|x| x as f32), direction],
            },
        });
    }
    Ok(frames)
}
