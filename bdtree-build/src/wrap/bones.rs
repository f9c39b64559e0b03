//! What nodes have of their bones: which ones, and the ranges of the weights below each lane (SPEC 6.10).

use bdtree_format::{
    BONE_ROW_DEFECT, BONE_ROW_SCALE, BONE_ROW_SPREAD, BONE_ROWS_FIXED, LANES, Row, bone_row_count,
};

use super::round::round_up;
use crate::error::{BakeError, Place};
use crate::parallel;
use crate::skin::{StoredSkin, weights};
use crate::tree::{LaneKind, Met, Tree, TreeNode};

/// Bone lists and bone rows as the file holds them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WrappedBones {
    /// First entry of each node, and the end of the last one's.
    pub list_starts: Vec<u32>,
    /// The bones of the nodes, ascending in each.
    pub lists: Vec<u16>,
    /// Bone rows of all nodes, in node order.
    pub rows: Vec<Row>,
    /// Length of the longest list.
    pub node_bones_max: u32,
}

/// A node with its bones and the place of its rows.
type Job<'j> = (&'j TreeNode, &'j [u16], &'j mut [Row]);

/// The bones of all nodes of `tree`, over the triangles of the mesh that `skin` carries. The result does not depend on
/// `threads`.
///
/// # Errors
/// More bones of all nodes than 32 bits count.
pub fn wrap_bones(
    tree: &Tree,
    triangles: &[[u32; 3]],
    skin: &StoredSkin,
    threads: usize,
) -> Result<WrappedBones, BakeError> {
    let mut out = WrappedBones::default();
    out.list_starts.push(0);
    for list in node_lists(tree, triangles, skin) {
        out.node_bones_max = out.node_bones_max.max(list.len() as u32);
        out.lists.extend_from_slice(&list);
        let Ok(end) = u32::try_from(out.lists.len()) else {
            let message = "more than 2^32 bones of all nodes: more triangles per leaf are needed";
            return Err(BakeError::one("wrap", Place::NOWHERE, message));
        };
        out.list_starts.push(end);
    }
    let starts = out.list_starts.windows(2);
    let lists = starts.map(|ends| &out.lists[ends[0] as usize..ends[1] as usize]);
    let total = BONE_ROWS_FIXED * tree.nodes.len() + 2 * out.lists.len();
    let mut rows = vec![[0.0; LANES]; total];
    let mut rest = rows.as_mut_slice();
    let mut jobs: Vec<Job<'_>> = Vec::with_capacity(tree.nodes.len());
    for (node, list) in tree.nodes.iter().zip(lists) {
        let (own, behind) = rest.split_at_mut(bone_row_count(list.len()));
        rest = behind;
        jobs.push((node, list, own));
    }
    let mut memory = parallel::states(threads, Scratch::default);
    parallel::for_each(jobs.into_iter(), &mut memory, |scratch, job: Job<'_>| {
        let (node, list, rows) = job;
        for (lane, own) in node.lanes.iter().enumerate() {
            if own.kind != LaneKind::Empty {
                let corners = tree.corners_below(*own, triangles);
                scratch.vertices.clear();
                let below = scratch.met.once(skin.starts.len() - 1, corners);
                scratch.vertices.extend(below);
                scratch.write(skin, list, lane, rows);
            }
        }
    });
    out.rows = rows;
    Ok(out)
}

/// The bones of each node, ascending.
fn node_lists(tree: &Tree, triangles: &[[u32; 3]], skin: &StoredSkin) -> Vec<Vec<u16>> {
    let mut lists: Vec<Vec<u16>> = vec![Vec::new(); tree.nodes.len()];
    // Per bone, the last node that has it.
    let mut met = vec![usize::MAX; skin.bones.len()];
    // Children stand behind their parents.
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        let mut own = Vec::new();
        let mut add = |bone: u16| {
            if std::mem::replace(&mut met[usize::from(bone)], i) != i {
                own.push(bone);
            }
        };
        for lane in node.lanes_of(LaneKind::Leaf) {
            for corner in tree.corners_below(node.lanes[lane], triangles) {
                skin.of(corner as usize)
                    .iter()
                    .for_each(|influence| add(influence.bone));
            }
        }
        let children = node.lanes_of(LaneKind::Inner).count();
        let first = node.first_child as usize;
        for child in &lists[first..first + children] {
            child.iter().copied().for_each(&mut add);
        }
        if own.is_empty() {
            // Vertices that nothing carries: a lane's middles of weights need a bone all the same.
            own.push(0);
        }
        own.sort_unstable();
        lists[i] = own;
    }
    lists
}

/// The weights below one lane.
#[derive(Default)]
struct Scratch {
    met: Met,
    vertices: Vec<u32>,
    /// Per bone, its place in the list of the node, for bones of the list.
    place: Vec<u32>,
    /// Per place: least and largest weight, and how many vertices have one.
    least: Vec<f32>,
    largest: Vec<f32>,
    count: Vec<usize>,
    /// The places with weights, and β of each.
    middles: Vec<(u32, f32)>,
}

impl Scratch {
    /// Writes what the vertices of a lane have of the bones `list`.
    fn write(&mut self, skin: &StoredSkin, list: &[u16], lane: usize, rows: &mut [Row]) {
        self.place.resize(skin.bones.len(), 0);
        for (place, &bone) in (0..).zip(list) {
            self.place[usize::from(bone)] = place;
        }
        self.add_ranges(skin, list.len());
        let ranges = self.least.iter().zip(&self.largest);
        let sum: f64 = ranges.map(|(&l, &h)| f64::from(l + h)).sum();
        // As readers compute it (SPEC 5.9), so that the sums below are those of what they use.
        let scale = (1.0 / sum) as f32;
        self.middles.clear();
        for (place, (&least, &largest)) in (0..).zip(self.least.iter().zip(&self.largest)) {
            if largest > 0.0 {
                self.middles.push((place, scale * (least + largest)));
            }
            let own = BONE_ROWS_FIXED + 2 * place as usize;
            rows[own][lane] = least;
            rows[own + 1][lane] = largest;
        }
        let (mut spread, mut defect) = (0.0_f64, 0.0_f32);
        for &vertex in &self.vertices {
            let influences = skin.of(vertex as usize);
            defect = defect.max(weights::defect(influences));
            let mut rest = influences.iter().peekable();
            let mut sum = 0.0_f64;
            for &(place, middle) in &self.middles {
                let own = rest.next_if(|i| self.place[usize::from(i.bone)] == place);
                let weight = own.map_or(0.0, |influence| influence.weight);
                sum += (f64::from(weight) - f64::from(middle)).abs();
            }
            spread = spread.max(sum);
        }
        // What differences and their sum lose in f64, with room to spare.
        let above = 1.0 + f64::EPSILON * (self.middles.len() + 4) as f64;
        rows[BONE_ROW_SCALE][lane] = scale;
        rows[BONE_ROW_SPREAD][lane] = round_up(spread * above);
        rows[BONE_ROW_DEFECT][lane] = defect;
    }

    /// The least and the largest weight of each place.
    fn add_ranges(&mut self, skin: &StoredSkin, places: usize) {
        self.least.clear();
        self.least.resize(places, f32::INFINITY);
        self.largest.clear();
        self.largest.resize(places, 0.0);
        self.count.clear();
        self.count.resize(places, 0);
        for &vertex in &self.vertices {
            for influence in skin.of(vertex as usize) {
                let place = self.place[usize::from(influence.bone)] as usize;
                self.least[place] = self.least[place].min(influence.weight);
                self.largest[place] = self.largest[place].max(influence.weight);
                self.count[place] += 1;
            }
        }
        for (least, &count) in self.least.iter_mut().zip(&self.count) {
            if count < self.vertices.len() {
                *least = 0.0;
            }
        }
        if self.largest.iter().all(|&w| w == 0.0) {
            // Nothing carries the lane; middles must sum to 1 all the same, and any range that holds 0 is one.
            self.largest[0] = 1.0;
        }
    }
}
