//! The nearest points of four triangles at once: the steps of [`super::closest_point`], in the
//! same order, four numbers side by side, so that the bits are the same.

use crate::rounding::{MARGIN, TOUCH};
use crate::simd::{Quad, Quad3, add3, cross3, dot3, scale3, select3, splat3, sub3};

use super::point_triangle::{LARGE, SMALL};

/// The nearest points of four triangles.
pub(crate) struct ClosestFour<Q: Quad> {
    /// The points.
    pub(crate) point: Quad3<Q>,
    /// Weights of the corners.
    pub(crate) barycentric: Quad3<Q>,
    pub(crate) distance: Q,
    /// The triangles that are fair and do not seem to touch: of the others nothing here is meant.
    pub(crate) fair: u8,
}

/// [`super::closest_point`] for those of four triangles that are no slivers.
#[inline(always)]
pub(crate) fn closest_four<Q: Quad>(p: [f64; 3], tri: &[Quad3<Q>; 3]) -> ClosestFour<Q> {
    let p = splat3::<Q>(p);
    let (zero, one, minus) = (Q::splat(0.0), Q::splat(1.0), Q::splat(-1.0));
    let r = [sub3(tri[0], p), sub3(tri[1], p), sub3(tri[2], p)];
    let sides = [
        sub3(tri[1], tri[0]),
        sub3(tri[2], tri[1]),
        sub3(tri[0], tri[2]),
    ];
    let lengths = [
        dot3(sides[0], sides[0]),
        dot3(sides[1], sides[1]),
        dot3(sides[2], sides[2]),
    ];

    // `foot_of_fair_triangle`; every length is asked for, so that NaN is not fair.
    let e = sides[0];
    let g = sub3([zero; 3], sides[2]);
    let n = cross3(e, g);
    let nn = dot3(n, n);
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    let rr = dot3(r[0], r[0]);
    let large = Q::splat(LARGE);
    let mut fair = nn.mul(Q::splat(64.0)).at_least(longest.mul(longest));
    fair = Q::both(fair, longest.above(Q::splat(SMALL)));
    fair = Q::both(fair, large.above(rr));
    for k in 0..3 {
        fair = Q::both(fair, large.above(lengths[k]));
    }
    let s = dot3(cross3(g, r[0]), n).div(nn);
    let t = dot3(cross3(r[0], e), n).div(nn);
    let w = one.sub(t).sub(s);
    let shortest = lengths[0].min(lengths[1]).min(lengths[2]);
    let margin = Q::splat(MARGIN).mul(one.add(rr.div(shortest)));
    let near = [margin.at_least(t), margin.at_least(w), margin.at_least(s)];

    let inside = Q::both(
        w.at_least(zero),
        Q::both(s.at_least(zero), t.at_least(zero)),
    );
    let q = add3(
        add3(r[0], scale3(sides[0], s)),
        scale3(sides[2], t.mul(minus)),
    );
    let mut weights = select3(inside, [w, s, t], [one, zero, zero]);
    let mut squared = Q::select(inside, dot3(q, q), Q::splat(f64::INFINITY));
    for k in 0..3 {
        let next = (k + 1) % 3;
        // `segment_minimum`
        let (a, b, e) = (r[k], r[next], sides[k]);
        let s = unit_clamp(dot3(a, e).div(lengths[k]).mul(minus));
        let rest = one.sub(s);
        let from_a = Q::splat(0.5).at_least(s);
        let factor = Q::select(from_a, s, rest.mul(minus));
        let q = add3(select3(from_a, a, b), scale3(e, factor));
        let edge = dot3(q, q);
        let better = Q::both(near[k], squared.above(edge));
        squared = Q::select(better, edge, squared);
        let mut on_edge = [zero; 3];
        on_edge[k] = rest;
        on_edge[next] = s;
        weights = select3(better, on_edge, weights);
    }
    // `touching_or` is for one triangle.
    fair = Q::both(fair, squared.above(longest.mul(Q::splat(TOUCH))));
    ClosestFour {
        point: combine(tri, weights),
        barycentric: weights,
        distance: squared.sqrt(),
        fair: Q::bits(fair),
    }
}

/// [`super::combine`].
#[inline(always)]
fn combine<Q: Quad>(tri: &[Quad3<Q>; 3], [w0, w1, w2]: Quad3<Q>) -> Quad3<Q> {
    let second = w1.at_least(w2);
    let first = Q::both(w0.at_least(w1), w0.at_least(w2));
    let base = select3(first, tri[0], select3(second, tri[1], tri[2]));
    let i = select3(first, tri[1], select3(second, tri[2], tri[0]));
    let j = select3(first, tri[2], select3(second, tri[0], tri[1]));
    let w_i = Q::select(first, w1, Q::select(second, w2, w0));
    let w_j = Q::select(first, w2, Q::select(second, w0, w1));
    let offset = add3([Q::splat(0.0); 3], scale3(sub3(i, base), w_i));
    add3(base, add3(offset, scale3(sub3(j, base), w_j)))
}

/// [`crate::math::clamp`] into `[0, 1]`.
#[inline(always)]
fn unit_clamp<Q: Quad>(x: Q) -> Q {
    let (zero, one) = (Q::splat(0.0), Q::splat(1.0));
    Q::select(x.above(one), one, Q::select(x.above(zero), x, zero))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::{ClosestFour, closest_four};
    use crate::narrow::{Triangle, closest_point};
    use crate::simd::quad::Array4;
    use crate::simd::{Quad, Quad3};

    /// Triangles of f32 coordinates: fair ones, slivers, needles, lines and points.
    fn triangle(rng: &mut rand_pcg::Pcg64Mcg) -> [[f32; 3]; 3] {
        let mut corner = || [0; 3].map(|_| rng.random_range(-1.0_f32..1.0));
        let (a, b, mut c) = (corner(), corner(), corner());
        match rng.random_range(0..6) {
            0 => c = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
            1 => c = b,
            2 => c = [0, 1, 2].map(|k| b[k] + 1e-4 * c[k]),
            _ => {}
        }
        [a, b, c]
    }

    #[test]
    fn four_have_the_bits_of_one() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(4);
        let mut compared = 0;
        for round in 0..20_000 {
            let stored = [0; 4].map(|_| triangle(&mut rng));
            let far = if round % 5 == 0 { 1e6 } else { 1.0 };
            let p: [f64; 3] = [0; 3].map(|_| far * rng.random_range(-1.5..1.5));
            let lanes: [Quad3<Array4>; 3] = [0, 1, 2].map(|corner| {
                [0, 1, 2].map(|axis| Array4::widen(&[0, 1, 2, 3].map(|i| stored[i][corner][axis])))
            });
            let ClosestFour {
                point,
                barycentric,
                distance,
                fair,
            } = closest_four(p, &lanes);
            for i in 0..4 {
                if fair & (1 << i) == 0 {
                    continue;
                }
                compared += 1;
                let one: Triangle = stored[i].map(|corner| corner.map(f64::from));
                let one = closest_point(p, &one);
                let lane = |x: Quad3<Array4>| x.map(|axis| axis.store()[i].to_bits());
                assert_eq!(lane(point), one.point.map(f64::to_bits));
                assert_eq!(lane(barycentric), one.barycentric.map(f64::to_bits));
                assert_eq!(distance.store()[i].to_bits(), one.distance.to_bits());
            }
        }
        assert!(compared > 20_000, "{compared}");
    }
}
