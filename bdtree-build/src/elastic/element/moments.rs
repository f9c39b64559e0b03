//! Moments of the filled part of a cell.
//!
//! The stiffness and the mass of a partly filled cell are integrals of polynomials of degree four
//! per coordinate over its filled part, so 125 numbers per cell say all about the filling (the
//! finite-cell method with moments instead of sub-cells).

/// Powers of a coordinate in a product of two quadratic functions: 0 to 4.
pub(crate) const POWERS: usize = 5;

/// ⅛ ∫ ξᵃ ηᵇ ζᶜ over the filled part, in [-1, 1]³, at `a + 5b + 25c`; entry 0 is the filled share.
pub(crate) type Moments = [f64; POWERS * POWERS * POWERS];

/// ½ ∫ ξᵃ over [-1, 1].
pub(crate) const LINE: [f64; POWERS] = [1.0, 0.0, 1.0 / 3.0, 0.0, 0.2];

/// Moments of a cell that is filled.
pub(crate) fn full_cell() -> Moments {
    std::array::from_fn(|n| LINE[n % 5] * LINE[n / 5 % 5] * LINE[n / 25])
}

/// The powers of a coordinate.
pub(crate) fn powers(x: f64) -> [f64; POWERS] {
    [1.0, x, x * x, x * x * x, x * x * x * x]
}

/// Adds the moments of one of a cell's eight parts to those of the cell. `upper` says on which
/// axes the part is the upper one.
pub(crate) fn add_eighth(sum: &mut Moments, part: &Moments, upper: [bool; 3]) {
    // ξ = (ξ' ± 1) / 2, so ξᵃ = 2⁻ᵃ Σ C(a, k) ξ'ᵏ (±1)ᵃ⁻ᵏ; the part has half the length.
    const BINOMIALS: [[f64; POWERS]; POWERS] = [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, 2.0, 1.0, 0.0, 0.0],
        [1.0, 3.0, 3.0, 1.0, 0.0],
        [1.0, 4.0, 6.0, 4.0, 1.0],
    ];
    let mut values = *part;
    for (axis, stride) in [1, 5, 25].into_iter().enumerate() {
        let sign: f64 = if upper[axis] { 1.0 } else { -1.0 };
        for start in (0..values.len()).filter(|n| n / stride % POWERS == 0) {
            let line: [f64; POWERS] = std::array::from_fn(|k| values[start + k * stride]);
            for (a, row) in BINOMIALS.iter().enumerate() {
                let terms = (0..=a).map(|k| row[k] * line[k] * sign.powi((a - k) as i32));
                values[start + a * stride] = 0.5f64.powi(a as i32 + 1) * terms.sum::<f64>();
            }
        }
    }
    for (s, v) in sum.iter_mut().zip(&values) {
        *s += v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eighths_of_a_full_cell_make_a_full_cell() {
        let mut sum = [0.0; 125];
        for n in 0..8 {
            add_eighth(&mut sum, &full_cell(), [0, 1, 2].map(|a| n >> a & 1 == 1));
        }
        for (a, b) in sum.iter().zip(full_cell()) {
            assert!((a - b).abs() < 1e-15, "{a} {b}");
        }
    }
}
