//! Four f32 side by side where no wider registers are of use: rows of bones' maps. Arrays where the processor is not known
//! to have registers for them.
//!
//! Every operation is rounded once, so the numbers are those of the same steps one at a time.

/// Four f32.
#[derive(Clone, Copy)]
pub(crate) struct Four([f32; 4]);

impl Four {
    #[inline(always)]
    pub(crate) fn splat(x: f32) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    pub(crate) fn load(x: &[f32; 4]) -> Self {
        Self(*x)
    }

    #[inline(always)]
    pub(crate) fn store(self) -> [f32; 4] {
        self.0
    }

    #[inline(always)]
    pub(crate) fn add(self, other: Self) -> Self {
        let ([a, b, c, d], [i, j, k, l]) = (self.0, other.0);
        Self([a + i, b + j, c + k, d + l])
    }

    #[inline(always)]
    pub(crate) fn mul(self, other: Self) -> Self {
        let ([a, b, c, d], [i, j, k, l]) = (self.0, other.0);
        Self([a * i, b * j, c * k, d * l])
    }

    /// The smaller of the two, `other` where one is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        let mut least = other;
        for (least, x) in least.0.iter_mut().zip(self.0) {
            *least = if x < *least { x } else { *least };
        }
        least
    }

    /// The larger of the two, `other` where one is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let mut most = other;
        for (most, x) in most.0.iter_mut().zip(self.0) {
            *most = if x > *most { x } else { *most };
        }
        most
    }

    /// Columns as rows.
    #[inline(always)]
    pub(crate) fn transposed(rows: [Self; 4]) -> [Self; 4] {
        let mut columns = rows;
        for (r, row) in rows.iter().enumerate() {
            for c in 0..4 {
                columns[c].0[r] = row.0[c];
            }
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::Four as Arrays;
    use crate::simd::Four;

    #[test]
    fn registers_do_as_arrays_do() {
        let rows: [[f32; 4]; 4] =
            [0, 1, 2, 3].map(|r| [1, 2, 3, 4].map(|c| (c * 7 + r) as f32 / 3.0));
        let transposed = Four::transposed(rows.map(|row| Four::load(&row))).map(Four::store);
        let expected = Arrays::transposed(rows.map(|row| Arrays::load(&row)));
        assert_eq!(transposed, expected.map(Arrays::store));
        assert_eq!(transposed[3][1].to_bits(), rows[1][3].to_bits());
        let [a, b, ..] = rows;
        let of_registers = Four::load(&a)
            .mul(Four::load(&b))
            .add(Four::splat(0.1))
            .store();
        let of_arrays = Arrays::load(&a).mul(Arrays::load(&b));
        let of_arrays = of_arrays.add(Arrays::splat(0.1)).store();
        assert_eq!(of_registers, of_arrays);
        let (a, b) = ([1.0, f32::NAN, -0.0, 5.0], [2.0, 3.0, 0.0, f32::NAN]);
        let of_registers = [
            Four::load(&a).min(Four::load(&b)).store(),
            Four::load(&a).max(Four::load(&b)).store(),
        ];
        let of_arrays = [
            Arrays::load(&a).min(Arrays::load(&b)).store(),
            Arrays::load(&a).max(Arrays::load(&b)).store(),
        ];
        let bits = |all: [[f32; 4]; 2]| all.map(|row| row.map(f32::to_bits));
        assert_eq!(bits(of_registers), bits(of_arrays));
    }
}
