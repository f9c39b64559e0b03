//! Connected components of the surface, and whether each one bounds a solid or is a sheet.
//!
//! A surface component is a set of triangles connected through shared positions, so that seams split for
//! texture coordinates do not tear it. Its directed edges tell whether it is closed: the edges of
//! a closed surface cancel in pairs, whatever non-manifold detail it has. Small holes are closed
//! by a cone over each boundary loop, which closes any surface exactly; wide openings make the
//! surface component a sheet. This is a statement about the surface alone, so that it does not change with
//! the lattice, as a flood fill's answer would.

use std::collections::HashMap;

use crate::disjoint_sets::DisjointSets;
use crate::vec3::{add, bounds, cross, dot, norm, scale, sub};

/// Holes of a solid may take up this share of the surface component's area in all …
const HOLE_AREA_MAX: f64 = 0.05;
/// … and each of them this share of the mean cross-section behind it (a pipe's end is 1).
const HOLE_SECTION_MAX: f64 = 0.25;
/// A closed surface component thinner than this share of its own diagonal has no inside: two-sided paper.
const PAPER_THICKNESS_REL: f64 = 1e-4;

/// What a surface component is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Bounds a volume.
    Solid,
    /// A surface that takes a thickness.
    Sheet,
    /// A closed surface without volume: a sheet whose area counts half, for it is there twice.
    Paper,
}

/// One connected surface component.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceComponent {
    /// Ids of its triangles, ascending, and whether each is taken in reverse.
    pub triangles: Vec<(u32, bool)>,
    /// Closing triangles over small holes (solids only).
    pub caps: Vec<[[f64; 3]; 3]>,
    /// What it is made of.
    pub kind: Kind,
    /// Makes volumes positive: 1 or -1 (a cavity carries the sign of the body around it).
    pub sign: f64,
    /// The body it belongs to: its own index, or that of the body it is a cavity of.
    pub body: usize,
    /// Surface area (mesh units²).
    pub area: f64,
    /// Signed volume with caps (mesh units³), before `sign`.
    pub volume: f64,
    min: [f64; 3],
    max: [f64; 3],
}

/// The surface components of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceComponents {
    /// In order of their first triangle; surface components without area are left out.
    pub list: Vec<SurfaceComponent>,
    /// Per vertex: its surface component, if a triangle of a surface component uses it.
    pub of_vertex: Vec<Option<u32>>,
}

/// Splits a mesh into surface components. Positions must be finite and indices in range.
pub(crate) fn find_components(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> SurfaceComponents {
    let weld = weld(positions);
    let mut sets = DisjointSets::new(positions.len());
    for t in triangles {
        let [a, b, c] = t.map(|v| weld[v as usize]);
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut index_of_root: HashMap<usize, usize> = HashMap::new();
    let mut members: Vec<Vec<u32>> = Vec::new();
    for (id, t) in triangles.iter().enumerate() {
        let root = sets.find(weld[t[0] as usize]);
        let next = members.len();
        let at = *index_of_root.entry(root).or_insert(next);
        if at == next {
            members.push(Vec::new());
        }
        members[at].push(id as u32);
    }
    let mut list = Vec::new();
    let mut of_vertex = vec![None; positions.len()];
    for ids in members {
        let index = list.len();
        if let Some(component) = measure(positions, triangles, &weld, ids, index) {
            for &(id, _) in &component.triangles {
                for v in triangles[id as usize] {
                    of_vertex[v as usize] = Some(index as u32);
                }
            }
            list.push(component);
        }
    }
    orient(positions, triangles, &mut list);
    SurfaceComponents { list, of_vertex }
}

/// Smallest index of a vertex with the same position, per vertex.
pub(crate) fn weld(positions: &[[f64; 3]]) -> Vec<usize> {
    // `+ 0.0` makes -0 and 0 one key.
    let key = |i: usize| positions[i].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_unstable_by_key(|&i| (key(i), i));
    let mut result = vec![0; positions.len()];
    let mut first = 0;
    for (n, &i) in order.iter().enumerate() {
        if n == 0 || key(i) != key(first) {
            first = i;
        }
        result[i] = first;
    }
    result
}

/// Directed edges that nothing cancels: (from, to, how often).
fn open_edges(triangles: &[[usize; 3]]) -> Vec<(usize, usize, i32)> {
    let mut edges: Vec<(usize, usize, i32)> = Vec::with_capacity(triangles.len() * 3);
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if a != b {
                edges.push(if a < b { (a, b, 1) } else { (b, a, -1) });
            }
        }
    }
    edges.sort_unstable();
    let mut open = Vec::new();
    for run in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let net: i32 = run.iter().map(|e| e.2).sum();
        if net != 0 {
            open.push((run[0].0, run[0].1, net));
        }
    }
    open
}

/// For each triangle, whether to reverse it so that neighbours over simple edges agree.
fn reversals(triangles: &[[usize; 3]]) -> Vec<bool> {
    let mut edges: Vec<(usize, usize, usize, bool)> = Vec::with_capacity(triangles.len() * 3);
    for (id, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if a != b {
                edges.push((a.min(b), a.max(b), id, a < b));
            }
        }
    }
    edges.sort_unstable();
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); triangles.len()];
    for run in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if let [x, y] = run {
            let clash = x.3 == y.3;
            neighbours[x.2].push((y.2, clash));
            neighbours[y.2].push((x.2, clash));
        }
    }
    let mut state: Vec<Option<bool>> = vec![None; triangles.len()];
    for start in 0..triangles.len() {
        if state[start].is_some() {
            continue;
        }
        state[start] = Some(false);
        let mut stack = vec![start];
        while let Some(t) = stack.pop() {
            let own = state[t].unwrap_or(false);
            for &(other, clash) in &neighbours[t] {
                if state[other].is_none() {
                    state[other] = Some(own ^ clash);
                    stack.push(other);
                }
            }
        }
    }
    state.into_iter().map(|s| s.unwrap_or(false)).collect()
}

fn measure(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    weld: &[usize],
    ids: Vec<u32>,
    index: usize,
) -> Option<SurfaceComponent> {
    let mut corners: Vec<[usize; 3]> = ids
        .iter()
        .map(|&id| triangles[id as usize].map(|v| weld[v as usize]))
        .collect();
    let mut flips = vec![false; ids.len()];
    let mut open = open_edges(&corners);
    if !open.is_empty() {
        // Not closed as given: perhaps only its triangles disagree about the outside.
        let turned = reversals(&corners);
        let mut trial = corners.clone();
        for (t, &flip) in trial.iter_mut().zip(&turned) {
            if flip {
                t.swap(1, 2);
            }
        }
        let trial_open = open_edges(&trial);
        if trial_open.len() < open.len() {
            (corners, flips, open) = (trial, turned, trial_open);
        }
    }
    let (min, max) = bounds(corners.iter().flatten().map(|&v| positions[v]));
    let center = scale(add(min, max), 0.5);
    let diagonal = norm(sub(max, min));
    let at = |v: usize| sub(positions[v], center);
    let (mut area, mut volume) = (0.0, 0.0);
    for t in &corners {
        let [a, b, c] = t.map(at);
        area += 0.5 * norm(cross(sub(b, a), sub(c, a)));
        volume += dot(a, cross(b, c)) / 6.0;
    }
    if area.is_nan() || area <= 1e-14 * diagonal * diagonal {
        return None;
    }
    let holes = cones(&open, &at);
    for cap in holes.iter().flatten() {
        volume += dot(cap[0], cross(cap[1], cap[2])) / 6.0;
    }
    let paper = 2.0 * volume.abs() <= PAPER_THICKNESS_REL * diagonal * area;
    let small = holes_are_small(&holes, area, volume, &|n| {
        let reach = corners.iter().flatten().map(|&v| dot(at(v), n));
        let (lo, hi) = reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
            (lo.min(x), hi.max(x))
        });
        hi - lo
    });
    let kind = match (open.is_empty(), paper, small) {
        (true, true, _) => Kind::Paper,
        (_, false, true) => Kind::Solid,
        _ => Kind::Sheet,
    };
    let caps = if kind == Kind::Solid {
        holes
            .into_iter()
            .flatten()
            .map(|cap| cap.map(|p| add(p, center)))
            .collect()
    } else {
        Vec::new()
    };
    Some(SurfaceComponent {
        triangles: ids.into_iter().zip(flips).collect(),
        caps,
        kind,
        sign: 1.0,
        body: index,
        area,
        volume,
        min,
        max,
    })
}

/// The closing cone over each loop of open edges, apex in the loop's mean.
fn cones(open: &[(usize, usize, i32)], at: &impl Fn(usize) -> [f64; 3]) -> Vec<Vec<[[f64; 3]; 3]>> {
    let mut vertices: Vec<usize> = open.iter().flat_map(|e| [e.0, e.1]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let local = |v: usize| vertices.binary_search(&v).unwrap_or(0);
    let mut sets = DisjointSets::new(vertices.len());
    for e in open {
        sets.join(local(e.0), local(e.1));
    }
    let mut sums = vec![([0.0; 3], 0.0); vertices.len()];
    for (n, &v) in vertices.iter().enumerate() {
        let sum = &mut sums[sets.find(n)];
        *sum = (add(sum.0, at(v)), sum.1 + 1.0);
    }
    let mut loops: Vec<(usize, [[f64; 3]; 3])> = Vec::new();
    for &(a, b, net) in open {
        let root = sets.find(local(a));
        let apex = scale(sums[root].0, 1.0 / sums[root].1);
        let (from, to) = if net > 0 { (b, a) } else { (a, b) };
        for _ in 0..net.unsigned_abs() {
            loops.push((root, [at(from), at(to), apex]));
        }
    }
    loops.sort_by_key(|l| l.0);
    loops
        .chunk_by(|x, y| x.0 == y.0)
        .map(|run| run.iter().map(|l| l.1).collect())
        .collect()
}

fn holes_are_small(
    holes: &[Vec<[[f64; 3]; 3]>],
    area: f64,
    volume: f64,
    extent_along: &dyn Fn([f64; 3]) -> f64,
) -> bool {
    let mut total = 0.0;
    for hole in holes {
        let (mut vector, mut own) = ([0.0; 3], 0.0);
        for [a, b, c] in hole {
            let n = scale(cross(sub(*b, *a), sub(*c, *a)), 0.5);
            vector = add(vector, n);
            own += norm(n);
        }
        total += own;
        let length = norm(vector);
        if total > HOLE_AREA_MAX * area {
            return false;
        }
        // A slit (no net area) cannot let a cross-section through.
        if length > 1e-12 * area {
            let extent = extent_along(scale(vector, 1.0 / length));
            if length * extent > HOLE_SECTION_MAX * volume.abs() {
                return false;
            }
        }
    }
    true
}

/// Decides which solids are inside out and which are cavities of others.
fn orient(positions: &[[f64; 3]], triangles: &[[u32; 3]], list: &mut [SurfaceComponent]) {
    let mut order: Vec<usize> = (0..list.len())
        .filter(|&i| list[i].kind == Kind::Solid)
        .collect();
    order.sort_by(|&a, &b| {
        let by_size = list[b].volume.abs().total_cmp(&list[a].volume.abs());
        by_size.then(a.cmp(&b))
    });
    for n in 0..order.len() {
        let inner = order[n];
        list[inner].sign = list[inner].volume.signum();
        // The smallest body around it decides, and it is the last one met on the way down.
        for &outer in order[..n].iter().rev() {
            let (o, i) = (&list[outer], &list[inner]);
            let boxed = (0..3).all(|a| o.min[a] <= i.min[a] && i.max[a] <= o.max[a]);
            if !boxed || o.body != outer || o.volume.signum() == i.volume.signum() {
                continue;
            }
            let point = positions[triangles[i.triangles[0].0 as usize][0] as usize];
            if encloses(positions, triangles, o, point) {
                let (sign, body) = (o.sign, o.body);
                list[inner].sign = sign;
                list[inner].body = body;
                break;
            }
        }
    }
}

/// Whether a ray from `point` crosses the surface component an odd number of times.
fn encloses(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    component: &SurfaceComponent,
    point: [f64; 3],
) -> bool {
    // An odd direction, so that the ray meets no edge of axis-aligned models.
    let direction = [0.836_516, 0.389_731, 0.384_917];
    let soup = component
        .triangles
        .iter()
        .map(|&(id, _)| triangles[id as usize].map(|v| positions[v as usize]))
        .chain(component.caps.iter().copied());
    let mut inside = false;
    for [a, b, c] in soup {
        let (e1, e2, s) = (sub(b, a), sub(c, a), sub(point, a));
        let p = cross(direction, e2);
        let det = dot(e1, p);
        let q = cross(s, e1);
        let (u, v, t) = (dot(s, p) / det, dot(direction, q) / det, dot(e2, q) / det);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 {
            inside = !inside;
        }
    }
    inside
}
