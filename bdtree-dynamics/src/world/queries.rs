//! Questions about all bodies of a world, as they are now.

use bdtree_runtime::{Contact, Coverage, Ray, RayIntersection, Shape, Sink};

use super::{BodyId, World};
use crate::error::DynamicsError;

impl World {
    /// Whether the spheres of a node were updated for what trees last said of the body: since it last left the allowance of an
    /// answer. With several threads a few are left out, which two of them needed at the same time.
    ///
    /// # Errors
    /// A body that the world does not have.
    pub fn has_updated(&self, body: BodyId, node: u32) -> Result<bool, DynamicsError> {
        let BodyId(index) = body;
        let cache = self.caches.get(index).ok_or(DynamicsError::Unknown {
            what: "body",
            index,
        })?;
        Ok(cache.get().is_some_and(|mut cache| cache.keeps(node)))
    }

    /// Poses the instances as bodies are now: what queries of the runtime on [`World::instances`] are asked of. Steps leave
    /// them elsewhere.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn pose_instances(&mut self) -> Result<(), DynamicsError> {
        if self.is_posed {
            return Ok(());
        }
        for index in 0..self.bodies.len() {
            let body = &self.bodies[index];
            let model = &self.models[body.model];
            let s = &self.modal.s[body.start..];
            let mut q = [0.0_f32; super::MODES_MAX];
            for (q, (mode, s)) in q.iter_mut().zip(model.modes.iter().zip(s)) {
                *q = mode.limit.q(*s) as f32;
            }
            let q = &q[..model.model.asset().mode_count()];
            let at = model.placement(body.state.position, body.state.orientation);
            self.instances[index].set_pose(q, at)?;
        }
        self.is_posed = true;
        Ok(())
    }

    /// What the ray meets first, and of which body; of several at the same distance, the first body's.
    ///
    /// # Errors
    /// Those of [`Query::cast_ray`](bdtree_runtime::Query::cast_ray).
    pub fn cast_ray(
        &mut self,
        ray: &Ray,
    ) -> Result<Option<(BodyId, RayIntersection)>, DynamicsError> {
        self.pose_instances()?;
        let mut nearest: Option<(BodyId, RayIntersection)> = None;
        for (index, instance) in self.instances.iter().enumerate() {
            if !instance.aabb()?.intersects_ray(ray) {
                continue;
            }
            let hit = instance.pose().query(&mut self.workspace).cast_ray(ray)?;
            if let Some(hit) = hit
                && nearest.is_none_or(|(_, best)| hit.distance < best.distance)
            {
                nearest = Some((BodyId(index), hit));
            }
        }
        Ok(nearest)
    }

    /// Reports every triangle of every body that the shape touches, with its body.
    ///
    /// # Errors
    /// Those of [`Query::contacts`](bdtree_runtime::Query::contacts).
    pub fn touched_by(
        &mut self,
        shape: impl Into<Shape>,
        out: &mut impl Sink<(BodyId, Contact)>,
    ) -> Result<Coverage, DynamicsError> {
        self.pose_instances()?;
        let shape = shape.into();
        for (index, instance) in self.instances.iter().enumerate() {
            let mut of_body = OfBody {
                body: BodyId(index),
                out,
            };
            let pose = instance.pose();
            let coverage = (pose.query(&mut self.workspace)).contacts(shape, &mut of_body)?;
            if coverage == Coverage::Truncated {
                return Ok(coverage);
            }
        }
        Ok(Coverage::Complete)
    }
}

/// Hands contacts on with their body.
struct OfBody<'o, S> {
    body: BodyId,
    out: &'o mut S,
}

impl<S: Sink<(BodyId, Contact)>> Sink<Contact> for OfBody<'_, S> {
    fn push(&mut self, contact: Contact) -> core::ops::ControlFlow<()> {
        self.out.push((self.body, contact))
    }
}
