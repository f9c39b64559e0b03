//! The motions that cost no energy, known exactly: what holds leave of the rigid ones.

use faer::{Mat, MatRef};

use crate::elastic::assemble::system::System;

/// `M`-orthonormal motions without strain (size × count) that held points and unknowns allow: of
/// the body, and of its blocks at the joints between them.
pub(crate) fn rigid_motions(system: &System) -> Mat<f64> {
    let frames = frames(system);
    let own = Mat::from_fn(system.size(), 6, |i, j| {
        let node = i / 3;
        frames[system.blocks.of(node)].motion(system.nodes[node], j)[i % 3]
    });
    let combinations = null_space(system, &frames, own.as_ref());
    let mut free = if frames.len() == 1 {
        own * combinations
    } else {
        Mat::from_fn(system.size(), combinations.ncols(), |i, c| {
            let first = 6 * system.blocks.of(i / 3);
            (0..6)
                .map(|j| own[(i, j)] * combinations[(first + j, c)])
                .sum()
        })
    };
    system.clear_held(&mut free);
    if free.ncols() == 0 {
        return free;
    }
    // Twice is enough for M-orthonormality to rounding.
    for _ in 0..2 {
        let product = free.transpose() * system.apply_mass(free.as_ref());
        let Ok(eigen) = product.self_adjoint_eigen(faer::Side::Lower) else {
            break;
        };
        let scale = Mat::from_fn(free.ncols(), free.ncols(), |i, j| {
            eigen.U()[(i, j)] / eigen.S()[j].max(f64::MIN_POSITIVE).sqrt()
        });
        free = free.as_ref() * scale;
    }
    free
}

/// The middle and the size of a block.
#[derive(Debug, Clone, Copy)]
struct Frame {
    center: [f64; 3],
    reach: f64,
}

impl Frame {
    /// How rigid motion `j` moves a point: three translations, then three rotations, scaled to the
    /// size of translations at the block's end.
    fn motion(&self, point: [f64; 3], j: usize) -> [f64; 3] {
        if j < 3 {
            return std::array::from_fn(|axis| f64::from(axis == j));
        }
        let p: [f64; 3] = std::array::from_fn(|a| (point[a] - self.center[a]) / self.reach);
        let j = j - 3;
        let mut motion = [0.0; 3];
        motion[(j + 1) % 3] = -p[(j + 2) % 3];
        motion[(j + 2) % 3] = p[(j + 1) % 3];
        motion
    }
}

fn frames(system: &System) -> Vec<Frame> {
    let blocks = &system.blocks;
    let joints = blocks.joints.iter();
    let all = (0..system.nodes.len()).map(|n| (n, blocks.of(n)));
    let all: Vec<(usize, usize)> = all
        .chain(joints.map(|&(n, b)| (n as usize, b as usize)))
        .collect();
    let mut counts = vec![0usize; 1 + blocks.further];
    for &(_, block) in &all {
        counts[block] += 1;
    }
    let none = Frame {
        center: [0.0; 3],
        reach: 0.0,
    };
    let mut frames = vec![none; counts.len()];
    for &(n, block) in &all {
        for a in 0..3 {
            frames[block].center[a] += system.nodes[n][a] / counts[block] as f64;
        }
    }
    for &(n, block) in &all {
        for a in 0..3 {
            let own = &mut frames[block];
            own.reach = own.reach.max((system.nodes[n][a] - own.center[a]).abs());
        }
    }
    for own in frames.iter_mut().filter(|f| f.reach <= 0.0) {
        own.reach = 1.0;
    }
    frames
}

/// Combinations (6 per block × count) of the blocks' rigid motions that leave all held points
/// where they are and the blocks together at the joints. `own` are the motions of each unknown's
/// block.
fn null_space(system: &System, frames: &[Frame], own: MatRef<'_, f64>) -> Mat<f64> {
    let size = 6 * frames.len();
    let blocks = &system.blocks;
    if system.constraints.is_empty() && system.held.is_empty() && blocks.joints.is_empty() {
        return Mat::identity(size, size);
    }
    let mut product = Mat::<f64>::zeros(size, size);
    for constraint in &system.constraints {
        for axis in (0..3).filter(|&a| constraint.axes[a]) {
            let nodes = constraint
                .anchor
                .nodes
                .iter()
                .zip(constraint.anchor.weights);
            let mut motion = [0.0; 6];
            for (&n, w) in nodes {
                for (j, m) in motion.iter_mut().enumerate() {
                    *m += w * own[(3 * n as usize + axis, j)];
                }
            }
            add_square(&mut product, &[(0, motion)]);
        }
    }
    for &i in &system.held {
        let motion = std::array::from_fn(|j| own[(i, j)]);
        add_square(&mut product, &[(blocks.of(i / 3), motion)]);
    }
    for &(node, other) in &blocks.joints {
        let (node, other) = (node as usize, other as usize);
        for axis in 0..3 {
            let here = std::array::from_fn(|j| own[(3 * node + axis, j)]);
            let there = std::array::from_fn(|j| -frames[other].motion(system.nodes[node], j)[axis]);
            add_square(&mut product, &[(blocks.of(node), here), (other, there)]);
        }
    }
    let trace: f64 = (0..size).map(|j| product[(j, j)]).sum();
    let Ok(eigen) = product.self_adjoint_eigen(faer::Side::Lower) else {
        return Mat::zeros(size, 0);
    };
    // Motions are of size 1 at the body's end. Springs give way: what moves all held points by less
    // than 3e-5 of that in all is free, for a hold of one point or of points on a line. Unknowns
    // do not, so 1e-6 allows for the rounding of coordinates, or 3e-8 at each of them.
    let least = if system.constraints.is_empty() {
        f64::max(1e-12, 1e-15 * trace)
    } else {
        1e-9
    };
    let free: Vec<usize> = (0..size).filter(|&j| eigen.S()[j] < least).collect();
    Mat::from_fn(size, free.len(), |i, j| eigen.U()[(i, free[j])])
}

/// Adds the square of a condition on the motions of some blocks.
fn add_square(product: &mut Mat<f64>, condition: &[(usize, [f64; 6])]) {
    for &(p, x) in condition {
        for &(q, y) in condition {
            for (a, x) in x.iter().enumerate() {
                for (b, y) in y.iter().enumerate() {
                    product[(6 * p + a, 6 * q + b)] += x * y;
                }
            }
        }
    }
}

/// As many unknowns as there are rigid motions, such that holding them holds the body: chosen
/// greedily for the best-conditioned support (heavy nodes far apart).
pub(crate) fn support(system: &System, rigid: MatRef<'_, f64>) -> Vec<usize> {
    let mut rows = Mat::from_fn(rigid.nrows(), rigid.ncols(), |i, j| {
        rigid[(i, j)] * system.mass_diagonal(i / 3).sqrt()
    });
    let mut pins = Vec::new();
    for _ in 0..rigid.ncols() {
        let length = |i: usize| (0..rows.ncols()).map(|j| rows[(i, j)] * rows[(i, j)]).sum();
        let mut best = (0, 0.0f64);
        for i in 0..rows.nrows() {
            let l: f64 = length(i);
            if l > best.1 * (1.0 + 1e-9) {
                best = (i, l);
            }
        }
        if best.1 <= 0.0 {
            break;
        }
        pins.push(best.0);
        let pivot: Vec<f64> = (0..rows.ncols()).map(|j| rows[(best.0, j)]).collect();
        for i in 0..rows.nrows() {
            let along: f64 = (0..rows.ncols())
                .map(|j| rows[(i, j)] * pivot[j])
                .sum::<f64>()
                / best.1;
            for (j, p) in pivot.iter().enumerate() {
                rows[(i, j)] -= along * p;
            }
        }
    }
    pins
}
