//! A scene of one mesh whose vertices change.

use std::ffi::c_void;
use std::rc::Rc;

use super::api::{
    DYNAMIC, FLOAT3, GeometryPointer, INDEX, LOW, NONE, PointQuery, PointQueryArguments,
    PointQueryContext, REFIT, RayHit, ScenePointer, TRIANGLES, UINT3, VERTEX,
};
use super::device::Device;

/// Three numbers of four bytes.
const STRIDE: usize = 12;

/// A mesh in a tree that is refitted when its vertices change.
pub(super) struct Scene {
    device: Rc<Device>,
    scene: ScenePointer,
    geometry: GeometryPointer,
    /// x, y, z of all vertices, in memory of the geometry's that its tree is made from.
    vertices: *mut f32,
    /// How many numbers there are.
    len: usize,
}

impl Scene {
    /// With a tree of these vertices.
    ///
    /// # Errors
    /// What Embree refuses.
    pub(super) fn new(
        device: &Rc<Device>,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, String> {
        let api = &device.api;
        // SAFETY: the device lives.
        let scene = unsafe { (api.new_scene)(device.pointer) };
        // SAFETY: the same.
        let geometry = unsafe { (api.new_geometry)(device.pointer, TRIANGLES) };
        // From here on dropped with what was made.
        let mut own = Self {
            device: Rc::clone(device),
            scene,
            geometry,
            vertices: std::ptr::null_mut(),
            len: 0,
        };
        device.check()?;
        // SAFETY: a scene that was made without an error.
        unsafe { (api.set_scene_flags)(scene, DYNAMIC) };
        // Otherwise the geometry's own quality is ignored, and every commit builds anew.
        // SAFETY: the same.
        unsafe { (api.set_scene_build_quality)(scene, LOW) };
        // SAFETY: a geometry that was made without an error.
        unsafe { (api.set_build_quality)(geometry, REFIT) };
        let corners = own.buffer(INDEX, UINT3, triangles.len())?.cast::<u32>();
        // SAFETY: Embree's memory of so many numbers, aligned to 16 bytes and nobody else's; every
        // pattern of bits is a number.
        let corners = unsafe { std::slice::from_raw_parts_mut(corners, 3 * triangles.len()) };
        corners.copy_from_slice(triangles.as_flattened());
        own.vertices = own.buffer(VERTEX, FLOAT3, positions.len())?.cast::<f32>();
        own.len = 3 * positions.len();
        own.vertices_mut().copy_from_slice(positions.as_flattened());
        // SAFETY: a geometry with its buffers.
        unsafe { (api.commit_geometry)(geometry) };
        // SAFETY: both live; the scene holds the geometry from now on.
        unsafe { (api.attach_geometry)(scene, geometry) };
        // SAFETY: a scene whose geometry is committed.
        unsafe { (api.commit_scene)(scene) };
        device.check()?;
        Ok(own)
    }

    /// New memory of `count` times three numbers.
    fn buffer(&self, kind: i32, format: i32, count: usize) -> Result<*mut c_void, String> {
        let new_buffer = self.device.api.new_buffer;
        // SAFETY: the geometry lives; Embree owns and pads what it allocates.
        let memory = unsafe { new_buffer(self.geometry, kind, 0, format, STRIDE, count) };
        self.device.check()?;
        if memory.is_null() {
            return Err("Embree: no memory".to_string());
        }
        Ok(memory)
    }

    /// x, y, z of all vertices.
    pub(super) fn vertices(&self) -> &[f32] {
        // SAFETY: the geometry's memory, which lives as long as `self` holds the geometry and was
        // filled by `new`; it is written by nobody but who borrows `self` alone.
        unsafe { std::slice::from_raw_parts(self.vertices, self.len) }
    }

    /// The same, to be written before [`Scene::refit`].
    pub(super) fn vertices_mut(&mut self) -> &mut [f32] {
        // SAFETY: as above, and `self` is borrowed alone; Embree reads them in calls that need `self`.
        unsafe { std::slice::from_raw_parts_mut(self.vertices, self.len) }
    }

    /// Refits the tree to the vertices.
    ///
    /// # Errors
    /// What Embree refuses.
    pub(super) fn refit(&mut self) -> Result<(), String> {
        let api = &self.device.api;
        // SAFETY: the geometry lives and has this buffer.
        unsafe { (api.update_buffer)(self.geometry, VERTEX, 0) };
        // SAFETY: the geometry lives.
        unsafe { (api.commit_geometry)(self.geometry) };
        // SAFETY: the scene lives and its geometry is committed.
        unsafe { (api.commit_scene)(self.scene) };
        self.device.check()
    }

    /// Distance to the first triangle along a unit direction.
    pub(super) fn ray(&self, origin: [f32; 3], direction: [f32; 3]) -> Option<f32> {
        let mut ray = RayHit {
            origin,
            near: 0.0,
            direction,
            time: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            barycentric: [0.0; 2],
            primitive: NONE,
            geometry: NONE,
            instances: [NONE; _],
        };
        let intersect = self.device.api.intersect;
        // SAFETY: a committed scene and a ray of the documented layout; no arguments is allowed.
        unsafe { intersect(self.scene, &raw mut ray, std::ptr::null_mut()) };
        (ray.geometry != NONE).then_some(ray.far)
    }

    /// Calls `visit` with the triangles whose boxes may be within a ball.
    pub(super) fn near<F: FnMut(u32)>(&self, center: [f32; 3], radius: f32, mut visit: F) {
        let mut query = PointQuery {
            center,
            time: 0.0,
            radius,
        };
        let mut context = PointQueryContext::WORLD;
        let point_query = self.device.api.point_query;
        // SAFETY: a committed scene and structures of the documented layout; `pass` gets the pointer
        // to a function of the type that it is made for, alive until the call returns.
        unsafe {
            point_query(
                self.scene,
                &raw mut query,
                &raw mut context,
                Some(pass::<F>),
                (&raw mut visit).cast::<c_void>(),
            )
        };
    }
}

/// Hands a triangle to the function that `user` points to; the radius stays.
unsafe extern "C" fn pass<F: FnMut(u32)>(arguments: *mut PointQueryArguments) -> bool {
    // SAFETY: Embree's arguments, alive during this call.
    let arguments = unsafe { &*arguments };
    // SAFETY: what `near` handed over, a function of this type that nobody else uses meanwhile.
    let visit = unsafe { &mut *arguments.user.cast::<F>() };
    visit(arguments.primitive);
    false
}

impl Drop for Scene {
    fn drop(&mut self) {
        let api = &self.device.api;
        if !self.geometry.is_null() {
            // SAFETY: the reference that `new` was given; the scene holds its own.
            unsafe { (api.release_geometry)(self.geometry) };
        }
        if !self.scene.is_null() {
            // SAFETY: the reference that `new` was given.
            unsafe { (api.release_scene)(self.scene) };
        }
    }
}
