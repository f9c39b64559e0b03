//! Where the picture is taken from.

use glam::{Quat, Vec3};

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box3 {
    /// Its lowest corner.
    pub low: [f32; 3],
    /// Its highest corner.
    pub high: [f32; 3],
}

impl Box3 {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    /// The box around points; those that are not finite are left out.
    pub fn around(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The box that holds this and a point.
    pub fn with(mut self, p: [f32; 3]) -> Self {
        if p.iter().all(|x| x.is_finite()) {
            for k in 0..3 {
                self.low[k] = self.low[k].min(p[k]);
                self.high[k] = self.high[k].max(p[k]);
            }
        }
        self
    }

    /// Its middle; 0 of an empty box.
    pub fn middle(&self) -> [f32; 3] {
        if self.low[0] > self.high[0] {
            return [0.0; 3];
        }
        [0, 1, 2].map(|k| 0.5 * self.low[k] + 0.5 * self.high[k])
    }

    /// Half its diagonal; 0 of an empty box.
    pub fn half_diagonal(&self) -> f32 {
        if self.low[0] > self.high[0] {
            return 0.0;
        }
        0.5 * Vec3::from(self.high).distance(self.low.into())
    }
}

/// A camera with perspective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// What it looks at: the middle of the picture.
    pub target: Vec3,
    /// What is up in the picture, unit, not along the line of sight.
    pub up: Vec3,
    /// Angle from the lower to the upper edge.
    pub fov_y_rad: f32,
}

/// From which side a picture is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewDirection {
    /// Degrees around the up axis. With y up, 0 looks from +z and 90 from +x.
    pub azimuth_deg: f32,
    /// Degrees above the ground, −90 to 90.
    pub elevation_deg: f32,
    /// The direction that points up in the picture, unit. The world is turned the shortest way until it is y, and
    /// −y about z: with z up, 0 looks from −y and 90 from +x.
    pub up: Vec3,
}

impl ViewDirection {
    /// With y up.
    pub fn new(azimuth_deg: f32, elevation_deg: f32) -> Self {
        Self {
            azimuth_deg,
            elevation_deg,
            up: Vec3::Y,
        }
    }

    /// From what is seen to the eye, unit.
    fn back(&self) -> Vec3 {
        let a = self.azimuth_deg.to_radians();
        let e = self
            .elevation_deg
            .clamp(-ELEVATION_MAX_DEG, ELEVATION_MAX_DEG);
        let e = e.to_radians();
        let with_y_up = Vec3::new(a.sin() * e.cos(), e.sin(), a.cos() * e.cos());
        Quat::from_rotation_arc(Vec3::Y, self.up) * with_y_up
    }
}

/// Field of view that [`Camera::around`] takes: far enough away that spheres look round.
const FOV_Y_RAD: f32 = 0.5;

/// The steepest look down or up.
const ELEVATION_MAX_DEG: f32 = 89.9;

impl Camera {
    /// A camera that sees all of a box in a picture of `aspect` (width over height), from a
    /// direction.
    pub fn around(bounds: &Box3, aspect: f32, direction: ViewDirection) -> Self {
        let corner = |i: usize| [0, 1, 2].map(|k| [bounds.low, bounds.high][i >> k & 1][k]);
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (corner(i), 0.0));
        Self::around_balls(&corners, aspect, direction)
    }

    /// [`Camera::around`] for balls, centers and radii given: it comes as near as they allow.
    pub fn around_balls(balls: &[([f32; 3], f32)], aspect: f32, direction: ViewDirection) -> Self {
        let ends = balls
            .iter()
            .flat_map(|(c, r)| [c.map(|x| x - r), c.map(|x| x + r)]);
        let bounds = Box3::around(ends);
        let mut camera = Self {
            eye: Vec3::Z,
            target: bounds.middle().into(),
            up: direction.up,
            fov_y_rad: FOV_Y_RAD,
        };
        let back = direction.back();
        camera.eye = camera.target + back;
        let [right, up, _] = camera.axes();
        let slope_y = (0.5 * FOV_Y_RAD).tan();
        let slope_x = slope_y * aspect.max(1e-3);
        let mut distance = 1e-3 * bounds.half_diagonal();
        for (center, radius) in balls {
            let p = Vec3::from(*center) - camera.target;
            // From how far away the ball is within the planes through the picture's edges.
            for (axis, slope) in [(right, slope_x), (up, slope_y)] {
                let aside = p.dot(axis).abs() + radius * (1.0 + slope * slope).sqrt();
                // What is not a number is not larger.
                distance = distance.max(p.dot(back) + aside / slope);
            }
        }
        if !(distance > 0.0 && distance.is_finite()) {
            distance = 1.0;
        }
        camera.eye = camera.target + back * distance;
        camera
    }

    /// The camera turned around its target, by degrees around its up axis and above the ground.
    #[must_use]
    pub fn orbited(&self, azimuth_deg: f32, elevation_deg: f32) -> Self {
        let away = self.eye - self.target;
        let distance = away.length();
        let height = away.dot(self.up);
        let flat = unit(away - self.up * height, Vec3::Z);
        let flat = Quat::from_axis_angle(self.up, azimuth_deg.to_radians()) * flat;
        let most = ELEVATION_MAX_DEG.to_radians();
        let sine = (height / distance.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0);
        let elevation = (sine.asin() + elevation_deg.to_radians()).clamp(-most, most);
        let back = flat * elevation.cos() + self.up * elevation.sin();
        Self {
            eye: self.target + back * distance,
            ..*self
        }
    }

    /// The camera at `factor` times the distance from its target.
    #[must_use]
    pub fn at_distance(&self, factor: f32) -> Self {
        Self {
            eye: self.target + (self.eye - self.target) * factor,
            ..*self
        }
    }

    /// The camera and its target moved by parts of the picture's height, right and up.
    #[must_use]
    pub fn moved(&self, right: f32, up: f32) -> Self {
        let [x, y, _] = self.axes();
        let height = 2.0 * self.distance() * (0.5 * self.fov_y_rad).tan();
        let by = x * (right * height) + y * (up * height);
        Self {
            eye: self.eye + by,
            target: self.target + by,
            ..*self
        }
    }

    /// Where a point is in a picture of `size` pixels, from the upper left corner; `None` behind the camera.
    pub fn project(&self, point: [f32; 3], size: [u32; 2]) -> Option<[f32; 2]> {
        let [right, up, forward] = self.axes();
        let d = Vec3::from(point) - self.eye;
        let depth = d.dot(forward);
        if !(depth > 0.0) {
            return None;
        }
        let [width, height] = size.map(|n| n as f32);
        let per_slope = 0.5 * height / (0.5 * self.fov_y_rad).tan();
        Some([
            0.5 * width + d.dot(right) / depth * per_slope,
            0.5 * height - d.dot(up) / depth * per_slope,
        ])
    }

    /// From eye to target.
    pub fn distance(&self) -> f32 {
        (self.eye - self.target).length()
    }

    /// Right, up and forward of the picture, unit.
    pub fn axes(&self) -> [Vec3; 3] {
        let forward = unit(self.target - self.eye, Vec3::NEG_Z);
        let right = unit(forward.cross(self.up), Vec3::X);
        [right, right.cross(forward), forward]
    }

    /// The distance before which nothing is seen.
    pub(crate) fn near(&self) -> f32 {
        1e-3 * self.distance()
    }
}

fn unit(v: Vec3, otherwise: Vec3) -> Vec3 {
    let n = v.length();
    if n > 0.0 && n.is_finite() {
        v * (1.0 / n)
    } else {
        otherwise
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_seen_whole_and_fills_the_picture() {
        let bounds = Box3 {
            low: [-3.0, 10.0, -1.0],
            high: [5.0, 11.0, 7.0],
        };
        for (azimuth, elevation) in [(0.0, 0.0), (35.0, 20.0), (-120.0, 80.0), (200.0, -90.0)] {
            for size in [[400, 300], [300, 900]] {
                let aspect = size[0] as f32 / size[1] as f32;
                let direction = ViewDirection::new(azimuth, elevation);
                let camera = Camera::around(&bounds, aspect, direction);
                let mut nearest_edge = f32::INFINITY;
                for corner in 0..8 {
                    let p = [0, 1, 2].map(|k| [bounds.low, bounds.high][corner >> k & 1][k]);
                    let [x, y] = camera.project(p, size).expect("in front");
                    for (x, n) in [(x, size[0]), (y, size[1])] {
                        assert!(x > -0.1 && x < n as f32 + 0.1, "{azimuth} {elevation} {x}");
                        nearest_edge = nearest_edge.min(x).min(n as f32 - x);
                    }
                }
                assert!(nearest_edge < 0.5, "{nearest_edge} pixels are left");
            }
        }
    }

    #[test]
    fn balls_are_seen_whole_and_fill_the_picture() {
        let balls = [
            ([1.0, 2.0, 3.0], 0.5),
            ([-1.0, 2.5, 2.0], 1.0),
            ([0.0, 4.0, 0.0], 0.1),
        ];
        let size = [400, 300];
        let camera = Camera::around_balls(&balls, 4.0 / 3.0, ViewDirection::new(25.0, 10.0));
        // Points of each ball where it is seen widest: nothing beyond the edge, something at it.
        let mut nearest_edge = f32::INFINITY;
        for (center, radius) in balls {
            for i in 0..64 * 64 {
                let (a, b) = ((i / 64) as f32 * 0.0982, (i % 64) as f32 * 0.0491 - 1.571);
                let ray = [a.cos() * b.cos(), b.sin(), a.sin() * b.cos()];
                let p = Vec3::from(center) + Vec3::from(ray) * radius;
                let [x, y] = camera.project(p.into(), size).expect("in front");
                for (x, n) in [(x, size[0]), (y, size[1])] {
                    nearest_edge = nearest_edge.min(x).min(n as f32 - x);
                }
            }
        }
        assert!(nearest_edge > -0.05 && nearest_edge < 1.0, "{nearest_edge}");
    }

    #[test]
    fn turning_moving_and_zooming_do_what_they_say() {
        let bounds = Box3::around([[-1.0; 3], [1.0; 3]]);
        let camera = Camera::around(&bounds, 1.0, ViewDirection::new(10.0, 20.0));
        let same = Camera::around(&bounds, 1.0, ViewDirection::new(0.0, 0.0));
        assert_eq!(camera.target, same.target);
        let turned = camera.orbited(30.0, -10.0);
        let there = Camera::around(&bounds, 1.0, ViewDirection::new(40.0, 10.0));
        let toward = |c: &Camera| (c.eye - c.target) / c.distance();
        for k in 0..3 {
            assert!((toward(&turned)[k] - toward(&there)[k]).abs() < 1e-5);
        }
        assert!((camera.at_distance(0.5).distance() / camera.distance() - 0.5).abs() < 1e-5);
        let before = camera.project([0.0; 3], [100, 100]).expect("in front");
        let after = camera
            .moved(0.1, 0.2)
            .project([0.0; 3], [100, 100])
            .expect("in front");
        assert!((before[0] - after[0] - 10.0).abs() < 1e-2);
        assert!((after[1] - before[1] - 20.0).abs() < 1e-2);
    }

    #[test]
    fn the_up_axis_is_up_and_orbits_turn_about_it() {
        let bounds = Box3::around([[-1.0; 3], [1.0; 3]]);
        // From the front: what points up, right and to the eye.
        let fronts = [
            [Vec3::Y, Vec3::X, Vec3::Z],
            [Vec3::NEG_Y, Vec3::NEG_X, Vec3::Z],
            [Vec3::Z, Vec3::X, Vec3::NEG_Y],
            [Vec3::NEG_Z, Vec3::X, Vec3::Y],
            [Vec3::X, Vec3::NEG_Y, Vec3::Z],
            [Vec3::NEG_X, Vec3::Y, Vec3::Z],
        ];
        let is_near = |a: Vec3, b: Vec3| a.distance(b) < 1e-5;
        for [up, right, eye] in fronts {
            let from = |azimuth_deg, elevation_deg| {
                let direction = ViewDirection {
                    azimuth_deg,
                    elevation_deg,
                    up,
                };
                Camera::around(&bounds, 1.0, direction)
            };
            let front = from(0.0, 0.0);
            let [x, y, forward] = front.axes();
            assert!(
                is_near(x, right) && is_near(y, up) && is_near(forward, -eye),
                "{up}"
            );
            let side = from(90.0, 0.0);
            assert!(is_near(side.axes()[2], -right), "{up}");
            let turned = front.orbited(40.0, 25.0).axes();
            let there = from(40.0, 25.0).axes();
            assert!((0..3).all(|k| is_near(turned[k], there[k])), "{up}");
        }
    }
}
