//! Over the size of the mesh, at the same number of contacts (P28, P41).

use std::error::Error;

use bdtree_measure::Place;
use bdtree_measure::clock::Clock;
use bdtree_measure::deform::Deformer;
use bdtree_measure::peers::{Obvhs, Peer, Target};
use bdtree_measure::stats;
use bdtree_runtime::{Asset, Transform, VertexId};
use serde_json::{Value, json};

use crate::contenders::assets::baked;
use crate::report::Table;
use crate::workloads::curtain::cloth;
use crate::workloads::sequence;
use bdtree_measure::ours::{self, Ours};
use bdtree_measure::plot::{Axis, Line, Plot};

/// Balls, each with its own q.
const BALLS: usize = 64;

/// Balls that are asked of the refitted tree, which takes its time.
const REFITS: usize = 8;

/// A q and a place on the deformed cloth.
struct Case {
    q: Vec<f32>,
    center: [f32; 3],
}

/// One cloth's figures per ball.
struct Figures {
    triangles: usize,
    radius: f32,
    contacts: f64,
    nodes: f64,
    seconds: f64,
    /// Deforming, refitting and asking the boxes.
    refitted: f64,
}

/// All cloths.
pub(super) struct Sizes(Vec<Figures>);

pub(super) fn measure(
    triangles: &[u32],
    contacts: f64,
    repeats: usize,
) -> Result<Sizes, Box<dyn Error>> {
    let mut all = Vec::new();
    for count in triangles {
        // A square of c² quads.
        let side = (f64::from(*count) / 2.0).sqrt().round() as usize + 1;
        let body = cloth("cloth", side, side);
        let model = baked(&body)?;
        let cases = cases(model.asset(), side)?;
        let mut figures = ours(*model.asset(), &cases, contacts, repeats)?;
        let deformer = Deformer::new(&body);
        let mut boxes = Obvhs::new(&body);
        let (mut scratch, mut found) = (Vec::new(), Vec::new());
        let mut times = Vec::new();
        // The refitted tree depends on the question hardly at all: a few balls, a few times.
        for _ in 0..repeats.clamp(1, 3) {
            for case in &cases[..REFITS] {
                let to = Target::without_bones(&deformer, &case.q, &Place::IDENTITY);
                let update = boxes.update(to, &mut scratch);
                let start = Clock::start();
                found.clear();
                boxes.ball(
                    case.center.map(f64::from),
                    f64::from(figures.radius),
                    &mut found,
                );
                times.push(update.deform + update.refit + start.seconds());
            }
        }
        figures.refitted = stats::median(&times);
        all.push(figures);
    }
    Ok(Sizes(all))
}

/// The balls of a cloth: at the same places of the sheet, whatever its vertices.
fn cases(asset: &Asset<'_>, side: usize) -> Result<Vec<Case>, Box<dyn Error>> {
    let modes = asset.mode_count();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut all = Vec::with_capacity(BALLS);
    for (i, q) in sequence(BALLS, modes, 0.8, 2)
        .chunks_exact(modes)
        .enumerate()
    {
        // Places of a lattice with irrational steps (Roberts 2018), off the cloth's border.
        let share = |step: f64| 0.1 + 0.8 * (0.5 + step * i as f64).fract();
        let [column, row] = [0.754_877_666, 0.569_840_291]
            .map(|step| (share(step) * (side - 1) as f64).round() as usize);
        let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
        let center = pose.deformed(VertexId((row * side + column) as u32))?;
        all.push(Case {
            q: q.to_vec(),
            center: center.map(|x| x as f32),
        });
    }
    Ok(all)
}

fn ours(
    asset: Asset<'_>,
    cases: &[Case],
    wanted: f64,
    repeats: usize,
) -> Result<Figures, Box<dyn Error>> {
    let triangles = asset.triangle_count();
    let mut ours = Ours::new(asset);
    // Contacts, nodes and seconds of all balls.
    let mut pass = |radius: f32| {
        let mut sums = [0.0; 3];
        for case in cases {
            let ball = (case.center.map(f64::from), f64::from(radius));
            let frame = ours::frame(|| ours.balls(&case.q, [ball].into_iter()));
            sums[0] += frame.found as f64;
            sums[1] += frame.nodes.visited as f64;
            sums[2] += frame.query;
        }
        sums.map(|sum| sum / cases.len() as f64)
    };
    // Contacts grow with the radius.
    let (mut low, mut high) = (0.0_f32, 1.0);
    let mut radius = 0.5;
    let [mut contacts, mut nodes] = [0.0; 2];
    for _ in 0..40 {
        radius = 0.5 * (low + high);
        [contacts, nodes, _] = pass(radius);
        if (contacts / wanted - 1.0).abs() < 0.01 {
            break;
        }
        if contacts < wanted {
            low = radius;
        } else {
            high = radius;
        }
    }
    if (contacts / wanted - 1.0).abs() > 0.05 {
        return Err(format!("{triangles} triangles: no radius gives {wanted} contacts").into());
    }
    let times: Vec<f64> = (0..repeats).map(|_| pass(radius)[2]).collect();
    Ok(Figures {
        triangles,
        radius,
        contacts,
        nodes,
        seconds: stats::median(&times),
        refitted: f64::NAN,
    })
}

impl Sizes {
    /// The exponent with which something grows with the number of triangles.
    fn exponent(&self, of: impl Fn(&Figures) -> f64) -> f64 {
        let logs = |of: &dyn Fn(&Figures) -> f64| -> Vec<f64> {
            self.0.iter().map(|f| of(f).ln()).collect()
        };
        slope(&logs(&|f| f.triangles as f64), &logs(&of))
    }

    pub(super) fn json(&self) -> Value {
        let row = |f: &Figures| -> Value {
            json!({"triangles": f.triangles, "radius": f.radius, "contacts": f.contacts,
                "nodes": f.nodes, "times": {"ours_us": 1e6 * f.seconds,
                "refit_us": 1e6 * f.refitted, "speedup": f.refitted / f.seconds}})
        };
        json!({"rows": self.0.iter().map(row).collect::<Vec<Value>>(),
            "exponent_nodes": self.exponent(|f| f.nodes),
            "times": {"exponent_ours": self.exponent(|f| f.seconds),
                "exponent_speedup": self.exponent(|f| f.refitted / f.seconds)}})
    }

    pub(super) fn table(&self) -> Table {
        let title = format!(
            "Over the size of a cloth with 12 modes, the ball so large that it touches as many triangles. Visited \
             nodes grow as F^{:.3}, time as F^{:.3}, the speed-up over deforming and refitting boxes as F^{:.2}.",
            self.exponent(|f| f.nodes),
            self.exponent(|f| f.seconds),
            self.exponent(|f| f.refitted / f.seconds)
        );
        Table::of(
            "",
            title,
            &self.0,
            &[
                ("triangles", &|f| f.triangles.into()),
                ("radius", &|f| f64::from(f.radius).into()),
                ("contacts", &|f| f.contacts.into()),
                ("nodes visited", &|f| f.nodes.into()),
                ("µs per ball", &|f| (1e6 * f.seconds).into()),
                ("deform + refit + query, µs", &|f| {
                    (1e6 * f.refitted).into()
                }),
                ("times faster", &|f| (f.refitted / f.seconds).into()),
            ],
        )
    }

    pub(super) fn chart(&self) -> Plot {
        let line = |name: &str, of: &dyn Fn(&Figures) -> f64| Line {
            name: name.to_string(),
            points: self.0.iter().map(|f| (f.triangles as f64, of(f))).collect(),
        };
        let lines = vec![
            line("ours, µs", &|f| 1e6 * f.seconds),
            line("ours, nodes visited", &|f| f.nodes),
            line("deform + refit + query, µs", &|f| 1e6 * f.refitted),
        ];
        let title = "A ball over the size of the mesh, equal contacts";
        Plot::new(
            title,
            &Axis::log("triangles"),
            &Axis::log("µs, or nodes"),
            lines,
        )
    }
}

/// The slope of the line of least squares.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let products = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y));
    products.sum::<f64>() / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slope_of_a_power() {
        let x: Vec<f64> = [1.0_f64, 3.0, 10.0, 40.0].iter().map(|x| x.ln()).collect();
        let y: Vec<f64> = x.iter().map(|x| 0.25 * x + 2.0).collect();
        assert!((slope(&x, &y) - 0.25).abs() < 1e-12);
    }
}
