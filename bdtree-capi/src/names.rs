//! Names of modes, joints, clips and groups.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::ffi::c_char;

use bdtree_runtime::{Asset, Skeleton};

use crate::border::{Handle, In, Out, call, done};
use crate::model::{BdtModel, missing};
use crate::sink::put_text;
use crate::status::{BdtStatus, Fault};
use crate::types::BDT_NONE;

fn skeleton<'a>(asset: &Asset<'a>) -> Result<Skeleton<'a>, Fault> {
    asset.skeleton().ok_or(Fault::NoSkin)
}

/// Writes the name of a mode, as the source called the morph target or field; empty if it has none.
/// `buffer` gets at most `capacity` bytes of UTF-8, the closing 0 included; `length` (may be NULL) the bytes of the whole
/// name without the 0.
/// Errors: `BDT_STATUS_TRUNCATED` (the name was cut), `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_INDEX`.
/// Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_mode_name(
    model: Handle<BdtModel>,
    index: usize,
    mut buffer: Out<c_char>,
    capacity: usize,
    mut length: Out<usize>,
) -> BdtStatus {
    call(|| {
        let asset = model.shared()?.asset();
        if index >= asset.mode_count() {
            return Err(missing("mode", asset.mode_count(), index));
        }
        let name = asset.mode_name(index).unwrap_or_default();
        put_text(name, &mut buffer, capacity, &mut length)
    })
}

/// Writes the mode of a name (UTF-8, closed by 0), the first of several: its place in q.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_ARGUMENT` (not UTF-8), `_INDEX` (no such name).
/// Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_mode_index(
    model: Handle<BdtModel>,
    name: In<c_char>,
    mut index: Out<usize>,
) -> BdtStatus {
    done(|| {
        let found = model.shared()?.asset().mode_index(name.text("name")?);
        index.one("index")?.write(found.ok_or(Fault::Name("mode"))?);
        Ok(())
    })
}

/// Writes the name of a joint, as `bdt_model_mode_name` does.
/// Errors: its errors; `BDT_STATUS_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_joint_name(
    model: Handle<BdtModel>,
    index: usize,
    mut buffer: Out<c_char>,
    capacity: usize,
    mut length: Out<usize>,
) -> BdtStatus {
    call(|| {
        let skeleton = skeleton(model.shared()?.asset())?;
        let count = skeleton.joint_count();
        if index >= count {
            return Err(missing("joint", count, index));
        }
        let name = skeleton.joint_name(index).unwrap_or_default();
        put_text(name, &mut buffer, capacity, &mut length)
    })
}

/// Writes the joint of a name, the first of several.
/// Errors: those of `bdt_model_mode_index`; `BDT_STATUS_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_joint_index(
    model: Handle<BdtModel>,
    name: In<c_char>,
    mut index: Out<usize>,
) -> BdtStatus {
    done(|| {
        let found = skeleton(model.shared()?.asset())?.joint_index(name.text("name")?);
        index
            .one("index")?
            .write(found.ok_or(Fault::Name("joint"))?);
        Ok(())
    })
}

/// Writes the joint that moves another one; `BDT_NONE` for a root.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_NO_SKIN`, `_INDEX`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_joint_parent(
    model: Handle<BdtModel>,
    index: usize,
    mut parent: Out<u32>,
) -> BdtStatus {
    done(|| {
        let skeleton = skeleton(model.shared()?.asset())?;
        let count = skeleton.joint_count();
        if index >= count {
            return Err(missing("joint", count, index));
        }
        let found = skeleton.joint_parent(index);
        parent
            .one("parent")?
            .write(found.map_or(BDT_NONE, |of| of as u32));
        Ok(())
    })
}

/// Writes the name of a clip, as `bdt_model_mode_name` does.
/// Errors: its errors; `BDT_STATUS_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_clip_name(
    model: Handle<BdtModel>,
    index: usize,
    mut buffer: Out<c_char>,
    capacity: usize,
    mut length: Out<usize>,
) -> BdtStatus {
    call(|| {
        let skeleton = skeleton(model.shared()?.asset())?;
        let clip = skeleton.clip(index);
        let clip = clip.ok_or(missing("clip", skeleton.clip_count(), index))?;
        put_text(clip.name(), &mut buffer, capacity, &mut length)
    })
}

/// Writes the clip of a name, the first of several.
/// Errors: those of `bdt_model_mode_index`; `BDT_STATUS_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_clip_index(
    model: Handle<BdtModel>,
    name: In<c_char>,
    mut index: Out<usize>,
) -> BdtStatus {
    done(|| {
        let found = skeleton(model.shared()?.asset())?.clip_index(name.text("name")?);
        index.one("index")?.write(found.ok_or(Fault::Name("clip"))?);
        Ok(())
    })
}

/// Writes how long a clip lasts: seconds from time 0 to its last key.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_NO_SKIN`, `_INDEX`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_clip_duration(
    model: Handle<BdtModel>,
    index: usize,
    mut duration_s: Out<f64>,
) -> BdtStatus {
    done(|| {
        let skeleton = skeleton(model.shared()?.asset())?;
        let clip = skeleton.clip(index);
        let clip = clip.ok_or(missing("clip", skeleton.clip_count(), index))?;
        duration_s.one("duration_s")?.write(clip.duration_s());
        Ok(())
    })
}

/// Writes the name of a group, as `bdt_model_mode_name` does.
/// Errors: its errors. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_model_group_name(
    model: Handle<BdtModel>,
    index: usize,
    mut buffer: Out<c_char>,
    capacity: usize,
    mut length: Out<usize>,
) -> BdtStatus {
    call(|| {
        let asset = model.shared()?.asset();
        let group = asset.groups().nth(index);
        let group = group.ok_or(missing("group", asset.groups().count(), index))?;
        put_text(group.name, &mut buffer, capacity, &mut length)
    })
}
