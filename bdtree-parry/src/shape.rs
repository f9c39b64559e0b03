//! A deforming mesh at one q: a shape.

use std::fmt;
use std::sync::Arc;

use bdtree_runtime::{CacheSize, Instance, Pose as RuntimePose, TriangleId};

use super::lasting::{Drift, Lasting};
use super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{Real, Vector};
use super::parry::query::details::NormalConstraints;
use super::parry::shape::{
    FeatureId, Shape, ShapeType, SubShapeId, Triangle, TrianglePseudoNormals, TypedShape,
};
use crate::error::ShapeError;
use crate::model::DeformingModel;

/// A [`DeformingModel`] at one q: a shape whose frame is the mesh's own, times the model's scale. Shares what it holds, so that
/// it is cheap to clone; another q is another shape ([`DeformingMesh::with_q`]).
///
/// A surface, as `TriMesh` is: points inside a closed mesh are not in it. The sub-shape of what queries find is the triangle.
#[derive(Clone)]
pub struct DeformingMesh {
    shared: Arc<Shared>,
}

struct Shared {
    model: DeformingModel,
    instance: Instance,
    aabb: Aabb,
    sphere: BoundingSphere,
    lasting: Option<Arc<Lasting>>,
}

impl DeformingMesh {
    /// A model at q, one number per mode: the weights of the fields.
    ///
    /// # Errors
    /// q of another length than the asset has modes, NaN, infinite or over the asset's hard limit; a damaged asset.
    pub fn new(model: &DeformingModel, q: &[f32]) -> Result<Self, ShapeError> {
        let mut instance = Instance::with_cache(model.model(), CacheSize::NONE)?;
        instance.set_pose(q, model.placement())?;
        Self::of_instance(model.clone(), instance)
    }

    /// The same mesh, whose contacts last: [`MeshDispatcher`](super::MeshDispatcher) lets the contacts that a pair has follow the
    /// surfaces, also those of [`DeformingMesh::with_q`], until the shapes may have moved by `drift` (world units) against each
    /// other, with their frames and by what they have bent at the contacts, or until both together may have bent by four times that
    /// anywhere. Then it looks for contacts anew. Until then it does not see those that begin elsewhere: parts may pass into each
    /// other by `drift`, and by up to five times that where they bend away from the contacts.
    ///
    /// For one body; others need meshes of their own. Contacts of meshes with bones are looked for in every step all the same.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn with_lasting_contacts(&self, drift: Real) -> Result<Self, ShapeError> {
        self.with_drift(Drift::Way(drift))
    }

    /// The same, by a rule.
    ///
    /// # Errors
    /// As above.
    pub(super) fn with_drift(&self, drift: Drift) -> Result<Self, ShapeError> {
        if self.model().model().asset().has_skin() {
            return Ok(self.clone());
        }
        Ok(Self::new(self.model(), self.q())?.lasting_as(Some(Arc::new(Lasting::new(drift)))))
    }

    /// What has just been made.
    fn lasting_as(mut self, lasting: Option<Arc<Lasting>>) -> Self {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.lasting = lasting;
        }
        self
    }

    /// A model at rest: q = 0.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn at_rest(model: &DeformingModel) -> Result<Self, ShapeError> {
        Self::new(model, &vec![0.0; model.model().asset().mode_count()])
    }

    /// The same model at another q.
    ///
    /// # Errors
    /// Those of [`DeformingMesh::new`].
    pub fn with_q(&self, q: &[f32]) -> Result<Self, ShapeError> {
        Ok(Self::new(self.model(), q)?.lasting_as(self.shared.lasting.clone()))
    }

    /// An instance of the model's file, bones and all: its placement is replaced by the model's scale.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn of_instance(model: DeformingModel, mut instance: Instance) -> Result<Self, ShapeError> {
        instance.set_placement(model.placement())?;
        let (around, ball) = (instance.aabb()?, instance.bounding_sphere()?);
        // Rounding to a narrower number may cut off a little.
        let size = ball.radius + ball.center.iter().map(|x| x.abs()).sum::<f64>();
        let margin = size * f64::from(f32::EPSILON);
        let vector = |x: [f64; 3]| Vector::from_array(x.map(|x| x as Real));
        let shared = Shared {
            aabb: Aabb::new(
                vector(around.min.map(|x| x - margin)),
                vector(around.max.map(|x| x + margin)),
            ),
            sphere: BoundingSphere::new(vector(ball.center), (ball.radius + margin) as Real),
            model,
            instance,
            lasting: None,
        };
        Ok(Self {
            shared: Arc::new(shared),
        })
    }

    /// What meshes of the file and scale have in common.
    pub fn model(&self) -> &DeformingModel {
        &self.shared.model
    }

    /// q as queries use it.
    pub fn q(&self) -> &[f32] {
        self.shared.instance.q()
    }

    /// The pose in `bdtree-runtime`, at the model's scale and in the shape's frame: for other queries, and for `Uᵀ f`.
    pub fn pose(&self) -> RuntimePose<'_> {
        self.shared.instance.pose()
    }

    /// The deformed corners of a triangle in the shape's frame; `None` where there is none of that id.
    pub fn triangle(&self, id: u32) -> Option<Triangle> {
        let corners = self.pose().deformed_triangle(TriangleId(id)).ok()?;
        let [a, b, c] = corners.map(|x| Vector::from_array(x.map(|x| x as Real)));
        Some(Triangle::new(a, b, c))
    }

    /// How many triangles it has.
    pub fn triangle_count(&self) -> u32 {
        self.model().model().asset().triangle_count() as u32
    }

    /// The directions in which a contact of a triangle may push: those between its normal and its neighbors' normals, as for
    /// a `TriMesh` with `FIX_INTERNAL_EDGES`; of a surface that is not closed, from both sides.
    pub fn normal_constraints(&self, id: u32) -> Option<TrianglePseudoNormals> {
        self.constraints_by(id, &|id| Some(self.triangle(id)?.normal()))
    }

    /// The same by the normals of triangles, where they have one.
    pub(super) fn constraints_by(
        &self,
        id: u32,
        normal: &dyn Fn(u32) -> Option<Option<Vector>>,
    ) -> Option<TrianglePseudoNormals> {
        let sign = self.model().outwards() as Real;
        let face = normal(id)?? * sign;
        let across = self.model().neighbors(id).map(|other| {
            if other == id {
                return Some(face);
            }
            match normal(other)? {
                Some(normal) => (face + normal * sign).try_normalize(),
                None => Some(face),
            }
        });
        let [Some(a), Some(b), Some(c)] = across else {
            return None;
        };
        Some(TrianglePseudoNormals {
            face,
            edges: [a, b, c],
            two_sided: !self.model().is_closed(),
        })
    }

    /// The corners of a triangle: vertex ids.
    pub(super) fn corners(&self, id: u32) -> Option<[u32; 3]> {
        let asset = self.model().model().asset();
        Some(asset.triangle(TriangleId(id)).ok()?.map(|v| v.0))
    }

    /// The contacts of its body, if they last.
    pub(super) fn lasting(&self) -> Option<&Arc<Lasting>> {
        self.shared.lasting.as_ref()
    }

    /// A sphere that holds it.
    pub(super) fn sphere(&self) -> BoundingSphere {
        self.shared.sphere
    }
}

impl fmt::Debug for DeformingMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeformingMesh")
            .field("triangles", &self.triangle_count())
            .field("q", &self.q())
            .finish()
    }
}

/// [`DeformingMesh::normal_constraints`] as parry's functions take them.
pub(super) fn constraints(of: &Option<TrianglePseudoNormals>) -> Option<&dyn NormalConstraints> {
    of.as_ref().map(|normals| normals as &dyn NormalConstraints)
}

impl Shape for DeformingMesh {
    fn compute_local_aabb(&self) -> Aabb {
        self.shared.aabb
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        self.shared.sphere
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    /// Scales that are the same along all axes and positive.
    fn scale_dyn(&self, scale: Vector, _num_subdivisions: u32) -> Option<Box<dyn Shape>> {
        let [x, y, z] = scale.to_array();
        if !(x > 0.0 && x == y && y == z) {
            return None;
        }
        let model = self
            .model()
            .scaled(self.model().scale() * f64::from(x))
            .ok()?;
        Some(Box::new(Self::new(&model, self.q()).ok()?))
    }

    /// The bake's center and inertia at rest, its mass being `density` (kg per cubic world unit) times its volume; zero
    /// without a mass section. [`DeformingMesh::baked_mass_properties`] has the bake's own mass.
    fn mass_properties(&self, density: Real) -> MassProperties {
        self.mass_of_density(density)
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    /// The radius of a sphere around it. rapier sweeps what moves by more than half of this in a step against what is fixed, and
    /// stops it where the two first touch. What does so while it rests on a floor hangs above it and cannot give way to what
    /// lies on it: with half the thickness of the material, boxes sank into the seats of chairs by a centimeter. Meshes of
    /// parry are never swept.
    fn ccd_thickness(&self) -> Real {
        self.sphere().radius
    }

    fn ccd_angular_thickness(&self) -> Real {
        // As a triangle mesh of parry.
        std::f64::consts::FRAC_PI_4 as Real
    }

    fn feature_normal_at_point(
        &self,
        subshape: SubShapeId,
        feature: FeatureId,
        _point: Vector,
    ) -> Option<Vector> {
        let normal = self.triangle(subshape)?.normal()? * self.model().outwards() as Real;
        match feature {
            FeatureId::Face(_) => Some(normal),
            _ => None,
        }
    }
}

/// A shape may be asked by any thread.
const _: () = {
    const fn is_shareable<T: Send + Sync>() {}
    is_shareable::<DeformingMesh>();
};
