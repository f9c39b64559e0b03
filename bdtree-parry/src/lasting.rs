//! Contacts that follow the surfaces that they are on, instead of being looked for anew with every new shape.
//!
//! Finding the contacts of two chairs takes a tenth of a millisecond, moving known ones along takes two microseconds. Contacts that
//! are found anew are at slightly other places, too, which shakes bodies that are coming to rest.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::parry::math::{Pose, Real, Vector};
use super::parry::query::ContactManifold;
use super::parry::shape::{PackedFeatureId, Shape, SubShapeId};
use super::shape::DeformingMesh;

/// Pairs that a body remembers at most.
const PAIRS: usize = 64;

/// How far both bodies may bend anywhere until contacts are looked for anew, in multiples of how far contacts may move: one end of a
/// body moves with every mode, contacts do not. With twice this, heaps of chairs take as long and come to rest later.
const BENT: Real = 4.0;

/// How far shapes may move against each other, where they touch, until contacts are looked for anew.
#[derive(Debug, Clone, Copy)]
pub(super) enum Drift {
    /// World units.
    Way(Real),
    /// World units, or more where both shapes are large: times the radius of the smaller one.
    OfSmaller { least: Real, share: Real },
}

impl Drift {
    /// World units, for two shapes of these radii.
    fn between(self, radius: [Real; 2]) -> Real {
        match self {
            Self::Way(way) => way,
            Self::OfSmaller { least, share } => least.max(share * radius[0].min(radius[1])),
        }
    }
}

/// What the meshes of one body at different q have in common: the contacts that it has.
#[derive(Debug)]
pub(super) struct Lasting {
    drift: Drift,
    /// How often contacts have been forgotten.
    epoch: AtomicU32,
    pairs: Mutex<Vec<Pair>>,
}

/// The contacts of two shapes when they were last looked for.
#[derive(Debug)]
struct Pair {
    other: Other,
    /// The second in the frame of the first.
    pos12: Pose,
    /// q of both; empty for what is no mesh.
    q: [Vec<f32>; 2],
    prediction: Real,
    /// Those of both bodies.
    epochs: [u32; 2],
    /// Whether they touched, or reached into each other.
    touches: bool,
    /// Of each manifold.
    points: Vec<Vec<Attached>>,
}

/// A point of contact on both shapes.
#[derive(Debug)]
struct Attached {
    features: [PackedFeatureId; 2],
    anchors: [Anchor; 2],
    /// Where it was found, in the frame of each.
    places: [Vector; 2],
}

/// What a body is in contact with.
#[derive(Debug, Clone)]
enum Other {
    Body(Weak<Lasting>),
    Ball(Real),
    Capsule([Vector; 2], Real),
    Cuboid(Vector),
    HalfSpace(Vector),
}

/// What a point of contact is attached to.
#[derive(Debug, Clone, Copy)]
enum Anchor {
    /// A place in the frame of a shape that does not deform.
    Frame(Vector),
    /// A triangle, in barycentric coordinates of the nearest point of its plane, and how far from that the point is.
    Triangle {
        id: u32,
        weights: [Real; 3],
        offset: Vector,
    },
}

impl PartialEq for Other {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Body(a), Self::Body(b)) => a.ptr_eq(b),
            (Self::Ball(a), Self::Ball(b)) => a == b,
            (Self::Capsule(a, r), Self::Capsule(b, s)) => a == b && r == s,
            (Self::Cuboid(a), Self::Cuboid(b)) | (Self::HalfSpace(a), Self::HalfSpace(b)) => a == b,
            _ => false,
        }
    }
}

impl Other {
    /// `None` for a shape that could become another one unseen.
    fn of(shape: &dyn Shape) -> Option<Self> {
        if let Some(mesh) = shape.as_shape::<DeformingMesh>() {
            return mesh.lasting().map(|own| Self::Body(Arc::downgrade(own)));
        }
        if let Some(ball) = shape.as_ball() {
            return Some(Self::Ball(ball.radius));
        }
        if let Some(capsule) = shape.as_capsule() {
            let ends = [capsule.segment.a, capsule.segment.b];
            return Some(Self::Capsule(ends, capsule.radius));
        }
        if let Some(cuboid) = shape.as_cuboid() {
            return Some(Self::Cuboid(cuboid.half_extents));
        }
        let plane = shape.as_halfspace()?;
        Some(Self::HalfSpace(plane.normal))
    }

    /// Whether no two shapes are equal.
    fn is_unique(&self) -> bool {
        matches!(self, Self::Body(_))
    }

    fn is_gone(&self) -> bool {
        matches!(self, Self::Body(body) if body.strong_count() == 0)
    }
}

impl Pair {
    /// An upper bound of how far any point of the smaller shape has moved with its frame against that of the other one.
    fn moved(&self, pos12: &Pose, reach: [Real; 2]) -> Real {
        let (was, is) = match reach[0] < reach[1] {
            true => (self.pos12.inverse(), pos12.inverse()),
            false => (self.pos12, *pos12),
        };
        let turn = was.rotation.inverse() * is.rotation;
        let chord = 2.0 * Vector::from(turn.xyz()).length();
        let way = (is.translation - was.translation).length();
        way + chord * reach[0].min(reach[1])
    }
}

impl Lasting {
    pub(super) fn new(drift: Drift) -> Self {
        Self {
            drift,
            epoch: AtomicU32::new(0),
            pairs: Mutex::new(Vec::new()),
        }
    }

    fn pairs(&self) -> MutexGuard<'_, Vec<Pair>> {
        self.pairs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes out the pair with another shape that has not moved far, so that nothing is locked while it is looked at.
    fn take(&self, other: &Other, is_near: impl Fn(&Pair) -> bool) -> Option<Pair> {
        let mut pairs = self.pairs();
        // Several shapes may be equal, and differ in where they are: the last one that was put here.
        let k = pairs
            .iter()
            .rposition(|pair| pair.other == *other && (other.is_unique() || is_near(pair)))?;
        let pair = pairs.remove(k);
        is_near(&pair).then_some(pair)
    }

    fn put(&self, pair: Pair) {
        let mut pairs = self.pairs();
        pairs.retain(|old| !old.other.is_gone());
        if pairs.len() >= PAIRS {
            // The one that was not asked for longest.
            pairs.remove(0);
        }
        pairs.push(pair);
    }
}

/// Two shapes of which one remembers the contacts of both.
pub(super) struct Both<'a> {
    shapes: [&'a dyn Shape; 2],
    meshes: [Option<&'a DeformingMesh>; 2],
    memory: &'a Lasting,
    other: Other,
}

impl<'a> Both<'a> {
    /// `None` where contacts are looked for in every step.
    pub(super) fn of(shape1: &'a dyn Shape, shape2: &'a dyn Shape) -> Option<Self> {
        let shapes = [shape1, shape2];
        let meshes = shapes.map(|shape| shape.as_shape::<DeformingMesh>());
        let mut own = (0..2).filter_map(|k| Some((k, meshes[k]?.lasting()?)));
        let (k, memory) = own.next()?;
        Some(Self {
            shapes,
            meshes,
            memory,
            other: Other::of(shapes[1 - k])?,
        })
    }

    /// Moves the points of manifolds along with the surfaces, if these have not moved far since the points were found. If not,
    /// manifolds are as they were.
    ///
    /// How far that is, shapes may move as a whole together with what bending has moved the points; bodies may bend by
    /// [`BENT`] times that.
    pub(super) fn follow<M, C>(
        &self,
        pos12: &Pose,
        prediction: Real,
        manifolds: &mut [ContactManifold<M, C>],
    ) -> bool {
        let spheres = self
            .shapes
            .map(|shape| shape.compute_local_bounding_sphere());
        let drift = self
            .memory
            .drift
            .between([0, 1].map(|side| spheres[side].radius));
        let reach = spheres
            .each_ref()
            .map(|sphere| sphere.center.length() + sphere.radius);
        let is_near = |pair: &Pair| {
            let moved = pair.moved(pos12, reach);
            // Where nothing touched, something may after half the way.
            let limit = match pair.touches {
                true => BENT * drift,
                false => drift.min(0.5 * pair.prediction) - moved,
            };
            pair.epochs == self.epochs()
                && prediction <= 2.0 * pair.prediction
                && moved <= drift
                && self.bent(pair) <= limit
        };
        let Some(pair) = self.memory.take(&self.other, is_near) else {
            return false;
        };
        let is_same = pair.points.len() == manifolds.len()
            && pair
                .points
                .iter()
                .zip(manifolds.iter())
                .all(|(all, manifold)| {
                    all.len() == manifold.points.len()
                        && (all.iter().zip(&manifold.points))
                            .all(|(own, point)| own.features == [point.fid1, point.fid2])
                });
        if !is_same {
            return false;
        }
        let places = pair.points.iter().flatten().map(|own| {
            let place = |side: usize| self.place(side, &own.anchors[side]);
            [0, 1].map(|side| place(side).unwrap_or(own.places[side]))
        });
        let places: Vec<[Vector; 2]> = places.collect();
        let left = drift - pair.moved(pos12, reach);
        let mut all = pair.points.iter().flatten().zip(&places);
        let is_apart = all.any(|(own, is)| {
            let [by1, by2] = [0, 1].map(|side| is[side] - own.places[side]);
            !((pos12.rotation * by2 - by1).length() <= left)
        });
        if is_apart {
            return false;
        }
        let mut places = places.into_iter();
        for manifold in manifolds {
            for (point, [p1, p2]) in manifold.points.iter_mut().zip(&mut places) {
                (point.local_p1, point.local_p2) = (p1, p2);
                point.dist = (pos12 * p2 - p1).dot(manifold.local_n1);
            }
        }
        self.memory.put(pair);
        true
    }

    /// Remembers points that have just been found, and on which triangles they are.
    pub(super) fn remember<M, C>(
        &self,
        pos12: &Pose,
        prediction: Real,
        manifolds: &[ContactManifold<M, C>],
        triangles: &[Vec<[SubShapeId; 2]>],
    ) {
        let points = manifolds.iter().zip(triangles).map(|(manifold, ids)| {
            let each = manifold.points.iter().zip(ids);
            each.map(|(point, [one, two])| Attached {
                features: [point.fid1, point.fid2],
                places: [point.local_p1, point.local_p2],
                anchors: [
                    self.anchor(0, *one, point.local_p1),
                    self.anchor(1, *two, point.local_p2),
                ],
            })
            .collect()
        });
        self.memory.put(Pair {
            points: points.collect(),
            other: self.other.clone(),
            pos12: *pos12,
            q: self
                .meshes
                .map(|mesh| mesh.map_or(Vec::new(), |mesh| mesh.q().to_vec())),
            prediction,
            epochs: self.epochs(),
            touches: (manifolds.iter().flat_map(|manifold| &manifold.points))
                .any(|point| point.dist <= 0.0),
        });
    }

    fn epochs(&self) -> [u32; 2] {
        let epoch = |mesh: &DeformingMesh| Some(mesh.lasting()?.epoch.load(Ordering::Relaxed));
        self.meshes
            .map(|mesh| mesh.and_then(epoch).unwrap_or_default())
    }

    /// An upper bound of how far points of both shapes have moved in their own frames, together.
    fn bent(&self, pair: &Pair) -> Real {
        let each = self.meshes.iter().zip(&pair.q);
        each.map(|(mesh, q)| mesh.map_or(0.0, |mesh| mesh.moved_since(q)))
            .sum()
    }

    fn anchor(&self, side: usize, id: u32, point: Vector) -> Anchor {
        let Some(mesh) = self.meshes[side] else {
            return Anchor::Frame(point);
        };
        let Some(triangle) = mesh.triangle(id) else {
            return Anchor::Frame(point);
        };
        let (u, v, w) = (
            triangle.b - triangle.a,
            triangle.c - triangle.a,
            point - triangle.a,
        );
        let normal = u.cross(v);
        let area = normal.length_squared();
        let weights = if area > 0.0 {
            let b = w.cross(v).dot(normal) / area;
            let c = u.cross(w).dot(normal) / area;
            [1.0 - b - c, b, c]
        } else {
            [1.0, 0.0, 0.0]
        };
        let [a, b, c] = weights;
        Anchor::Triangle {
            id,
            weights,
            offset: point - (triangle.a * a + triangle.b * b + triangle.c * c),
        }
    }

    /// Where a point is now; `None` of a damaged file.
    fn place(&self, side: usize, anchor: &Anchor) -> Option<Vector> {
        match anchor {
            Anchor::Frame(point) => Some(*point),
            Anchor::Triangle {
                id,
                weights: [a, b, c],
                offset,
            } => {
                let triangle = self.meshes[side]?.triangle(*id)?;
                Some(triangle.a * *a + triangle.b * *b + triangle.c * *c + *offset)
            }
        }
    }
}

impl DeformingMesh {
    /// Lets the body's contacts be looked for anew, if they last.
    pub(super) fn forget_contacts(&self) -> bool {
        let lasting = self.lasting();
        if let Some(lasting) = lasting {
            lasting.epoch.fetch_add(1, Ordering::Relaxed);
        }
        lasting.is_some()
    }

    /// An upper bound of how far any vertex has moved since q was this, in the shape's frame.
    fn moved_since(&self, q: &[f32]) -> Real {
        let asset = self.model().model().asset();
        let world_per_stored = asset.unit() * self.model().scale();
        let each = self.q().iter().zip(q).zip(asset.modes());
        let moved: f64 = each
            .map(|((new, old), mode)| {
                f64::from((new - old).abs()) * f64::from(mode.field_norm_max.get())
            })
            .sum();
        (moved * world_per_stored) as Real
    }
}
