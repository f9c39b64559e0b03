//! Which of many instances may meet at all.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_runtime::{BoundingSphere, QueryError, broad};

use crate::answers::BdtIndexPair;
use crate::border::{Handle, In, Out, call};
use crate::instance::BdtInstance;
use crate::sink::{Array, converted};
use crate::status::BdtStatus;
use crate::types::BdtSphere;
use crate::workspace::BdtWorkspace;

/// Writes every pair of `sphere_count` spheres (world) that are at most `prediction` apart, as two ascending numbers,
/// once. Arrays as in `bdt_contacts`.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`. Thread-safety: one thread at
/// a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_sphere_pairs(
    workspace: Handle<BdtWorkspace>,
    spheres: In<BdtSphere>,
    sphere_count: usize,
    prediction: f64,
    mut out: Out<BdtIndexPair>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let spheres: Vec<BoundingSphere> = converted(&spheres, sphere_count, "spheres")?;
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        let mut desk = workspace.exclusive()?;
        broad::pairs(&spheres, prediction, &mut desk.memory, &mut array)?;
        desk.stats = desk.memory.stats();
        array.end(&mut count)
    })
}

/// Writes every pair of `instance_count` instances whose bounding spheres are at most `prediction` apart (world) and whose
/// groups meet (`BdtTags`), as two ascending numbers, once: what to ask by `bdt_pair_contacts`. Arrays as in
/// `bdt_contacts`.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file).
/// Thread-safety: one thread at a time per workspace; several threads may read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_pairs(
    workspace: Handle<BdtWorkspace>,
    instances: In<Handle<BdtInstance>>,
    instance_count: usize,
    prediction: f64,
    mut out: Out<BdtIndexPair>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let handles = instances.handles(instance_count, "instances")?;
        let mut instances = Vec::with_capacity(handles.len());
        for handle in handles {
            instances.push(handle.shared()?);
        }
        let spheres = instances.iter().map(|instance| instance.bounding_sphere());
        let spheres = spheres.collect::<Result<Vec<_>, QueryError>>()?;
        let mut near: Vec<[usize; 2]> = Vec::new();
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        let mut desk = workspace.exclusive()?;
        broad::pairs(&spheres, prediction, &mut desk.memory, &mut near)?;
        desk.stats = desk.memory.stats();
        for [i, j] in near {
            if instances[i].may_meet(instances[j]) {
                array.put([i, j].into());
            }
        }
        array.end(&mut count)
    })
}
