//! The samplers of an animation as curves.

use std::collections::{HashMap, HashSet};

use gltf::json::Animation;
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Purpose};
use super::curve::Curve;
use super::notes::Notes;
use super::plan::ELEMENTS_MAX;

/// The curves of an animation; channels with one sampler share one.
pub(super) struct Curves<'a> {
    pub(super) list: Vec<Curve>,
    /// The animation and its index.
    animation: (usize, &'a Animation),
    /// Index in `list` by sampler and number of weights; `None` if something is wrong with it.
    known: HashMap<(usize, usize), Option<usize>>,
}

impl<'a> Curves<'a> {
    /// None of those of the animation `index`.
    pub(super) fn of(index: usize, animation: &'a Animation) -> Self {
        Self {
            list: Vec::new(),
            animation: (index, animation),
            known: HashMap::new(),
        }
    }

    /// The samplers `used` are not too large; otherwise that is noted. Many samplers can name the
    /// same bytes.
    pub(super) fn check_size(
        &self,
        used: HashSet<usize>,
        accessors: &Accessors<'_>,
        notes: &mut Notes,
    ) -> bool {
        let (index, animation) = self.animation;
        let count = used
            .into_iter()
            .filter_map(|sampler| animation.samplers.get(sampler))
            .flat_map(|sampler| [sampler.input.value(), sampler.output.value()])
            .filter_map(|index| accessors.list.get(index))
            .fold(0_u64, |sum, accessor| sum.saturating_add(accessor.count.0));
        if count > ELEMENTS_MAX {
            let message = format!(
                "{count} times and values of all samplers; at most {ELEMENTS_MAX} are read"
            );
            notes.problem(format!("animations[{index}].samplers"), message);
        }
        count <= ELEMENTS_MAX
    }

    /// Index of the curve of a sampler for `width` weights. What is wrong with it is noted once.
    pub(super) fn add(
        &mut self,
        sampler: usize,
        width: usize,
        accessors: &Accessors<'_>,
        notes: &mut Notes,
    ) -> Option<usize> {
        if let Some(&known) = self.known.get(&(sampler, width)) {
            return known;
        }
        let curve = curve(self.animation, sampler, width, accessors, notes);
        let index = curve.map(|curve| {
            self.list.push(curve);
            self.list.len() - 1
        });
        self.known.insert((sampler, width), index);
        index
    }
}

/// The curve of a sampler for `width` weights.
fn curve(
    animation: (usize, &Animation),
    sampler: usize,
    width: usize,
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> Option<Curve> {
    let (index, animation) = animation;
    let place = format!("animations[{}].samplers[{sampler}]", index);
    let Some(sampler) = animation.samplers.get(sampler) else {
        return notes.refuse(place, "there is no such element");
    };
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return notes.refuse(place, "interpolation is none of LINEAR, STEP, CUBICSPLINE");
    };
    let (input, output) = (format!("{place}.input"), format!("{place}.output"));
    let times = times(sampler.input.value(), accessors, &input, true, notes);
    let values = accessors.read(sampler.output.value(), Purpose::Weights, &output, notes);
    let (times, values) = times.zip(values)?;
    let keys = times.len();
    if Curve::value_count(interpolation, keys, width) != Some(values.count) {
        let kind = match interpolation {
            gltf::json::animation::Interpolation::CubicSpline => " of 3 values",
            _ => "",
        };
        let message = format!(
            "{} values for {keys} keys{kind} of {width} morph targets",
            values.count
        );
        return notes.refuse(output, message);
    }
    let values = values.all::<1>().into_flattened();
    for (i, w) in values.iter().enumerate() {
        if !w.is_finite() {
            notes.problem(&output, format!("value {i} is {w}"));
        }
    }
    Some(Curve {
        interpolation,
        times,
        width,
        values,
    })
}

/// The times of keys in accessor `index`, one at least; what is wrong with them is noted at `place`. `tells`: what is
/// odd about them is, too.
pub(super) fn times(
    index: usize,
    accessors: &Accessors<'_>,
    place: &str,
    tells: bool,
    notes: &mut Notes,
) -> Option<Vec<f64>> {
    let times = accessors.read(index, Purpose::Times, place, notes)?;
    if times.count == 0 {
        return notes.refuse(place, "has no keys");
    }
    let times = times.all::<1>().into_flattened();
    let mut equal = 0;
    // The first key whose time is none, and how many there are.
    let mut wrong = None;
    for (i, &t) in times.iter().enumerate() {
        let before = if i == 0 { 0.0 } else { times[i - 1] };
        if !(t.is_finite() && t >= before) {
            let (_, count) = wrong.get_or_insert((i, 0));
            *count += 1;
        } else if i > 0 && t == before {
            equal += 1;
        }
    }
    if let Some((i, count)) = wrong {
        let t = times[i];
        let mut message = format!("key {i} at {t} s: times are numbers of at least 0 that ascend");
        if count > 1 {
            message += &format!(" (and {} more like it)", count - 1);
        }
        notes.problem(place, message);
    }
    if equal > 0 && tells {
        notes.warn(
            place,
            format!("{equal} keys have the time of the key before them: jumps"),
        );
    }
    Some(times)
}
