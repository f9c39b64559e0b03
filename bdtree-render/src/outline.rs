//! Outlines: where an eye sees shapes end.

use std::f32::consts::TAU;

use glam::Vec3;

/// Straight parts of a circle.
const PARTS: usize = 96;

/// The circle where an eye's lines of sight touch a ball, as lines; none from within it.
pub fn ball_outline(center: [f32; 3], radius: f32, eye: Vec3) -> Vec<[[f32; 3]; 2]> {
    let center = Vec3::from(center);
    let to_eye = eye - center;
    let share = radius / to_eye.length();
    if !(share > 0.0 && share < 1.0) {
        return Vec::new();
    }
    let normal = to_eye.normalize();
    let (x, y) = normal.any_orthonormal_pair();
    let middle = center + normal * (radius * share);
    let across = radius * (1.0 - share * share).sqrt();
    let at = |k: usize| {
        let (s, c) = (TAU * k as f32 / PARTS as f32).sin_cos();
        (middle + (x * c + y * s) * across).to_array()
    };
    (0..PARTS).map(|k| [at(k), at(k + 1)]).collect()
}

/// The outlines of a capsule's two balls and the lines along its sides.
pub fn capsule_outline(ends: [[f32; 3]; 2], radius: f32, eye: Vec3) -> Vec<[[f32; 3]; 2]> {
    let mut lines: Vec<_> = ends
        .into_iter()
        .flat_map(|end| ball_outline(end, radius, eye))
        .collect();
    let [a, b] = ends.map(Vec3::from);
    let side = (b - a).cross(eye - a.midpoint(b));
    if let Some(side) = side.try_normalize() {
        lines.extend([-radius, radius].map(|r| [a, b].map(|end| (end + side * r).to_array())));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_sight_touch_a_ball_at_its_outline() {
        let (center, radius, eye) = ([1.0, 2.0, 3.0], 0.5, Vec3::new(4.0, 2.5, 2.0));
        let lines = ball_outline(center, radius, eye);
        assert_eq!(lines.len(), PARTS);
        let center = Vec3::from(center);
        for p in lines.iter().flatten().map(|p| Vec3::from(*p)) {
            assert!((p.distance(center) - radius).abs() < 1e-5, "{p}");
            assert!((p - center).dot(p - eye).abs() < 1e-5, "{p}");
        }
        assert!(
            ball_outline(center.into(), 4.0, eye).is_empty(),
            "the eye is in it"
        );
        assert!(ball_outline(center.into(), f32::NAN, eye).is_empty());
    }

    #[test]
    fn a_capsule_has_two_ends_and_two_sides() {
        let eye = Vec3::Z * 9.0;
        let ends = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let lines = capsule_outline(ends, 0.5, eye);
        assert_eq!(lines.len(), 2 * PARTS + 2);
        for k in [0, 1] {
            let heights = lines[2 * PARTS + k].map(|[_, y, _]| y);
            assert!(
                heights.iter().all(|y| (y.abs() - 0.5).abs() < 1e-6),
                "{heights:?}"
            );
        }
        let ball = capsule_outline([[0.0; 3]; 2], 0.5, eye);
        assert_eq!(ball.len(), 2 * PARTS, "a ball has no sides");
    }
}
