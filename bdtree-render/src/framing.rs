//! Where a camera stands to see all of something, as near as that allows.

use glam::{DVec3, Vec3};

use crate::camera::{Camera, FOV_Y_RAD, ViewDirection};
use crate::place::Place;

/// Part of the half width and of the half height that stays empty at each edge.
const MARGIN: f64 = 0.04;

/// Slopes per axis: for each k of them the k-th part of that of the picture's edge.
const STEPS: usize = 8;

/// What a picture has to hold, as seen from a direction: held ball by ball (world), then seen by its camera.
///
/// A ball of radius r at distances x right, y up and z back of the origin is between the planes through the left
/// and the right edge when both s + D·t ≥ x + z·t + r√(1+t²) and −s + D·t ≥ −x + z·t + r√(1+t²), where the eye is
/// at s and D, and t is the planes' slope. So the largest right sides of both are all there is to keep,
/// and the two of y: they give the nearest eye. Seen from there, what does not reach both planes lies between two of a
/// smaller slope: these are kept, too, and give the s at which it has as much room on either side.
#[derive(Debug, Clone)]
pub struct Framing {
    direction: ViewDirection,
    /// Right and up of the picture, and back, unit.
    axes: [DVec3; 3],
    /// Parts of the slopes of the planes through the picture's edges, less the margin: right and left, upper and
    /// lower; each with √(1+t²).
    slopes: [[[f64; 2]; STEPS]; 2],
    /// The largest right sides, along and against each axis, for each of them.
    reaches: [[[f64; 2]; STEPS]; 2],
    /// Of all balls, along back.
    depths: [f64; 2],
}

impl Framing {
    /// Nothing yet, in a picture of `aspect` (width over height).
    pub fn new(direction: ViewDirection, aspect: f32) -> Self {
        let [right, up, forward] = direction.camera(Vec3::ZERO).axes();
        let slope = (1.0 - MARGIN) * f64::from(0.5 * FOV_Y_RAD).tan();
        Self {
            direction,
            axes: [right, up, -forward].map(|axis| axis.as_dvec3()),
            slopes: [slope * f64::from(aspect.max(1e-3)), slope].map(parts),
            reaches: [[[f64::NEG_INFINITY; 2]; STEPS]; 2],
            depths: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Holds a ball; radius 0: a point. What is not finite is left out.
    pub fn hold(&mut self, center: [f64; 3], radius: f64) {
        let center = DVec3::from(center);
        if !(center.is_finite() && radius.is_finite()) {
            return;
        }
        let [right, up, back] = self.axes;
        let depth = center.dot(back);
        self.depths[0] = self.depths[0].min(depth - radius);
        self.depths[1] = self.depths[1].max(depth + radius);
        for (k, axis) in [right, up].into_iter().enumerate() {
            let aside = center.dot(axis);
            let slopes = self.slopes[k].iter();
            for ([slope, secant], [along, against]) in slopes.zip(&mut self.reaches[k]) {
                let rest = depth * slope + radius * secant;
                *along = along.max(rest + aside);
                *against = against.max(rest - aside);
            }
        }
    }

    /// The nearest D between planes of a part of an axis' slope, and its s.
    fn between(&self, axis: usize, i: usize) -> [f64; 2] {
        let [along, against] = self.reaches[axis][i];
        let distance = 0.5 * (along + against) / self.slopes[axis][i][0];
        [distance, 0.5 * (along - against)]
    }

    /// The s at which there is as much room on either side of what is seen from D.
    fn centered(&self, axis: usize, distance: f64) -> f64 {
        let all = (0..STEPS).map(|i| self.between(axis, i));
        // The smaller the slope, the farther away.
        let (far, near): (Vec<_>, Vec<_>) = all.partition(|[d, _]| *d > distance);
        match (far.last(), near.first()) {
            (Some([far, a]), Some([near, b])) if far > near => {
                b + (a - b) * (distance - near) / (far - near)
            }
            (_, Some([_, s])) | (Some([_, s]), None) => *s,
            (None, None) => 0.0,
        }
    }

    /// The camera that sees all of it, in drawn units. It looks at the middle of the depths.
    pub fn camera(&self, place: &Place) -> Camera {
        let [near, far] = [self.depths[1], self.depths[0]];
        if far > near {
            return self.direction.camera(Vec3::ZERO);
        }
        let middle = 0.5 * near + 0.5 * far;
        // A line straight ahead has no width, a point no size at all: the eye stays before them.
        let mut distance = (near + 1e-3 * (near - far)).max(middle + 1e-3 * place.size);
        let [right, up, back] = self.axes;
        let mut aside = DVec3::ZERO;
        for k in 0..2 {
            distance = distance.max(self.between(k, STEPS - 1)[0]);
        }
        for (k, axis) in [right, up].into_iter().enumerate() {
            aside += axis * self.centered(k, distance);
        }
        let at = |depth: f64| place.shown((aside + back * depth).to_array()).into();
        Camera {
            eye: at(distance),
            target: at(middle),
            ..self.direction.camera(Vec3::ZERO)
        }
    }
}

/// Parts of a slope, the last one whole, and √(1+t²) of each.
fn parts(slope: f64) -> [[f64; 2]; STEPS] {
    std::array::from_fn(|i| {
        let slope = slope * (i + 1) as f64 / STEPS as f64;
        [slope, (1.0 + slope * slope).sqrt()]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Place = Place {
        middle: [0.0; 3],
        size: 1.0,
    };

    /// The smallest and largest x and y of all points of balls in a picture.
    fn seen(camera: &Camera, balls: &[([f64; 3], f64)], size: [u32; 2]) -> [[f32; 2]; 2] {
        let mut seen = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
        for (center, radius) in balls {
            for i in 0..64 * 64 {
                let (a, b) = ((i / 64) as f64 * 0.0982, (i % 64) as f64 * 0.0491 - 1.571);
                let ray = [a.cos() * b.cos(), b.sin(), a.sin() * b.cos()];
                let p = [0, 1, 2].map(|k| (center[k] + ray[k] * radius) as f32);
                let at = camera.project(p, size).expect("in front");
                for k in 0..2 {
                    seen[0][k] = seen[0][k].min(at[k]);
                    seen[1][k] = seen[1][k].max(at[k]);
                }
            }
        }
        seen
    }

    #[test]
    fn all_is_seen_and_fills_the_picture_up_to_the_margin() {
        let corners = [-3.0, 5.0].iter().flat_map(|x| {
            [10.0, 11.0]
                .into_iter()
                .flat_map(move |y| [-1.0, 7.0].map(|z| ([*x, y, z], 0.0)))
        });
        let corners: Vec<_> = corners.collect();
        let balls = [
            ([1.0, 2.0, 3.0], 0.5),
            ([-1.0, 2.5, 2.0], 1.0),
            ([0.0, 4.0, 0.0], 0.1),
        ];
        let sides = [(0.0, 0.0), (35.0, 20.0), (-120.0, 80.0), (200.0, -90.0)];
        for content in [&corners[..], &balls] {
            for (side, size) in sides
                .iter()
                .flat_map(|s| [(s, [400, 300]), (s, [300, 900])])
            {
                let direction = ViewDirection::new(side.0, side.1);
                let mut framing = Framing::new(direction, size[0] as f32 / size[1] as f32);
                for (center, radius) in content {
                    framing.hold(*center, *radius);
                }
                let [low, high] = seen(&framing.camera(&UNIT), content, size);
                let part = |k: usize| (high[k] - low[k]) / size[k] as f32;
                let margin = |k: usize| low[k].min(size[k] as f32 - high[k]) / size[k] as f32;
                let edge = MARGIN as f32 / 2.0;
                assert!(
                    margin(0) > edge - 2e-3 && margin(1) > edge - 2e-3,
                    "{side:?} {size:?}"
                );
                let fill = part(0).max(part(1));
                for k in 0..2 {
                    let room = [low[k], size[k] as f32 - high[k]];
                    let off = (room[0] - room[1]).abs() / size[k] as f32;
                    assert!(off < 0.01, "{side:?} {size:?}: {room:?}");
                }
                assert!(
                    (fill - (1.0 - MARGIN as f32)).abs() < 3e-3,
                    "{side:?} {size:?}: {fill}"
                );
            }
        }
    }

    #[test]
    fn what_has_no_size_and_what_is_no_number_has_a_camera_too() {
        let camera = |points: &[[f64; 3]]| {
            let mut framing = Framing::new(ViewDirection::new(0.0, 0.0), 1.5);
            for p in points {
                framing.hold(*p, 0.0);
            }
            framing.camera(&UNIT)
        };
        assert_eq!(
            camera(&[]),
            camera(&[[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]])
        );
        for points in [
            &[][..],
            &[[3.0, 2.0, 1.0]],
            &[[0.0, 0.0, -1.0], [0.0, 0.0, 4.0]],
        ] {
            let camera = camera(points);
            assert!(
                camera.eye.is_finite() && camera.distance() > 0.0,
                "{points:?}"
            );
            for p in points {
                let p = p.map(|x| x as f32);
                assert!(camera.project(p, [300, 200]).is_some(), "{points:?}");
            }
        }
    }
}
