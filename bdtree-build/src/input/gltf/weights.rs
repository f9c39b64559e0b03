//! Which joints of its skin move each vertex of a primitive: JOINTS_n and WEIGHTS_n, any number of sets.

use std::collections::BTreeMap;

use bdtree_format::INFLUENCES_MAX;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Purpose};
use super::notes::Notes;

/// Joints, as the skin counts them, and weights of a primitive's vertices. Weights are positive, joints of a vertex
/// ascend.
#[derive(Debug, Default)]
pub(super) struct JointWeights {
    /// First entry of each vertex, and the end of the last one's.
    starts: Vec<u32>,
    list: Vec<(u16, f64)>,
}

impl JointWeights {
    /// The entries of a vertex.
    pub(super) fn of(&self, vertex: usize) -> &[(u16, f64)] {
        let ends = self
            .starts
            .get(vertex..)
            .and_then(<[u32]>::first_chunk::<2>);
        let run = ends.and_then(|&[start, end]| self.list.get(start as usize..end as usize));
        run.unwrap_or_default()
    }
}

/// One set: four joints and four weights for each vertex.
struct Set {
    joints: Vec<[u16; 4]>,
    weights: Vec<[f64; 4]>,
}

/// Problems of one kind: the first is told in full, the others are counted.
#[derive(Default)]
pub(super) struct Kind {
    first: Option<(usize, String)>,
    more: usize,
}

impl Kind {
    pub(super) fn add(&mut self, vertex: usize, message: impl FnOnce() -> String) {
        match self.first {
            None => self.first = Some((vertex, message())),
            Some(_) => self.more += 1,
        }
    }

    pub(super) fn tell(self, place: &str, notes: &mut Notes) {
        let Some((vertex, mut message)) = self.first else {
            return;
        };
        if self.more > 0 {
            message += &format!(" (and {} more like it)", self.more);
        }
        notes.problem(place, format!("vertex {vertex}: {message}"));
    }
}

/// The joints and weights of the primitive at `place`, which a skin moves.
pub(super) fn read(
    primitive: &Primitive,
    vertex_count: usize,
    accessors: &Accessors<'_>,
    place: &str,
    notes: &mut Notes,
) -> Option<JointWeights> {
    let place = format!("{place}.attributes");
    let mut pairs: BTreeMap<u32, [Option<usize>; 2]> = BTreeMap::new();
    for (semantic, accessor) in &primitive.attributes {
        let (set, which) = match semantic {
            Checked::Valid(Semantic::Joints(set)) => (*set, 0),
            Checked::Valid(Semantic::Weights(set)) => (*set, 1),
            _ => continue,
        };
        pairs.entry(set).or_default()[which] = Some(accessor.value());
    }
    if pairs.is_empty() {
        return notes.refuse(
            place,
            "has no JOINTS_0 and WEIGHTS_0, but a skin moves the mesh",
        );
    }
    let mut sets = Vec::with_capacity(pairs.len());
    for (set, pair) in pairs {
        let [joints, weights] = match pair {
            [Some(joints), Some(weights)] => [joints, weights],
            [Some(_), None] => {
                return notes.refuse(place, format!("has JOINTS_{set} but no WEIGHTS_{set}"));
            }
            _ => return notes.refuse(place, format!("has WEIGHTS_{set} but no JOINTS_{set}")),
        };
        sets.push(self::set(
            set,
            joints,
            weights,
            vertex_count,
            accessors,
            &place,
            notes,
        )?);
    }
    join(&sets, vertex_count, &place, notes)
}

/// The numbers of one set.
fn set(
    set: u32,
    joints: usize,
    weights: usize,
    vertex_count: usize,
    accessors: &Accessors<'_>,
    place: &str,
    notes: &mut Notes,
) -> Option<Set> {
    let mut elements = |name: &str, index: usize, purpose: Purpose| {
        let place = format!("{place}.{name}_{set}");
        let elements = accessors.read(index, purpose, &place, notes)?;
        if elements.count != vertex_count {
            let message = format!("{} elements for {vertex_count} vertices", elements.count);
            return notes.refuse(place, message);
        }
        Some(elements.all::<4>())
    };
    let joints = elements("JOINTS", joints, Purpose::Joints)?;
    let weights = elements("WEIGHTS", weights, Purpose::JointWeights)?;
    Some(Set {
        // No loss: integers of at most 16 bits.
        joints: joints
            .iter()
            .map(|joints| joints.map(|joint| joint as u16))
            .collect(),
        weights,
    })
}

/// All sets together: the weights of a joint that a vertex has several times are added.
fn join(sets: &[Set], vertex_count: usize, place: &str, notes: &mut Notes) -> Option<JointWeights> {
    let mut out = JointWeights::default();
    out.starts.push(0);
    let (mut wrong, mut many) = (Kind::default(), Kind::default());
    let mut own: Vec<(u16, f64)> = Vec::new();
    for vertex in 0..vertex_count {
        own.clear();
        for set in sets {
            for (&joint, &weight) in set.joints[vertex].iter().zip(&set.weights[vertex]) {
                if !(weight >= 0.0 && weight.is_finite()) {
                    wrong.add(vertex, || {
                        format!("weight {weight} of joint {joint} is not a number of at least 0")
                    });
                } else if weight > 0.0 {
                    own.push((joint, weight));
                }
            }
        }
        add_equal(&mut own);
        if own.len() > INFLUENCES_MAX {
            many.add(vertex, || {
                format!(
                    "{} joints; at most {INFLUENCES_MAX} move a vertex",
                    own.len()
                )
            });
        }
        out.list.extend_from_slice(&own);
        let Ok(end) = u32::try_from(out.list.len()) else {
            return notes.refuse(place, "more weights than 32 bits count");
        };
        out.starts.push(end);
    }
    let is_sound = wrong.first.is_none() && many.first.is_none();
    wrong.tell(place, notes);
    many.tell(place, notes);
    is_sound.then_some(out)
}

/// Sorts by the first number; of equal ones the weights are added.
pub(in crate::input) fn add_equal(own: &mut Vec<(u16, f64)>) {
    own.sort_by_key(|&(index, _)| index);
    own.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}
