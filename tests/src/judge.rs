//! Whether the numbers of a file bound what they say they bound, decided without `verify`.

use bdtree_runtime::{Asset, VertexId};

use crate::lanes::{Lane, Number, Verdict};

/// What a checker must say of a file whose order of nodes is sound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Judgement {
    /// Every bound holds.
    Holds,
    /// The first that does not.
    Broken(String),
    /// A number is too near to its bound to say, within the tolerances of SPEC 5.8.
    Unclear,
}

/// Norms within this share of P and W_j are too close to call (SPEC 5.8: 2⁻³⁹).
const DOUBT: f64 = 1.0 / (1_u64 << 38) as f64;

/// A norm as a share of the limit that bounds it.
fn share_verdict(share: f64) -> Verdict {
    match share {
        s if s <= 1.0 => Some(false),
        s if s > 1.0 + DOUBT => Some(true),
        _ => None,
    }
}

fn norm(x: [f32; 3]) -> f64 {
    x.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt()
}

fn share(x: [f32; 3], limit: f32) -> f64 {
    match norm(x) {
        0.0 => 0.0,
        norm => norm / f64::from(limit),
    }
}

/// Judges every bound of a file: R, ΔR, b±, δR of all lanes, modes left out, P, W_j, and `q_limit` as
/// a bound of the frames' q.
///
/// # Panics
/// When the order of the nodes is not sound, or an index is none.
pub fn judge(asset: &Asset<'_>) -> Judgement {
    let mut unclear = false;
    let mut broken = |verdict: Verdict| {
        unclear |= verdict.is_none();
        verdict == Some(true)
    };
    let header = asset.header();
    for (i, x) in asset.positions().iter().enumerate() {
        if broken(share_verdict(share(*x, header.position_norm_max.get()))) {
            return Judgement::Broken(format!("position {i} is beyond P"));
        }
        let own = asset.displacements(VertexId(i as u32)).expect("a vertex");
        for (j, u) in own.iter() {
            let w = asset.modes()[j].field_norm_max.get();
            if broken(share_verdict(share(u, w))) {
                return Judgement::Broken(format!("displacement of vertex {i} is beyond W_{j}"));
            }
        }
    }
    for k in 0..asset.frame_count() {
        let frame = asset.frame(k).expect("a frame");
        for (j, (q, mode)) in frame.q().iter().zip(asset.modes()).enumerate() {
            if q.abs() > mode.q_limit.get() {
                return Judgement::Broken(format!("frame {k} is beyond the limit of mode {j}"));
            }
        }
    }
    for lane in Lane::all(asset) {
        if broken(share_verdict(lane.centre_shares())) {
            return Judgement::Broken(format!("{lane:?}: a centre is beyond P or W"));
        }
        if lane.misses_a_mode() {
            return Judgement::Broken(format!("{lane:?}: a mode is left out"));
        }
        for number in lane.numbers() {
            let (units, _) = lane.units(number);
            let negative = units < 0.0 && !matches!(number, Number::Cross(..));
            if negative || broken(lane.verdict(number, lane.value(number))) {
                return Judgement::Broken(format!("{lane:?}: {number:?} is {units} units"));
            }
        }
    }
    if unclear {
        Judgement::Unclear
    } else {
        Judgement::Holds
    }
}
