//! Instances: deforming bodies.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_runtime::{
    BoneMatrices, CacheSize, Instance, JointMatrix, Transform, TriangleId, VertexId,
};
use zerocopy::FromBytes;

use crate::border::{Handle, In, Kind, Out, done, give};
use crate::model::{BdtModel, range};
use crate::sink::{converted, put_all, same_length};
use crate::status::{BdtStatus, Fault};
use crate::types::{BdtAabb, BdtMatrix, BdtSphere, BdtTransform, BdtVec3};

/// One deforming body: a model, q, bones, a placement, and what queries of a step keep. One thread at a time may use it;
/// where a function says so, several may read it at once.
pub struct BdtInstance {
    _opaque: [u8; 0],
}

impl Kind for BdtInstance {
    type Value = Instance;
    const TAG: u64 = u64::from_le_bytes(*b"bdtINSTA");
    const NAME: &'static str = "instance";
}

/// Makes an instance at q = 0, at rest, placed where the mesh is, with a step cache of 64 nodes and 32 leaves (14 KB).
/// Ownership: `*out` is yours, to be freed by `bdt_instance_free`; NULL on errors. The model may be freed before it.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`. Thread-safety: any number of threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_new(
    model: Handle<BdtModel>,
    mut out: Out<*mut BdtInstance>,
) -> BdtStatus {
    give(&mut out, || Ok(Instance::new(model.shared()?)?))
}

/// The same with a step cache of another size, which keeps what queries of one pose compute: 0 and 0 for bodies that are
/// queried once per step. A node takes 160 bytes, a leaf 128.
/// Ownership, errors, thread-safety: as `bdt_instance_new`; `_ARGUMENT` beyond 2^24 of either.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_new_with_cache(
    model: Handle<BdtModel>,
    nodes: usize,
    leaves: usize,
    mut out: Out<*mut BdtInstance>,
) -> BdtStatus {
    const MOST: usize = 1 << 24;
    give(&mut out, || {
        if nodes > MOST || leaves > MOST {
            return Err(Fault::Argument("nodes, leaves: beyond 2^24"));
        }
        let size = CacheSize { nodes, leaves };
        Ok(Instance::with_cache(model.shared()?, size)?)
    })
}

/// Frees an instance. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`, `_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
/// may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_free(instance: Handle<BdtInstance>) -> BdtStatus {
    done(|| instance.free())
}

/// Sets q: `count` numbers, as many as the model has modes. Placement and bones stay. On errors nothing changes.
/// Of a vibration mode 1 moves the farthest vertex by one mesh unit; of a morph target 1 is the whole target.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_LENGTH`, `_POSE` (not finite, or beyond `BdtMode::q_limit`).
/// Thread-safety: one thread at a time per instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_q(
    instance: Handle<BdtInstance>,
    q: In<f32>,
    count: usize,
) -> BdtStatus {
    done(|| Ok(instance.exclusive()?.set_q(q.many(count, "q")?)?))
}

/// Writes q as queries use it: `count` numbers, as many as the model has modes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_LENGTH`. Thread-safety: several threads may read an instance at
/// once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_q(
    instance: Handle<BdtInstance>,
    mut q: Out<f32>,
    count: usize,
) -> BdtStatus {
    done(|| put_all("entries of q", instance.shared()?.q(), &mut q, count))
}

/// Sets the placement. q and bones stay. On errors nothing changes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_POSE`. Thread-safety: one thread at a time per instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_placement(
    instance: Handle<BdtInstance>,
    at: In<BdtTransform>,
) -> BdtStatus {
    done(|| Ok(instance.exclusive()?.set_placement(*at.one("at")?)?))
}

/// Lets queries refine the pose by themselves where a step asks so much that it pays (some 500 rays for 36000 triangles), or
/// not any more: 0 for no. It takes some 65 bytes per triangle then. Answers stay the same. Queries of workspaces whose
/// instances are shared do without.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_refining(instance: Handle<BdtInstance>, on: i32) -> BdtStatus {
    done(|| {
        instance.exclusive()?.set_refining(on != 0);
        Ok(())
    })
}

/// Writes the placement, as it was given.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_placement(
    instance: Handle<BdtInstance>,
    mut out: Out<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let at = instance.shared()?.placement();
        out.one("out")?.write(at.into());
        Ok(())
    })
}

/// Sets q and the placement, faster than one after the other. Bones stay. On errors nothing changes.
/// Errors and thread-safety: as `bdt_instance_set_q` and `bdt_instance_set_placement`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_pose(
    instance: Handle<BdtInstance>,
    q: In<f32>,
    count: usize,
    at: In<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let (q, at) = (q.many(count, "q")?, *at.one("at")?);
        Ok(instance.exclusive()?.set_pose(q, at)?)
    })
}

/// Moves the bones: `count` matrices, one per joint of the model, each from the joint's space to the model's (mesh
/// units), without inverse bind matrices (`bdt_joint_in_model` makes them from matrices of world space). q and placement
/// stay. On errors nothing changes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_NO_SKIN`, `_LENGTH`, `_POSE` (a matrix that is not finite).
/// Thread-safety: one thread at a time per instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_joints(
    instance: Handle<BdtInstance>,
    joints: In<BdtMatrix>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let joints = matrices(&joints, count)?;
        Ok(instance.exclusive()?.set_joints(&joints)?)
    })
}

/// Moves the bones: `count` matrices, one per bone of the model, joint matrix times inverse bind matrix, as skinning
/// shaders take them. Else as `bdt_instance_set_joints`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_skinning_matrices(
    instance: Handle<BdtInstance>,
    bones: In<BdtMatrix>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let bones = matrices(&bones, count)?;
        Ok(instance.exclusive()?.set_skinning_matrices(&bones)?)
    })
}

/// Sets q, moves the bones by one matrix per joint and places the instance, faster than one after the other. On errors
/// nothing changes. `joints` may be NULL with `joint_count` 0: bones at rest.
/// Errors and thread-safety: as `bdt_instance_set_q`, `bdt_instance_set_joints` and `bdt_instance_set_placement`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_pose_with_joints(
    instance: Handle<BdtInstance>,
    q: In<f32>,
    count: usize,
    joints: In<BdtMatrix>,
    joint_count: usize,
    at: In<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let (q, at) = (q.many(count, "q")?, *at.one("at")?);
        let joints = matrices(&joints, joint_count)?;
        let bones = if joints.is_empty() {
            BoneMatrices::Rest
        } else {
            BoneMatrices::Joints(&joints)
        };
        Ok(instance.exclusive()?.set_pose_with_bones(q, bones, at)?)
    })
}

fn matrices(matrices: &In<BdtMatrix>, count: usize) -> Result<Vec<JointMatrix>, Fault> {
    converted(matrices, count, "matrices")
}

/// Writes a box that holds the deformed mesh in the world, conservatively: it follows q, bones and placement, and costs
/// one node.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_FORMAT` (a damaged file). Thread-safety: several threads may
/// read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_aabb(
    instance: Handle<BdtInstance>,
    mut out: Out<BdtAabb>,
) -> BdtStatus {
    done(|| {
        let aabb = instance.shared()?.aabb()?;
        out.one("out")?.write(aabb.into());
        Ok(())
    })
}

/// Writes the smallest box around the deformed mesh in the world: it computes every triangle. For tools.
/// Errors and thread-safety: as `bdt_instance_aabb`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_exact_aabb(
    instance: Handle<BdtInstance>,
    mut out: Out<BdtAabb>,
) -> BdtStatus {
    done(|| {
        let aabb = instance.shared()?.snapshot().exact_aabb()?;
        out.one("out")?.write(aabb.into());
        Ok(())
    })
}

/// Writes a sphere that holds the deformed mesh in the world, conservatively.
/// Errors and thread-safety: as `bdt_instance_aabb`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_bounding_sphere(
    instance: Handle<BdtInstance>,
    mut out: Out<BdtSphere>,
) -> BdtStatus {
    done(|| {
        let sphere = instance.shared()?.bounding_sphere()?;
        out.one("out")?.write(sphere.into());
        Ok(())
    })
}

/// Writes where `count` vertices from `first` on are in the world, as queries compute them.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX` (vertices that the model does not have), `_FORMAT` (a
/// damaged file). Thread-safety: several threads may read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_vertices(
    instance: Handle<BdtInstance>,
    first: u32,
    count: usize,
    mut out: Out<BdtVec3>,
) -> BdtStatus {
    done(|| {
        let instance = instance.shared()?;
        range(
            "vertex",
            first,
            count,
            instance.model().asset().vertex_count(),
        )?;
        let pose = instance.snapshot();
        for (id, slot) in (first..).zip(out.many(count, "out")?) {
            slot.write(pose.deformed(VertexId(id))?.into());
        }
        Ok(())
    })
}

/// Adds the generalised force of a world force that acts on a point of a triangle to `forces`: Uᵀ f, one number per mode
/// (world units · force per unit of q). `forces` holds `count` numbers, as many as the model has modes, which are read
/// and changed. Weights and force are not checked.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX`, `_LENGTH`, `_FORMAT` (a damaged file). Thread-safety:
/// several threads may read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_add_generalized_force(
    instance: Handle<BdtInstance>,
    triangle: u32,
    barycentric: BdtVec3,
    force: BdtVec3,
    mut forces: Out<f64>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let instance = instance.shared()?;
        let asset = instance.model().asset();
        range("triangle", triangle, 1, asset.triangle_count())?;
        same_length("forces", asset.mode_count(), count)?;
        let (id, weights) = (TriangleId(triangle), barycentric.into());
        let forces = forces.values(count, "forces")?;
        let pose = instance.snapshot();
        Ok(pose.add_generalized_force(id, weights, force.into(), forces)?)
    })
}

/// What a program keeps with an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtTags {
    /// Any number of the program's own; default 0.
    pub user_data: u64,
    /// Bits of the groups it is in; default all.
    pub collision_group: u32,
    /// Bits of the groups it collides with; default all. `bdt_instance_pairs` leaves out pairs of which one's group is
    /// not in the other's mask.
    pub collision_mask: u32,
}

/// Sets user data and collision groups.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_tags(
    instance: Handle<BdtInstance>,
    tags: In<BdtTags>,
) -> BdtStatus {
    done(|| {
        let tags = tags.one("tags")?;
        let mut instance = instance.exclusive()?;
        instance.user_data = tags.user_data;
        instance.collision_group = tags.collision_group;
        instance.collision_mask = tags.collision_mask;
        Ok(())
    })
}

/// Writes user data and collision groups.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read an instance at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_tags(
    instance: Handle<BdtInstance>,
    mut out: Out<BdtTags>,
) -> BdtStatus {
    done(|| {
        let instance = instance.shared()?;
        out.one("out")?.write(BdtTags {
            user_data: instance.user_data,
            collision_group: instance.collision_group,
            collision_mask: instance.collision_mask,
        });
        Ok(())
    })
}

/// Writes the placement that does what `first` does and then what `then` does. `out` may be one of them.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_POSE`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_transform_after(
    then: BdtTransform,
    first: BdtTransform,
    mut out: Out<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let both = Transform::from(then).after(first.into())?;
        out.one("out")?.write(both.into());
        Ok(())
    })
}

/// Writes the matrix of a joint from its space to the model's (mesh units), of one from its space to the world's, and of
/// the instance's placement `at`, which is not checked: what `bdt_instance_set_joints` takes.
/// Errors: `BDT_STATUS_ERROR_NULL`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_joint_in_model(
    at: BdtTransform,
    in_world: BdtMatrix,
    mut out: Out<BdtMatrix>,
) -> BdtStatus {
    done(|| {
        let matrix = Transform::from(at).joint_in_model(&in_world.rows);
        out.one("out")?.write(matrix.into());
        Ok(())
    })
}
