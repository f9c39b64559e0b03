//! Which element is of which material: `*MATERIAL`, `*SET` and `*REGION` of a .veg file.

use std::collections::HashMap;

use super::super::draft::Draft;
use super::super::notes::Notes;
use super::super::number::Kind;
use super::super::source::Source;
use super::super::{RawMaterial, RawNodeSet};
use super::next_line_of_section;
use crate::input::obj::tokens::{integer, show};

/// The set of all elements, which needs no `*SET`.
const ALL: &str = "allElements";

/// What the sections say, in file order; resolved when all elements are known.
#[derive(Default)]
pub(super) struct Assignment {
    materials: Vec<RawMaterial>,
    sets: Vec<Set>,
    regions: Vec<Region>,
}

struct Set {
    name: String,
    /// Elements as the file numbers them, each with its line.
    elements: Vec<(i64, u64)>,
}

struct Region {
    set: String,
    material: String,
    position: u64,
}

impl Assignment {
    /// After `*MATERIAL`: the name, then a line `ENU, density, E, nu`.
    pub(super) fn material(&mut self, source: &mut Source<'_>, notes: &mut Notes<'_>) {
        let name = name(source.line_rest());
        source.skip_line();
        let found = next_line_of_section(source);
        let position = source.position();
        if !found {
            notes.problem(position, format!("material {name} has no line of values"));
            return;
        }
        match material(source, &name) {
            Ok(material) => self.materials.push(material),
            Err(message) => notes.problem(position, format!("material {name}: {message}")),
        }
        source.skip_line();
    }

    /// After `*SET`: the name, then element numbers up to the next section.
    pub(super) fn set(&mut self, source: &mut Source<'_>, notes: &mut Notes<'_>) {
        let mut set = Set {
            name: name(source.line_rest()),
            elements: Vec::new(),
        };
        source.skip_line();
        while next_line_of_section(source) {
            let position = source.position();
            while let Some(word) = source.field() {
                match integer(word) {
                    Some(number) => set.elements.push((number, position)),
                    None => {
                        let message = format!("`{}` is not an element's number", show(word));
                        notes.problem(position, message);
                    }
                }
            }
        }
        self.sets.push(set);
    }

    /// After `*REGION`: a line `set, material`.
    pub(super) fn region(&mut self, source: &mut Source<'_>, notes: &mut Notes<'_>) {
        source.skip_line();
        let found = next_line_of_section(source);
        let position = source.position();
        let line = if found { source.line_rest() } else { b"" };
        let mut parts = line.splitn(2, |&b| b == b',');
        match (parts.next(), parts.next()) {
            (Some(set), Some(material)) => self.regions.push(Region {
                set: name(set),
                material: name(material),
                position,
            }),
            _ => notes.problem(position, "*REGION needs a line `set, material`".into()),
        }
        if found {
            source.skip_line();
        }
    }

    /// Hands materials, the material of each element, and the nodes of each set to `draft`.
    /// `base` is the number of the first element.
    pub(super) fn resolve(mut self, base: i64, draft: &mut Draft, notes: &mut Notes<'_>) {
        let count = draft.tetrahedra.len() + draft.hexahedra.len();
        let sets: Vec<(String, Vec<u32>)> = std::mem::take(&mut self.sets)
            .into_iter()
            .map(|set| (set.name, indices(&set.elements, base, count, notes)))
            .collect();
        let material_of = self.materials_of(&sets, count, notes);
        if let Some(last) = self.materials.len().checked_sub(1) {
            let unassigned = material_of.iter().filter(|m| m.is_none()).count();
            if unassigned > 0 {
                let name = self.materials[last].name.as_deref().unwrap_or_default();
                let message = format!(
                    "{unassigned} of {count} elements are in no region; they get the last material, \
                     {name}, as VegaFEM has it"
                );
                notes.warn(0, &message);
            }
            draft.material_of = material_of
                .into_iter()
                .map(|m| m.unwrap_or(last as u32))
                .collect();
        }
        draft.materials = self.materials;
        draft.node_sets = sets
            .into_iter()
            .map(|(name, elements)| RawNodeSet {
                name,
                nodes: nodes_of(&elements, draft),
            })
            .collect();
    }

    /// The material of each element, `None` for those in no region.
    fn materials_of(
        &self,
        sets: &[(String, Vec<u32>)],
        count: usize,
        notes: &mut Notes<'_>,
    ) -> Vec<Option<u32>> {
        let names = self.materials.iter().map(|m| m.name.as_deref());
        let material_called = first_of(names.map(Option::unwrap_or_default));
        let set_called = first_of(sets.iter().map(|(name, _)| name.as_str()));
        // Of the regions of a set the last one shows: what the others say is overwritten.
        let mut last_region: HashMap<&str, usize> = HashMap::new();
        for (r, region) in self.regions.iter().enumerate() {
            let Region {
                set,
                material,
                position,
            } = region;
            if !material_called.contains_key(material.as_str()) {
                notes.problem(*position, format!("no material is called `{material}`"));
            } else if set == ALL || set_called.contains_key(set.as_str()) {
                last_region.insert(set, r);
            } else {
                notes.problem(*position, format!("no set is called `{set}`"));
            }
        }
        let mut material_of = vec![None; count];
        for (r, Region { set, material, .. }) in self.regions.iter().enumerate() {
            if last_region.get(set.as_str()) != Some(&r) {
                continue;
            }
            // No truncation: a material takes bytes of a file that is held in memory.
            let index = material_called.get(material.as_str()).map(|&i| i as u32);
            match set_called.get(set.as_str()) {
                Some(&s) => sets[s]
                    .1
                    .iter()
                    .for_each(|&e| material_of[e as usize] = index),
                None => material_of.fill(index),
            }
        }
        material_of
    }
}

/// Where each name comes first.
fn first_of<'n>(names: impl Iterator<Item = &'n str>) -> HashMap<&'n str, usize> {
    let mut first = HashMap::new();
    for (i, name) in names.enumerate() {
        first.entry(name).or_insert(i);
    }
    first
}

/// A name as VegaFEM reads it: without blanks.
fn name(text: &[u8]) -> String {
    let text: Vec<u8> = text
        .iter()
        .copied()
        .filter(|b| !b.is_ascii_whitespace())
        .collect();
    String::from_utf8_lossy(&text).into_owned()
}

fn material(source: &mut Source<'_>, name: &str) -> Result<RawMaterial, String> {
    let kind = source.field().unwrap_or_default();
    if kind != b"ENU" {
        return Err(format!(
            "`{}` is not read, only linear isotropic ones: ENU, density, E, nu",
            show(kind)
        ));
    }
    let material = RawMaterial {
        name: Some(name.to_string()),
        density_kg_m3: source.real("density", Kind::F64)?,
        young_pa: source.real("E", Kind::F64)?,
        poisson: source.real("nu", Kind::F64)?,
    };
    let RawMaterial {
        density_kg_m3: density,
        young_pa: young,
        poisson,
        ..
    } = material;
    if !(density > 0.0 && young > 0.0) {
        return Err(format!("density {density} and E {young} must be above 0"));
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        return Err(format!("nu {poisson} is not between -1 and 0.5"));
    }
    Ok(material)
}

/// Element indices from element numbers.
fn indices(numbers: &[(i64, u64)], base: i64, count: usize, notes: &mut Notes<'_>) -> Vec<u32> {
    let mut indices = Vec::new();
    for &(number, position) in numbers {
        match u32::try_from(number.saturating_sub(base)) {
            Ok(index) if (index as usize) < count => indices.push(index),
            _ => {
                let message = format!("element {number} is not one of the {count}");
                notes.problem(position, message);
            }
        }
    }
    indices
}

/// The corners of `elements`, ascending, each once.
fn nodes_of(elements: &[u32], draft: &Draft) -> Vec<u32> {
    let mut nodes = Vec::new();
    for &element in elements {
        let element = element as usize;
        // A .veg file holds one kind of element.
        if let Some(tetrahedron) = draft.tetrahedra.get(element) {
            nodes.extend(tetrahedron.corners);
        } else if let Some(hexahedron) = draft.hexahedra.get(element) {
            nodes.extend(hexahedron.corners);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
