//! The node that scripts see.
// Within the module: what the macros write is public.
#![allow(unreachable_pub)]

use bdtree_runtime::joint::compose;
use bdtree_runtime::{Ball, BoneMatrices, Capsule, JointMatrix, Shape, Transform};
use godot::classes::{ArrayMesh, FileAccess, INode3D, Mesh, MeshInstance3D, Skeleton3D, Skin};
use godot::prelude::*;

use crate::body::{Body, Found, Value};
use crate::fault::{Fault, Told};
use crate::names::{binds_of_bones, bones_of_joints, modes_of_shapes};
use crate::place::{bone_in_model, cuboid, matrix, placement};
use crate::shared::Files;

static FILES: Files = Files::new();

/// A deforming mesh that can be asked: a `.bdt` file in the pose of a MeshInstance3D. All points, lengths and transforms of
/// its methods are global. A method that fails pushes an error, once per kind, emits `failed`, and answers that there is
/// nothing.
#[derive(GodotClass)]
#[class(init, base = Node3D)]
pub struct BdtCollider3D {
    /// The `.bdt` file; nodes with the same one share it.
    #[export(file = "*.bdt")]
    #[var(set = set_file)]
    file: GString,
    /// The MeshInstance3D whose skeleton and blend shapes pose it. Empty: the parent if that is one, else the first child of
    /// the parent that is one.
    #[export(node_path = ("MeshInstance3D"))]
    #[var(set = set_mesh_instance)]
    mesh_instance: NodePath,
    /// Takes the pose in every frame. Else call `update_pose()`.
    #[export]
    #[init(val = true)]
    auto_update: bool,
    /// Takes the bind poses of the MeshInstance3D's Skin instead of those of the file: for imports that change rests.
    #[export]
    #[var(set = set_use_skin_binds)]
    use_skin_binds: bool,
    body: Option<Body>,
    source: Option<Source>,
    /// A pose was taken since the file was opened.
    is_posed: bool,
    told: Told,
    base: Base<Node3D>,
}

/// What was found of a MeshInstance3D, until one of the two is another.
struct Source {
    mesh: Gd<MeshInstance3D>,
    /// What it showed, and whose bones it named.
    drawn: Option<Gd<Mesh>>,
    path: NodePath,
    skeleton: Option<Gd<Skeleton3D>>,
    /// The Skin and, of each bone of the file, its bind, if that is wanted.
    skin: Option<(Gd<Skin>, Vec<usize>)>,
    /// Of each joint of the file its bone in the skeleton.
    places: Vec<usize>,
    /// Names of these bones.
    names: Vec<String>,
    /// Of each bone of the file its joint.
    joint_of: Vec<usize>,
    /// Of each blend shape its mode.
    modes: Vec<usize>,
    /// In the collider's model, of each joint; or of each bone with its bind.
    matrices: Vec<JointMatrix>,
}

#[godot_api]
impl INode3D for BdtCollider3D {
    fn ready(&mut self) {
        if self.base().get_process_priority() == 0 {
            // After animations, scripts and whatever else poses the skeleton.
            self.base_mut().set_process_priority(1000);
        }
    }

    fn process(&mut self, _delta: f64) {
        if self.auto_update {
            self.update_pose();
        }
    }
}

#[godot_api]
impl BdtCollider3D {
    /// Something could not be done: for the first time since file and mesh were set, or `forget_failures()` was called.
    #[signal]
    fn failed(kind: GString, message: GString);

    /// Takes skeleton, blend shapes and transforms as they are now. Without a mesh, the pose is what `set_q()` said, at this
    /// node's transform. Returns whether that was possible; if not, the last pose stays.
    #[func]
    fn update_pose(&mut self) -> bool {
        let posed = self.try_update();
        self.is_posed |= posed.is_ok();
        self.answer(posed.map(|()| true), false)
    }

    /// What the segment meets first; empty if nothing.
    #[func]
    fn cast_ray(&mut self, from: Vector3, to: Vector3) -> VarDictionary {
        let hit = self.query(|body| body.cast_ray(wide(from), wide(to)));
        self.dictionary(hit.flatten())
    }

    /// Whether a ball touches the surface.
    #[func]
    fn intersects_sphere(&mut self, center: Vector3, radius: f64) -> bool {
        self.intersects(|| Ok(Ball::new(wide(center), radius)))
    }

    /// Whether a box touches the surface: that of a BoxShape3D of this size in a node of this global transform.
    #[func]
    fn intersects_box(&mut self, transform: Transform3D, size: Vector3) -> bool {
        self.intersects(|| cuboid(&rows(&transform), size.to_array()))
    }

    /// Whether a capsule touches the surface: all points within the radius of the segment.
    #[func]
    fn intersects_capsule(&mut self, from: Vector3, to: Vector3, radius: f64) -> bool {
        self.intersects(|| Ok(Capsule::new(wide(from), wide(to), radius)))
    }

    /// All triangles that a ball touches.
    #[func]
    fn contacts_sphere(&mut self, center: Vector3, radius: f64) -> Array<VarDictionary> {
        let contacts = self.query(|body| body.contacts(wide(center), radius));
        let contacts = contacts.unwrap_or_default().into_iter();
        contacts.map(|found| self.dictionary(Some(found))).collect()
    }

    /// The nearest point of the surface within a distance (`INF`: any); empty if there is none.
    #[func]
    fn closest_point(&mut self, point: Vector3, max_distance: f64) -> VarDictionary {
        let found = self.query(|body| body.closest_point(wide(point), max_distance));
        self.dictionary(found.flatten())
    }

    /// A box that holds the surface in its pose; it is not the smallest one.
    #[func]
    fn get_aabb(&mut self) -> Aabb {
        let (low, size) = self.query(|body| body.aabb()).unwrap_or_default();
        Aabb::new(Vector3::from_array(low), Vector3::from_array(size))
    }

    /// Weights of the file's modes that no blend shape moves, one per mode, for the next `update_pose()`.
    #[func]
    fn set_q(&mut self, q: PackedFloat32Array) {
        self.ask(|body| body.set_q(q.as_slice()));
    }

    /// The weights of all modes.
    #[func]
    fn get_q(&mut self) -> PackedFloat32Array {
        let q = self.ask(|body| Ok(PackedFloat32Array::from(body.q())));
        q.unwrap_or_default()
    }

    /// Names of the file's modes, empty for those without.
    #[func]
    fn get_mode_names(&mut self) -> PackedStringArray {
        let names = self.ask(|body| {
            let names = body.mode_names().into_iter();
            Ok(names
                .map(|name| GString::from(name.unwrap_or_default()))
                .collect())
        });
        names.unwrap_or_default()
    }

    /// The last failure in words; empty without one.
    #[func]
    fn last_failure(&self) -> GString {
        GString::from(self.told.last())
    }

    /// Failures are told anew from now on.
    #[func]
    fn forget_failures(&mut self) {
        self.told.forget();
    }

    #[func]
    fn set_file(&mut self, file: GString) {
        self.file = file;
        self.body = None;
        self.is_posed = false;
        self.source = None;
        self.told.forget();
    }

    #[func]
    fn set_mesh_instance(&mut self, path: NodePath) {
        self.mesh_instance = path;
        self.source = None;
        self.told.forget();
    }

    #[func]
    fn set_use_skin_binds(&mut self, is_wanted: bool) {
        self.use_skin_binds = is_wanted;
        self.source = None;
        self.told.forget();
    }
}

impl BdtCollider3D {
    /// The value; of a fault, what stands for none, after telling it.
    fn answer<T>(&mut self, answer: Result<T, Fault>, none: T) -> T {
        let fault = match answer {
            Ok(value) => return value,
            Err(fault) => fault,
        };
        if self.told.is_new(&fault) {
            let name = self.base().get_name();
            godot_error!("BdtCollider3D {name}: {fault}");
            let (kind, words) = (GString::from(fault.kind()), self.last_failure());
            self.signals().failed().emit(&kind, &words);
        }
        none
    }

    fn ask<T>(&mut self, question: impl FnOnce(&mut Body) -> Result<T, Fault>) -> Option<T> {
        let answer = self.open().and_then(|()| match &mut self.body {
            Some(body) => question(body),
            None => Err(Fault::NoFile),
        });
        self.answer(answer.map(Some), None)
    }

    /// Asks a body that has a pose: the first query comes before the first frame.
    fn query<T>(&mut self, question: impl FnOnce(&mut Body) -> Result<T, Fault>) -> Option<T> {
        if !self.is_posed && self.auto_update {
            self.update_pose();
        }
        self.ask(question)
    }

    fn intersects<S: Into<Shape>>(&mut self, shape: impl FnOnce() -> Result<S, Fault>) -> bool {
        self.query(|body| body.intersects(shape()?))
            .unwrap_or(false)
    }

    fn dictionary(&self, found: Option<Found>) -> VarDictionary {
        let mut out = VarDictionary::new();
        let names = self.source.as_ref().map(|source| source.names.as_slice());
        for (key, value) in found
            .iter()
            .flat_map(|found| found.entries(names.unwrap_or_default()))
        {
            let value = match value {
                Value::Vector(xyz) => Vector3::from_array(xyz).to_variant(),
                Value::Float(x) => x.to_variant(),
                Value::Int(i) => i.to_variant(),
                Value::Name(name) => GString::from(&name).to_variant(),
            };
            out.set(key, &value);
        }
        out
    }

    /// Reads the file, unless that is done.
    fn open(&mut self) -> Result<(), Fault> {
        if self.body.is_some() {
            return Ok(());
        }
        if self.file.is_empty() {
            return Err(Fault::NoFile);
        }
        let path = self.file.to_string();
        let model = FILES.model(&path, || {
            let bytes = FileAccess::get_file_as_bytes(&self.file);
            if bytes.is_empty() {
                let reason = format!("{:?}", FileAccess::get_open_error());
                return Err(Fault::Read {
                    path: path.clone(),
                    reason,
                });
            }
            Ok(bytes.to_vec())
        })?;
        self.body = Some(Body::new(model)?);
        Ok(())
    }

    fn try_update(&mut self) -> Result<(), Fault> {
        self.open()?;
        let mesh = self.mesh()?;
        let is_same = match (&self.source, &mesh) {
            (Some(source), Some(mesh)) => source.is_current() && source.mesh == *mesh,
            _ => false,
        };
        if !is_same {
            self.source = None;
        }
        let at = placement(&rows(&self.base().get_global_transform()))?;
        let Some(body) = &mut self.body else {
            return Err(Fault::NoFile);
        };
        if self.source.is_none() {
            self.source = match mesh {
                Some(mesh) => Some(Source::find(mesh, body, self.use_skin_binds)?),
                None if body.asset().has_skin() => return Err(Fault::SkinWithoutMesh),
                None => None,
            };
        }
        let Some(source) = &mut self.source else {
            return body.pose(BoneMatrices::Rest, at);
        };
        for (shape, mode) in source.modes.iter().enumerate() {
            body.set_weight(*mode, source.mesh.get_blend_shape_value(shape as i32));
        }
        source.read_bones(&at);
        if let Some((skin, binds)) = &source.skin {
            for (of, bind) in source.matrices.iter_mut().zip(binds) {
                *of = compose(of, &rows(&skin.get_bind_pose(*bind as i32)));
            }
            return body.pose(BoneMatrices::Skinning(&source.matrices), at);
        }
        body.pose(BoneMatrices::Joints(&source.matrices), at)
    }

    /// The MeshInstance3D that is meant; none where none is named or near.
    fn mesh(&self) -> Result<Option<Gd<MeshInstance3D>>, Fault> {
        let base = self.base();
        if !self.mesh_instance.is_empty() {
            let found = base.try_get_node_as::<MeshInstance3D>(&self.mesh_instance);
            let missing = || Fault::NoMesh(self.mesh_instance.to_string());
            return found.map(Some).ok_or_else(missing);
        }
        let Some(parent) = base.get_parent() else {
            return Ok(None);
        };
        let parent = match parent.try_cast::<MeshInstance3D>() {
            Ok(mesh) => return Ok(Some(mesh)),
            Err(parent) => parent,
        };
        let siblings = parent.get_children();
        Ok((siblings.iter_shared()).find_map(|node| node.try_cast::<MeshInstance3D>().ok()))
    }
}

impl Source {
    /// Finds what the file's joints and modes are by name.
    fn find(mesh: Gd<MeshInstance3D>, body: &Body, with_binds: bool) -> Result<Self, Fault> {
        let shapes = match mesh.get_mesh().map(|mesh| mesh.try_cast::<ArrayMesh>()) {
            Some(Ok(mesh)) => (0..mesh.get_blend_shape_count())
                .map(|shape| mesh.get_blend_shape_name(shape).to_string())
                .collect(),
            // Other meshes have none.
            _ => Vec::new(),
        };
        let node = mesh.get_name().to_string();
        let mut source = Self {
            modes: modes_of_shapes(&body.mode_names(), &shapes, &node)?,
            skeleton: None,
            skin: None,
            places: Vec::new(),
            names: Vec::new(),
            joint_of: body.joints_of_bones(),
            matrices: Vec::new(),
            drawn: mesh.get_mesh(),
            path: mesh.get_skeleton_path(),
            mesh,
        };
        if !body.asset().has_skin() {
            return Ok(source);
        }
        let skeleton = source.mesh.try_get_node_as::<Skeleton3D>(&source.path);
        let skeleton = skeleton.ok_or_else(|| Fault::NoSkeleton(source.path.to_string()))?;
        let bones: Vec<_> = (0..skeleton.get_bone_count())
            .map(|bone| skeleton.get_bone_name(bone).to_string())
            .collect();
        let joints = body.joint_names();
        source.places = bones_of_joints(&joints, &bones)?;
        source.names = source
            .places
            .iter()
            .map(|bone| bones[*bone].clone())
            .collect();
        if with_binds {
            let skin = source.mesh.get_skin().ok_or(Fault::NoSkin)?;
            let bone_of = |bind| {
                let name = skin.get_bind_name(bind).to_string();
                // Binds have a name or a number.
                match bones.iter().position(|bone| *bone == name) {
                    Some(bone) => Some(bone),
                    None => usize::try_from(skin.get_bind_bone(bind)).ok(),
                }
            };
            let binds: Vec<_> = (0..skin.get_bind_count()).map(bone_of).collect();
            let of_bones = binds_of_bones(&source.joint_of, &source.places, &binds, &joints)?;
            source.skin = Some((skin, of_bones));
        }
        source.skeleton = Some(skeleton);
        Ok(source)
    }

    /// Whether the nodes still exist, and the mesh and its skeleton are those of before.
    fn is_current(&self) -> bool {
        // First: nodes that were freed must not be asked.
        self.mesh.is_instance_valid()
            && (self.skeleton.as_ref()).is_none_or(|skeleton| skeleton.is_instance_valid())
            && self.mesh.get_mesh() == self.drawn
            && self.mesh.get_skeleton_path() == self.path
    }

    /// Where the skeleton puts the joints, or the bones of the file, in the model of a collider that stands at `at`.
    fn read_bones(&mut self, at: &Transform) {
        self.matrices.clear();
        let Some(skeleton) = &self.skeleton else {
            return;
        };
        let world = rows(&self.mesh.get_global_transform());
        let pose = |joint: usize| {
            let bone = self.places[joint] as i32;
            bone_in_model(at, &world, &rows(&skeleton.get_bone_global_pose(bone)))
        };
        if self.skin.is_some() {
            self.matrices
                .extend(self.joint_of.iter().map(|joint| pose(*joint)));
        } else {
            self.matrices.extend((0..self.places.len()).map(pose));
        }
    }
}

/// A vector in f64.
fn wide(v: Vector3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn rows(of: &Transform3D) -> JointMatrix {
    matrix(
        of.basis.rows.map(|row| row.to_array()),
        of.origin.to_array(),
    )
}
