//! What is compared: bounds and how they are tested.

use super::affine::{Affine, Stretch};
use super::bound::Bound;
use super::overlap::BoxTest;
use super::pair::Filter;
use super::sphere::Growth;

/// A bound and the tests it is used with.
#[derive(Debug, Clone, Copy)]
pub struct Contender {
    /// Name in tables.
    pub name: &'static str,
    /// The bound.
    pub bound: Bound,
    /// How two boxes are tested.
    pub boxes: BoxTest,
    /// How two nodes are tested.
    pub filter: Filter,
    /// Whether the bound of hot nodes is refitted: those that are asked for more often than this.
    pub hot: Option<u32>,
}

const NORM: Affine = Affine {
    shared: false,
    tangent: false,
    bent: false,
    placed: false,
    stretch: Stretch::Norm,
};

const SHARED_FLAT: Affine = Affine {
    shared: true,
    tangent: true,
    stretch: Stretch::Flat,
    ..NORM
};

const SHARED_PARTS: Affine = Affine {
    shared: true,
    stretch: Stretch::Parts,
    ..NORM
};

const PLACED_PARTS: Affine = Affine {
    placed: true,
    ..SHARED_PARTS
};

const PLACED: Affine = Affine {
    bent: true,
    stretch: Stretch::Points(4),
    ..PLACED_PARTS
};

/// The product's ball, every lane against every node's, is the first.
pub fn contenders() -> Vec<Contender> {
    let of = |name, bound, boxes| Contender {
        name,
        bound,
        boxes,
        filter: Filter::Parent,
        hot: None,
    };
    let plain = |name, bound| of(name, bound, BoxTest::Full);
    vec![
        Contender {
            filter: Filter::None,
            ..plain("ball b±, every lane", Bound::Ball(Growth::SecondOrder))
        },
        plain("ball b±", Bound::Ball(Growth::SecondOrder)),
        plain("ball R + s, mean", Bound::Ball(Growth::Mean)),
        plain("ball R + s, ball", Bound::Ball(Growth::Sum)),
        plain("ball, similarity", Bound::Ball(Growth::Similarity)),
        plain("affine", Bound::Affine(NORM)),
        plain("flat affine, shared", Bound::Affine(SHARED_FLAT)),
        plain("affine by parts, shared", Bound::Affine(SHARED_PARTS)),
        plain("placed affine by parts", Bound::Affine(PLACED_PARTS)),
        plain(
            "b± or affine by parts, by node",
            Bound::BestOf(&[SHARED_PARTS]),
        ),
        plain(
            "b± or placed affine by parts, by node",
            Bound::BestOf(&[PLACED_PARTS]),
        ),
        plain("placed quadratic, 4 points", Bound::Affine(PLACED)),
        plain("b± or placed quadratic, by node", Bound::BestOf(&[PLACED])),
        plain("ball wrapped at c'", Bound::Wrapped),
        plain("smallest ball", Bound::Smallest),
        plain("b±, leaves wrapped at c'", Bound::LeafWrapped),
        of("box refitted", Bound::RefittedBox, BoxTest::Hull),
        of("aabb, hull", Bound::Aabb, BoxTest::Hull),
        of("aabb, 6 axes", Bound::Aabb, BoxTest::Faces),
        of("aabb, 15 axes", Bound::Aabb, BoxTest::Full),
        of("obb, hull", Bound::Obb, BoxTest::Hull),
        of("obb, 6 axes", Bound::Obb, BoxTest::Faces),
        of("obb, 15 axes", Bound::Obb, BoxTest::Full),
        of("ball and aabb, 6 axes", Bound::BallAndAabb, BoxTest::Faces),
        of("ball and obb, 6 axes", Bound::BallAndObb, BoxTest::Faces),
        plain("7-dop", Bound::Dop(7)),
        plain("13-dop", Bound::Dop(13)),
        of("leaves aabb, 6 axes", Bound::LeafAabb, BoxTest::Faces),
        of("leaves obb, 6 axes", Bound::LeafObb, BoxTest::Faces),
        of("inner aabb, 6 axes", Bound::InnerAabb, BoxTest::Faces),
        of("ball and slab, plane", Bound::Disc, BoxTest::Faces),
        plain("ball and slab, both", Bound::Disc),
        of("turning slab, plane", Bound::TurningDisc, BoxTest::Faces),
        plain("turning slab, both", Bound::TurningDisc),
        of(
            "leaf turning slab, plane",
            Bound::LeafTurningDisc,
            BoxTest::Faces,
        ),
        Contender {
            hot: Some(1),
            ..plain(
                "b±, refitted above 1 visit",
                Bound::Ball(Growth::SecondOrder),
            )
        },
        Contender {
            hot: Some(8),
            ..plain(
                "b±, refitted above 8 visits",
                Bound::Ball(Growth::SecondOrder),
            )
        },
    ]
}
