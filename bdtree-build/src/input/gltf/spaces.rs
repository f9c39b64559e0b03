//! One bind space for all meshes that bones carry.
//!
//! Each skin of a file has a bind space of its own, in which exporters put its meshes: often in other units than the
//! rest, or each at the origin. Spheres around triangles of several meshes then span the gap between their bind spaces
//! in every pose. Moving a mesh by G and its inverse bind matrices by G⁻¹ changes no pose:
//! Σ_b w_b J_b V_b p = Σ_b w_b J_b (V_b G⁻¹) (G p).

use std::collections::HashMap;

use super::affine::Affine;
use super::mesh::MeshData;
use super::nodes::Instance;
use super::notes::Notes;
use super::skeleton::{Carriers, Rig};
use crate::disjoint_sets::DisjointSets;
use crate::vec3;

/// A bind space whose lengths differ from the others' by more than this factor is moved.
const SCALE_MAX: f64 = 2.0;

/// So is one that lies farther from the others than this share of the larger diagonal. What lies nearer may differ only
/// because the rest pose of the file is not its bind pose.
const DISTANCE_MAX: f64 = 0.25;

/// A change of space with a larger condition number would cost digits of the positions.
const CONDITION_MAX: f64 = 64.0;

/// Two bones of one joint whose matrices differ by no more than this share have one bind space.
const SAME_MAX: f64 = 1e-3;

/// A bind space: meshes without a skin stand in that of the scene, skins that share bones in one that is named after
/// its bone of the largest weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Space {
    Scene,
    Skins { main: usize },
}

/// What is known about the meshes of a bind space.
#[derive(Debug)]
struct Content {
    space: Space,
    vertex_count: usize,
    /// Lowest and highest corner, in the bind space.
    extent: ([f64; 3], [f64; 3]),
    /// A skin of the file that has this space.
    skin: Option<usize>,
}

/// Brings skinned meshes whose bind space has another scale or place than the others' to that of the others: their
/// instances get a placement, their bones other inverse bind matrices. That of the others is the scene at rest if it has
/// meshes without a skin, else the bind space of most vertices.
pub(super) fn unify(
    rig: &mut Rig,
    instances: &mut [Instance],
    meshes: &[MeshData],
    notes: &mut Notes,
) {
    let spaces = BindSpaces::of(rig, instances, meshes);
    let of_instances: Vec<Option<Space>> = instances
        .iter()
        .map(
            |instance| match (rig.carriers(instance.node, instance.skin)?, instance.skin) {
                (Carriers::Skin(_), Some(skin)) => spaces.of_skins.get(&skin).copied(),
                _ => Some(Space::Scene),
            },
        )
        .collect();
    let contents = contents(instances, meshes, &of_instances);
    let in_scene = contents.iter().find(|c| c.space == Space::Scene);
    // The first of those with most.
    let largest = contents.iter().rev().max_by_key(|c| c.vertex_count);
    let Some(common) = in_scene.or(largest) else {
        return;
    };
    let rests = rig.rests();
    let from_scene = match common.space {
        Space::Scene => Some(Affine::IDENTITY),
        Space::Skins { main } => rests[main].inverse(),
    };
    let Some(from_scene) = from_scene else {
        return;
    };
    for content in &contents {
        let (Space::Skins { main }, Some(skin)) = (content.space, content.skin) else {
            continue;
        };
        let change = from_scene.after(&rests[main]);
        let Some(back) = change.inverse_within(CONDITION_MAX) else {
            continue;
        };
        if content.space == common.space || !is_apart(&change, content.extent, common.extent) {
            continue;
        }
        for (instance, space) in instances.iter_mut().zip(&of_instances) {
            if *space == Some(content.space) {
                instance.world = change;
            }
        }
        for (bone, space) in rig.bones.iter_mut().zip(&spaces.of_bones) {
            if *space == Some(content.space) {
                bone.inverse_bind = Affine::of_rows(&bone.inverse_bind).after(&back).rows();
            }
        }
        let others = match common.skin {
            Some(other) => format!("skins[{other}]"),
            None => "the scene".to_string(),
        };
        let message = format!(
            "its bind pose had another scale or place than that of {others} and was converted to it; every pose looks as \
             before. A program that forms skinning matrices itself needs the inverse bind matrices of the .bdt file"
        );
        notes.warn(format!("skins[{skin}]"), message);
    }
}

/// True if `change` alters the scale of `own`, or moves a corner of it far for what `own` and `common` span.
fn is_apart(change: &Affine, own: ([f64; 3], [f64; 3]), common: ([f64; 3], [f64; 3])) -> bool {
    let scale = change.scale();
    if !(1.0 / SCALE_MAX..=SCALE_MAX).contains(&scale) {
        return true;
    }
    let (low, high) = own;
    let corners = (0..8)
        .map(|bits| std::array::from_fn(|k| if bits >> k & 1 == 0 { low[k] } else { high[k] }));
    let moved = |corner: [f64; 3]| vec3::norm(vec3::sub(change.point(corner), corner));
    let farthest = corners.map(moved).fold(0.0, f64::max);
    let span = (scale * vec3::diagonal(own)).max(vec3::diagonal(common));
    farthest > DISTANCE_MAX * span
}

/// What is known about the bind spaces, in order of their first instances.
fn contents(
    instances: &[Instance],
    meshes: &[MeshData],
    of_instances: &[Option<Space>],
) -> Vec<Content> {
    let mut contents: Vec<Content> = Vec::new();
    for (instance, space) in instances.iter().zip(of_instances) {
        let (&Some(space), Some(mesh)) = (space, meshes.get(instance.mesh)) else {
            continue;
        };
        let positions = mesh.primitives.iter().flat_map(|p| &p.positions);
        let vertex_count = positions.clone().count();
        let (low, high) = vec3::bounds(positions.map(|&p| instance.world.point(p)));
        match contents.iter_mut().find(|content| content.space == space) {
            Some(content) => {
                let (lowest, highest) = content.extent;
                content.extent = vec3::bounds([lowest, highest, low, high]);
                content.vertex_count += vertex_count;
            }
            None => contents.push(Content {
                space,
                vertex_count,
                extent: (low, high),
                skin: instance.skin,
            }),
        }
    }
    contents
}

/// Which bones and skins have which bind space.
struct BindSpaces {
    /// By bone; `None` for a bone of a skin that carries nothing at all.
    of_bones: Vec<Option<Space>>,
    /// By skin of the file.
    of_skins: HashMap<usize, Space>,
}

impl BindSpaces {
    /// Skins share a space where bones that carry vertices are of one joint and have nearly equal matrices; a bone that
    /// carries none goes with the first skin that has it.
    fn of(rig: &Rig, instances: &[Instance], meshes: &[MeshData]) -> Self {
        let count = rig.bones.len();
        let weights = weights(rig, instances, meshes);
        let carries = |bone: usize| weights[bone] > 0.0;
        let mut sets = DisjointSets::new(count);
        let skins = rig.skins();
        let first_of = |bones: &[u16]| bones.iter().map(|&b| usize::from(b)).find(|&b| carries(b));
        for (_, bones) in &skins {
            if let Some(first) = first_of(bones) {
                let all = bones.iter().map(|&b| usize::from(b));
                all.filter(|&b| carries(b))
                    .for_each(|b| sets.join(first, b));
            }
        }
        let positions = meshes.iter().flat_map(|mesh| &mesh.primitives);
        let positions = positions.flat_map(|primitive| &primitive.positions);
        let reach = positions.map(|&p| vec3::norm(p)).fold(0.0, f64::max);
        let mut by_joint: Vec<usize> = (0..count).filter(|&b| carries(b)).collect();
        by_joint.sort_by_key(|&b| rig.bones[b].joint);
        for run in by_joint.chunk_by(|&a, &b| rig.bones[a].joint == rig.bones[b].joint) {
            for (i, &a) in run.iter().enumerate() {
                for &b in &run[..i] {
                    let [v, w] = [a, b].map(|b| Affine::of_rows(&rig.bones[b].inverse_bind));
                    if v.apart(&w, reach) <= SAME_MAX * v.apart(&Affine::ZERO, reach) {
                        sets.join(a, b);
                    }
                }
            }
        }
        let set_of: Vec<usize> = (0..count).map(|bone| sets.find(bone)).collect();
        let mut main = set_of.clone();
        for (bone, &set) in set_of.iter().enumerate() {
            if weights[bone] > weights[main[set]] {
                main[set] = bone;
            }
        }
        let mut space_of: Vec<Space> = main.iter().map(|&main| Space::Skins { main }).collect();
        for instance in instances {
            if let Some(Carriers::One(bone)) = rig.carriers(instance.node, instance.skin) {
                // With the bone, skins that have it stand in the scene.
                space_of[set_of[usize::from(bone)]] = Space::Scene;
            }
        }
        let space = |bone: usize| space_of[set_of[bone]];
        let mut of_bones: Vec<Option<Space>> =
            (0..count).map(|b| carries(b).then(|| space(b))).collect();
        let mut of_skins = HashMap::new();
        for (skin, bones) in &skins {
            let Some(first) = first_of(bones) else {
                continue;
            };
            of_skins.insert(*skin, space(first));
            for &bone in *bones {
                of_bones[usize::from(bone)].get_or_insert(space(first));
            }
        }
        Self { of_bones, of_skins }
    }
}

/// The sum of each bone's weights.
fn weights(rig: &Rig, instances: &[Instance], meshes: &[MeshData]) -> Vec<f64> {
    let mut sums = vec![0.0; rig.bones.len()];
    for instance in instances {
        let Some(mesh) = meshes.get(instance.mesh) else {
            continue;
        };
        for primitive in &mesh.primitives {
            for vertex in 0..primitive.positions.len() {
                match rig.carriers(instance.node, instance.skin) {
                    Some(Carriers::One(bone)) => sums[usize::from(bone)] += 1.0,
                    Some(Carriers::Skin(bones)) => {
                        let joints = primitive.joints.as_ref().map(|joints| joints.of(vertex));
                        for &(joint, weight) in joints.unwrap_or_default() {
                            // A joint out of range is told later.
                            if let Some(&bone) = bones.get(usize::from(joint)) {
                                sums[usize::from(bone)] += weight;
                            }
                        }
                    }
                    None => {}
                }
            }
        }
    }
    sums
}
