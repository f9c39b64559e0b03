//! What is asked and given, checked and brought to common units.

use super::VolumeOptions;
use crate::basis::elastic::{ElasticOptions, check_axes, check_values};
use crate::elastic::element::NodeLists;
use crate::elastic::element::material::Material;
use crate::elastic::volume::Model;
use crate::error::{BakeError, Part, Place, Problems};
use crate::input::volume::{RawMaterial, RawVolume};
use crate::mass::integrals::Frame;
use crate::vec3::{bounds, norm, sub};

/// Elements whose least Jacobian determinant is below this share of their longest edge's cube are
/// flat to rounding.
const FLAT: f64 = 1e-12;

/// Linear tetrahedra with a larger Poisson's ratio lock.
const LOCKING_POISSON: f64 = 0.4;

/// What a model's numbers count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// Mesh units.
    pub length: f64,
    /// What positions count from (mesh units).
    pub middle: [f64; 3],
    /// Kilograms.
    pub mass_kg: f64,
    /// Square root of an eigenvalue, in rad/s.
    pub omega_rad_s: f64,
}

impl Units {
    /// Where the model's positions count from, and in what.
    pub(super) fn frame(&self) -> Frame {
        Frame {
            about: self.middle,
            length: self.length,
        }
    }
}

/// Numbers of the options, whatever is asked of them.
fn numbers(options: &VolumeOptions) -> Problems {
    let positive = [
        ("--young", options.young_pa),
        ("--density", options.density_kg_m3),
        ("--scale", Some(options.scale_m)),
    ];
    check_values(&positive, options.poisson)
}

pub(super) fn values(options: &VolumeOptions) -> Result<(), BakeError> {
    numbers(options).into_result(Place::NOWHERE)
}

pub(super) fn options(options: &VolumeOptions) -> Result<(), BakeError> {
    let mut found = numbers(options);
    if options.mode_count == 0 {
        found.add(|| (Place::option("--modes"), "no mode is asked for"));
    }
    check_axes(&options.fixes, &mut found);
    found.into_result(Place::NOWHERE)
}

/// The elements with their materials, in units of their size, stiffness and density.
pub(super) fn model(
    volume: &RawVolume,
    options: &VolumeOptions,
    warnings: &mut Vec<String>,
) -> Result<(Model, Units), BakeError> {
    let mut found = Problems::new("basis");
    let file = Place::file(&volume.name);
    let place = |part| file.clone().at(part);
    for (n, p) in volume.nodes.iter().enumerate() {
        // Products of three lengths must stay finite.
        if p.iter().any(|x| x.is_nan() || x.abs() > 1e90) {
            let message = "its position is not a number below 1e90";
            found.add(|| (place(Part::Node(n as u32)), message));
        }
    }
    let mut elements = NodeLists::default();
    for t in &volume.tetrahedra {
        elements.push(*t);
    }
    for h in &volume.hexahedra {
        elements.push(*h);
    }
    if elements.len() == 0 {
        found.add(|| (file.clone(), "has no elements"));
    }
    for (e, corners) in elements.iter().enumerate() {
        if corners.iter().any(|&n| n as usize >= volume.nodes.len()) {
            let message = "a corner index is out of range";
            found.add(|| (place(Part::Element(e)), message));
        }
    }
    let materials = materials(volume, options, &mut found);
    let material_of = volume.material_of.as_slice();
    if !(material_of.is_empty() || material_of.len() == elements.len()) {
        let message = "there is not one material for each element";
        found.add(|| (file.clone(), message));
    }
    for (e, &m) in material_of.iter().enumerate() {
        if m as usize >= materials.len() {
            let message = format!("its material {m} does not exist");
            found.add(|| (place(Part::Element(e)), message));
        }
    }
    found.into_result(file.clone())?;

    let length = mean_edge(&volume.nodes, &elements);
    let young_pa = materials.iter().map(|m| m.young_pa).fold(0.0, f64::max);
    let density = materials
        .iter()
        .map(|m| m.density_kg_m3)
        .fold(0.0, f64::max);
    let size_m = length * options.scale_m;
    let units = Units {
        length,
        middle: middle(&volume.nodes, &elements),
        mass_kg: density * size_m.powi(3),
        omega_rad_s: (young_pa / density).sqrt() / size_m,
    };
    let mut found = Problems::new("basis");
    if !(units.mass_kg.is_normal() && units.omega_rad_s.is_normal()) {
        let message = format!("elements {size_m:e} m long are beyond the range of numbers");
        found.add(|| (file.clone(), message));
    }
    let middle = units.middle;
    let model = Model {
        positions: volume
            .nodes
            .iter()
            .map(|p| std::array::from_fn(|a| (p[a] - middle[a]) / length))
            .collect(),
        elements,
        materials: materials
            .iter()
            .map(|m| {
                let law = Material::new(m.young_pa / young_pa, m.poisson);
                (law, m.density_kg_m3 / density)
            })
            .collect(),
        material_of: material_of.to_vec(),
        lumped: options.mass == super::MassMatrix::Lumped,
    };
    for e in 0..model.elements.len() {
        let (volume, shape) = model.shape(e);
        if !(volume > 0.0 && shape > FLAT) {
            let message = "it is flat or turned inside out";
            found.add(|| (place(Part::Element(e)), message));
        }
    }
    found.into_result(file.clone())?;
    warn_locking(volume, &materials, warnings);
    Ok((model, units))
}

/// The file's materials with what the options override; one by default.
fn materials(
    volume: &RawVolume,
    options: &VolumeOptions,
    found: &mut Problems,
) -> Vec<RawMaterial> {
    let default = ElasticOptions::default();
    let mut materials = volume.materials.clone();
    if materials.is_empty() {
        materials.push(RawMaterial {
            name: None,
            young_pa: default.young_pa,
            poisson: default.poisson,
            density_kg_m3: default.density_kg_m3,
        });
    }
    for (n, m) in materials.iter_mut().enumerate() {
        m.young_pa = options.young_pa.unwrap_or(m.young_pa);
        m.poisson = options.poisson.unwrap_or(m.poisson);
        m.density_kg_m3 = options.density_kg_m3.unwrap_or(m.density_kg_m3);
        let name = m.name.clone().unwrap_or_else(|| (n + 1).to_string());
        let place = || Place::file(&volume.name).at(Part::Material(name.clone()));
        for (what, value) in [
            ("Young's modulus", m.young_pa),
            ("density", m.density_kg_m3),
        ] {
            if !(value.is_normal() && value > 0.0) {
                let message = format!("its {what}, {value}, is not a positive number");
                found.add(|| (place(), message));
            }
        }
        if !(m.poisson > -1.0 && m.poisson < 0.5) {
            let message = format!(
                "its Poisson's ratio, {}, is not between -1 and 0.5",
                m.poisson
            );
            found.add(|| (place(), message));
        }
    }
    materials
}

/// Mean distance of successive corners.
fn mean_edge(nodes: &[[f64; 3]], elements: &NodeLists) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for corners in elements.iter() {
        for pair in corners.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|n| nodes[n as usize]);
            sum += norm(sub(a, b));
            count += 1;
        }
    }
    sum / count.max(1) as f64
}

/// Middle of the box around the elements.
fn middle(nodes: &[[f64; 3]], elements: &NodeLists) -> [f64; 3] {
    let corners = elements.iter().flatten();
    let (lo, hi) = bounds(corners.map(|&n| nodes[n as usize]));
    std::array::from_fn(|a| 0.5 * (lo[a] + hi[a]))
}

fn warn_locking(volume: &RawVolume, materials: &[RawMaterial], warnings: &mut Vec<String>) {
    let of_tetrahedra = |m: usize| {
        let own = volume.material_of.iter().take(volume.tetrahedra.len());
        volume.material_of.is_empty() || own.into_iter().any(|&x| x as usize == m)
    };
    let worst = (materials.iter().enumerate())
        .filter(|(m, _)| !volume.tetrahedra.is_empty() && of_tetrahedra(*m))
        .map(|(_, m)| m.poisson)
        .fold(0.0, f64::max);
    if worst > LOCKING_POISSON {
        warnings.push(format!(
            "linear tetrahedra with a Poisson's ratio of {worst} are too stiff: their frequencies \
             come out too high (docs/reference/volumes.md); hexahedra, finer tetrahedra or a lower ratio help"
        ));
    }
}
