//! Assets whose vertices bones carry, and what bones may do to them.

use bdtree_fixtures::skin::{
    BoneSource, LocalSource, NodeSource, SkinSource, skinned_bar, skinned_tree, with_skin,
};
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{Asset, JointMatrix, Model, Transform};
use rand::{Rng, RngExt};

/// A pose of all of it.
pub(crate) struct Posed {
    /// What the bones do, for messages.
    pub(crate) kind: &'static str,
    pub(crate) q: Vec<f32>,
    /// From mesh to model space, one per bone.
    pub(crate) matrices: Vec<JointMatrix>,
    pub(crate) place: Transform,
}

/// Skins of one bone, some and many, of modes of all vertices, of some, and of none; with weights that sum to 1 and that do not,
/// with and without vertices that no bone moves.
///
/// # Panics
/// When a bake fails.
pub(crate) fn assets() -> Vec<(String, Model)> {
    let mut all = Vec::new();
    for (name, bytes) in [("bar", skinned_bar()), ("tree", skinned_tree())] {
        all.push((name.to_string(), Model::from_bytes(&bytes).expect("a bar")));
    }
    let (small, large) = (bake::bumpy_sphere(6, 2), bake::bumpy_sphere(12, 1));
    let mut far = small.clone();
    for p in &mut far.positions {
        *p = [1e-3 * p[0] + 1e4, 1e-3 * p[1], 1e-3 * p[2] - 1e4];
    }
    for (name, mesh, basis, bones, influences, sums) in [
        ("rigid", &large, bake::rigid(&large), 5, 4, true),
        (
            "one bone",
            &small,
            bake::smooth_basis(&small, 3, 1),
            1,
            1,
            true,
        ),
        (
            "ten modes",
            &large,
            bake::smooth_basis(&large, 10, 3),
            18,
            4,
            true,
        ),
        (
            "any weights",
            &small,
            bake::smooth_basis(&small, 5, 3),
            7,
            7,
            false,
        ),
        (
            "many influences",
            &small,
            bake::smooth_basis(&small, 2, 3),
            300,
            255,
            true,
        ),
        (
            "local",
            &small,
            bake::local_basis(&small, 13, 3),
            9,
            6,
            true,
        ),
        ("far", &far, bake::local_basis(&far, 6, 3), 3, 3, false),
    ] {
        let plain = bake::baked(mesh, &basis);
        let vertices = plain.asset().vertex_count();
        let source = random_skin(vertices, bones, influences, sums);
        let bytes = with_skin(plain.asset().bytes(), &source);
        all.push((name.into(), Model::from_bytes(&bytes).expect("a skin")));
    }
    all
}

fn random_skin(vertices: usize, bones: usize, influences: usize, sums: bool) -> SkinSource {
    let mut rng = poses::rng(7);
    let one = |_| {
        let least = usize::from(sums);
        let count = rng.random_range(least..=influences.min(bones));
        let mut of: Vec<u16> = (0..count)
            .map(|_| rng.random_range(0..bones as u16))
            .collect();
        of.sort_unstable();
        of.dedup();
        let weights: Vec<f64> = of.iter().map(|_| rng.random_range(1e-4..1.0)).collect();
        let sum: f64 = weights.iter().sum();
        let whole = if sums {
            sum
        } else {
            sum.max(0.6 * of.len() as f64)
        };
        let weights = weights.iter().map(|w| (w / whole) as f32);
        of.iter().copied().zip(weights).collect()
    };
    let influences = (0..vertices).map(one).collect();
    let identity = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ];
    let bone = |joint| BoneSource {
        joint,
        inverse_bind: identity,
    };
    let node = |_| NodeSource {
        name: String::new(),
        parent: None,
        local: LocalSource::Matrix(identity.map(|row| row.map(|x| x as f32))),
    };
    SkinSource {
        influences,
        bones: (0..bones as u32).map(bone).collect(),
        nodes: (0..bones).map(node).collect(),
        joints: (0..bones as u32).collect(),
        clips: Vec::new(),
    }
}

/// What bones do: turns, mirrors, shears, flattens to planes, lines and points, enlarges to the limit of a pose, shrinks.
const KINDS: [&str; 9] = [
    "rest", "turned", "mirrored", "sheared", "flat", "line", "point", "huge", "tiny",
];

/// Poses of all kinds.
pub(crate) fn posed(asset: &Asset<'_>, seed: u64) -> Vec<Posed> {
    let mut rng = poses::rng(seed);
    let mut all = Vec::new();
    let hard = poses::hard_qs(asset);
    for (k, kind) in KINDS.into_iter().cycle().take(2 * KINDS.len()).enumerate() {
        let q = match k % 3 {
            0 => hard[k % hard.len()].clone(),
            _ => poses::random_q(asset, 0.3, &mut rng),
        };
        let matrices = (0..asset.bone_count())
            .map(|_| matrix(asset, kind, &q, &mut rng))
            .collect();
        let place = match k {
            0 => Transform::IDENTITY,
            _ => poses::random_transform(3.0, &mut rng),
        };
        all.push(Posed {
            kind,
            q,
            matrices,
            place,
        });
    }
    all
}

/// X of a pose, about.
fn reach(asset: &Asset<'_>, q: &[f32]) -> f64 {
    let weighted = asset.modes().iter().zip(q);
    let moved: f64 = weighted
        .map(|(mode, q)| f64::from(mode.field_norm_max.get()) * f64::from(q.abs()))
        .sum();
    f64::from(asset.header().position_norm_max.get()) + moved
}

fn matrix(asset: &Asset<'_>, kind: &str, q: &[f32], rng: &mut impl Rng) -> JointMatrix {
    let turn = turn(rng);
    let mut any = || -> [f64; 3] { [0, 1, 2].map(|_| rng.random_range(-1.0..1.0)) };
    let scaled = |by: [f64; 3]| turn.map(|row| [0, 1, 2].map(|c| row[c] * by[c]));
    let linear = match kind {
        "rest" => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "turned" => turn,
        "mirrored" => scaled([-1.0, 1.2, 0.9]),
        "sheared" => [any(), any(), any()],
        "flat" => scaled([1.0, 0.0, 1.0]),
        "line" => scaled([0.0, 2.0, 0.0]),
        "point" => scaled([0.0; 3]),
        "huge" => scaled([2_f64.powi(57) / reach(asset, q); 3]),
        _ => scaled([1e-20, -1e-18, 1e-12]),
    };
    let far = match kind {
        "rest" => 0.0,
        "huge" => 2_f64.powi(57),
        _ => reach(asset, q),
    };
    let offset = any().map(|x| x * far * asset.unit());
    let o = asset.origin();
    // About the asset's origin.
    [0, 1, 2].map(|r| {
        let [x, y, z] = linear[r];
        let turned = x * o[0] + y * o[1] + z * o[2];
        [x, y, z, o[r] + offset[r] - turned]
    })
}

/// The matrix of a random rotation.
fn turn(rng: &mut impl Rng) -> [[f64; 3]; 3] {
    let [x, y, z, w] = [0; 4].map(|_| rng.random_range(-1.0..1.0_f64));
    let s = 2.0 / (x * x + y * y + z * z + w * w);
    [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y - w * z),
            s * (x * z + w * y),
        ],
        [
            s * (x * y + w * z),
            1.0 - s * (x * x + z * z),
            s * (y * z - w * x),
        ],
        [
            s * (x * z - w * y),
            s * (y * z + w * x),
            1.0 - s * (x * x + y * y),
        ],
    ]
}
