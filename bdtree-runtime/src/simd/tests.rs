//! Every kernel has the bits of the portable one.

use std::vec::Vec;

use bdtree_format::{LANES, PairRow, Row};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::whole::Whole8;
use super::{Compact, Kernel, Lanes, Order, PairSums, Work};

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
        let expected = Operations([a, b]).run::<Compact>();
        for kernel in Kernel::ALL.into_iter().filter(|k| k.is_available()) {
            assert_eq!(
                kernel.run(Operations([a, b])),
                expected,
                "{kernel:?}: {a:?}, {b:?}"
            );
        }
    }
}

/// Keys in their order and what else the lanes hold.
struct OrderOf<'a>(&'a Row, u8);

impl Work for OrderOf<'_> {
    type Output = [[u32; LANES]; 3];

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let order = L::Order::new(self.0, self.1);
        let lanes: [u8; LANES] = core::array::from_fn(|k| k as u8);
        [
            order.keys(self.0).map(f32::to_bits),
            order.numbers(&lanes.map(|k| 1000 + u32::from(k))),
            order.bytes(&lanes),
        ]
    }
}

#[test]
fn every_kernel_orders_lanes_alike() {
    let mut random = Pcg64Mcg::seed_from_u64(4);
    for round in 0..20_000 {
        let keys: Row = core::array::from_fn(|_| match random.random_range(0..9) {
            0 => f32::INFINITY,
            1 => f32::NEG_INFINITY,
            2 => f32::NAN,
            3 => -f32::NAN,
            4 | 5 => random.random_range(-2.0_f32..2.0).round(),
            6 => 1.0 + f32::EPSILON * random.random_range(0.0..20.0_f32).round(),
            _ => random.random_range(-1.0..1.0),
        });
        let among = match round % 3 {
            0 => u8::MAX,
            _ => random.random_range(0..=u8::MAX),
        };
        let expected = OrderOf(&keys, among).run::<Compact>();
        let count = among.count_ones() as usize;
        let [_, numbers, lanes] = expected;
        let mut met = 0;
        for k in 0..count {
            assert_eq!(numbers[k], 1000 + lanes[k]);
            met |= 1 << lanes[k];
            if k > 0 {
                let [before, key] = [k - 1, k].map(|k| keys[lanes[k] as usize]);
                // Eight steps of the last place are not told apart.
                let near = key.abs().max(before.abs()) * 2_f32.powi(-20);
                assert!(!(key > before + near), "{keys:?}, {among:b}: {lanes:?}");
                let is_same = key.to_bits() == before.to_bits();
                assert!(!is_same || lanes[k] < lanes[k - 1], "{keys:?}: {lanes:?}");
            }
        }
        assert_eq!(met, among, "{keys:?}: {lanes:?}");
        for kernel in Kernel::ALL.into_iter().filter(|k| k.is_available()) {
            let found = kernel.run(OrderOf(&keys, among));
            for (found, expected) in found.iter().zip(&expected) {
                assert_eq!(found[..count], expected[..count], "{kernel:?}: {keys:?}");
            }
        }
    }
}

/// The columns of eight rows.
struct ColumnsOf<'a>([&'a [f32; 4]; LANES]);

impl Work for ColumnsOf<'_> {
    type Output = [Row; 4];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Row; 4] {
        L::columns(self.0).map(L::store)
    }
}

#[test]
fn rows_become_columns() {
    let rows: [[f32; 4]; LANES] =
        core::array::from_fn(|r| core::array::from_fn(|c| (10 * r + c) as f32));
    for kernel in Kernel::ALL.into_iter().filter(|k| k.is_available()) {
        let columns = kernel.run(ColumnsOf(rows.each_ref()));
        for (c, column) in columns.iter().enumerate() {
            for (r, x) in column.iter().enumerate() {
                assert_eq!(*x, rows[r][c], "{kernel:?}, row {r}, column {c}");
            }
        }
    }
}

/// Sums of products of all rows, with each kind of factor, as f32.
struct SumsOf<'a>(&'a [(PairRow, [i16; 2])]);

impl Work for SumsOf<'_> {
    type Output = [Row; 4];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Row; 4] {
        let mut sums = [L::Sums::zero(); 4];
        for (row, n) in self.0 {
            for (sum, factor) in sums.iter_mut().zip(L::Sums::factors(*n)) {
                *sum = sum.add_products(row, factor);
            }
        }
        sums.map(|sum| L::round(sum).store())
    }
}

#[test]
fn every_kernel_sums_the_same_whole_numbers() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    // Any length, and extremes: the least factor is not −2¹⁵, rows may hold it. Large sums wrap around.
    for round in 0..2_000 {
        let mut number = || match random.random_range(0..4) {
            0 => i16::MIN,
            1 => i16::MAX,
            _ => random.random_range(i16::MIN..=i16::MAX),
        };
        let rows: Vec<(PairRow, [i16; 2])> = (0..round % 9)
            .map(|_| {
                let row = core::array::from_fn(|_| [number(), number()]);
                (row, [number(), number()].map(|n| n.max(-i16::MAX)))
            })
            .collect();
        let mut expected = [Whole8::zero(); 4];
        for (row, n) in &rows {
            for (sum, factor) in expected.iter_mut().zip(Whole8::factors(*n)) {
                *sum = sum.add_products(row, factor);
            }
        }
        let expected = expected.map(|sum| sum.store().map(|sum| sum as f32));
        for kernel in Kernel::ALL.into_iter().filter(|k| k.is_available()) {
            assert_eq!(kernel.run(SumsOf(&rows)), expected, "{kernel:?}: {rows:?}");
        }
    }
}
