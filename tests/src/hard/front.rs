//! Pairs over several steps with a front, beside walks from the root.

use bdtree_runtime::query::{self, PairFront};
use bdtree_runtime::{Asset, FrontSlot, Motion, PairStackEntry, Pose, Transform, TrianglePair};

use super::check::has_collapsed;
use crate::compare::extent;
use crate::oracle;

/// The case and a copy of it that slides along an axis, comes and goes in q, and jumps, with fronts of several
/// lengths: at each step the pairs that touch.
///
/// # Panics
/// When a front finds others than a walk from the root.
pub(super) fn check_front(asset: &Asset<'_>, q: &[f32], place: Transform) {
    let mut memory = [0; 3].map(|_| vec![0.0; asset.pose_len()]);
    let [m0, m1, m2] = &mut memory;
    let fixed = Pose::new(asset, q, place, m0).expect("pose");
    let body = oracle::deformed_triangles(asset, &fixed);
    if has_collapsed(&body) {
        return;
    }
    let size = extent(&body);
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(asset)];
    let steps = [
        (0.5, 1.0),
        (0.5, 1.0),
        (0.4999, 1.0),
        (0.49, 0.999),
        (0.48, 0.9),
        (3.0, 0.5),
        (0.45, 0.5),
    ];
    let at = |(shift, share): (f64, f32)| {
        let mut moved = place;
        moved.translation[0] += shift * size;
        let q: Vec<f32> = q.iter().map(|q| share * q).collect();
        (q, moved)
    };
    for slots in [0, 7, 4096] {
        let mut front = PairFront::new(vec![FrontSlot::EMPTY; slots]);
        let still = Motion::new(&fixed);
        let mut before: Option<((Vec<f32>, Transform), Motion)> = None;
        for step in steps {
            let (q, moved) = at(step);
            let pose = Pose::new(asset, &q, moved, m1).expect("pose");
            let motion = match &before {
                None => Motion::new(&pose),
                Some(((q, moved), motion)) => {
                    let old = Pose::new(asset, q, *moved, m2).expect("pose");
                    let mut motion = *motion;
                    motion
                        .advance(asset, &old, &pose)
                        .expect("poses of the asset");
                    motion
                }
            };
            let (mut with, mut without): (Vec<TrianglePair>, Vec<TrianglePair>) = (vec![], vec![]);
            let pair = ((asset, &fixed, &still), (asset, &pose, &motion));
            front
                .touching(pair.0, pair.1, 0.0, &mut stack, &mut with)
                .expect("touching");
            let plain = ((asset, &fixed), (asset, &pose));
            query::touching(plain.0, plain.1, 0.0, &mut stack, &mut without).expect("touching");
            with.sort_unstable_by_key(|p| (p.triangle1, p.triangle2));
            without.sort_unstable_by_key(|p| (p.triangle1, p.triangle2));
            assert_eq!(with, without, "{step:?}, {slots} slots");
            before = Some(((q, moved), motion));
        }
    }
}
