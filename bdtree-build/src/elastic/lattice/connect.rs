//! Which fillings hang together: parts of cells, components, and the nodes of their functions.

use std::collections::HashMap;

use crate::disjoint_sets::DisjointSets;
use crate::elastic::element::spline::FUNCTIONS;
use crate::elastic::lattice::grid::Grid;
use crate::elastic::lattice::table::{Fillings, SHARE_MIN};
use crate::elastic::lattice::{CellPart, Component, FINE, Lattice};

/// Two parts that are connected: the lower one, the upper one, and the axis between them.
type Link = (u32, u32, u8);

/// Finds parts and components. Fine cells hang together where one body reaches through the face
/// between them. Bodies are joined where they share a fine cell or nearly do, so that whether
/// bodies that touch are joined does not depend on where the lattice lies.
pub(super) fn connect(grid: Grid, fine: Grid, fillings: Fillings) -> Lattice {
    let Fillings { list, touches } = fillings;
    let count = list.len();
    let mut lattice = Lattice {
        grid,
        fine,
        fillings: list,
        part_of: vec![0; count],
        parts: Vec::new(),
        components: Vec::new(),
    };
    let cells: Vec<[usize; 3]> = (lattice.fillings.iter())
        .map(|f| fine.cell(f.key).map(|n| n / FINE))
        .collect();
    let mut sets = DisjointSets::new(count);
    let mut across: Vec<(usize, usize, u8)> = Vec::new();
    for (here, f) in lattice.fillings.iter().enumerate() {
        if here > 0 && lattice.fillings[here - 1].key == f.key {
            sets.join(here - 1, here);
        }
        for axis in 0..3 {
            let mut next = fine.cell(f.key);
            next[axis] += 1;
            if next[axis] >= fine.dims[axis] {
                continue;
            }
            let Some(there) = lattice.find(fine.key(next), f.body) else {
                continue;
            };
            if lattice.fillings[there].faces[axis].abs() <= SHARE_MIN {
                continue;
            }
            if cells[here] == cells[there] {
                sets.join(here, there);
            } else {
                across.push((here, there, axis as u8));
            }
        }
    }
    for (from, to, body) in touches {
        let Some(one) = lattice.find(from, body) else {
            continue;
        };
        let first = lattice.fillings.partition_point(|f| f.key < to);
        let others = lattice.fillings[first..].iter().enumerate();
        for (n, f) in others.take_while(|(_, f)| f.key == to) {
            let other = first + n;
            if f.body == body {
                continue;
            }
            if cells[one] == cells[other] {
                sets.join(one, other);
            } else if let Some(axis) = (0..3).find(|&a| cells[one][a] != cells[other][a]) {
                let (lower, upper) = if from < to {
                    (one, other)
                } else {
                    (other, one)
                };
                across.push((lower, upper, axis as u8));
            }
        }
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&n| (grid.key(cells[n]), n));
    for own in order.chunk_by(|&a, &b| cells[a] == cells[b]) {
        for &n in own {
            let root = sets.find(n);
            if root == n {
                lattice.part_of[n] = lattice.parts.len() as u32;
                lattice.parts.push(CellPart {
                    cell: cells[n],
                    component: 0,
                    place: 0,
                });
            }
            lattice.part_of[n] = lattice.part_of[root];
        }
    }
    let part = |n: usize| lattice.part_of[n];
    let mut links: Vec<Link> = (across.iter())
        .map(|&(a, b, axis)| (part(a), part(b), axis))
        .collect();
    links.sort_unstable();
    links.dedup();
    gather(&mut lattice, &links);
    number_nodes(&mut lattice, &links);
    lattice
}

/// Puts the parts into components.
fn gather(lattice: &mut Lattice, links: &[Link]) {
    let mut sets = DisjointSets::new(lattice.parts.len());
    for &(a, b, _) in links {
        sets.join(a as usize, b as usize);
    }
    let mut number: HashMap<usize, u32> = HashMap::new();
    for n in 0..lattice.parts.len() {
        let next = number.len() as u32;
        let component = *number.entry(sets.find(n)).or_insert(next);
        if component == next {
            lattice.components.push(Component::default());
        }
        let own = &mut lattice.components[component as usize];
        lattice.parts[n].component = component;
        lattice.parts[n].place = own.cells.len() as u32;
        own.cells.push([0; FUNCTIONS]);
    }
}

/// Gives every place its nodes: one for each group of parts in the 27 cells around it that hang
/// together over faces *there*. So cells that merely touch stay apart, be it two bodies in
/// neighbouring cells or two cells of one body that meet in an edge, which would be a hinge; and
/// two walls of one body with a gap between them move apart.
fn number_nodes(lattice: &mut Lattice, links: &[Link]) {
    let [nx, ny, _] = lattice.grid.dims.map(|n| n as u64 + 2);
    let mut uses: Vec<(u64, u32, u8)> = Vec::with_capacity(FUNCTIONS * lattice.parts.len());
    for (n, part) in lattice.parts.iter().enumerate() {
        for function in 0..FUNCTIONS {
            let step = [function % 3, function / 3 % 3, function / 9];
            let [i, j, k] = [0, 1, 2].map(|a| (part.cell[a] + step[a]) as u64);
            uses.push(((k * ny + j) * nx + i, n as u32, function as u8));
        }
    }
    uses.sort_unstable();
    for around in uses.chunk_by(|a, b| a.0 == b.0) {
        let mut sets = DisjointSets::new(around.len());
        for (n, &(_, lower, function)) in around.iter().enumerate() {
            let first = links.partition_point(|l| l.0 < lower);
            for &(_, upper, axis) in links[first..].iter().take_while(|l| l.0 == lower) {
                // The lower cell of two has the place farther up on that axis.
                let stride = [1, 3, 9][usize::from(axis)];
                if usize::from(function) / stride % 3 > 0
                    && let Ok(m) = around.binary_search_by_key(&upper, |u| u.1)
                {
                    sets.join(n, m);
                }
            }
        }
        let mut nodes = vec![0u32; around.len()];
        for (n, &(_, part, function)) in around.iter().enumerate() {
            let part = lattice.parts[part as usize];
            let function = usize::from(function);
            let root = sets.find(n);
            let own = &mut lattice.components[part.component as usize];
            if root == n {
                nodes[n] = own.nodes.len() as u32;
                let step = [function % 3, function / 3 % 3, function / 9];
                own.nodes
                    .push([0, 1, 2].map(|a| part.cell[a] as i32 + step[a] as i32 - 1));
            }
            own.cells[part.place as usize][function] = nodes[root];
        }
    }
}
