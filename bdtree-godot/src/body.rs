//! One collider without Godot: its pose, and its answers as the numbers that scripts get.

use std::sync::Arc;

use bdtree_runtime::{
    Aabb, Asset, Ball, BoneMatrices, Contact, Instance, Model, PointProjection, QueryError, Ray,
    RayIntersection, Shape, Transform, TriangleId, Workspace,
};

use crate::fault::Fault;

/// A deforming body and the memory of its queries. All coordinates and lengths are the world's.
pub(crate) struct Body {
    model: Arc<Model>,
    instance: Instance,
    workspace: Workspace<'static>,
    q: Vec<f32>,
}

/// A point of the surface that a query has found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    /// Its number among the source's.
    pub(crate) triangle: u32,
    pub(crate) point: [f64; 3],
    /// Unit: towards what was asked with.
    pub(crate) normal: [f64; 3],
    /// Weights of the triangle's corners that give the point.
    pub(crate) barycentric: [f64; 3],
    /// From what was asked with; of contacts negative where it reaches into the surface.
    pub(crate) distance: f64,
    /// The joint of the file that carries most of the point; none without a skin.
    pub(crate) joint: Option<usize>,
}

/// A value of a dictionary.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Vector([f32; 3]),
    Float(f64),
    Int(i64),
    Name(String),
}

impl Found {
    /// What a script's dictionary has. `bones`: of each joint the name of its bone.
    pub(crate) fn entries(&self, bones: &[String]) -> [(&'static str, Value); 6] {
        let vector = |of: [f64; 3]| Value::Vector(of.map(|x| x as f32));
        let bone = self.joint.and_then(|joint| bones.get(joint));
        [
            ("point", vector(self.point)),
            ("normal", vector(self.normal)),
            ("triangle", Value::Int(i64::from(self.triangle))),
            ("barycentric", vector(self.barycentric)),
            ("distance", Value::Float(self.distance)),
            ("bone", Value::Name(bone.cloned().unwrap_or_default())),
        ]
    }
}

impl Body {
    /// A body at rest at the identity placement, with the default weights of its morph targets.
    ///
    /// # Errors
    /// Default weights beyond the file's limits.
    pub(crate) fn new(model: Arc<Model>) -> Result<Self, Fault> {
        let instance = Instance::new(&model)?;
        let mut q = vec![0.0; model.asset().mode_count()];
        for (own, weight) in q.iter_mut().zip(model.asset().default_q()) {
            *own = weight.unwrap_or(0.0) as f32;
        }
        let mut body = Self {
            model,
            instance,
            workspace: Workspace::new(),
            q,
        };
        body.instance.set_q(&body.q)?;
        Ok(body)
    }

    pub(crate) fn asset(&self) -> &Asset<'_> {
        self.model.asset()
    }

    /// Names of the joints, in the file's order; empty for joints that have none.
    pub(crate) fn joint_names(&self) -> Vec<&str> {
        let skeleton = self.asset().skeleton();
        let name = |joint| skeleton.and_then(|skeleton| skeleton.joint_name(joint));
        (0..self.asset().joint_count())
            .map(|joint| name(joint).unwrap_or_default())
            .collect()
    }

    /// Names of the modes, in the file's order, as many as there are.
    pub(crate) fn mode_names(&self) -> Vec<Option<&str>> {
        let mut names: Vec<_> = self.asset().mode_names().collect();
        // A file without metadata has none.
        names.resize(self.q.len(), None);
        names
    }

    /// Of each bone of the file its joint.
    pub(crate) fn joints_of_bones(&self) -> Vec<usize> {
        let bones = self.asset().bones().iter();
        bones.map(|bone| bone.joint.get() as usize).collect()
    }

    /// The weights that the next [`Body::pose`] sets.
    pub(crate) fn q(&self) -> &[f32] {
        &self.q
    }

    /// # Errors
    /// Another number than there are modes.
    pub(crate) fn set_q(&mut self, q: &[f32]) -> Result<(), Fault> {
        if q.len() != self.q.len() {
            return Err(Fault::Length {
                expected: self.q.len(),
                found: q.len(),
            });
        }
        self.q.copy_from_slice(q);
        Ok(())
    }

    /// One weight for the next [`Body::pose`].
    pub(crate) fn set_weight(&mut self, mode: usize, weight: f32) {
        self.q[mode] = weight;
    }

    /// Takes the weights, moves the bones and places the body. It stays as it was on an error.
    ///
    /// # Errors
    /// What the library refuses: numbers that are not finite or beyond the file's limits, other numbers of bones.
    pub(crate) fn pose(&mut self, bones: BoneMatrices<'_>, at: Transform) -> Result<(), Fault> {
        if self.asset().has_skin() {
            self.instance.set_pose_with_bones(&self.q, bones, at)?;
        } else {
            self.instance.set_pose(&self.q, at)?;
        }
        Ok(())
    }

    /// What the segment meets first.
    ///
    /// # Errors
    /// Two ends that are the same, or not finite.
    pub(crate) fn cast_ray(
        &mut self,
        from: [f64; 3],
        to: [f64; 3],
    ) -> Result<Option<Found>, Fault> {
        let along = [0, 1, 2].map(|k| to[k] - from[k]);
        let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        let ray = Ray::new(from, along).with_max_distance(length);
        let hit = self.instance.query(&mut self.workspace).cast_ray(&ray)?;
        let found = |hit: RayIntersection| {
            let vectors = [hit.point, hit.normal, hit.barycentric];
            self.found(hit.triangle, vectors, hit.distance)
        };
        hit.map(found).transpose()
    }

    /// # Errors
    /// Coordinates or lengths that are not finite, or negative lengths.
    pub(crate) fn intersects(&mut self, shape: impl Into<Shape>) -> Result<bool, Fault> {
        let mut query = self.instance.query(&mut self.workspace);
        Ok(query.intersects(shape)?)
    }

    /// All triangles that the ball touches, the lowest first.
    ///
    /// # Errors
    /// Those of [`Body::intersects`].
    pub(crate) fn contacts(&mut self, center: [f64; 3], radius: f64) -> Result<Vec<Found>, Fault> {
        let mut contacts: Vec<Contact> = Vec::new();
        let mut query = self.instance.query(&mut self.workspace);
        query.contacts(Ball::new(center, radius), &mut contacts)?;
        contacts.sort_unstable_by_key(|contact| contact.triangle);
        let found = |contact: Contact| {
            let vectors = [contact.point, contact.normal, contact.barycentric];
            self.found(contact.triangle, vectors, contact.distance)
        };
        contacts.into_iter().map(found).collect()
    }

    /// The nearest point of the surface within a distance.
    ///
    /// # Errors
    /// A point that is not finite, a distance that is negative or NaN.
    pub(crate) fn closest_point(
        &mut self,
        point: [f64; 3],
        max_distance: f64,
    ) -> Result<Option<Found>, Fault> {
        let mut query = self.instance.query(&mut self.workspace);
        let nearest = query.project_point(point, max_distance)?;
        let found = |nearest: PointProjection| {
            let vectors = [nearest.point, nearest.normal, nearest.barycentric];
            self.found(nearest.triangle, vectors, nearest.distance)
        };
        nearest.map(found).transpose()
    }

    /// A box that holds the surface, as Godot keeps it: its least corner and its size.
    ///
    /// # Errors
    /// A damaged file.
    pub(crate) fn aabb(&self) -> Result<([f32; 3], [f32; 3]), Fault> {
        Ok(outwards(&self.instance.aabb()?))
    }

    /// With the joint, which scripts want to know of every answer.
    fn found(
        &self,
        triangle: TriangleId,
        [point, normal, barycentric]: [[f64; 3]; 3],
        distance: f64,
    ) -> Result<Found, Fault> {
        let joint = self.asset().joint_of(triangle, barycentric);
        Ok(Found {
            triangle: triangle.0,
            point,
            normal,
            barycentric,
            distance,
            joint: joint.map_err(QueryError::Corrupt)?,
        })
    }
}

/// Corner and size in f32, so that the box and the sum of the two hold the given box.
fn outwards(aabb: &Aabb) -> ([f32; 3], [f32; 3]) {
    let low = aabb.min.map(|x| {
        let near = x as f32;
        if f64::from(near) > x {
            near.next_down()
        } else {
            near
        }
    });
    let size = [0, 1, 2].map(|k| {
        let mut size = (aabb.max[k] - f64::from(low[k])) as f32;
        // The sum is rounded as well. Infinite ones end it.
        while f64::from(low[k] + size) < aabb.max[k] {
            size = size.next_up();
        }
        size
    });
    (low, size)
}

#[cfg(test)]
mod tests;
