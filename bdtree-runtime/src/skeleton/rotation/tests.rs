//! The arithmetic against 300-bit numbers (mpmath 1.3), and four at a time against one.

use std::vec::Vec;

use bdtree_format::{NO_PARENT, SkeletonNode, local_kind};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::joint::{self, JointMatrix};
use crate::simd::Kernel;
use crate::skeleton::LocalTransform;
use crate::skeleton::model_space::ModelSpace;

/// The unit roundoff of f64.
const V: f64 = f64::EPSILON / 2.0;

/// Squares of chords, shares, and sin((1 − t) θ) / sin θ and sin(t θ) / sin θ.
#[rustfmt::skip]
const SHARES: [(f64, f64, [f64; 2]); 28] = [
    (1e-300, 0.001, [0.999, 0.001]),
    (1e-300, 0.3, [0.7, 0.3]),
    (1e-300, 0.5, [0.5, 0.5]),
    (1e-300, 0.77, [0.22999999999999998, 0.77]),
    (9.094947017729282e-13, 0.001, [0.9990000000000003, 0.0010000000000001516]),
    (9.094947017729282e-13, 0.3, [0.7000000000000541, 0.30000000000004134]),
    (9.094947017729282e-13, 0.5, [0.5000000000000568, 0.5000000000000568]),
    (9.094947017729282e-13, 0.77, [0.230000000000033, 0.7700000000000475]),
    (0.000244140625, 0.001, [0.9990000812611566, 0.0010000406920503996]),
    (0.000244140625, 0.3, [0.7000145269896249, 0.3000111089286632]),
    (0.000244140625, 0.5, [0.50001525948759, 0.50001525948759]),
    (0.000244140625, 0.77, [0.2300088640745547, 0.7700127555353967]),
    (0.01, 0.001, [0.9990033333403673, 0.0010016700054879233]),
    (0.01, 0.3, [0.7005960463453668, 0.30045589141624307]),
    (0.01, 0.5, [0.5006261743217588, 0.5006261743217588]),
    (0.01, 0.77, [0.23036377303693156, 0.7705233367965274]),
    (0.0625, 0.001, [0.999020999597797, 0.0010105486328491455]),
    (0.0625, 0.3, [0.7037600636443659, 0.30287896423334726]),
    (0.0625, 0.5, [0.5039526306789697, 0.5039526306789697]),
    (0.0625, 0.77, [0.2322974601885455, 0.773300488153654]),
    (0.14, 0.001, [0.9990476027764832, 0.0010240068723168985]),
    (0.14, 0.3, [0.7085406545853554, 0.3065496904411012]),
    (0.14, 0.5, [0.5089865985592876, 0.5089865985592876]),
    (0.14, 0.77, [0.23522752784200746, 0.777493711850928]),
    (0.2499999999990905, 0.001, [0.9990864876855158, 0.0010438681369871405]),
    (0.2499999999990905, 0.3, [0.7155625855298611, 0.3119621652089733]),
    (0.2499999999990905, 0.5, [0.5163977794942596, 0.5163977794942596]),
    (0.2499999999990905, 0.77, [0.2395494412126297, 0.7836467950819114]),
];

/// Two rotations, a share, and what is between them.
type Arc = ([f64; 4], [f64; 4], f64, [f64; 4]);

#[rustfmt::skip]
const ARCS: [Arc; 8] = [
    ([-0.7195032835006714, 0.22194428741931915, 0.5848553776741028, -0.30166202783584595], [-0.7195034027099609, 0.2219444066286087, 0.5848551392555237, -0.30166205763816833], 0.5, [-0.7195033376018979, 0.22194434532633134, 0.5848552539913048, -0.3016620404296204]),
    ([0.35117679834365845, 0.23584264516830444, 0.7630099058151245, 0.48874223232269287], [0.3511752784252167, 0.23525391519069672, 0.7630684971809387, 0.48893555998802185], 0.5, [0.3511760574097454, 0.23554829294136864, 0.7630392428363469, 0.48883892263841744]),
    ([-0.7081953287124634, -0.6917324066162109, 0.1303168386220932, 0.05461796000599861], [-0.699953556060791, -0.6974495053291321, 0.14646892249584198, 0.04664815589785576], 0.5, [-0.7041118625741545, -0.6946278720571172, 0.13840023577620975, 0.05063574904003908]),
    ([-0.6913431882858276, -0.08347418159246445, -0.7176876664161682, 0.0010229401523247361], [0.7384243607521057, 0.13488274812698364, 0.6522026658058167, -0.10567785799503326], 0.25, [-0.7044581697580753, -0.09652472734027288, -0.7026221965061693, 0.027271102834956283]),
    ([-0.19003604352474213, -0.7000023126602173, 0.08771183341741562, 0.6827808022499084], [-0.3360234797000885, -0.5509806871414185, 0.04444310814142227, 0.762583315372467], 0.3, [-0.2352223798970912, -0.6587823527593722, 0.07510956680812415, 0.7106580026020044]),
    ([0.235000342130661, 0.10491181910037994, -0.38434192538261414, -0.8865944147109985], [0.509312093257904, -0.1988508552312851, -0.4497775435447693, -0.7062292098999023], 0.3, [0.3251907091476012, 0.01318028671674843, -0.4131764269798292, -0.8505072150865779]),
    ([0.7813132405281067, 0.3860439360141754, 0.08738566190004349, -0.4825799763202667], [0.38168808817863464, 0.2471901923418045, 0.8601772785186768, -0.2308814525604248], 0.25, [0.7385621314567374, 0.3818798187125303, 0.3191897805043817, -0.45476550667319793]),
    ([0.5398186445236206, 0.6091834306716919, 0.5795643925666809, 0.03995592147111893], [-0.4655821621417999, -0.8825699090957642, 0.03959273546934128, -0.05230723321437836], 0.5, [0.534648461222769, 0.7932792773905951, 0.2871442085852193, 0.04906337178332254]),
];

#[test]
fn series_are_within_three_roundings() {
    for (chord_square, share, expected) in SHARES {
        let found = shares(chord_square, share);
        for (a, b) in found.iter().zip(expected) {
            assert!(
                (a - b).abs() <= 3.0 * V * b,
                "{chord_square} {share}: {found:?}"
            );
        }
    }
}

#[test]
fn arcs_are_within_two_roundings() {
    for (a, b, share, expected) in ARCS {
        let found = slerp(a, b, share);
        for (x, y) in found.iter().zip(expected) {
            assert!((x - y).abs() <= 2.0 * V, "{a:?} {b:?} {share}: {found:?}");
        }
    }
}

#[test]
fn series_and_sines_meet() {
    // Half the angles between rotations: chords on both sides of where the series ends.
    let start = [0.0, 0.0, 0.0, 1.0];
    for k in 0..400 {
        let angle = 1e-6 + 0.0025 * f64::from(k);
        let end = [libm::sin(angle), 0.0, 0.0, libm::cos(angle)];
        for share in [-0.1, 0.0, 0.001, 0.3, 0.5, 0.77, 1.0, 1.2] {
            let turn = angle * share;
            let expected = [libm::sin(turn), 0.0, 0.0, libm::cos(turn)];
            for (a, b) in slerp(start, end, share).iter().zip(expected) {
                assert!((a - b).abs() <= 4.0 * V, "{angle} {share}");
            }
        }
    }
}

/// A quaternion about as long as files have them, or a very small turn, or of any length.
fn quaternion(random: &mut Pcg64Mcg) -> [f64; 4] {
    let size = [1e-3, 1.0][random.random_range(0..2)];
    let length = [1.0, 1.0007, 3.3][random.random_range(0..3)];
    let mut q: [f64; 4] = core::array::from_fn(|_| size * random.random_range(-1.0..1.0));
    q[3] += 1.5 - size;
    unit(q).map(|x| f64::from((length * x) as f32))
}

#[test]
fn rows_are_within_six_roundings() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for _ in 0..2000 {
        let q = quaternion(&mut random);
        let [x, y, z, w] = q.map(|x| BigRational::from_float(x).expect("a number"));
        let twice =
            BigRational::from_integer(BigInt::from(2)) / (&x * &x + &y * &y + &z * &z + &w * &w);
        let one = BigRational::one();
        let expected = [
            &one - &twice * (&y * &y + &z * &z),
            &twice * (&x * &y - &w * &z),
            &twice * (&z * &x + &w * &y),
            &twice * (&x * &y + &w * &z),
            &one - &twice * (&x * &x + &z * &z),
            &twice * (&y * &z - &w * &x),
            &twice * (&z * &x - &w * &y),
            &twice * (&y * &z + &w * &x),
            &one - &twice * (&x * &x + &y * &y),
        ];
        for (found, expected) in rows(q).as_flattened().iter().zip(expected) {
            let off = (BigRational::from_float(*found).expect("a number") - expected).abs();
            let off = off.to_f64().expect("a number");
            assert!(off <= 6.0 * V, "{q:?}: off by {off:e}");
        }
    }
    let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for q in [[0.0; 4], [f64::NAN; 4], [1e200; 4], [1e-160; 4]] {
        assert_eq!(rows(q), straight, "{q:?}");
    }
}

#[test]
fn every_kernel_has_the_bits_of_one_rotation() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for round in 0..200 {
        let count = 1 + round % KEYS;
        let mut from = [[0.0, 0.0, 0.0, 1.0]; KEYS];
        let (mut to, mut shares) = (from, [0.0; KEYS]);
        for k in 0..count {
            from[k] = quaternion(&mut random);
            // Near and far ones, opposite ones, some without a direction.
            let near = [1e-4, 0.3, 2.0][random.random_range(0..3)];
            to[k] = from[k].map(|x| x + near * random.random_range(-0.5..0.5));
            if random.random_range(0..3) == 0 {
                to[k] = to[k].map(|x| -x);
            }
            if random.random_range(0..20) == 0 {
                to[k] = [0.0; 4];
            }
            shares[k] = random.random_range(0.0..1.0);
        }
        for kernel in Kernel::ALL
            .into_iter()
            .filter(|kernel| kernel.is_available())
        {
            let mut turned = from;
            kernel.run(Slerps {
                from: &mut turned,
                to: &to,
                shares: &shares,
                count,
            });
            for k in 0..count {
                let expected = slerp(from[k], to[k], shares[k]);
                assert_eq!(turned[k].map(f64::to_bits), expected.map(f64::to_bits));
            }
        }
    }
}

#[test]
fn every_kernel_has_the_bits_of_products() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mut numbers = |size: f64| core::array::from_fn(|_| size * random.random_range(-1.0..1.0));
    let mut turns = Pcg64Mcg::seed_from_u64(4);
    for count in 1..12 {
        let locals: Vec<LocalTransform> = (0..count)
            .map(|k| match k % 4 {
                2 => LocalTransform::Matrix([0, 1, 2].map(|_| {
                    let [x, y, z]: [f64; 3] = numbers(1.0);
                    [x, y, z, x * y]
                })),
                _ => LocalTransform::Parts {
                    translation: numbers(3.0),
                    rotation: quaternion(&mut turns),
                    scale: numbers(2.0),
                },
            })
            .collect();
        let records: Vec<SkeletonNode> = (0..count as u32)
            .map(|k| SkeletonNode {
                parent: if k % 5 == 0 { NO_PARENT } else { k / 2 },
                kind: local_kind::PARTS,
                local: [0.0; 12],
                name_start: 0,
                name_bytes: 0,
            })
            .collect();
        let mut expected: Vec<JointMatrix> = Vec::new();
        for (record, local) in records.iter().zip(&locals) {
            let own = local.to_matrix();
            expected.push(match expected.get(record.parent as usize) {
                Some(parent) => joint::compose(parent, &own),
                None => own,
            });
        }
        let bits = |all: &[JointMatrix]| -> Vec<u64> {
            let numbers = all.as_flattened().as_flattened();
            numbers.iter().map(|x| x.to_bits()).collect()
        };
        for kernel in Kernel::ALL
            .into_iter()
            .filter(|kernel| kernel.is_available())
        {
            let mut nodes = std::vec![joint::IDENTITY; count];
            let made = kernel.run(ModelSpace {
                records: &records,
                locals: &locals,
                nodes: &mut nodes,
            });
            assert_eq!(made, Ok(()));
            assert_eq!(bits(&nodes), bits(&expected));
        }
    }
}
