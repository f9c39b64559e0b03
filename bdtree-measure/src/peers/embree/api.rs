//! The part of Embree 4's C interface that is used, found in a shared library by name.
//!
//! Structures and numbers are those of Embree's API documentation. Two structures end in words whose
//! number depends on how the library was built (levels of instances); here they have room for eight.

use std::error::Error;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::Path;

use libloading::Library;

/// `RTC_INVALID_GEOMETRY_ID`.
pub(super) const NONE: u32 = u32::MAX;
/// `RTC_DEVICE_PROPERTY_VERSION`: 10000 major + 100 minor + patch.
pub(super) const VERSION: c_int = 0;
/// `RTC_GEOMETRY_TYPE_TRIANGLE`.
pub(super) const TRIANGLES: c_int = 0;
/// `RTC_BUFFER_TYPE_INDEX`.
pub(super) const INDEX: c_int = 0;
/// `RTC_BUFFER_TYPE_VERTEX`.
pub(super) const VERTEX: c_int = 1;
/// `RTC_FORMAT_UINT3`.
pub(super) const UINT3: c_int = 0x5003;
/// `RTC_FORMAT_FLOAT3`.
pub(super) const FLOAT3: c_int = 0x9003;
/// `RTC_BUILD_QUALITY_LOW`: of a scene, a tree over one tree per geometry, each built in its own quality.
pub(super) const LOW: c_int = 0;
/// `RTC_BUILD_QUALITY_REFIT`.
pub(super) const REFIT: c_int = 3;
/// `RTC_SCENE_FLAG_DYNAMIC`.
pub(super) const DYNAMIC: c_int = 1;

/// Words of instance ids: two kinds, eight levels.
const INSTANCES: usize = 16;

/// `RTCDevice`.
pub(super) type DevicePointer = *mut DeviceType;
/// `RTCScene`.
pub(super) type ScenePointer = *mut SceneType;
/// `RTCGeometry`.
pub(super) type GeometryPointer = *mut GeometryType;

/// What a device handle points to.
#[repr(C)]
pub(super) struct DeviceType([u8; 0]);
/// What a scene handle points to.
#[repr(C)]
pub(super) struct SceneType([u8; 0]);
/// What a geometry handle points to.
#[repr(C)]
pub(super) struct GeometryType([u8; 0]);

/// `RTCRayHit`.
#[repr(C, align(16))]
pub(super) struct RayHit {
    pub(super) origin: [f32; 3],
    pub(super) near: f32,
    pub(super) direction: [f32; 3],
    pub(super) time: f32,
    /// Where the ray ends; after a hit, where that is.
    pub(super) far: f32,
    pub(super) mask: u32,
    pub(super) id: u32,
    pub(super) flags: u32,
    pub(super) normal: [f32; 3],
    pub(super) barycentric: [f32; 2],
    pub(super) primitive: u32,
    /// [`NONE`] without a hit.
    pub(super) geometry: u32,
    pub(super) instances: [u32; INSTANCES],
}

/// `RTCPointQuery`.
#[repr(C, align(16))]
pub(super) struct PointQuery {
    pub(super) center: [f32; 3],
    pub(super) time: f32,
    pub(super) radius: f32,
}

/// `RTCPointQueryContext` outside all instances: of what it holds only the first instance id and the
/// depth, which is 0, are read.
#[repr(C, align(16))]
pub(super) struct PointQueryContext {
    /// To the instance and back, for one level.
    matrices: [[f32; 16]; 2],
    instance: u32,
    /// 0: the depth, and what a library for deeper instances has there.
    rest: [u32; 32 * 8 + INSTANCES],
}

impl PointQueryContext {
    pub(super) const WORLD: Self = Self {
        matrices: [[0.0; 16]; 2],
        instance: NONE,
        rest: [0; 32 * 8 + INSTANCES],
    };
}

/// `RTCPointQueryFunctionArguments`.
#[repr(C, align(16))]
pub(super) struct PointQueryArguments {
    query: *mut PointQuery,
    pub(super) user: *mut c_void,
    pub(super) primitive: c_uint,
    geometry: c_uint,
    context: *mut PointQueryContext,
    similarity: f32,
}

/// `RTCPointQueryFunction`: true if the radius was reduced.
pub(super) type PointQueryFunction = unsafe extern "C" fn(*mut PointQueryArguments) -> bool;

/// Makes the table of functions and what fills it.
macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of a loaded library.
        pub(super) struct Api {
            $(pub(super) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Api {
            /// Loads a library, for good.
            ///
            /// # Errors
            /// What the loader says, or the first function that is missing.
            pub(super) fn load(path: &Path) -> Result<Self, String> {
                // SAFETY: whoever names a file as Embree vouches for what loading it runs; Embree's
                // own initialisers ask for nothing.
                let library = unsafe { Library::new(path) }.map_err(|e| told(&e))?;
                // Never unloaded: functions stay valid, and no thread of it loses its code.
                let library: &'static Library = Box::leak(Box::new(library));
                Ok(Self {
                    $($field: {
                        type Function = unsafe extern "C" fn($($argument),*) $(-> $result)?;
                        // SAFETY: the type is that of Embree's documentation for this name; the
                        // major version is checked before any function is called whose type
                        // differs between versions.
                        let function = unsafe { library.get::<Function>($symbol) };
                        *function.map_err(|e| told(&e))?
                    },)*
                })
            }
        }
    };
}

functions! {
    new_device = c"rtcNewDevice": fn(*const c_char) -> DevicePointer;
    release_device = c"rtcReleaseDevice": fn(DevicePointer);
    device_property = c"rtcGetDeviceProperty": fn(DevicePointer, c_int) -> isize;
    device_error = c"rtcGetDeviceError": fn(DevicePointer) -> c_int;
    new_scene = c"rtcNewScene": fn(DevicePointer) -> ScenePointer;
    release_scene = c"rtcReleaseScene": fn(ScenePointer);
    set_scene_flags = c"rtcSetSceneFlags": fn(ScenePointer, c_int);
    set_scene_build_quality = c"rtcSetSceneBuildQuality": fn(ScenePointer, c_int);
    attach_geometry = c"rtcAttachGeometry": fn(ScenePointer, GeometryPointer) -> c_uint;
    commit_scene = c"rtcCommitScene": fn(ScenePointer);
    new_geometry = c"rtcNewGeometry": fn(DevicePointer, c_int) -> GeometryPointer;
    release_geometry = c"rtcReleaseGeometry": fn(GeometryPointer);
    set_build_quality = c"rtcSetGeometryBuildQuality": fn(GeometryPointer, c_int);
    new_buffer = c"rtcSetNewGeometryBuffer":
        fn(GeometryPointer, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
    update_buffer = c"rtcUpdateGeometryBuffer": fn(GeometryPointer, c_int, c_uint);
    commit_geometry = c"rtcCommitGeometry": fn(GeometryPointer);
    intersect = c"rtcIntersect1": fn(ScenePointer, *mut RayHit, *mut c_void);
    point_query = c"rtcPointQuery":
        fn(
            ScenePointer,
            *mut PointQuery,
            *mut PointQueryContext,
            Option<PointQueryFunction>,
            *mut c_void
        ) -> bool;
}

/// An error of the loader with what is behind it.
fn told(error: &libloading::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {source}"),
        None => error.to_string(),
    }
}
