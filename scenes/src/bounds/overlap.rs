//! Which shapes meet: pairs of them in one frame, a shape and a ball, a shape and a ray.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::shape::{Ball, Cuboid, Shape, Slab};

/// Separating axes that two boxes, or two slabs, are tried along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxTest {
    /// The coordinate axes of the first body, the second's box replaced by its hull there.
    Hull,
    /// The axes of both boxes; each slab's normal, the other's ball there.
    Faces,
    /// Those and the nine products of edges: exact; the normals, the other's slab counted too.
    Full,
}

/// What a pair test needs to know of the two bodies' frames (the first's is the common one).
#[derive(Debug, Clone)]
pub struct Relation {
    /// How boxes are tested.
    pub boxes: BoxTest,
    /// Fixed directions of both bodies.
    directions: Vec<Vector3<f64>>,
    /// From the second's frame to the first's.
    place: Isometry3<f64>,
    /// Each direction of the first as three directions of the second, and the other way round.
    combinations: [Vec<[(usize, f64); 3]>; 2],
}

impl Relation {
    /// The relation of two bodies whose k-DOPs have these directions (none: no k-DOPs).
    pub fn new(boxes: BoxTest, directions: &[Vector3<f64>], place: &Isometry3<f64>) -> Self {
        let back = place.inverse();
        let combine = |turn: &Isometry3<f64>| {
            let all = directions.iter();
            all.map(|n| combination(&(turn * n), directions)).collect()
        };
        Self {
            boxes,
            directions: directions.to_vec(),
            place: *place,
            combinations: [combine(&back), combine(place)],
        }
    }

    /// Whether two shapes may share a point; that of the second was moved to the first's frame.
    pub fn meet(&self, a: &Shape, b: &Shape) -> bool {
        let slab_misses = |slab: &Option<Slab>, other: &Shape| {
            slab.is_some_and(|slab| slab_apart(&slab, other, self.boxes == BoxTest::Full))
        };
        let apart = match (&a.ball, &b.ball) {
            (Some(a), Some(b)) => (a.centre - b.centre).norm() > a.radius + b.radius,
            _ => false,
        } || match (&a.cuboid, &b.cuboid) {
            (Some(a), Some(b)) => boxes_apart(a, b, self.boxes),
            (Some(a), None) => b.ball.is_some_and(|ball| distance(a, &ball) > 0.0),
            (None, Some(b)) => a.ball.is_some_and(|ball| distance(b, &ball) > 0.0),
            (None, None) => false,
        };
        !(apart || slab_misses(&a.slab, b) || slab_misses(&b.slab, a) || self.ranges_apart(a, b))
    }

    fn ranges_apart(&self, a: &Shape, b: &Shape) -> bool {
        let shift = self.place.translation.vector;
        let back = self.place.inverse().translation.vector;
        let sides = [(a, b, shift), (b, a, back)];
        sides
            .iter()
            .zip(&self.combinations)
            .any(|((own, other, shift), combinations)| {
                if own.ranges.is_empty() || other.ranges.is_empty() {
                    return false;
                }
                let all = self.directions.iter().zip(&own.ranges).zip(combinations);
                all.into_iter().any(|((n, range), combination)| {
                    let (mut low, mut high) = (n.dot(shift), n.dot(shift));
                    for (k, weight) in combination {
                        let [l, h] = other.ranges[*k];
                        low += (weight * l).min(weight * h);
                        high += (weight * l).max(weight * h);
                    }
                    low > range[1] || high < range[0]
                })
            })
    }
}

/// A direction as the sum of three others that costs least: Σ|weights| smallest.
fn combination(n: &Vector3<f64>, directions: &[Vector3<f64>]) -> [(usize, f64); 3] {
    let mut best = ([(0, 0.0); 3], f64::INFINITY);
    for i in 0..directions.len() {
        for j in i + 1..directions.len() {
            for k in j + 1..directions.len() {
                let matrix = Matrix3::from_columns(&[directions[i], directions[j], directions[k]]);
                if matrix.determinant().abs() < 0.1 {
                    continue;
                }
                let Some(inverse) = matrix.try_inverse() else {
                    continue;
                };
                let weights = inverse * n;
                let cost = weights.abs().sum();
                if cost < best.1 {
                    best = ([(i, weights[0]), (j, weights[1]), (k, weights[2])], cost);
                }
            }
        }
    }
    best.0
}

/// Whether the plane pair misses the other shape's ball, seen alone or cut by its own slab.
fn slab_apart(slab: &Slab, other: &Shape, by_slab: bool) -> bool {
    let Some(ball) = other.ball else {
        return false;
    };
    let n = slab.normal;
    let gap = (n.dot(&ball.centre) - slab.middle).abs();
    if gap > slab.half + ball.radius * n.norm() || !by_slab {
        return gap > slab.half + ball.radius * n.norm();
    }
    // n = α m + e with e across m: α from the other's slab, e from its ball.
    other.slab.is_some_and(|cut| {
        let m = cut.normal;
        let share = n.dot(&m) / m.norm_squared();
        let across = n - m * share;
        let middle = share * cut.middle + across.dot(&ball.centre);
        let half = share.abs() * cut.half + across.norm() * ball.radius;
        (middle - slab.middle).abs() > slab.half + half
    })
}

/// Distance of a ball from a box; at most 0 where they meet.
fn distance(cuboid: &Cuboid, ball: &Ball) -> f64 {
    let local = cuboid.axes.tr_mul(&(ball.centre - cuboid.centre)).abs() - cuboid.half;
    local.sup(&Vector3::zeros()).norm() - ball.radius
}

fn boxes_apart(a: &Cuboid, b: &Cuboid, test: BoxTest) -> bool {
    let offset = a.axes.tr_mul(&(b.centre - a.centre));
    let turn = a.axes.tr_mul(&b.axes);
    let size = turn.abs();
    let out_a = offset.abs() - a.half - size * b.half;
    if out_a.max() > 0.0 {
        return true;
    }
    if test == BoxTest::Hull {
        return false;
    }
    let out_b = turn.tr_mul(&offset).abs() - size.tr_mul(&a.half) - b.half;
    if out_b.max() > 0.0 {
        return true;
    }
    test == BoxTest::Full
        && (0..3).any(|i| {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            (0..3).any(|j| {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let reach_a = a.half[i1] * size[(i2, j)] + a.half[i2] * size[(i1, j)];
                let reach_b = b.half[j1] * size[(i, j2)] + b.half[j2] * size[(i, j1)];
                let gap = offset[i2] * turn[(i1, j)] - offset[i1] * turn[(i2, j)];
                // Parallel edges give no axis, only rounding.
                gap.abs() > (reach_a + reach_b) * (1.0 + 1e-9) + 1e-12
            })
        })
}

/// Whether a shape may meet a ball.
pub fn meets_ball(shape: &Shape, directions: &[Vector3<f64>], ball: &Ball) -> bool {
    let as_shape = Shape {
        ball: Some(*ball),
        ..Shape::default()
    };
    let apart = match (&shape.ball, &shape.cuboid) {
        (Some(own), _) if (own.centre - ball.centre).norm() > own.radius + ball.radius => true,
        (_, Some(cuboid)) => distance(cuboid, ball) > 0.0,
        _ => false,
    };
    let outside = |(range, n): (&[f64; 2], &Vector3<f64>)| {
        let x = n.dot(&ball.centre);
        x - ball.radius > range[1] || x + ball.radius < range[0]
    };
    let slab = shape
        .slab
        .is_some_and(|slab| slab_apart(&slab, &as_shape, false));
    !(apart || slab || shape.ranges.iter().zip(directions).any(outside))
}

/// A ray: origin and unit direction.
pub type RayLine = (Vector3<f64>, Vector3<f64>);

/// Where a ray may enter a shape; `None` where it misses.
pub fn entry(shape: &Shape, directions: &[Vector3<f64>], (o, d): &RayLine) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    if let Some(ball) = shape.ball {
        let to = ball.centre - o;
        let along = to.dot(d);
        let root = (along * along - to.norm_squared() + ball.radius * ball.radius).sqrt();
        if root.is_nan() {
            return None;
        }
        (enter, leave) = (enter.max(along - root), leave.min(along + root));
    }
    let mut cut = |n: &Vector3<f64>, low: f64, high: f64| {
        let (x, v) = (n.dot(o), n.dot(d));
        let (a, b) = ((low - x) / v, (high - x) / v);
        // Along the planes: NaN or infinities of the right signs.
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    };
    if let Some(cuboid) = shape.cuboid {
        for k in 0..3 {
            let n = cuboid.axes.column(k).into_owned();
            let middle = n.dot(&cuboid.centre);
            cut(&n, middle - cuboid.half[k], middle + cuboid.half[k]);
        }
    }
    if let Some(slab) = shape.slab {
        cut(
            &slab.normal,
            slab.middle - slab.half,
            slab.middle + slab.half,
        );
    }
    for (range, n) in shape.ranges.iter().zip(directions) {
        cut(n, range[0], range[1]);
    }
    (enter <= leave).then_some(enter)
}
