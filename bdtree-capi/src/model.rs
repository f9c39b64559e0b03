//! Models: opened `.bdt` files.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::ffi::c_char;
use std::ops::ControlFlow;

use bdtree_dynamics::MassProperties;
use bdtree_runtime::{Asset, FormatError, GroupKind, Model, TriangleId};
use zerocopy::FromBytes;

use crate::border::{Handle, In, Kind, Out, done, give};
use crate::sink::same_length;
use crate::status::{BdtStatus, Fault};
use crate::types::{BDT_NONE, BdtTransform, BdtVec3};

/// A `.bdt` file, opened and checked once; shared by any number of instances, which keep what they need of it: it may be
/// freed before them. Any number of threads may read it at once.
pub struct BdtModel {
    _opaque: [u8; 0],
}

impl Kind for BdtModel {
    type Value = Model;
    const TAG: u64 = u64::from_le_bytes(*b"bdtMODEL");
    const NAME: &'static str = "model";
}

/// Opens a file by mapping it: pages are read when queries touch them. Header and tables are checked;
/// `bdt_model_verify` checks the rest.
/// `path`: UTF-8, closed by 0. The file must not be changed or truncated while the model or an instance of it lives;
/// replacing it by renaming another over it is safe. Use `bdt_model_read` where others may change it.
/// Ownership: `*out` is yours, to be freed by `bdt_model_free`; NULL on errors.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_ARGUMENT` (a path that is not UTF-8), `_IO`, `_FORMAT`.
/// Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_load(path: In<c_char>, mut out: Out<*mut BdtModel>) -> BdtStatus {
    give(&mut out, || Ok(Model::load(path.text("path")?)?))
}

/// Opens a file by reading all of it into memory, which nobody else can change. Else as `bdt_model_load`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_read(path: In<c_char>, mut out: Out<*mut BdtModel>) -> BdtStatus {
    give(&mut out, || Ok(Model::read(path.text("path")?)?))
}

/// Opens the bytes of a file, at any address: they are copied, and `bytes` may be freed at once.
/// Ownership: `*out` is yours, to be freed by `bdt_model_free`; NULL on errors.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_FORMAT`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_from_memory(
    bytes: In<u8>,
    length: usize,
    mut out: Out<*mut BdtModel>,
) -> BdtStatus {
    give(&mut out, || {
        Ok(Model::from_bytes(bytes.many(length, "bytes")?)?)
    })
}

/// Frees a model; instances of it live on. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_free(model: Handle<BdtModel>) -> BdtStatus {
    done(|| model.free())
}

/// What a model has. Lengths are mesh units, those of the source.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtModelInfo {
    /// Vertices.
    pub vertex_count: u32,
    /// Triangles.
    pub triangle_count: u32,
    /// Modes: how many numbers q has.
    pub mode_count: u32,
    /// Nodes of the tree.
    pub node_count: u32,
    /// Levels of the tree.
    pub depth: u32,
    /// Joints of the skin; 0 without one.
    pub joint_count: u32,
    /// Bones: joints that move vertices, with an inverse bind matrix each; 0 without a skin.
    pub bone_count: u32,
    /// Nodes of the skeleton; 0 without a skin.
    pub skeleton_node_count: u32,
    /// Clips of the skeleton.
    pub clip_count: u32,
    /// Frames of the animation of q.
    pub frame_count: u32,
    /// Runs of triangles with names.
    pub group_count: u32,
    /// 1 if the file says mass, center of mass and inertia.
    pub has_mass: u32,
    /// Length of the animation of q, seconds; negative without one or without times.
    pub duration_s: f64,
    /// Mesh units per stored unit.
    pub unit: f64,
    /// Where stored coordinates begin, mesh units.
    pub origin: BdtVec3,
}

/// Writes what a model has.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_info(model: Handle<BdtModel>, mut out: Out<BdtModelInfo>) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        let skeleton = asset.skeleton();
        out.one("out")?.write(BdtModelInfo {
            vertex_count: asset.vertex_count() as u32,
            triangle_count: asset.triangle_count() as u32,
            mode_count: asset.mode_count() as u32,
            node_count: asset.node_count() as u32,
            depth: asset.depth() as u32,
            joint_count: asset.joint_count() as u32,
            bone_count: asset.bone_count() as u32,
            skeleton_node_count: skeleton.map_or(0, |of| of.node_count() as u32),
            clip_count: skeleton.map_or(0, |of| of.clip_count() as u32),
            frame_count: asset.frame_count() as u32,
            group_count: asset.groups().count() as u32,
            has_mass: u32::from(asset.mass_properties().is_some()),
            duration_s: asset.duration_s().unwrap_or(-1.0),
            unit: asset.unit(),
            origin: asset.origin().into(),
        });
        Ok(())
    })
}

/// A mode: one displacement field, moved by one number of q.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtMode {
    /// Beyond this |q| is refused.
    pub q_limit: f32,
    /// Typical largest |q|.
    pub q_range: f32,
    /// Angular frequency, rad/s; -1 if unknown.
    pub omega_rad_s: f64,
    /// Modal mass, kg; -1 if unknown.
    pub modal_mass_kg: f64,
    /// The weight of a morph target while nothing moves it; NaN for modes that have none.
    pub default_q: f64,
}

/// Writes what is known of a mode.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_mode(
    model: Handle<BdtModel>,
    index: usize,
    mut out: Out<BdtMode>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        let mode = asset.modes().get(index);
        let mode = mode.ok_or(missing("mode", asset.mode_count(), index))?;
        out.one("out")?.write(BdtMode {
            q_limit: mode.q_limit.get(),
            q_range: mode.q_range.get(),
            omega_rad_s: mode.omega_rad_s.get(),
            modal_mass_kg: mode.modal_mass_kg.get(),
            default_q: asset.default_q().nth(index).flatten().unwrap_or(f64::NAN),
        });
        Ok(())
    })
}

/// Mass properties of a body at rest.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtMass {
    /// kg.
    pub mass_kg: f64,
    /// Center of mass, mesh units.
    pub center: BdtVec3,
    /// About the center of mass, kg · mesh unit²: xx, yy, zz, xy, xz, yz of the tensor (xy is minus the integral of
    /// x y dm).
    pub inertia: [f64; 6],
}

impl From<BdtMass> for MassProperties {
    fn from(mass: BdtMass) -> Self {
        Self {
            mass_kg: mass.mass_kg,
            center: mass.center.into(),
            inertia: mass.inertia,
        }
    }
}

/// Writes mass, center of mass and inertia of the undeformed mesh, where the file says them (`BdtModelInfo::has_mass`).
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX` (the file says none). Thread-safety: any number of threads at
/// once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_mass(model: Handle<BdtModel>, mut out: Out<BdtMass>) -> BdtStatus {
    done(|| {
        let mass = MassProperties::of(model.shared()?.asset());
        let mass = mass.ok_or(missing("mass record", 0, 0))?;
        out.one("out")?.write(BdtMass {
            mass_kg: mass.mass_kg,
            center: mass.center.into(),
            inertia: mass.inertia,
        });
        Ok(())
    })
}

/// `BdtGroup::kind`: an object of the source.
pub const BDT_GROUP_OBJECT: u32 = 1;
/// `BdtGroup::kind`: a group of the source.
pub const BDT_GROUP_GROUP: u32 = 2;
/// `BdtGroup::kind`: a material of the source.
pub const BDT_GROUP_MATERIAL: u32 = 3;

/// A run of triangles that the source put under one name (`bdt_model_group_name`).
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtGroup {
    /// `BDT_GROUP_OBJECT`, `BDT_GROUP_GROUP` or `BDT_GROUP_MATERIAL`; 0 for kinds of later versions.
    pub kind: u32,
    /// Its first triangle.
    pub first_triangle: u32,
    /// How many triangles it has.
    pub triangle_count: u32,
}

/// Writes a group.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_group(
    model: Handle<BdtModel>,
    index: usize,
    mut out: Out<BdtGroup>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        let group = asset.groups().nth(index);
        let group = group.ok_or(missing("group", asset.groups().count(), index))?;
        out.one("out")?.write(BdtGroup {
            kind: match group.kind {
                GroupKind::Object => BDT_GROUP_OBJECT,
                GroupKind::Group => BDT_GROUP_GROUP,
                GroupKind::Material => BDT_GROUP_MATERIAL,
                _ => 0,
            },
            first_triangle: group.first_triangle.0,
            triangle_count: group.triangle_count,
        });
        Ok(())
    })
}

/// Writes the three vertices of each of `count` triangles from `first` on, three numbers each, to `corners`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX` (triangles that the model does not have), `_FORMAT` (a damaged
/// file). Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_triangles(
    model: Handle<BdtModel>,
    first: u32,
    count: usize,
    mut corners: Out<u32>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        range("triangle", first, count, asset.triangle_count())?;
        let slots = corners.many(count.saturating_mul(3), "corners")?;
        let (slots, _) = slots.as_chunks_mut::<3>();
        for (id, slots) in (first..).zip(slots) {
            let own = asset.triangle(TriangleId(id))?;
            for (slot, corner) in slots.iter_mut().zip(own) {
                slot.write(corner.0);
            }
        }
        Ok(())
    })
}

/// Checks everything that opening does not read: checksums, indices, numbers, and that every stored bound holds. It reads
/// the whole file several times: for tools, and once for files of unknown origin.
/// Errors: `BDT_STATUS_ERROR_FORMAT`; `bdt_last_error` says the first rule that is broken, and where. `_NULL`, `_HANDLE`.
/// Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_verify(model: Handle<BdtModel>) -> BdtStatus {
    done(|| Ok(first_broken(model.shared()?.asset())?))
}

fn first_broken(asset: &Asset<'_>) -> Result<(), FormatError> {
    let mut first = Ok(());
    asset.verify(&mut |error| {
        first = Err(error);
        ControlFlow::Break(())
    });
    first
}

/// Checks the checksums of all sections, which finds damage by accident: what to do with a file before it is trusted.
/// Errors: as `bdt_model_verify`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_verify_checksums(model: Handle<BdtModel>) -> BdtStatus {
    done(|| Ok(model.shared()?.asset().verify_checksums()?))
}

/// Writes the q of a frame of the animation, its placement (mesh units to mesh units: the rigid motion that the bake took
/// out) and when it is shown.
/// `q`: `count` numbers, as many as the model has modes. `at` and `time_s` (seconds; -1 without times) may be NULL.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX`, `_LENGTH`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_frame(
    model: Handle<BdtModel>,
    index: usize,
    mut q: Out<f32>,
    count: usize,
    mut at: Out<BdtTransform>,
    mut time_s: Out<f64>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        let frame = asset.frame(index);
        let frame = frame.ok_or(missing("frame", asset.frame_count(), index))?;
        crate::sink::put_all("entries of q", frame.q(), &mut q, count)?;
        if let Some(at) = at.optional("at")? {
            at.write(frame.transform().into());
        }
        if let Some(time) = time_s.optional("time_s")? {
            time.write(frame.time_s().unwrap_or(-1.0));
        }
        Ok(())
    })
}

/// Writes the pose of the animation at a time (seconds), between its frames by interpolation: q, and the placement that
/// goes with it. A loop is `fmod(time, duration)`.
/// `q`: `count` numbers, as many as the model has modes. `at` may be NULL.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_NO_ANIMATION`, `_ARGUMENT` (a time that is not finite), `_LENGTH`.
/// Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_sample(
    model: Handle<BdtModel>,
    time_s: f64,
    mut q: Out<f32>,
    count: usize,
    mut at: Out<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        same_length("entries of q", asset.mode_count(), count)?;
        let mut own = vec![0.0; count];
        let placement = asset.sample(time_s, &mut own)?;
        crate::sink::put_all("entries of q", &own, &mut q, count)?;
        if let Some(at) = at.optional("at")? {
            at.write(placement.into());
        }
        Ok(())
    })
}

/// Writes the joint that carries most of a point of a triangle (of a contact or hit: its `triangle` and `barycentric`):
/// which part of a character was hit. `BDT_NONE` without a skin, or where no bone moves the point.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX`, `_FORMAT` (a damaged file). Thread-safety: any number of threads
/// at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_joint_of(
    model: Handle<BdtModel>,
    triangle: u32,
    barycentric: BdtVec3,
    mut joint: Out<u32>,
) -> BdtStatus {
    done(|| {
        let asset = model.shared()?.asset();
        range("triangle", triangle, 1, asset.triangle_count())?;
        let found = asset.joint_of(TriangleId(triangle), barycentric.into())?;
        joint
            .one("joint")?
            .write(found.map_or(BDT_NONE, |of| of as u32));
        Ok(())
    })
}

pub(crate) fn missing(what: &'static str, count: usize, found: usize) -> Fault {
    Fault::Index { what, count, found }
}

/// Refuses items that are not there.
pub(crate) fn range(
    what: &'static str,
    first: u32,
    asked: usize,
    count: usize,
) -> Result<(), Fault> {
    let end = (first as usize).saturating_add(asked);
    if end <= count {
        return Ok(());
    }
    Err(missing(what, count, end - 1))
}
