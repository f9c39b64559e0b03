//! From meshes and where they stand to one mesh with its groups and morph targets.

use super::document::Document;
use super::mesh::{MeshData, PrimitiveData};
use super::nodes::Instance;
use super::notes::Notes;
use super::skeleton::{Carriers, Rig};
use super::weights::{Kind, add_equal};
use crate::input::degenerate::Oddity;
use crate::input::{GroupKind, RawGroup, RawInfluences, RawMesh, RawTarget};

/// The morph targets that one node has of its mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MorphNode {
    pub(super) node: Option<usize>,
    /// Place of its first target among all.
    pub(super) first: usize,
    pub(super) count: usize,
}

/// The model in the making.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub(super) mesh: RawMesh,
    pub(super) targets: Vec<RawTarget>,
    pub(super) nodes: Vec<MorphNode>,
    /// The bones of the vertices, where there are bones.
    pub(super) influences: RawInfluences,
}

impl Model {
    /// All instances in order; `meshes[i]` is mesh i of the file, `rig` what carries them. The counts were planned,
    /// so that 32 bits hold them.
    pub(super) fn build(
        document: &Document,
        instances: &[Instance],
        meshes: &[MeshData],
        rig: Option<&Rig>,
        notes: &mut Notes,
    ) -> Self {
        let mut model = Self::default();
        model.influences.starts.push(0);
        let morphing = |i: &&Instance| meshes.get(i.mesh).is_some_and(|m| m.target_count > 0);
        let several = instances.iter().filter(morphing).count() > 1;
        for instance in instances {
            let Some(data) = meshes.get(instance.mesh) else {
                continue;
            };
            let name = instance.name(document);
            let first_vertex = model.mesh.positions.len();
            let first_triangle = model.mesh.triangles.len();
            let group = model.mesh.groups.len();
            model.group(GroupKind::Object, name.clone(), 0);
            for primitive in &data.primitives {
                model.primitive(document, instance, primitive, notes);
                if let Some(rig) = rig {
                    model.carry(instance, primitive, rig, notes);
                }
            }
            let added = model.mesh.triangles.len() - first_triangle;
            model.mesh.groups[group].triangle_count = added as u32;
            let prefix = several.then_some(name);
            model.targets(document, instance, data, first_vertex, prefix, notes);
        }
        model
    }

    /// Opens a group at the next triangle.
    fn group(&mut self, kind: GroupKind, name: String, triangle_count: usize) {
        self.mesh.groups.push(RawGroup {
            kind,
            name,
            first_triangle: self.mesh.triangles.len() as u32,
            triangle_count: triangle_count as u32,
        });
    }

    fn primitive(
        &mut self,
        document: &Document,
        instance: &Instance,
        primitive: &PrimitiveData,
        notes: &mut Notes,
    ) {
        let path = format!("meshes[{}].primitives[{}]", instance.mesh, primitive.index);
        let count = primitive.triangles.len();
        self.group(GroupKind::Group, path.clone(), count);
        if let Some(material) = primitive.material {
            let name = document.materials.get(material).cloned().flatten();
            let name = name.unwrap_or_else(|| format!("materials[{material}]"));
            self.group(GroupKind::Material, name, count);
        }
        let base = self.mesh.positions.len();
        for (i, &p) in primitive.positions.iter().enumerate() {
            let p = instance.world.point(p);
            if !p.iter().all(|x| x.is_finite()) {
                let node = instance.node.unwrap_or_default();
                let message = format!("vertex {i} of {path} leaves the range of numbers");
                notes.problem(format!("nodes[{node}]"), message);
            }
            self.mesh.positions.push(p);
        }
        for corners in &primitive.triangles {
            let corners = corners.map(|corner| base as u32 + corner);
            if let Some(oddity) = Oddity::of(corners, &self.mesh.positions) {
                notes.oddity(oddity, &path, self.mesh.triangles.len());
            }
            self.mesh.triangles.push(corners);
        }
    }

    /// Adds the bones of a primitive's vertices.
    fn carry(
        &mut self,
        instance: &Instance,
        primitive: &PrimitiveData,
        rig: &Rig,
        notes: &mut Notes,
    ) {
        let at = format!(
            "meshes[{}].primitives[{}].attributes",
            instance.mesh, primitive.index
        );
        let all = &mut self.influences;
        // No loss: the counts were planned.
        all.places.push((all.starts.len() as u32 - 1, at.clone()));
        let mut own = Vec::new();
        let mut out_of_range = Kind::default();
        for vertex in 0..primitive.positions.len() {
            own.clear();
            match rig.carriers(instance.node, instance.skin) {
                Some(Carriers::One(bone)) => own.push((bone, 1.0)),
                Some(Carriers::Skin(bones)) => {
                    let joints = primitive.joints.as_ref().map(|joints| joints.of(vertex));
                    for &(joint, weight) in joints.unwrap_or_default() {
                        match bones.get(usize::from(joint)) {
                            Some(&bone) => own.push((bone, weight)),
                            None => out_of_range.add(vertex, || {
                                let skin = instance.skin.unwrap_or_default();
                                let count = bones.len();
                                format!("joint {joint}, but skins[{skin}] has {count} joints")
                            }),
                        }
                    }
                    add_equal(&mut own);
                }
                None => {}
            }
            all.list.extend_from_slice(&own);
            all.starts.push(all.list.len() as u32);
        }
        out_of_range.tell(&at, notes);
    }

    fn targets(
        &mut self,
        document: &Document,
        instance: &Instance,
        data: &MeshData,
        first_vertex: usize,
        prefix: Option<String>,
        notes: &mut Notes,
    ) {
        let count = data.target_count;
        let weights = default_weights(document, instance, count, notes);
        if count == 0 {
            return;
        }
        self.nodes.push(MorphNode {
            node: instance.node,
            first: self.targets.len(),
            count,
        });
        let names = target_names(document, instance.mesh, count, notes);
        for (k, name) in names.into_iter().enumerate() {
            let mut displacements = Vec::new();
            let mut base = first_vertex as u32;
            let mut speaks = false;
            for primitive in &data.primitives {
                if let Some(Some(own)) = primitive.targets.get(k) {
                    speaks = true;
                    let world = |&(i, u): &(u32, [f64; 3])| (base + i, instance.world.vector(u));
                    displacements.extend(own.iter().map(world));
                }
                base += primitive.positions.len() as u32;
            }
            if !displacements
                .iter()
                .all(|(_, u)| u.iter().all(|x| x.is_finite()))
            {
                let at = format!("meshes[{}]", instance.mesh);
                let message = format!("displacements of target {k} leave the range of numbers");
                notes.problem(at, message);
            }
            if !speaks {
                let at = format!("meshes[{}]", instance.mesh);
                notes.warn(at, format!("target {k} moves no positions"));
            }
            let name = match (&prefix, name) {
                (Some(prefix), Some(name)) => Some(format!("{prefix}/{name}")),
                (Some(prefix), None) => Some(format!("{prefix}/target {k}")),
                (None, name) => name,
            };
            self.targets.push(RawTarget {
                name,
                default_weight: weights[k],
                largest_weight: 0.0,
                displacements,
            });
        }
    }
}

/// The weights of a node, else of its mesh, else zeros: `count` of them.
fn default_weights(
    document: &Document,
    instance: &Instance,
    count: usize,
    notes: &mut Notes,
) -> Vec<f64> {
    let node = instance
        .node
        .and_then(|node| document.exact.nodes.get(node));
    let mesh = document.exact.meshes.get(instance.mesh);
    let (at, weights) = match (node.and_then(|n| n.weights.as_ref()), instance.node) {
        (Some(weights), Some(node)) => (format!("nodes[{node}].weights"), weights),
        _ => match mesh.and_then(|m| m.weights.as_ref()) {
            Some(weights) => (format!("meshes[{}].weights", instance.mesh), weights),
            None => return vec![0.0; count],
        },
    };
    if weights.len() != count {
        let message = format!("{} weights for {count} morph targets", weights.len());
        if count > 0 {
            notes.problem(at, message);
        } else {
            notes.warn(at, message);
        }
        return vec![0.0; count];
    }
    weights.clone()
}

/// `extras.targetNames` of a mesh, else of its first primitive (as some exporters write it).
fn target_names(
    document: &Document,
    index: usize,
    count: usize,
    notes: &mut Notes,
) -> Vec<Option<String>> {
    let mesh = document.exact.meshes.get(index);
    let own = mesh.map(|mesh| &mesh.extras);
    let first = mesh
        .and_then(|mesh| mesh.primitives.first())
        .map(|p| &p.extras);
    let list = [own, first]
        .into_iter()
        .flatten()
        .find_map(|extras| extras["targetNames"].as_array());
    let mut names: Vec<Option<String>> = list
        .into_iter()
        .flatten()
        .map(|name| name.as_str().map(str::to_string))
        .collect();
    if list.is_some() && names.len() != count {
        let at = format!("meshes[{index}].extras.targetNames");
        notes.warn(
            at,
            format!("{} names for {count} morph targets", names.len()),
        );
    }
    names.resize(count, None);
    names
}
