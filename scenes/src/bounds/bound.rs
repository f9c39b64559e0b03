//! The bounds that are compared, their numbers for a body, and their shapes at a pose.

use bdtree_build::tree::LaneKind;
use bdtree_fixtures::poses::rng;
use bdtree_format::LANES;
use nalgebra::{Matrix3, Vector3};

use super::affine::{Affine, AffineBall, Fields};
use super::body::Body;
use super::scene::amplitudes;
use super::shape::{Ball, Cuboid, Shape};
use super::slabs::{Direction, TurningSlab, dop_directions, principal_axes};
use super::sphere::{Growth, Sphere, enclosing};

/// A kind of bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// A ball.
    Ball(Growth),
    /// A ball over an affine field.
    Affine(Affine),
    /// For each node whichever is smallest over some random poses: the product's ball or one of
    /// these.
    BestOf(&'static [Affine]),
    /// The smallest ball about c' of the vertices as deformed: what no ball with this centre beats.
    Wrapped,
    /// The smallest ball of the vertices as deformed.
    Smallest,
    /// The product's ball, for leaf lanes as `Wrapped`.
    LeafWrapped,
    /// The box of the vertices as deformed, in the axes of the query: what a refit gives.
    RefittedBox,
    /// A box in the body's axes.
    Aabb,
    /// A box in the lane's principal axes.
    Obb,
    /// The product's ball and a box in the body's axes.
    BallAndAabb,
    /// The product's ball and a box in the lane's principal axes.
    BallAndObb,
    /// Intervals along this many fixed directions.
    Dop(usize),
    /// Boxes in the body's axes for leaf lanes, the product's balls for the others.
    LeafAabb,
    /// Boxes in principal axes for leaf lanes, the product's balls for the others.
    LeafObb,
    /// Boxes in the body's axes for inner lanes, the product's balls for leaf lanes.
    InnerAabb,
    /// The product's ball and a slab across its thinnest direction.
    Disc,
    /// The product's ball and a slab whose normal follows the modes.
    TurningDisc,
    /// As `TurningDisc`, the slab for leaf lanes only.
    LeafTurningDisc,
}

impl Bound {
    /// Numbers per lane with M modes, δR left out; 0 where the bound is not stored.
    pub fn numbers(self, m: usize) -> usize {
        match self {
            Self::Ball(Growth::Mean | Growth::Sum) => 4 + 4 * m,
            Self::Ball(Growth::SecondOrder) => 4 + 6 * m,
            Self::Ball(Growth::Similarity) => 4 + 8 * m,
            Self::LeafWrapped => 4 + 6 * m,
            Self::Affine(kind) => kind.numbers(m),
            Self::BestOf(kinds) => {
                let all = kinds.iter().map(|kind| kind.numbers(m));
                all.fold(4 + 6 * m, usize::max)
            }
            Self::Wrapped | Self::Smallest | Self::RefittedBox => 0,
            Self::Aabb | Self::LeafAabb | Self::InnerAabb => 6 + 6 * m,
            Self::Obb | Self::LeafObb => 15 + 6 * m,
            Self::BallAndAabb => 10 + 12 * m,
            Self::BallAndObb => 19 + 12 * m,
            Self::Dop(k) => 2 * k * (1 + m),
            Self::Disc => 9 + 8 * m,
            Self::TurningDisc | Self::LeafTurningDisc => 9 + 11 * m,
        }
    }

    /// Rows that an update multiplies by q_j and adds, for each mode; 0 where nothing is stored.
    pub fn rows_per_mode(self) -> f64 {
        let rows = match self {
            Self::Affine(kind) => return kind.rows_per_mode(),
            Self::BestOf(kinds) => {
                let all = kinds.iter().map(|kind| kind.rows_per_mode());
                return all.fold(5.0, f64::max);
            }
            Self::Ball(Growth::Mean | Growth::Sum) => 4,
            Self::Ball(Growth::SecondOrder) | Self::LeafWrapped => 5,
            Self::Ball(Growth::Similarity) => 8,
            Self::Wrapped | Self::Smallest | Self::RefittedBox => 0,
            Self::Aabb | Self::Obb | Self::LeafAabb | Self::LeafObb | Self::InnerAabb => 6,
            Self::BallAndAabb | Self::BallAndObb => 11,
            Self::Dop(k) => 2 * k as i32,
            Self::Disc => 7,
            Self::TurningDisc | Self::LeafTurningDisc => 10,
        };
        f64::from(rows)
    }

    /// Operations on eight lanes after those rows, where they are more than a few.
    pub fn operations(self) -> usize {
        match self {
            Self::Affine(kind) => kind.operations(),
            Self::BestOf(kinds) => kinds.iter().map(|k| k.operations()).max().unwrap_or(0),
            _ => 0,
        }
    }

    /// Fixed directions of the bound.
    pub fn directions(self) -> Vec<Vector3<f64>> {
        match self {
            Self::Dop(count) => dop_directions(count),
            _ => Vec::new(),
        }
    }
}

/// The numbers of one lane.
#[derive(Debug, Clone, Default)]
struct Numbers {
    ball: Option<Sphere>,
    affine: Option<AffineBall>,
    axes: Option<Matrix3<f64>>,
    sides: Vec<Direction>,
    slab: Option<Direction>,
    turning: Option<TurningSlab>,
    dop: Vec<Direction>,
}

/// The numbers of a bound for all lanes of a body.
#[derive(Debug, Clone)]
pub struct Wrapped {
    /// Which bound.
    pub bound: Bound,
    /// Its fixed directions.
    pub directions: Vec<Vector3<f64>>,
    lanes: Vec<Numbers>,
}

impl Wrapped {
    /// Computes them.
    pub fn new(body: &Body, bound: Bound) -> Self {
        let directions = bound.directions();
        let lanes = (0..body.tree.nodes.len()).flat_map(|node| match bound {
            Bound::Affine(kind) => affine(body, node, kind),
            Bound::BestOf(kinds) => best(body, node, kinds),
            _ => each(body, node, |lane| {
                let leaf = body.kind(lane) == LaneKind::Leaf;
                numbers(body, lane, bound, leaf, &directions)
            }),
        });
        Self {
            bound,
            lanes: lanes.collect(),
            directions,
        }
    }

    /// A lane's shape at a pose, in the body's frame. `vertices` are all vertices as deformed, in
    /// whichever axes boxes are to be refitted.
    pub fn at(&self, body: &Body, lane: usize, q: &[f64], vertices: &[Vector3<f64>]) -> Shape {
        let numbers = &self.lanes[lane];
        let mut shape = Shape {
            ball: numbers.ball_at(q),
            slab: numbers.slab.as_ref().map(|slab| slab.at(q)),
            ..Shape::default()
        };
        let now = || {
            let below = body.vertices_below(lane).iter();
            below.map(|v| vertices[*v as usize]).collect::<Vec<_>>()
        };
        match self.bound {
            Bound::Wrapped => {
                let centre = shape.ball.map_or(Vector3::zeros(), |ball| ball.centre);
                shape.ball = Some(wrapped(centre, &now()));
            }
            Bound::LeafWrapped if body.kind(lane) == LaneKind::Leaf => {
                let centre = shape.ball.map_or(Vector3::zeros(), |ball| ball.centre);
                shape.ball = Some(wrapped(centre, &now()));
            }
            Bound::Smallest => shape.ball = Some(enclosing(&now())),
            Bound::RefittedBox => shape.cuboid = Some(box_of(&now())),
            _ => {}
        }
        if let (Some(turning), Some(sphere), Some(ball)) =
            (&numbers.turning, &numbers.ball, &shape.ball)
        {
            shape.slab = Some(turning.at(q, ball.centre, sphere.spread(q)));
        }
        if let Some(axes) = numbers.axes {
            let sides = [0, 1, 2].map(|k| numbers.sides[k].at(q));
            shape.cuboid = Some(Cuboid {
                centre: axes * Vector3::from(sides.map(|side| side.middle)),
                axes,
                half: Vector3::from(sides.map(|side| side.half)),
            });
        }
        shape.ranges = numbers
            .dop
            .iter()
            .map(|direction| {
                let slab = direction.at(q);
                [slab.middle - slab.half, slab.middle + slab.half]
            })
            .collect();
        shape
    }
}

impl Numbers {
    fn ball_at(&self, q: &[f64]) -> Option<Ball> {
        let affine = self.affine.as_ref().map(|ball| ball.at(q));
        affine.or_else(|| Some(self.ball.as_ref()?.at(q)))
    }
}

/// The numbers of a node's eight lanes.
fn each(body: &Body, node: usize, of: impl Fn(usize) -> Numbers) -> Vec<Numbers> {
    let lanes = LANES * node..LANES * (node + 1);
    lanes
        .map(|lane| match body.kind(lane) {
            LaneKind::Empty => Numbers::default(),
            _ => of(lane),
        })
        .collect()
}

fn affine(body: &Body, node: usize, kind: Affine) -> Vec<Numbers> {
    let full = (LANES * node..LANES * (node + 1)).filter(|l| body.kind(*l) != LaneKind::Empty);
    let shared = Fields::fit(body, &full.collect::<Vec<_>>(), kind);
    each(body, node, |lane| {
        let ball = if kind.shared {
            AffineBall::wrap(body, lane, kind, &shared)
        } else {
            AffineBall::wrap(body, lane, kind, &Fields::fit(body, &[lane], kind))
        };
        Numbers {
            affine: Some(ball),
            ..Numbers::default()
        }
    })
}

/// The product's balls or one of `kinds`, by the sum of radii over random poses.
fn best(body: &Body, node: usize, kinds: &[Affine]) -> Vec<Numbers> {
    let mut rng = rng(node as u64);
    let poses: Vec<_> = (0..8)
        .map(|_| amplitudes(body.mode_count(), &mut rng))
        .collect();
    let size = |lanes: &[Numbers]| {
        let radii = poses.iter().flat_map(|q| {
            lanes
                .iter()
                .filter_map(|lane| Some(lane.ball_at(q)?.radius))
        });
        radii.sum::<f64>()
    };
    let product = each(body, node, |lane| Numbers {
        ball: Some(Sphere::wrap(body, lane, Growth::SecondOrder)),
        ..Numbers::default()
    });
    let others = kinds.iter().map(|kind| affine(body, node, *kind));
    others.fold(product, |best, other| {
        if size(&other) < size(&best) {
            other
        } else {
            best
        }
    })
}

fn numbers(
    body: &Body,
    lane: usize,
    bound: Bound,
    leaf: bool,
    directions: &[Vector3<f64>],
) -> Numbers {
    let ball = |growth| Some(Sphere::wrap(body, lane, growth));
    let product = || ball(Growth::SecondOrder);
    let with_box = |ball: Option<Sphere>, axes: Matrix3<f64>| Numbers {
        ball,
        axes: Some(axes),
        sides: (0..3)
            .map(|k| Direction::wrap(body, lane, axes.column(k).into_owned()))
            .collect(),
        ..Numbers::default()
    };
    let only = |ball| Numbers {
        ball,
        ..Numbers::default()
    };
    let thin = || principal_axes(body, lane).column(2).into_owned();
    match bound {
        Bound::Ball(growth) => only(ball(growth)),
        Bound::Wrapped | Bound::LeafWrapped => only(product()),
        Bound::Smallest | Bound::RefittedBox | Bound::Affine(_) | Bound::BestOf(_) => {
            Numbers::default()
        }
        Bound::Aabb => with_box(None, Matrix3::identity()),
        Bound::Obb => with_box(None, principal_axes(body, lane)),
        Bound::BallAndAabb => with_box(product(), Matrix3::identity()),
        Bound::BallAndObb => with_box(product(), principal_axes(body, lane)),
        Bound::LeafAabb if leaf => with_box(None, Matrix3::identity()),
        Bound::LeafObb if leaf => with_box(None, principal_axes(body, lane)),
        Bound::InnerAabb if !leaf => with_box(None, Matrix3::identity()),
        Bound::LeafAabb | Bound::LeafObb | Bound::InnerAabb => only(product()),
        Bound::Dop(_) => Numbers {
            dop: directions
                .iter()
                .map(|n| Direction::wrap(body, lane, *n))
                .collect(),
            ..Numbers::default()
        },
        Bound::Disc => Numbers {
            slab: Some(Direction::wrap(body, lane, thin())),
            ..only(product())
        },
        Bound::LeafTurningDisc if !leaf => only(product()),
        Bound::TurningDisc | Bound::LeafTurningDisc => {
            let sphere = Sphere::wrap(body, lane, Growth::SecondOrder);
            Numbers {
                turning: Some(TurningSlab::wrap(body, lane, thin(), sphere.centres())),
                ..only(Some(sphere))
            }
        }
    }
}

fn wrapped(centre: Vector3<f64>, points: &[Vector3<f64>]) -> Ball {
    let radius = points.iter().map(|p| (p - centre).norm());
    Ball {
        centre,
        radius: radius.fold(0.0, f64::max),
    }
}

/// The box of points in the coordinate axes.
pub fn box_of(points: &[Vector3<f64>]) -> Cuboid {
    let first = points.first().copied().unwrap_or_default();
    let (low, high) = points
        .iter()
        .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    Cuboid {
        centre: (low + high) * 0.5,
        axes: Matrix3::identity(),
        half: (high - low) * 0.5,
    }
}
