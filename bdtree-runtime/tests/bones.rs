//! Poses with bones: every query beside brute force, every sphere around what lies below it, wherever bones stand.

use bdtree_fixtures::bones::{KINDS, random_matrices};
use bdtree_fixtures::compare::check_pose_with_bones;
use bdtree_fixtures::skin::{BoneSource, LocalSource, NodeSource, SkinSource, with_skin};
use bdtree_fixtures::{bake, lanes, poses};
use bdtree_runtime::{BoneMatrices, Kernel, Model, PoseError, Transform, VertexId};
use rand::RngExt;

const IDENTITY: [[f64; 4]; 3] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

/// An inverse bind matrix unlike others, of an animated joint.
fn bind(joint: u32) -> [[f64; 4]; 3] {
    let (s, c) = (0.7 + f64::from(joint)).sin_cos();
    [
        [c, -s, 0.0, 0.3 * s],
        [1.1 * s, 1.1 * c, 0.1, -0.2],
        [0.0, 0.2 * c, 0.9, 0.1 * c],
    ]
}

/// A bumpy sphere with three modes and `bones` bones, of which each vertex has up to `influences`: near ones of a ring if
/// `smooth`, else any. Weights sum to 1, or to `sum`.
pub(crate) fn creature(
    bones: usize,
    influences: usize,
    smooth: bool,
    sum: f32,
    seed: u64,
) -> Model {
    let mesh = bake::bumpy_sphere(8, 3);
    let basis = bake::smooth_basis(&mesh, 3, 1);
    let plain = bake::baked(&mesh, &basis);
    let mut rng = poses::rng(seed);
    let of_vertex = |p: &[f64; 3]| {
        let count = rng.random_range(1..=influences);
        let turn = (p[1].atan2(p[0]) / std::f64::consts::TAU + 0.5) * bones as f64;
        let mut own: Vec<u16> = (0..count)
            .map(|k| match smooth {
                true => ((turn as usize + k) % bones) as u16,
                false => rng.random_range(0..bones) as u16,
            })
            .collect();
        own.sort_unstable();
        own.dedup();
        let parts: Vec<f32> = own.iter().map(|_| rng.random_range(0.05..1.0)).collect();
        let total: f32 = parts.iter().sum();
        let weights = parts.iter().map(|x| sum * x / total);
        own.into_iter().zip(weights).collect()
    };
    let source = SkinSource {
        influences: mesh.positions.iter().map(of_vertex).collect(),
        bones: (0..bones as u32)
            .map(|joint| BoneSource {
                joint,
                inverse_bind: bind(joint),
            })
            .collect(),
        nodes: (0..bones)
            .map(|k| NodeSource {
                name: format!("joint {k}"),
                parent: None,
                local: LocalSource::Matrix(IDENTITY.map(|row| row.map(|x| x as f32))),
            })
            .collect(),
        joints: (0..bones as u32).collect(),
        clips: Vec::new(),
    };
    Model::from_bytes(&with_skin(plain.asset().bytes(), &source)).expect("a sound file")
}

/// All of them: few bones and many, smooth weights and wild ones, sums of 1 and others.
fn creatures() -> Vec<Model> {
    vec![
        creature(1, 1, true, 1.0, 1),
        creature(2, 2, true, 1.0, 2),
        creature(6, 3, true, 1.0, 3),
        creature(20, 4, false, 1.0, 4),
        creature(40, 12, false, 1.0, 5),
        creature(6, 3, true, 1.3, 6),
        creature(6, 3, true, 0.4, 7),
    ]
}

#[test]
fn every_query_equals_brute_force_wherever_bones_stand() {
    for (number, model) in creatures().iter().enumerate() {
        let asset = model.asset();
        let mut rng = poses::rng(number as u64);
        for kind in 0..KINDS {
            let matrices = random_matrices(asset, kind, &mut rng);
            let q = poses::random_q(asset, 0.1, &mut rng);
            let at = poses::random_transform(2.0, &mut rng);
            let kernels = Kernel::ALL.iter().filter_map(|k| asset.with_kernel(*k));
            let bones = BoneMatrices::Skinning(&matrices);
            check_pose_with_bones(kernels, &q, bones, at, kind as u64, 4);
        }
    }
}

#[test]
fn spheres_hold_the_vertices_below_them_and_have_the_same_bits_with_every_kernel() {
    let mut checked = 0;
    for (number, model) in creatures().iter().enumerate() {
        let asset = model.asset();
        let mut rng = poses::rng(100 + number as u64);
        for round in 0..3 * KINDS {
            let matrices = random_matrices(asset, round % KINDS, &mut rng);
            let q = match round % 3 {
                0 => vec![0.0; asset.mode_count()],
                _ => poses::random_q(asset, 0.3, &mut rng),
            };
            let mut bits: Option<Vec<u32>> = None;
            for asset in Kernel::ALL.iter().filter_map(|k| asset.with_kernel(*k)) {
                let mut memory = vec![0.0; asset.pose_len()];
                let bones = BoneMatrices::Skinning(&matrices);
                let pose = asset
                    .pose_with_bones(&q, bones, Transform::IDENTITY, &mut memory)
                    .expect("pose");
                let mut own = Vec::new();
                for node in 0..asset.node_count() as u32 {
                    let spheres = pose.node_spheres(node).expect("spheres");
                    let rows = spheres.center.iter().chain([&spheres.radius]);
                    own.extend(rows.flatten().map(|x| x.to_bits()));
                    for lane in asset.nodes()[node as usize].lanes() {
                        let center = spheres.center.map(|row| f64::from(row[lane]));
                        for vertex in lanes::vertices(&asset, node as usize, lane) {
                            let vertex = VertexId(vertex as u32);
                            let p = pose.deformed_stored(vertex).expect("vertex");
                            let square: f64 =
                                (0..3).map(|k| (f64::from(p[k]) - center[k]).powi(2)).sum();
                            let radius = f64::from(spheres.radius[lane]);
                            assert!(
                                square.sqrt() <= radius,
                                "creature {number}, round {round}, node {node}, lane {lane}"
                            );
                            checked += 1;
                        }
                    }
                }
                assert_eq!(*bits.get_or_insert_with(|| own.clone()), own);
            }
        }
    }
    assert!(checked > 100_000, "{checked}");
}

#[test]
fn matrices_that_are_wrong_are_errors() {
    let model = creature(3, 2, true, 1.0, 1);
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut pose = |bones: BoneMatrices<'_>| {
        let found = asset.pose_with_bones(&[0.0; 3], bones, Transform::IDENTITY, &mut memory);
        found.map(|_| ())
    };
    let (expected, found) = (3, 2);
    let joints = PoseError::JointCount { expected, found };
    let bones = PoseError::BoneCount { expected, found };
    assert_eq!(pose(BoneMatrices::Joints(&[IDENTITY; 2])), Err(joints));
    assert_eq!(pose(BoneMatrices::Skinning(&[IDENTITY; 2])), Err(bones));
    for bad in [f64::NAN, f64::INFINITY, 1e30] {
        let mut matrices = [IDENTITY; 3];
        matrices[1][2][3] = bad;
        let range = PoseError::MatrixRange { index: 1 };
        assert_eq!(pose(BoneMatrices::Joints(&matrices)), Err(range), "{bad}");
        matrices = [IDENTITY; 3];
        matrices[1][0][1] = bad;
        assert_eq!(pose(BoneMatrices::Skinning(&matrices)), Err(range), "{bad}");
    }
    assert_eq!(pose(BoneMatrices::Joints(&[IDENTITY; 3])), Ok(()));
    assert_eq!(pose(BoneMatrices::Skinning(&[[[0.0; 4]; 3]; 3])), Ok(()));

    let plain = bake::baked(&bake::bumpy_sphere(4, 3), &Default::default());
    let asset = plain.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let bones = BoneMatrices::Joints(&[]);
    let found = asset.pose_with_bones(&[], bones, Transform::IDENTITY, &mut memory);
    assert_eq!(found.map(|_| ()), Err(PoseError::NoSkin));
}
