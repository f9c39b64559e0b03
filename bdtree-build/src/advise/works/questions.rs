//! Where balls, rays and the second instance are.

use bdtree_runtime::{Asset, Pose, Ray, Transform, VertexId, Workspace};

use super::{BALL_RADIUS_REL, BALLS, Contender, RAYS, Works, WorksError, at_rest, poses};
use crate::advise::samples::Samples;
use crate::report::random::Random;
use crate::vec3::{bounds, cross, diagonal, dot, norm};

/// How far the second instance stands off, over the box's longest side: the first of these at which half of the
/// samples touch, else the one at which most do.
const APART: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.45, 0.3, 0.15, 0.05];

/// Its turn (rad), about an axis that is none of the box's, so that no faces are parallel.
const TURN_RAD: f64 = 0.2;
const TURN_AXIS: [f64; 3] = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];

pub(super) fn make(asset: &Asset<'_>, samples: &Samples) -> Result<Works, WorksError> {
    let space = Space::of(asset)?;
    let mut random = Random::new();
    let (mut balls, mut rays) = (Vec::new(), Vec::new());
    let mut memory = vec![0.0; asset.pose_len().max(1) * samples.count];
    let contender = Contender { asset, samples };
    for pose in poses(&contender, Transform::IDENTITY, &mut memory)? {
        let mut centers = [[0.0; 3]; BALLS];
        for center in &mut centers {
            *center = surface_point(&pose, &mut random)?;
        }
        balls.push(centers);
        let mut toward = [Ray::new([0.0; 3], [0.0, 0.0, 1.0]); RAYS];
        for ray in &mut toward {
            ray.origin = space.outside(direction(&mut random));
            let target = surface_point(&pose, &mut random)?;
            let way = [0, 1, 2].map(|k| target[k] - ray.origin[k]);
            // A body that reaches the ray's start exactly is asked along z.
            if way != [0.0; 3] {
                ray.direction = way;
            }
        }
        rays.push(toward);
    }
    Ok(Works {
        radius: BALL_RADIUS_REL * space.diagonal,
        balls,
        rays,
        beside: beside(contender, &space)?,
    })
}

/// The box around the rest positions of all triangles (mesh units).
struct Space {
    low: [f64; 3],
    high: [f64; 3],
    diagonal: f64,
}

impl Space {
    fn of(asset: &Asset<'_>) -> Result<Self, WorksError> {
        let (origin, unit) = (asset.origin(), asset.unit());
        let corners = asset.triangles().iter().flat_map(|t| t.corners);
        let at_rest = at_rest(asset)?;
        // Corners that are no vertices are met again, and named, where they are deformed.
        let positions = corners.filter_map(|corner| at_rest.get(corner as usize));
        let place = |p: &[f32; 3]| [0, 1, 2].map(|k| origin[k] + unit * f64::from(p[k]));
        let (low, high) = bounds(positions.map(place));
        Ok(Self {
            low,
            high,
            diagonal: diagonal((low, high)),
        })
    }

    fn center(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 0.5 * self.low[k] + 0.5 * self.high[k])
    }

    /// A point one diagonal from the center (one unit where all is one point).
    fn outside(&self, direction: [f64; 3]) -> [f64; 3] {
        let far = if self.diagonal > 0.0 {
            self.diagonal
        } else {
            1.0
        };
        let center = self.center();
        [0, 1, 2].map(|k| center[k] + far * direction[k])
    }

    /// Where the second instance stands: turned about the box's center, and off along the longest side.
    fn placed(&self, apart: f64) -> Transform {
        let side = [0, 1, 2].map(|k| self.high[k] - self.low[k]);
        let longest = (1..3).fold(0, |best, k| if side[k] > side[best] { k } else { best });
        let (sin, cos) = (0.5 * TURN_RAD).sin_cos();
        let rotation = [
            sin * TURN_AXIS[0],
            sin * TURN_AXIS[1],
            sin * TURN_AXIS[2],
            cos,
        ];
        let center = self.center();
        let turned = rotate(center);
        let mut translation = [0, 1, 2].map(|k| center[k] - turned[k]);
        translation[longest] += apart * side[longest];
        Transform {
            rotation,
            translation,
            scale: 1.0,
        }
    }
}

/// x turned by [`TURN_RAD`] about [`TURN_AXIS`] (Rodrigues).
fn rotate(x: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = TURN_RAD.sin_cos();
    let n = TURN_AXIS;
    let (along, across) = (dot(n, x), cross(n, x));
    [0, 1, 2].map(|k| cos * x[k] + sin * across[k] + (1.0 - cos) * along * n[k])
}

/// Evenly distributed over the unit sphere: a point of the ball, thrown until it is one, scaled.
fn direction(random: &mut Random) -> [f64; 3] {
    loop {
        let v = [(); 3].map(|()| 2.0 * random.unit() - 1.0);
        let length = norm(v);
        if (0.1..=1.0).contains(&length) {
            return v.map(|x| x / length);
        }
    }
}

/// The middle of one of the deformed triangles, each as likely as any other.
fn surface_point(pose: &Pose<'_>, random: &mut Random) -> Result<[f64; 3], WorksError> {
    let asset = pose.asset();
    let slot = random.bits() % (asset.triangle_count() as u64).max(1);
    let corners = asset.triangles().get(slot as usize).map(|t| t.corners);
    let mut middle = [0.0; 3];
    for corner in corners.into_iter().flatten() {
        let p = pose.deformed(VertexId(corner))?;
        middle = [0, 1, 2].map(|k| middle[k] + p[k] / 3.0);
    }
    Ok(middle)
}

fn beside(contender: Contender<'_>, space: &Space) -> Result<Transform, WorksError> {
    let (asset, count) = (contender.asset, contender.samples.count);
    let mut memory = [(); 2].map(|()| vec![0.0; asset.pose_len().max(1) * count]);
    let mut workspace = Workspace::new();
    let [here, there] = &mut memory;
    let here = poses(&contender, Transform::IDENTITY, here)?;
    let (mut best, mut most) = (space.placed(APART[0]), 0);
    for apart in APART {
        let transform = space.placed(apart);
        let there = poses(&contender, transform, there)?;
        let mut touching = 0;
        for (sample, pose) in here.iter().enumerate() {
            let other = &there[Works::partner(sample, count)];
            touching += usize::from(pose.against(other, &mut workspace).intersects()?);
        }
        if touching > most {
            (best, most) = (transform, touching);
        }
        if 2 * most >= count {
            break;
        }
    }
    Ok(best)
}
