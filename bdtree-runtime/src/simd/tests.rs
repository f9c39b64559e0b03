//! Every kernel has the bits of the portable one.

use bdtree_format::{LANES, Row};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Kernel, Lanes, Reference, Work};

/// All operations on two rows: numbers by their bits, masks by theirs.
struct Operations([Row; 2]);

type Answers = ([[u32; LANES]; 6], [u8; 2]);

impl Work for Operations {
    type Output = Answers;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Answers {
        let [a, b] = self.0.map(|row| L::load(&row));
        let numbers = [a.add(b), a.sub(b), a.mul(b), a.sqrt(), a.min(b), a.max(b)];
        let bits = numbers.map(|x| x.store().map(f32::to_bits));
        (bits, [a.above(b), b.above(a)])
    }
}

#[test]
fn every_kernel_rounds_each_operation_once() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut number = || {
        let size = random.random_range(-60..60);
        random.random_range(0.5_f32..1.0) * 2_f32.powi(size)
    };
    for round in 0..10_000 {
        let a: Row = core::array::from_fn(|_| number());
        // Near ones too, where differences cancel.
        let b: Row = core::array::from_fn(|k| match (round + k) % 3 {
            0 => -number(),
            1 => a[k] * (1.0 + 2_f32.powi(-20)),
            _ => number(),
        });
        let expected = Operations([a, b]).run::<Reference>();
        for kernel in Kernel::ALL.into_iter().filter(|k| k.is_available()) {
            assert_eq!(
                kernel.run(Operations([a, b])),
                expected,
                "{kernel:?}: {a:?}, {b:?}"
            );
        }
    }
}
