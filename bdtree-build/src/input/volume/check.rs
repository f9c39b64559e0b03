//! From a draft to a volume: orientation, flat and folded elements, duplicates, unused nodes.

use super::RawVolume;
use super::draft::{Draft, Element};
use super::notes::{Notes, Tally};
use super::shape::{Sense, hexahedron, tetrahedron};
use crate::error::BakeError;
use crate::vec3::bounds;

/// The volume of `draft`, with every element positively oriented; name and hash are left empty.
///
/// # Errors
/// What `notes` holds already, solids of other kinds, a volume without nodes or elements, elements
/// that repeat a corner, have no volume or are folded.
pub(super) fn finish(mut draft: Draft, mut notes: Notes<'_>) -> Result<RawVolume, BakeError> {
    draft.others.report(&mut notes);
    let count = draft.tetrahedra.len() + draft.hexahedra.len();
    if !notes.has_problems() {
        if draft.nodes.is_empty() {
            notes.problem(0, "no nodes".into());
        } else if count == 0 {
            notes.problem(0, "no tetrahedra or hexahedra".into());
        } else if draft.nodes.len().max(count) > u32::MAX as usize {
            notes.problem(0, format!("more than {} nodes or elements", u32::MAX));
        }
    }
    if notes.has_problems() {
        return notes.into_warnings().map(|_| RawVolume::default());
    }
    let unit = unit_positions(&draft.nodes);
    turn(
        &mut draft.tetrahedra,
        &unit,
        &mut notes,
        "tetrahedra",
        &TETRAHEDRON,
    );
    turn(
        &mut draft.hexahedra,
        &unit,
        &mut notes,
        "hexahedra",
        &HEXAHEDRON,
    );
    let first_tetrahedra = firsts(&draft.tetrahedra, &mut notes, "tetrahedra");
    let first_hexahedra = firsts(&draft.hexahedra, &mut notes, "hexahedra");
    let is_first = [first_tetrahedra.as_slice(), &first_hexahedra].concat();
    warn_of_unused(&draft, &mut notes);
    Ok(RawVolume {
        tetrahedra: marked(&draft.tetrahedra, &first_tetrahedra)
            .iter()
            .map(|e| e.corners)
            .collect(),
        hexahedra: marked(&draft.hexahedra, &first_hexahedra)
            .iter()
            .map(|e| e.corners)
            .collect(),
        material_of: marked(&draft.material_of, &is_first),
        nodes: draft.nodes,
        materials: draft.materials,
        node_sets: draft.node_sets,
        warnings: notes.into_warnings()?,
        ..RawVolume::default()
    })
}

/// The nodes scaled to a box of size 1, so that neither tiny nor huge volumes leave the range of f64.
fn unit_positions(nodes: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (low, high) = bounds(nodes.iter().copied());
    // Halves, because a difference of finite numbers may not be finite.
    let half = (0..3).fold(0.0_f64, |m, a| m.max(0.5 * high[a] - 0.5 * low[a]));
    let size = if half > 0.0 { half } else { 1.0 };
    nodes
        .iter()
        .map(|node| node.map(|x| 0.5 * x / size))
        .collect()
}

/// How the corners of one kind of element are looked at, and turned.
struct Kind<const N: usize> {
    sense: fn(&[[f64; 3]; N]) -> Sense,
    /// The order of corners that mirrors the element.
    mirrored: [usize; N],
}

const TETRAHEDRON: Kind<4> = Kind {
    sense: |corners| tetrahedron(*corners),
    mirrored: [0, 1, 3, 2],
};

const HEXAHEDRON: Kind<8> = Kind {
    sense: hexahedron,
    mirrored: [4, 5, 6, 7, 0, 1, 2, 3],
};

/// Brings all corners into positive order; notes a problem for elements that have none.
fn turn<const N: usize>(
    elements: &mut [Element<N>],
    nodes: &[[f64; 3]],
    notes: &mut Notes<'_>,
    name: &str,
    kind: &Kind<N>,
) {
    let mut turned = Tally::default();
    for element in elements {
        let Element {
            corners,
            number,
            position,
        } = *element;
        if let Some((i, j)) = repeated(&corners) {
            let message = format!(
                "element {number}: corners {} and {} are the same",
                i + 1,
                j + 1
            );
            notes.problem(position, message);
            continue;
        }
        let message = match (kind.sense)(&corners.map(|c| nodes[c as usize])) {
            Sense::Positive => continue,
            Sense::Negative => {
                element.corners = kind.mirrored.map(|i| corners[i]);
                turned.add(position);
                continue;
            }
            Sense::Flat => "has no volume",
            Sense::Folded => {
                "is folded: its Jacobian changes sign (corners in another order than VTK's, or the \
                 element is too distorted)"
            }
        };
        notes.problem(position, format!("element {number} {message}"));
    }
    notes.warn_tally(
        &turned,
        &format!("{name} were mirrored; their corners were reordered"),
    );
}

/// The first pair of equal corners.
fn repeated(corners: &[u32]) -> Option<(usize, usize)> {
    (0..corners.len())
        .flat_map(|i| (i + 1..corners.len()).map(move |j| (i, j)))
        .find(|&(i, j)| corners[i] == corners[j])
}

/// Which elements are the first with their corners; the others are warned of.
fn firsts<const N: usize>(elements: &[Element<N>], notes: &mut Notes<'_>, name: &str) -> Vec<bool> {
    let mut keys: Vec<([u32; N], usize)> = elements
        .iter()
        .enumerate()
        .map(|(i, element)| {
            let mut key = element.corners;
            key.sort_unstable();
            (key, i)
        })
        .collect();
    keys.sort_unstable();
    let mut is_first = vec![true; elements.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        is_first[pair[1].1] = false;
    }
    let mut tally = Tally::default();
    for (element, _) in elements.iter().zip(&is_first).filter(|(_, first)| !**first) {
        tally.add(element.position);
    }
    let message = format!("{name} have the corners of an earlier one and are left out");
    notes.warn_tally(&tally, &message);
    is_first
}

/// The entries that are marked.
fn marked<T: Copy>(all: &[T], marks: &[bool]) -> Vec<T> {
    let pairs = all.iter().zip(marks);
    pairs.filter(|(_, mark)| **mark).map(|(x, _)| *x).collect()
}

fn warn_of_unused(draft: &Draft, notes: &mut Notes<'_>) {
    let count = draft.nodes.len();
    let mut used = vec![false; count];
    let corners = draft.tetrahedra.iter().flat_map(|e| e.corners);
    for corner in corners.chain(draft.hexahedra.iter().flat_map(|e| e.corners)) {
        used[corner as usize] = true;
    }
    let unused = used.iter().filter(|&&used| !used).count();
    if unused > 0 {
        let message = format!("{unused} of {count} nodes belong to no element; they are kept");
        notes.warn(0, &message);
    }
}
