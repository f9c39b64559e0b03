//! What nodes have of their bones: which ones, and how far the weights below each lane reach (SPEC 6.10).

use bdtree_format::{
    BONE_ROW_DEFECT, BONE_ROW_SPREAD, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneEntry, LANES, Row,
    bone_row_count,
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
    /// The entries of the nodes.
    pub lists: Vec<BoneEntry>,
    /// Bone rows of all nodes, in node order.
    pub rows: Vec<Row>,
    /// Length of the longest list.
    pub node_bones_max: u32,
}

/// A node with its entries and the place of its rows.
type Job<'j> = (&'j TreeNode, &'j [BoneEntry], &'j mut [Row]);

/// The bones of all nodes of `tree`, over the triangles of the mesh that `skin` carries. The result does not depend on
/// `threads`.
///
/// # Errors
/// More entries of all nodes than 32 bits count.
pub fn wrap_bones(
    tree: &Tree,
    triangles: &[[u32; 3]],
    skin: &StoredSkin,
    threads: usize,
) -> Result<WrappedBones, BakeError> {
    let mut out = WrappedBones::default();
    out.list_starts.push(0);
    for lanes in lane_bones(tree, triangles, skin) {
        let list = entries(&lanes);
        out.node_bones_max = out.node_bones_max.max(list.len() as u32);
        out.lists.extend_from_slice(&list);
        let Ok(end) = u32::try_from(out.lists.len()) else {
            let message =
                "more than 2^32 bone entries of all nodes: more triangles per leaf are needed";
            return Err(BakeError::one("wrap", Place::NOWHERE, message));
        };
        out.list_starts.push(end);
    }
    let starts = out.list_starts.windows(2);
    let lists = starts.map(|ends| &out.lists[ends[0] as usize..ends[1] as usize]);
    let total = BONE_ROWS_FIXED * tree.nodes.len() + BONE_ROWS_PER_ENTRY * out.lists.len();
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

/// The bones of each lane, ascending, and those of all of them.
#[derive(Debug, Clone, Default)]
struct LaneBones {
    lanes: [Vec<u16>; LANES],
    all: Vec<u16>,
}

/// The bones of the vertices below each lane of each node.
fn lane_bones(tree: &Tree, triangles: &[[u32; 3]], skin: &StoredSkin) -> Vec<LaneBones> {
    let mut nodes = vec![LaneBones::default(); tree.nodes.len()];
    // Children stand behind their parents.
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        let mut own = LaneBones::default();
        for lane in node.lanes_of(LaneKind::Leaf) {
            let corners = tree.corners_below(node.lanes[lane], triangles);
            let influences = corners.flat_map(|corner| skin.of(corner as usize));
            own.lanes[lane].extend(influences.map(|influence| influence.bone));
        }
        let children = &nodes[node.first_child as usize..];
        for (lane, child) in node.lanes_of(LaneKind::Inner).zip(children) {
            own.lanes[lane].clone_from(&child.all);
        }
        for bones in &mut own.lanes {
            bones.sort_unstable();
            bones.dedup();
            own.all.extend_from_slice(bones);
        }
        own.all.sort_unstable();
        own.all.dedup();
        nodes[i] = own;
    }
    nodes
}

/// What an entry costs a reader that has one bone for all lanes, and one that has a bone for each, whose eight maps are put
/// side by side: measured with AVX2, where 4 to 7 do about as well.
const SHARED_COST: usize = 4;
const PER_LANE_COST: usize = 5;

/// The entries of a node. Bones of many lanes have one each; the others share entries, so that the root of a character
/// with 60 bones, each of which moves two or three lanes, has a third as many. The split is the one that costs readers
/// least.
fn entries(own: &LaneBones) -> Vec<BoneEntry> {
    let has = |bones: &Vec<u16>, bone: u16| bones.binary_search(&bone).is_ok();
    let lanes_of = |&bone: &u16| own.lanes.iter().filter(|lane| has(lane, bone)).count();
    let counts: Vec<usize> = own.all.iter().map(lanes_of).collect();
    // Bones of at least `lanes` lanes have entries of their own.
    let split = |lanes: usize| {
        let with_counts = own.all.iter().zip(&counts);
        let shared = with_counts.filter(|(_, count)| **count >= lanes);
        let shared: Vec<u16> = shared.map(|(bone, _)| *bone).collect();
        let rest = own.lanes.each_ref().map(|bones| {
            let rest = bones.iter().filter(|bone| !has(&shared, **bone));
            rest.copied().collect::<Vec<u16>>()
        });
        let longest = rest.iter().map(Vec::len).max().unwrap_or(0);
        (shared, rest, longest)
    };
    let splits = (1..=LANES).map(split);
    let best = splits
        .min_by_key(|(shared, _, longest)| SHARED_COST * shared.len() + PER_LANE_COST * longest);
    let Some((shared, rest, longest)) = best else {
        return Vec::new();
    };
    let mut entries: Vec<BoneEntry> = shared.iter().map(|&bone| [bone; LANES]).collect();
    for k in 0..longest {
        // Lanes without another bone have no weight in the entry: any bone does.
        let any = rest.iter().find_map(|bones| bones.get(k)).copied();
        let entry = rest.each_ref().map(|bones| bones.get(k).copied().or(any));
        entries.push(entry.map(Option::unwrap_or_default));
    }
    entries
}

/// The weights below one lane.
#[derive(Default)]
struct Scratch {
    met: Met,
    vertices: Vec<u32>,
    /// Per bone, its place in the list of the node, for bones of the lane.
    place: Vec<usize>,
    /// Per place: least and largest weight, and how many vertices have one.
    least: Vec<f32>,
    largest: Vec<f32>,
    count: Vec<usize>,
    /// Per place, β and the weight of one vertex.
    middles: Vec<f32>,
    weights: Vec<f32>,
}

impl Scratch {
    /// Writes what the vertices of a lane have of the bones in `list`.
    fn write(&mut self, skin: &StoredSkin, list: &[BoneEntry], lane: usize, rows: &mut [Row]) {
        self.place.resize(skin.bones.len(), 0);
        // The first entry with a bone is that of its weights.
        for (place, entry) in list.iter().enumerate().rev() {
            self.place[usize::from(entry[lane])] = place;
        }
        self.add_ranges(skin, list.len());
        let ranges = self.least.iter().zip(&self.largest);
        let sums = ranges.clone().map(|(&l, &h)| f64::from(l) + f64::from(h));
        let sum: f64 = sums.clone().sum();
        self.middles.clear();
        // Nothing carries the lane if the sum is 0: its middles are zero, too.
        let middle = |own: f64| if own > 0.0 { (own / sum) as f32 } else { 0.0 };
        self.middles.extend(sums.map(middle));
        for (k, ((&least, &largest), &middle)) in ranges.zip(&self.middles).enumerate() {
            let own = BONE_ROWS_FIXED + BONE_ROWS_PER_ENTRY * k;
            rows[own][lane] = middle;
            rows[own + 1][lane] = gap([least, largest], middle);
        }
        self.weights.clear();
        self.weights.resize(list.len(), 0.0);
        let (mut spread, mut defect) = (0.0_f64, 0.0_f32);
        for &vertex in &self.vertices {
            let influences = skin.of(vertex as usize);
            defect = defect.max(weights::defect(influences));
            for influence in influences {
                self.weights[self.place[usize::from(influence.bone)]] = influence.weight;
            }
            let apart = self.weights.iter().zip(&self.middles);
            let apart = apart.map(|(&w, &middle)| (f64::from(w) - f64::from(middle)).abs());
            spread = spread.max(apart.sum());
            for influence in influences {
                self.weights[self.place[usize::from(influence.bone)]] = 0.0;
            }
        }
        // What differences and their sum lose in f64, with room to spare.
        let above = 1.0 + f64::EPSILON * (list.len() + 4) as f64;
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
                let place = self.place[usize::from(influence.bone)];
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
    }
}

/// g: no weight of the range is farther from the middle, nor below the middle less g as readers round it.
fn gap([least, largest]: [f32; 2], middle: f32) -> f32 {
    let [least_, largest_, middle_] = [least, largest, middle].map(f64::from);
    let mut gap = round_up((largest_ - middle_).max(middle_ - least_).max(0.0));
    while middle - gap > least {
        gap = gap.next_up();
    }
    gap
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own(lanes: [&[u16]; LANES]) -> LaneBones {
        let mut all = lanes.concat();
        all.sort_unstable();
        all.dedup();
        LaneBones {
            lanes: lanes.map(<[u16]>::to_vec),
            all,
        }
    }

    #[test]
    fn bones_of_few_lanes_share_entries() {
        let all: &[u16] = &[3];
        assert_eq!(entries(&own([all; LANES])), [[3; LANES]]);
        assert_eq!(entries(&own([&[]; LANES])), [[0; LANES]; 0]);
        // One bone for all lanes, and three of each lane's own.
        let lanes: [[u16; 4]; LANES] = std::array::from_fn(|k| {
            let first = 3 * k as u16;
            [first, first + 1, first + 2, 40]
        });
        let found = entries(&own(lanes.each_ref().map(<[u16; 4]>::as_slice)));
        let third = |k: u16| std::array::from_fn(|lane| 3 * lane as u16 + k);
        assert_eq!(found, [[40; LANES], third(0), third(1), third(2)]);
        // Of lanes that have fewer, the entry holds another lane's bone.
        let lanes: [&[u16]; LANES] = [&[1], &[2], &[3], &[4], &[5], &[6], &[], &[]];
        assert_eq!(entries(&own(lanes)), [[1, 2, 3, 4, 5, 6, 1, 1]]);
        // Bones of all lanes are cheaper repeated than put side by side.
        let lanes: [&[u16]; LANES] = [
            &[1, 2],
            &[1, 2],
            &[1, 2],
            &[1, 2],
            &[1, 2],
            &[1, 2],
            &[1, 2],
            &[1, 2],
        ];
        assert_eq!(entries(&own(lanes)), [[1; LANES], [2; LANES]]);
    }

    #[test]
    fn gaps_reach_both_ends_of_a_range() {
        for [least, middle, largest] in [
            [0.0, 1.0 / 3.0, 1.0],
            [0.1, 0.3, 0.35],
            [0.099_999_99, 0.1, 0.1],
            [1.0, 1.0, 1.0],
            [0.0, 0.0, 0.0],
        ] {
            let gap = gap([least, largest], middle);
            let reach: f64 = f64::from(gap);
            assert!(reach >= f64::from(largest) - f64::from(middle));
            assert!(reach >= f64::from(middle) - f64::from(least));
            assert!(middle - gap <= least && gap <= 1.001 * (largest - middle).max(middle - least));
        }
    }
}
