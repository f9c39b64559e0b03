//! Mass properties and momenta of modes, within the tolerance. Scales: the mass; the center of mass against the size of
//! the mesh; the largest entry of the inertia; volume, density and scale each by themselves; momenta against the
//! largest of all modes and what the whole mass at the mode's speed would have.

use bdtree_format::{MassRecord, ModeMomentum};
use bdtree_runtime::Asset;

use super::findings::{Findings, largest};
use super::numbers::{AXES, mesh_size};

/// Names of the entries of the inertia.
const ENTRIES: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];

/// Compares what both files have; the section tables differ where only one has it.
pub(super) fn compare(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let (Some(x), Some(y)) = (a.mass_properties(), b.mass_properties()) else {
        return;
    };
    findings.compare("section MASS: source", [x.source.get(), y.source.get()]);
    type Values = fn(&MassRecord) -> Vec<f64>;
    let size = mesh_size(a).max(mesh_size(b));
    let quantities: [(&str, &[&str], f64, Values); 6] = [
        ("mass_kg", &[], 0.0, |m| vec![m.mass_kg.get()]),
        ("center_of_mass", &AXES, size, |m| {
            m.center_of_mass.map(|x| x.get()).to_vec()
        }),
        ("inertia", &ENTRIES, 0.0, |m| {
            m.inertia.map(|x| x.get()).to_vec()
        }),
        ("density_kg_m3", &[], 0.0, |m| vec![m.density_kg_m3.get()]),
        ("scale_m", &[], 0.0, |m| vec![m.scale_m.get()]),
        ("volume", &[], 0.0, |m| vec![m.volume.get()]),
    ];
    for (name, axes, size, values) in quantities {
        let (x, y) = (values(x), values(y));
        let scale = largest(x.iter().chain(&y).copied()).max(size);
        let mut numbers = findings.numbers(format!("section MASS: {name}"), scale);
        for (i, (x, y)) in x.into_iter().zip(y).enumerate() {
            numbers.compare(x, y, || axes.get(i).copied().unwrap_or(name).to_string());
        }
        numbers.finish(findings);
    }
    let (Some(p), Some(q)) = (a.mode_momenta(), b.mode_momenta()) else {
        return;
    };
    if p.len() != q.len() {
        return; // the header's mode_count says so
    }
    let mass = largest([x.mass_kg.get(), y.mass_kg.get()]);
    type Vector = fn(&ModeMomentum) -> [f64; 3];
    let vectors: [(&str, f64, Vector); 2] = [
        ("linear", mass, |m| m.linear.map(|x| x.get())),
        ("angular", mass * size, |m| m.angular.map(|x| x.get())),
    ];
    for (name, speed, vector) in vectors {
        // What free bodies have is rounding: against the mass that moves by one mesh unit it is none.
        let all = largest(p.iter().chain(q).flat_map(vector));
        let mut numbers = findings.numbers(format!("section MMOM: {name}"), all.max(speed));
        for (j, (x, y)) in p.iter().zip(q).enumerate() {
            for (axis, (x, y)) in vector(x).into_iter().zip(vector(y)).enumerate() {
                numbers.compare(x, y, || format!("mode {j} {}", AXES[axis]));
            }
        }
        numbers.finish(findings);
    }
}
