//! The rounding slack: how much larger spheres are than their formula says.

use bdtree_format::ROW_RADIUS;
use bdtree_runtime::{Asset, FormatError, Transform};
use rand::RngExt;

use super::poses::HardPoses;

/// q that are tried.
const POSES: u64 = 8;

/// The mean of what radii have beyond `√(R² + 2 Σ b_j |q_j| + s²)` (docs/design/guarantees.md; formed in
/// f64 at the given q), over the mean radius: slack, what rounding q to whole numbers adds, and
/// the guard under the root. All spheres, at q spread evenly over ± `q_range`.
///
/// # Errors
/// As [`run`](super::run).
pub fn rounding_slack(asset: &Asset<'_>, seed: u64) -> Result<f64, FormatError> {
    let mut poses = HardPoses::new(*asset, seed, u64::MAX);
    let mut memory = vec![0.0; asset.pose_len()];
    let (mut total, mut added) = (0.0, 0.0);
    for _ in 0..POSES {
        let mut q: Vec<f32> = asset.modes().iter().map(|m| m.q_range.get()).collect();
        q.iter_mut()
            .for_each(|q| *q *= poses.rng().random_range(-1.0..=1.0_f32));
        poses.clamp(&mut q);
        let Ok(pose) = asset.pose(&q, Transform::IDENTITY, &mut memory) else {
            continue; // only q beyond the limits is refused
        };
        for (i, node) in (0..).zip(asset.nodes()) {
            let spheres = pose.node_spheres(i)?;
            let (rows, modes) = (asset.node_rows(node)?, asset.node_modes(node)?);
            for lane in node.lanes() {
                if asset.has_skin() {
                    // What bones do to a radius is no formula of the rows alone.
                    total += f64::from(spheres.radius[lane]);
                    added += pose.slack() / asset.unit();
                    continue;
                }
                let rest = f64::from(rows.leading[ROW_RADIUS][lane]);
                let (mut growth, mut cross) = (0.0, 0.0);
                for (k, mode) in modes.iter().enumerate() {
                    let mode = usize::from(*mode);
                    let share = f64::from(q[mode]) / f64::from(asset.modes()[mode].q_limit.get());
                    let [.., r, plus, minus] = rows.numbers(k, lane).map(f64::from);
                    let b = if share > 0.0 { plus } else { minus };
                    growth += r * f64::from(rows.units[1]) * share.abs();
                    cross += b * f64::from(rows.units[2]) * share.abs();
                }
                let radius = f64::from(spheres.radius[lane]);
                let square = rest * rest + 2.0 * cross + growth * growth;
                total += radius;
                added += radius - square.max(0.0).sqrt();
            }
        }
    }
    Ok(if total > 0.0 { added / total } else { 0.0 })
}
