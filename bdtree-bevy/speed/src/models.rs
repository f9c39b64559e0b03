//! What is measured: a face of 52 morph targets, balls of some fields, a limb of 40 bones.

use bdtree_bevy::bdtree_runtime::Model;
use bdtree_fixtures::bake;
use bdtree_fixtures::skin::{
    BoneSource, ChannelSource, ClipSource, LocalSource, NodeSource, SkinSource, inverse,
    node_matrices, with_skin,
};

/// Bones of the limb.
const BONES: usize = 40;
/// Rings of the limb along each bone.
const RINGS: usize = 6;
/// Corners of a ring.
const SIDES: usize = 16;

/// A ball of about `4 n²` triangles with 8 smooth fields.
pub(crate) fn ball(n: u32) -> Model {
    let mesh = bake::bumpy_sphere(n, 3);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 8, 5))
}

/// A face with 52 morph targets.
pub(crate) fn face() -> Model {
    let (mesh, basis) = bake::face_with_shapes();
    bake::baked(&mesh, &basis)
}

/// A tube along y on 40 joints, each the parent of the next, 0.1 apart, with two to four bones per vertex; its clip turns
/// every joint to and fro.
pub(crate) fn limb() -> Model {
    let mut mesh = bake::bumpy_sphere(3, 1);
    (mesh.positions, mesh.triangles) = (Vec::new(), Vec::new());
    let rings = BONES * RINGS;
    let mut influences = Vec::new();
    for ring in 0..=rings {
        let y = ring as f64 / RINGS as f64;
        for side in 0..SIDES {
            let turn = std::f64::consts::TAU * side as f64 / SIDES as f64;
            mesh.positions
                .push([0.3 * turn.cos(), 0.1 * y, 0.3 * turn.sin()]);
            let shares = (0..BONES).map(|b| {
                let near = (1.0 - (y - b as f64 - 0.5).abs() / 2.0).max(0.0);
                (b as u16, near * near)
            });
            let near: Vec<_> = shares.filter(|(_, w)| *w > 1e-2).collect();
            let sum: f64 = near.iter().map(|(_, w)| w).sum();
            influences.push(near.iter().map(|(b, w)| (*b, (w / sum) as f32)).collect());
        }
    }
    let at = |ring: usize, side: usize| (ring * SIDES + side % SIDES) as u32;
    for ring in 0..rings {
        for side in 0..SIDES {
            let [a, b] = [at(ring, side), at(ring, side + 1)];
            let [c, d] = [at(ring + 1, side), at(ring + 1, side + 1)];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    let nodes: Vec<NodeSource> = (0..BONES)
        .map(|b| NodeSource {
            name: format!("joint {b}"),
            parent: b.checked_sub(1).map(|above| above as u32),
            local: LocalSource::Parts {
                translation: [0.0, if b == 0 { 0.0 } else { 0.1 }, 0.0],
                rotation: [0.0, 0.0, 0.0, 1.0],
                scale: [1.0; 3],
            },
        })
        .collect();
    let matrices = node_matrices(&nodes);
    let bones = (0..BONES)
        .map(|b| BoneSource {
            joint: b as u32,
            inverse_bind: inverse(&matrices[b]),
        })
        .collect();
    let swing = |target: u32| {
        let turn = |angle: f32| [0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
        let angle = 0.1 * (1.0 + target as f32).sin();
        ChannelSource {
            target,
            target_count: 1,
            path: bdtree_bevy::bdtree_runtime::format::channel_path::ROTATION,
            interpolation: bdtree_bevy::bdtree_runtime::format::interpolation::LINEAR,
            times: vec![0.0, 0.5, 1.0],
            values: [turn(-angle), turn(angle), turn(-angle)].concat(),
        }
    };
    let source = SkinSource {
        influences,
        bones,
        nodes,
        joints: (0..BONES as u32).collect(),
        clips: vec![ClipSource {
            name: "swing".to_string(),
            channels: (0..BONES as u32).map(swing).collect(),
        }],
    };
    let plain = bake::baked(&mesh, &bake::rigid(&mesh));
    Model::from_bytes(&with_skin(plain.asset().bytes(), &source)).expect("a sound file")
}
