//! The maps of bones beside three lines of plain arithmetic, bit by bit with every kernel.

use bdtree_fixtures::bones::{KINDS, random_matrices};
use bdtree_fixtures::poses;
use bdtree_runtime::{
    Asset, BoneMatrices, JointMatrix, Kernel, PoseError, Transform, VertexId, joint,
};
use rand::RngExt;

use crate::bones::creature;

/// y ↦ (J V (o + u y) − o) / u in f64, rounded (SPEC 7.8), products and sums in the order written.
fn plain(asset: &Asset<'_>, joint: &JointMatrix, bind: Option<&JointMatrix>) -> [[f32; 4]; 3] {
    let o = asset.origin();
    let per_unit = 1.0 / asset.unit();
    let moved =
        |m: &JointMatrix| m.map(|[x, y, z, t]| [x, y, z, (x * o[0] + y * o[1] + z * o[2]) + t]);
    let rows = bind.map_or_else(|| moved(joint), |v| joint::compose(joint, &moved(v)));
    [0, 1, 2].map(|r| {
        let [x, y, z, t] = rows[r];
        [x, y, z, (t - o[r]) * per_unit].map(|x| match x as f32 {
            x if x.abs() < f32::MIN_POSITIVE => 0.0,
            x => x,
        })
    })
}

/// ‖A‖₂ from below, and within 10⁻⁶ of it for similarities: what A makes of vectors that it makes longer and longer.
fn norm_from_below(rows: &[[f32; 4]; 3]) -> f64 {
    let a = rows.map(|row| [0, 1, 2].map(|c| f64::from(row[c])));
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut best = 0.0_f64;
    for start in [[1.0, 0.2, 0.1], [0.1, 1.0, 0.2], [0.2, 0.1, 1.0]] {
        let mut v: [f64; 3] = start;
        for _ in 0..60 {
            let of = length(v);
            if of == 0.0 {
                break;
            }
            v = v.map(|x| x / of);
            let image = a.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
            best = best.max(length(image));
            v = [0, 1, 2].map(|c| a[0][c] * image[0] + a[1][c] * image[1] + a[2][c] * image[2]);
        }
    }
    best
}

/// Counts that do and do not fill vectors; every kind of matrices, some numbers of them so small that f32 has none.
#[test]
fn maps_have_the_bits_of_plain_arithmetic_and_stretches_bound_their_norms() {
    for bones in [1, 2, 3, 4, 5, 7, 8, 13, 58] {
        let model = creature(bones, 2, true, 1.0, bones as u64);
        let mut rng = poses::rng(bones as u64);
        for round in 0..4 * KINDS {
            let asset = model.asset();
            let mut matrices = random_matrices(asset, round % KINDS, &mut rng);
            if round % 3 == 0 {
                for x in matrices.iter_mut().flatten().flatten() {
                    if rng.random_range(0..4) == 0 {
                        *x *= [0.0, -0.0, 1e-39, -1e-300][rng.random_range(0..4_usize)];
                    }
                }
            }
            let binds = asset.bones().iter();
            let binds: Vec<JointMatrix> = binds
                .map(|bone| bone.inverse_bind.map(|row| row.map(|x| x.get())))
                .collect();
            for asset in Kernel::ALL.iter().filter_map(|k| asset.with_kernel(*k)) {
                let mut memory = vec![0.0; asset.pose_len()];
                for given in [
                    BoneMatrices::Joints(&matrices),
                    BoneMatrices::Skinning(&matrices),
                ] {
                    let pose = asset
                        .pose_with_bones(&[0.0; 3], given, Transform::IDENTITY, &mut memory)
                        .expect("pose");
                    let maps = pose.bone_maps();
                    assert_eq!(maps.len(), bones);
                    for (bone, map) in maps.iter().enumerate() {
                        let joint = &matrices[bone]; // joint b moves bone b
                        let bind = matches!(given, BoneMatrices::Joints(_)).then(|| &binds[bone]);
                        let expected = plain(&asset, joint, bind);
                        let bits = |rows: &[[f32; 4]; 3]| rows.map(|row| row.map(f32::to_bits));
                        assert_eq!(
                            bits(map.rows()),
                            bits(&expected),
                            "{bones}, {round}, {bone}"
                        );
                        let (norm, stretch) = (norm_from_below(map.rows()), map.stretch());
                        assert!(norm <= f64::from(stretch), "{norm} {stretch}");
                        let is_rigid = matches!(round % KINDS, 0 | 1 | 4) && round % 3 != 0;
                        if is_rigid && bind.is_none() {
                            assert!(
                                f64::from(stretch) <= norm * (1.0 + 1e-5),
                                "{norm} {stretch}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn stretches_and_boxes_have_the_same_bits_with_every_kernel_and_boxes_hold_all_vertices() {
    for bones in [1, 4, 6, 11] {
        let model = creature(bones, 3, true, 1.0, 20 + bones as u64);
        let mut rng = poses::rng(bones as u64);
        for round in 0..3 * KINDS {
            let matrices = random_matrices(model.asset(), round % KINDS, &mut rng);
            let q = match round % 3 {
                0 => vec![0.0; 3],
                _ => poses::random_q(model.asset(), 0.3, &mut rng),
            };
            let at = poses::random_transform(2.0, &mut rng);
            let mut first: Option<Vec<u64>> = None;
            for asset in Kernel::ALL
                .iter()
                .filter_map(|k| model.asset().with_kernel(*k))
            {
                let mut memory = vec![0.0; asset.pose_len()];
                let given = BoneMatrices::Skinning(&matrices);
                let pose = asset
                    .pose_with_bones(&q, given, at, &mut memory)
                    .expect("pose");
                let aabb = pose.aabb().expect("a box");
                let maps = pose.bone_maps().iter();
                let mut bits: Vec<u64> =
                    maps.map(|map| u64::from(map.stretch().to_bits())).collect();
                bits.extend(aabb.min.iter().chain(&aabb.max).map(|x| x.to_bits()));
                assert_eq!(*first.get_or_insert_with(|| bits.clone()), bits);
                for vertex in 0..asset.vertex_count() as u32 {
                    let x = pose.deformed(VertexId(vertex)).expect("vertex");
                    for k in 0..3 {
                        assert!(
                            aabb.min[k] <= x[k] && x[k] <= aabb.max[k],
                            "{round}, {vertex}"
                        );
                    }
                }
            }
        }
    }
}

/// A linear part beyond f32 is an error, wherever the origin is: 0 times it is a sound offset.
#[test]
fn maps_that_f32_does_not_hold_are_errors() {
    let model = creature(9, 2, true, 1.0, 1);
    for asset in Kernel::ALL
        .iter()
        .filter_map(|k| model.asset().with_kernel(*k))
    {
        let mut memory = vec![0.0; asset.pose_len()];
        let (o, plain) = (asset.origin(), joint::IDENTITY);
        for (bone, c) in (0..27).map(|k| (k / 3, k % 3)) {
            for huge in [1e39, -1e300] {
                let mut matrices = [plain; 9];
                matrices[bone][1][c] = huge;
                matrices[bone][1][3] = -huge * o[c];
                matrices[8][0][3] = f64::NAN; // a later one, unless it is this one
                let given = BoneMatrices::Skinning(&matrices);
                let found =
                    asset.pose_with_bones(&[0.0; 3], given, Transform::IDENTITY, &mut memory);
                let range = PoseError::MatrixRange { index: bone };
                assert_eq!(found.map(|_| ()), Err(range), "{bone}, {c}, {huge}");
            }
        }
    }
}
