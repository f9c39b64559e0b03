//! Where the picture is taken from.

use bdtree_runtime::Frustum;
use glam::{DVec3, Quat, Vec3};

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

    /// The camera that looks at `target` from there, a unit away.
    pub fn camera(&self, target: Vec3) -> Camera {
        Camera {
            eye: target + self.back(),
            target,
            up: self.up,
            fov_y_rad: FOV_Y_RAD,
        }
    }
}

/// Field of view of pictures: from far enough away that spheres look round.
pub(crate) const FOV_Y_RAD: f32 = 0.5;

/// The steepest look down or up.
const ELEVATION_MAX_DEG: f32 = 89.9;

impl Camera {
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

    /// From the eye through a point of a picture of `size` pixels, from the upper left corner: unit.
    pub fn toward(&self, [x, y]: [f32; 2], size: [u32; 2]) -> Vec3 {
        let [right, up, forward] = self.axes();
        let [width, height] = size.map(|n| n.max(1) as f32);
        let slope_per_pixel = 2.0 * (0.5 * self.fov_y_rad).tan() / height;
        let aside = right * (x - 0.5 * width) + up * (0.5 * height - y);
        unit(forward + aside * slope_per_pixel, forward)
    }

    /// What a picture of `size` pixels shows, in the world; the camera's own coordinates are relative to `origin`. It is
    /// a pixel larger at each edge, so that rounding leaves nothing out. Nothing if a coordinate is not finite.
    pub fn frustum(&self, size: [u32; 2], origin: [f64; 3]) -> Option<Frustum> {
        let [right, up, forward] = self.axes().map(|axis| axis.as_dvec3());
        let eye = self.eye.as_dvec3() + DVec3::from(origin);
        let slope = f64::from((0.5 * self.fov_y_rad).tan());
        let [width, height] = size.map(|n| f64::from(n.max(1)));
        let upper = slope * (1.0 + 2.0 / height);
        let side = slope * (width + 2.0) / height;
        let plane = |n: DVec3, before: f64| [n.x, n.y, n.z, -n.dot(eye) - before];
        Frustum::new(&[
            plane(forward * side + right, 0.0),
            plane(forward * side - right, 0.0),
            plane(forward * upper + up, 0.0),
            plane(forward * upper - up, 0.0),
            plane(forward, 0.999 * f64::from(self.near())),
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
    fn turning_moving_and_zooming_do_what_they_say() {
        let from = |azimuth, elevation| {
            let camera = ViewDirection::new(azimuth, elevation).camera(Vec3::ZERO);
            camera.at_distance(3.0)
        };
        let camera = from(10.0, 20.0);
        let turned = camera.orbited(30.0, -10.0);
        let there = from(40.0, 10.0);
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
    fn a_ray_through_a_pixel_meets_what_is_drawn_there() {
        let camera = ViewDirection::new(30.0, 20.0).camera(Vec3::new(1.0, 2.0, 3.0));
        let camera = camera.at_distance(5.0);
        let size = [640, 400];
        assert!(
            camera
                .toward([320.0, 200.0], size)
                .distance(camera.axes()[2])
                < 1e-6
        );
        for at in [[0.0, 0.0], [639.0, 17.5], [100.0, 399.0]] {
            let point = camera.eye + camera.toward(at, size) * 7.0;
            let seen = camera.project(point.into(), size).expect("in front");
            let apart = (seen[0] - at[0]).hypot(seen[1] - at[1]);
            assert!(apart < 1e-2, "{at:?}: {seen:?}");
        }
    }

    #[test]
    fn the_up_axis_is_up_and_orbits_turn_about_it() {
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
                direction.camera(Vec3::ZERO)
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
