//! Weights as stored: f32, normalised unless told otherwise.

use bdtree_format::{InfluenceRecord, WEIGHT_MAX, WEIGHT_MIN};

use crate::error::{BakeError, Part, Place};
use crate::input::RawInfluences;
use crate::words::words;
use crate::wrap::round::round_up;

/// What becomes of weights whose sum is not 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Weights {
    /// They are divided by it.
    #[default]
    Normalise,
    /// They stay: the vertex then moves by more or by less than its bones.
    AsStored,
}

words!(
    Weights,
    "is neither normalise nor as-stored",
    Normalise = "normalise" | "normalize",
    AsStored = "as-stored"
);

/// 2⁵⁵: the last bit of a weight of 2⁻³² or more counts one of 2⁻⁵⁵, so that sums of whole numbers are exact.
const ONE: i128 = 1 << 55;

/// Influences as the file has them.
#[derive(Debug)]
pub(super) struct Taken {
    pub(super) starts: Vec<u32>,
    pub(super) list: Vec<InfluenceRecord>,
    /// Largest number of influences of a vertex.
    pub(super) most: u32,
    /// Largest |Σ w − 1|, rounded up.
    pub(super) defect: f32,
}

impl Taken {
    /// The influences of each vertex.
    pub(super) fn vertices(&self) -> impl Iterator<Item = &[InfluenceRecord]> {
        let ends = self.starts.windows(2);
        ends.map(|ends| &self.list[ends[0] as usize..ends[1] as usize])
    }
}

/// Σ w in units of 2⁻⁵⁵, exactly.
fn sum(influences: &[InfluenceRecord]) -> i128 {
    // Exact: whole numbers of at most 57 bits.
    let whole = |w: f32| (f64::from(w) * ONE as f64) as i128;
    influences
        .iter()
        .map(|influence| whole(influence.weight))
        .sum()
}

/// |Σ w − 1|, rounded up.
pub(crate) fn defect(influences: &[InfluenceRecord]) -> f32 {
    let off = (sum(influences) - ONE).unsigned_abs();
    let nearest = off as f64;
    // More than 53 bits may have been rounded down; the quotient is exact.
    let above = if (nearest as u128) < off {
        1.0 + f64::EPSILON
    } else {
        1.0
    };
    round_up(nearest / ONE as f64 * above)
}

/// The influences of all vertices, as `weights` says; bones of a vertex ascend. Weights below 2⁻³² go.
///
/// # Errors
/// Weights that are negative or not finite, that cannot be normalised because they are all zero, or whose sum is beyond
/// 2: the first vertex of each kind with the number of others.
pub(super) fn take(
    file: &str,
    influences: &RawInfluences,
    weights: Weights,
) -> Result<Taken, BakeError> {
    let mut taken = Taken {
        starts: Vec::with_capacity(influences.starts.len()),
        list: Vec::with_capacity(influences.list.len()),
        most: 0,
        defect: 0.0,
    };
    taken.starts.push(0);
    let mut wrong: [Option<(usize, usize)>; 3] = [None; 3];
    let mut own: Vec<InfluenceRecord> = Vec::new();
    for vertex in 0..influences.vertex_count() {
        let given = influences.of(vertex);
        let total: f64 = given.iter().map(|&(_, w)| w).sum();
        let divisor = match weights {
            Weights::Normalise => total,
            Weights::AsStored => 1.0,
        };
        let kind = if given.iter().any(|&(_, w)| !(w >= 0.0 && w.is_finite())) {
            Some(0)
        } else if !(divisor > 0.0 && divisor.is_finite()) {
            Some(1)
        } else {
            own.clear();
            own.extend(
                given
                    .iter()
                    .filter_map(|&(bone, w)| influence(bone, w / divisor)),
            );
            if weights == Weights::Normalise {
                fill(&mut own);
            }
            let is_large = own.iter().any(|i| i.weight > WEIGHT_MAX) || sum(&own) > 2 * ONE;
            is_large.then_some(2)
        };
        if let Some(kind) = kind {
            let (_, count) = wrong[kind].get_or_insert((vertex, 0));
            *count += 1;
            continue;
        }
        taken.defect = taken.defect.max(defect(&own));
        taken.most = taken.most.max(own.len() as u32);
        taken.list.extend_from_slice(&own);
        // No loss: starts of the source count as many or more in 32 bits.
        taken.starts.push(taken.list.len() as u32);
    }
    let mut problems = Vec::new();
    for (kind, found) in wrong.into_iter().enumerate() {
        let Some((vertex, count)) = found else {
            continue;
        };
        let mut message = match kind {
            0 => "a weight is negative or not finite".to_string(),
            1 => {
                "all weights are zero: they cannot be normalised (--weights as-stored keeps them, \
                  and the vertex at the origin)"
                    .to_string()
            }
            _ => format!(
                "the sum of its weights is beyond {WEIGHT_MAX} (--weights normalise divides by it)"
            ),
        };
        if count > 1 {
            let others = count - 1;
            let vertices = if others == 1 { "vertex" } else { "vertices" };
            message += &format!(" (and {others} {vertices} like it)");
        }
        problems.extend(BakeError::one("skin", place(file, influences, vertex), message).problems);
    }
    if problems.is_empty() {
        Ok(taken)
    } else {
        Err(BakeError { problems })
    }
}

/// A weight as stored, unless it is too small.
fn influence(bone: u16, weight: f64) -> Option<InfluenceRecord> {
    let weight = weight as f32;
    (weight >= WEIGHT_MIN).then_some(InfluenceRecord {
        weight,
        bone,
        reserved: 0,
    })
}

/// Puts what rounding and small weights left of 1 on the largest weight, the first of equal ones.
fn fill(own: &mut [InfluenceRecord]) {
    let rest = (ONE - sum(own)) as f64 / ONE as f64;
    let largest = own.iter().map(|i| i.weight).fold(0.0, f32::max);
    if let Some(first) = own.iter_mut().find(|i| i.weight == largest) {
        first.weight = (f64::from(first.weight) + rest) as f32;
    }
}

/// Where the weights of a vertex stand.
fn place(file: &str, influences: &RawInfluences, vertex: usize) -> Place {
    let run = influences
        .places
        .partition_point(|&(first, _)| first as usize <= vertex);
    match run
        .checked_sub(1)
        .and_then(|run| influences.places.get(run))
    {
        Some((first, path)) => Place::file(file)
            .at(Part::JsonPath(path.clone()))
            .at(Part::Vertex(vertex - *first as usize)),
        None => match &influences.file {
            Some(file) => Place::file(file).at(Part::Vertex(vertex)),
            None => Part::Vertex(vertex).into(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(weights: &[f64], how: Weights) -> Result<Vec<f32>, String> {
        let list: Vec<(u16, f64)> = (0..).zip(weights.iter().copied()).collect();
        let influences = RawInfluences {
            starts: vec![0, list.len() as u32],
            file: None,
            list,
            places: vec![(0, "here".to_string())],
        };
        let taken = take("a.glb", &influences, how).map_err(|e| e.to_string())?;
        Ok(taken.list.iter().map(|i| i.weight).collect())
    }

    #[test]
    fn weights_are_divided_and_the_rest_goes_to_the_largest() {
        assert_eq!(all(&[1.0, 1.0], Weights::Normalise), Ok(vec![0.5, 0.5]));
        assert_eq!(all(&[7.0], Weights::Normalise), Ok(vec![1.0]));
        // Too small to count.
        assert_eq!(all(&[1.0, 1e-11], Weights::Normalise), Ok(vec![1.0]));
        for n in 2..200_u32 {
            let weights: Vec<f64> = (1..=n).map(|k| f64::from(k * k % 17 + 1) / 3.0).collect();
            let stored = all(&weights, Weights::Normalise).expect("sound");
            let sum: f64 = stored.iter().map(|&w| f64::from(w)).sum();
            // Half a unit of the largest, which is below 1.
            assert!((sum - 1.0).abs() <= 2.0_f64.powi(-25), "{n}: {sum}");
        }
    }

    #[test]
    fn weights_stay_if_told_to() {
        assert_eq!(all(&[0.25, 0.5], Weights::AsStored), Ok(vec![0.25, 0.5]));
        assert_eq!(all(&[], Weights::AsStored), Ok(vec![]));
        let records = |weights: &[f32]| -> Vec<InfluenceRecord> {
            let record = |(bone, &weight): (u16, &f32)| InfluenceRecord {
                weight,
                bone,
                reserved: 0,
            };
            (0..).zip(weights).map(record).collect()
        };
        assert_eq!(defect(&records(&[0.25, 0.5])), 0.25);
        assert_eq!(defect(&records(&[1.0, WEIGHT_MIN])), WEIGHT_MIN);
        assert_eq!(defect(&[]), 1.0);
    }

    #[test]
    fn what_is_no_weight_is_told_with_its_place() {
        let told = |weights: &[f64], how| all(weights, how).expect_err("a problem");
        let text = told(&[1.0, -0.5], Weights::Normalise);
        assert_eq!(
            text,
            "a.glb: here, vertex 0: a weight is negative or not finite"
        );
        assert!(told(&[f64::NAN], Weights::AsStored).contains("not finite"));
        assert!(told(&[], Weights::Normalise).contains("all weights are zero"));
        assert!(told(&[1.5, 0.75], Weights::AsStored).contains("beyond 2"));
    }
}
