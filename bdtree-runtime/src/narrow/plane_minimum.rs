//! The smallest `|w + s e + t g|`: what point–triangle and edge–edge distances share.
//!
//! Solving the 2 × 2 normal equations squares the condition number, and slivers then lose all
//! digits. Here the shorter of e and g is made orthogonal to the longer (Gram–Schmidt, twice), t
//! follows from that part, s from a one-dimensional minimum; for slivers the step is repeated on
//! the residual, which gains the same factor each time.

use crate::math::{add_scaled, clamp, dot};

/// 2⁻¹⁰²: a height below 2⁻⁵¹ of the side is rounding; the boundary is as near as that.
const DEGENERATE: f64 = f64::from_bits((1023 - 102) << 52);

/// Where the smallest `|w + s e + t g|` is taken.
pub(super) struct Minimum {
    /// Factor of e, not clamped.
    pub(super) s: f64,
    /// Factor of g, clamped to `[0, 1]` if the pair is a sliver, else not.
    pub(super) t: f64,
    /// The pair is well enough conditioned for s and t to be trusted within 64 u |w| / |e|, |g|.
    pub(super) trusted: bool,
}

/// Returns the minimum over all s and t, nothing if e and g are parallel to rounding or zero.
#[inline]
pub(super) fn plane_minimum(w: [f64; 3], e: [f64; 3], g: [f64; 3]) -> Option<Minimum> {
    let (ee, gg) = (dot(e, e), dot(g, g));
    if ee >= gg {
        along_longer(w, e, ee, g, gg)
    } else {
        let m = along_longer(w, g, gg, e, ee)?;
        Some(Minimum {
            s: m.t,
            t: m.s,
            trusted: m.trusted,
        })
    }
}

#[inline]
fn along_longer(w: [f64; 3], e: [f64; 3], ee: f64, g: [f64; 3], gg: f64) -> Option<Minimum> {
    if !(ee > 0.0 && gg > 0.0) {
        return None;
    }
    // h: the part of g across e. Once would leave a part along e of u|g|, much against a small h.
    let h = add_scaled(g, -(dot(g, e) / ee), e);
    let h = add_scaled(h, -(dot(h, e) / ee), e);
    let hh = dot(h, h);
    if hh <= gg * DEGENERATE || hh.is_nan() {
        return None;
    }
    let t = -(dot(w, h) / hh);
    if hh * 64.0 >= gg {
        let s = -(dot(add_scaled(w, t, g), e) / ee);
        return Some(Minimum {
            s,
            t,
            trusted: true,
        });
    }
    // h is wrong by u|g|: t by κ|w|/h with κ = u|g|/h. On the residual, small where the shapes
    // touch, the same relative error counts for less; κ < 1/2 here, five steps reach the rounding.
    let mut t = clamp(t, 0.0, 1.0);
    let mut s = 0.0;
    for _ in 0..6 {
        let foot = add_scaled(w, t, g);
        s = -(dot(foot, e) / ee);
        let step = -(dot(add_scaled(foot, s, e), h) / hh);
        let next = clamp(t + step, 0.0, 1.0);
        if next == t {
            break;
        }
        t = next;
        s = -(dot(add_scaled(w, t, g), e) / ee);
    }
    Some(Minimum {
        s,
        t,
        trusted: false,
    })
}
