//! What a bound is at one pose: a ball, a box, a slab, or several of them at once.

use nalgebra::{Isometry3, Matrix3, Vector3};

/// A ball.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre.
    pub centre: Vector3<f64>,
    /// Its radius.
    pub radius: f64,
}

/// A box with any axes.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    /// Its centre.
    pub centre: Vector3<f64>,
    /// Its unit axes, as columns.
    pub axes: Matrix3<f64>,
    /// Half extents along them.
    pub half: Vector3<f64>,
}

/// The points x with |n·x − middle| ≤ half.
#[derive(Debug, Clone, Copy)]
pub struct Slab {
    /// n, of any length.
    pub normal: Vector3<f64>,
    /// n·x of its middle plane.
    pub middle: f64,
    /// Half its thickness times ‖n‖.
    pub half: f64,
}

/// The meet of what is there.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// A ball.
    pub ball: Option<Ball>,
    /// A box.
    pub cuboid: Option<Cuboid>,
    /// A slab of the lane's own.
    pub slab: Option<Slab>,
    /// Lower and upper ends along the body's fixed directions; none where the bound has none.
    pub ranges: Vec<[f64; 2]>,
}

impl Cuboid {
    /// The box with the coordinate axes around it.
    pub fn hull(&self) -> Self {
        Self {
            centre: self.centre,
            axes: Matrix3::identity(),
            half: self.axes.abs() * self.half,
        }
    }
}

impl Shape {
    /// The shape in another frame; ranges stay those of the body's own.
    pub fn moved(&self, place: &Isometry3<f64>) -> Self {
        let turn = place.rotation.to_rotation_matrix();
        Self {
            ball: self.ball.map(|ball| Ball {
                centre: place * nalgebra::Point3::from(ball.centre) - nalgebra::Point3::origin(),
                radius: ball.radius,
            }),
            cuboid: self.cuboid.map(|cuboid| Cuboid {
                centre: turn * cuboid.centre + place.translation.vector,
                axes: turn * cuboid.axes,
                half: cuboid.half,
            }),
            slab: self.slab.map(|slab| {
                let normal = turn * slab.normal;
                Slab {
                    normal,
                    middle: slab.middle + normal.dot(&place.translation.vector),
                    half: slab.half,
                }
            }),
            ranges: self.ranges.clone(),
        }
    }

    /// How far a point lies outside, over the size of what it lies outside of; 0 inside.
    pub fn excess(&self, point: &Vector3<f64>, directions: &[Vector3<f64>]) -> f64 {
        let mut worst = 0.0_f64;
        if let Some(ball) = self.ball {
            worst = worst.max(((point - ball.centre).norm() - ball.radius) / ball.radius);
        }
        if let Some(cuboid) = self.cuboid {
            let local = cuboid.axes.tr_mul(&(point - cuboid.centre)).abs() - cuboid.half;
            worst = worst.max(local.max() / cuboid.half.max());
        }
        if let Some(slab) = self.slab {
            let size = slab.half + slab.normal.norm();
            worst = worst.max(((slab.normal.dot(point) - slab.middle).abs() - slab.half) / size);
        }
        for (range, n) in self.ranges.iter().zip(directions) {
            let size = range[1] - range[0] + 1.0;
            let out = (n.dot(point) - range[1]).max(range[0] - n.dot(point));
            worst = worst.max(out / size);
        }
        worst
    }
}
