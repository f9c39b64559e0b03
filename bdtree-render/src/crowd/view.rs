//! Which bodies a picture shows.

use bdtree_runtime::{BoundingSphere, Frustum, FrustumState, Model, Workspace};

use super::Body;
use crate::error::RenderError;

/// A body that is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn {
    /// Its number.
    pub(super) number: usize,
    /// Its asset's.
    pub(super) asset: usize,
    /// From the eye to its sphere; 0 within it.
    pub(super) away: f64,
}

/// What is known of bodies before they are drawn.
#[derive(Debug, Default)]
pub(super) struct View {
    /// Of each body, a sphere around it (world).
    pub(super) spheres: Vec<BoundingSphere>,
    /// Those that are drawn, by asset, the nearest first: what they hide needs no shading.
    pub(super) drawn: Vec<Drawn>,
    /// Those whose sphere is outside of the picture.
    pub(super) culled_by_sphere: usize,
    /// Those whose sphere is not, but whose triangles are.
    pub(super) culled_by_tree: usize,
}

/// Memory that finding out takes.
#[derive(Debug, Default)]
pub(super) struct ViewMemory {
    pose: Vec<f32>,
    workspace: Workspace<'static>,
}

impl View {
    /// The bodies in a frustum, all without one; `eye` is where they are seen from (world).
    pub(super) fn of(
        models: &[&Model],
        bodies: &[Body<'_>],
        (eye, frustum): ([f64; 3], Option<&Frustum>),
        memory: &mut ViewMemory,
    ) -> Result<Self, RenderError> {
        let mut view = Self {
            spheres: Vec::with_capacity(bodies.len()),
            ..Self::default()
        };
        for (number, body) in bodies.iter().enumerate() {
            let refused = |reason: String| RenderError::Body {
                body: number,
                reason,
            };
            let Some(model) = models.get(body.asset) else {
                let what = format!("asset {} of {}", body.asset, models.len());
                return Err(refused(what));
            };
            let asset = model.asset();
            memory.pose.resize(asset.pose_len(), 0.0);
            let pose = asset
                .pose_with_bones(body.q, body.bones, body.placement, &mut memory.pose)
                .map_err(|e| refused(e.to_string()))?;
            let sphere = pose.bounding_sphere().map_err(|e| refused(e.to_string()))?;
            view.spheres.push(sphere);
            let apart: f64 = (0..3).map(|k| (sphere.center[k] - eye[k]).powi(2)).sum();
            let drawn = Drawn {
                number,
                asset: body.asset,
                away: (apart.sqrt() - sphere.radius).max(0.0),
            };
            let Some(frustum) = frustum else {
                view.drawn.push(drawn);
                continue;
            };
            match sphere.state(frustum) {
                FrustumState::Outside => view.culled_by_sphere += 1,
                FrustumState::Inside => view.drawn.push(drawn),
                // At the picture's edge: the tree knows more, and a body costs many triangles.
                FrustumState::Intersects => {
                    let state = pose.query(&mut memory.workspace).frustum_state(frustum);
                    match state.map_err(|e| refused(e.to_string()))? {
                        FrustumState::Outside => view.culled_by_tree += 1,
                        FrustumState::Inside | FrustumState::Intersects => view.drawn.push(drawn),
                    }
                }
            }
        }
        view.drawn.sort_by(|a, b| {
            let order = a.asset.cmp(&b.asset).then(a.away.total_cmp(&b.away));
            order.then(a.number.cmp(&b.number))
        });
        Ok(view)
    }
}
