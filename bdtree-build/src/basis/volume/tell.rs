//! Warnings and errors in words.

use super::VolumeOptions;
use crate::elastic::assemble::joints::{BLOCKS_MAX, TooManyBlocks};
use crate::elastic::solve::factor::FactorError;
use crate::elastic::solve::{Solution, SolveError};
use crate::elastic::volume::Component;
use crate::error::{BakeError, Part, Place};
use crate::input::volume::RawVolume;

/// Too many joints in the component of this node.
pub(super) fn joints_error(volume: &RawVolume, node: u32, blocks: TooManyBlocks) -> BakeError {
    let message = format!(
        "{} blocks of elements hang together by single nodes or edges only, at most {BLOCKS_MAX} \
         can be handled",
        blocks.0
    );
    let place = Place::file(&volume.name).at(Part::Body(node));
    BakeError::one("basis", place, message)
}

/// Components that bend at joints.
pub(super) fn joints(components: &[Component], warnings: &mut Vec<String>) {
    for component in components.iter().filter(|p| p.blocks.further > 0) {
        let joint = component.blocks.joints.first();
        let node = joint.map_or(0, |&(n, _)| component.nodes[n as usize]);
        warnings.push(format!(
            "{} blocks of elements hang together by single nodes or edges only (first: node {}); \
             what moves there without strain is left out of the modes",
            component.blocks.further + 1,
            node + 1
        ));
    }
}

/// Components that move in none of the modes.
pub(super) fn silent(components: &[Component], solution: &Solution, warnings: &mut Vec<String>) {
    let mut moving = vec![false; components.len()];
    for mode in &solution.modes {
        moving[mode.component] = true;
    }
    let silent: Vec<u32> = (components.iter().zip(&moving))
        .filter(|(_, moves)| !**moves)
        .filter_map(|(component, _)| component.nodes.first().copied())
        .collect();
    let nodes = silent.iter().map(|n| format!("node {}", n + 1));
    warnings.extend(silent_warning(nodes, components.len(), "parts", solution));
}

/// That components move in none of the modes, the first few named; `None` without such components.
pub(crate) fn silent_warning(
    silent: impl ExactSizeIterator<Item = String>,
    count: usize,
    what: &str,
    solution: &Solution,
) -> Option<String> {
    let silent_count = silent.len();
    let names: Vec<String> = silent.take(5).collect();
    (silent_count > 0).then(|| {
        format!(
            "{silent_count} of {count} {what} move in none of the {} modes (from {}{})",
            solution.modes.len(),
            names.join(", "),
            if silent_count > 5 { ", …" } else { "" }
        )
    })
}

/// Why there are no modes.
pub(super) fn solve_error(
    error: SolveError,
    volume: &RawVolume,
    components: &[Component],
    options: &VolumeOptions,
) -> BakeError {
    let file = Place::file(&volume.name);
    let component = |c: usize| {
        let node = components[c].nodes.first().copied().unwrap_or(0);
        file.clone().at(Part::Body(node))
    };
    let (place, message) = match error {
        SolveError::Memory(bytes) => (
            file,
            format!(
                "its elements need about {} MiB, the limit is {} MiB (--memory-limit)",
                bytes.div_ceil(1 << 20),
                options.memory_limit_bytes >> 20
            ),
        ),
        SolveError::Factor(c, FactorError::Memory) => {
            (component(c), "not enough memory".to_owned())
        }
        SolveError::Factor(c, FactorError::Pivot) => (
            component(c),
            "its stiffness is not positive definite to rounding: elements may be nearly flat, or \
             a Poisson's ratio too near -1 or 0.5"
                .to_owned(),
        ),
        SolveError::Missed(c, counted, found) => (
            component(c),
            format!("the inertia count finds {counted} modes where the iteration found {found}"),
        ),
        SolveError::Residual(worst) => (
            file,
            format!(
                "the modes converged to a residual of {worst:.1e} only: its stiffest and softest \
                 motions are too far apart for the precision of numbers (nearly flat elements, a \
                 Poisson's ratio too near 0.5, materials a billion times apart, a wire of \
                 thousands of elements)"
            ),
        ),
        SolveError::Element(c, e) => (
            file.at(Part::Element(components[c].elements[e] as usize)),
            "it has no stiffness to rounding".to_owned(),
        ),
    };
    BakeError::one("basis", place, message)
}
