//! Weights over time as one sampler has them (glTF 2.0, appendix C).

use gltf::json::animation::Interpolation;

/// Linear playback stays within this share of a curve's largest weight (at least 1).
const TOLERANCE_REL: f64 = 1e-3;

/// Most pieces that one cubic piece is divided into.
const PIECES_MAX: usize = 256;

/// Which value a curve has at a jump.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Before,
    After,
}

/// The weights of one node's targets; constant before the first key and after the last.
#[derive(Debug)]
pub(super) struct Curve {
    pub(super) interpolation: Interpolation,
    /// Seconds of the K keys, never descending.
    pub(super) times: Vec<f64>,
    /// Number of weights M.
    pub(super) width: usize,
    /// K × M weights; for cubic splines K × 3 × M: slope before the key, weight, slope after it.
    pub(super) values: Vec<f64>,
}

impl Curve {
    /// Values that a curve of `keys` keys and `width` weights has.
    pub(super) fn value_count(
        interpolation: Interpolation,
        keys: usize,
        width: usize,
    ) -> Option<usize> {
        let rows = match interpolation {
            Interpolation::CubicSpline => 3,
            Interpolation::Linear | Interpolation::Step => 1,
        };
        keys.checked_mul(width)?.checked_mul(rows)
    }

    /// The M weights at time `t`, into `out`.
    pub(super) fn weights(&self, t: f64, side: Side, out: &mut [f64]) {
        let next = self.times.partition_point(|&key| match side {
            Side::Before => key < t,
            Side::After => key <= t,
        });
        let last = self.times.len().saturating_sub(1);
        if next == 0 || next > last {
            out.copy_from_slice(self.row(next.min(last), 0));
            return;
        }
        let (from, to) = (next - 1, next);
        let span = self.times[to] - self.times[from];
        let u = (t - self.times[from]) / span;
        let (v, w) = (self.row(from, 0), self.row(to, 0));
        match self.interpolation {
            Interpolation::Step => out.copy_from_slice(v),
            Interpolation::Linear => {
                for k in 0..self.width {
                    out[k] = v[k] * (1.0 - u) + w[k] * u;
                }
            }
            Interpolation::CubicSpline => {
                let (a, b) = (self.row(from, 1), self.row(to, -1));
                let (u2, u3) = (u * u, u * u * u);
                for k in 0..self.width {
                    out[k] = (2.0 * u3 - 3.0 * u2 + 1.0) * v[k]
                        + (u3 - 2.0 * u2 + u) * span * a[k]
                        + (3.0 * u2 - 2.0 * u3) * w[k]
                        + (u3 - u2) * span * b[k];
                }
            }
        }
    }

    /// The ascending times between which the curve is linear within the tolerance, and by how much
    /// it is beyond that where it bends too fast, 0 if nowhere. `None` for more than `most` times.
    pub(super) fn frames(&self, most: usize) -> Option<(Vec<f64>, f64)> {
        let mut times: Vec<f64> = Vec::new();
        let mut push = |t: f64| {
            if times.last().is_none_or(|&last| last < t) {
                if times.len() == most {
                    return None;
                }
                times.push(t);
            }
            Some(())
        };
        if self.interpolation != Interpolation::CubicSpline {
            self.times.iter().try_for_each(|&t| push(t))?;
            return Some((times, 0.0));
        }
        push(*self.times.first()?)?;
        let weights = (0..self.times.len()).flat_map(|key| self.row(key, 0));
        let tolerance = TOLERANCE_REL * weights.fold(1.0, |m: f64, w| m.max(w.abs()));
        let mut worst = 0.0_f64;
        for (from, pair) in self.times.windows(2).enumerate() {
            let span = pair[1] - pair[0];
            // A chord of 1/n of a piece is off by at most |p''| / (8 n²).
            let off = self.bend(from, span) / 8.0;
            let wanted = (off / tolerance).sqrt().ceil();
            // No overflow: cut to the greatest number of pieces; NaN becomes 1.
            let pieces = wanted.clamp(1.0, PIECES_MAX as f64) as usize;
            if wanted > PIECES_MAX as f64 {
                worst = worst.max(off / (PIECES_MAX * PIECES_MAX) as f64);
            }
            for i in 1..pieces {
                push(pair[0] + span * (i as f64 / pieces as f64))?;
            }
            push(pair[1])?;
        }
        Some((times, worst))
    }

    /// Largest |p''| of the cubic piece after key `from`, per square of the piece's length: p'' is
    /// linear, so that one of the ends has it.
    fn bend(&self, from: usize, span: f64) -> f64 {
        let (v, w) = (self.row(from, 0), self.row(from + 1, 0));
        let (a, b) = (self.row(from, 1), self.row(from + 1, -1));
        (0..self.width)
            .map(|k| {
                let (rise, a, b) = (w[k] - v[k], span * a[k], span * b[k]);
                let begin = (6.0 * rise - 4.0 * a - 2.0 * b).abs();
                begin.max((2.0 * a + 4.0 * b - 6.0 * rise).abs())
            })
            .fold(0.0, f64::max)
    }

    /// The weights of a key, or its slopes before (−1) or after (1) it; empty where there are none.
    fn row(&self, key: usize, which: isize) -> &[f64] {
        let row = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + 1).saturating_add_signed(which),
            Interpolation::Linear | Interpolation::Step => key,
        };
        self.values
            .get(row * self.width..(row + 1) * self.width)
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(curve: &Curve, t: f64, side: Side) -> Vec<f64> {
        let mut out = vec![f64::NAN; curve.width];
        curve.weights(t, side, &mut out);
        out
    }

    #[test]
    fn steps_and_keys_of_one_time_jump() {
        let mut curve = Curve {
            interpolation: Interpolation::Step,
            times: vec![1.0, 2.0, 4.0],
            width: 1,
            values: vec![0.25, 0.5, 1.0],
        };
        for (t, before, after) in [
            (0.0, 0.25, 0.25),
            (1.0, 0.25, 0.25),
            (2.0, 0.25, 0.5),
            (3.0, 0.5, 0.5),
            (4.0, 0.5, 1.0),
            (5.0, 1.0, 1.0),
        ] {
            assert_eq!(at(&curve, t, Side::Before), [before], "{t}");
            assert_eq!(at(&curve, t, Side::After), [after], "{t}");
        }
        curve.interpolation = Interpolation::Linear;
        curve.times = vec![1.0, 1.0, 2.0];
        assert_eq!(at(&curve, 1.0, Side::Before), [0.25]);
        assert_eq!(at(&curve, 1.0, Side::After), [0.5]);
        assert_eq!(at(&curve, 1.5, Side::After), [0.75]);
    }

    /// The twin: the polynomial through values and slopes, sampled densely.
    #[test]
    fn cubic_pieces_are_divided_finely_enough() {
        let curve = Curve {
            interpolation: Interpolation::CubicSpline,
            times: vec![0.0, 0.5, 2.0],
            width: 2,
            values: [
                [[0.0, 0.0], [0.0, 1.0], [4.0, -2.0]],
                [[1.0, 0.0], [1.0, 0.5], [-6.0, 0.0]],
                [[0.0, 3.0], [0.2, 0.0], [0.0, 0.0]],
            ]
            .as_flattened()
            .as_flattened()
            .to_vec(),
        };
        // p = v + a s + c s² + d s³ with s in seconds.
        let truth = |t: f64, k: usize| {
            let (t0, h, v, w, a, b) = if t < 0.5 {
                (0.0, 0.5, [0.0, 1.0], [1.0, 0.5], [4.0, -2.0], [1.0, 0.0])
            } else {
                (0.5, 1.5, [1.0, 0.5], [0.2, 0.0], [-6.0, 0.0], [0.0, 3.0])
            };
            let (s, rise) = (t - t0, (w[k] - v[k]) / h);
            let c = (3.0 * rise - 2.0 * a[k] - b[k]) / h;
            let d = (a[k] + b[k] - 2.0 * rise) / (h * h);
            v[k] + s * (a[k] + s * (c + s * d))
        };
        let (times, off) = curve.frames(200).expect("few frames");
        assert_eq!(off, 0.0);
        assert!(times.is_sorted_by(|a, b| a < b));
        assert!(curve.frames(times.len()).is_some() && curve.frames(times.len() - 1).is_none());
        let mut worst = 0.0_f64;
        for pair in times.windows(2) {
            let (v, w) = (
                at(&curve, pair[0], Side::After),
                at(&curve, pair[1], Side::Before),
            );
            for i in 0..=10 {
                let u = f64::from(i) / 10.0;
                let t = pair[0] + (pair[1] - pair[0]) * u;
                let exact = at(&curve, t, Side::After);
                for k in 0..2 {
                    assert!((exact[k] - truth(t, k)).abs() < 1e-14 * 16.0);
                    worst = worst.max((v[k] * (1.0 - u) + w[k] * u - truth(t, k)).abs());
                }
            }
        }
        // Not far finer than needed either.
        assert!(worst < 1e-3 && worst > 2e-4, "{worst}");
    }
}
