//! Integrals over a body, and the mass properties that they make.

use super::{MassProperties, MassSource};

/// ∫ dm, ∫ x dm and ∫ x xᵀ dm, in units and about a point of the summer's choice.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Integrals {
    /// ∫ dm.
    pub whole: f64,
    /// ∫ x dm.
    pub first: [f64; 3],
    /// ∫ x xᵀ dm: xx yy zz xy xz yz.
    pub second: [f64; 6],
}

/// Where coordinates of integrals count from, and in what.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// In mesh units.
    pub about: [f64; 3],
    /// Mesh units.
    pub length: f64,
}

/// The products x xᵀ: xx yy zz xy xz yz.
pub(crate) fn products(a: [f64; 3], b: [f64; 3]) -> [f64; 6] {
    let mixed = |i: usize, j: usize| 0.5 * (a[i] * b[j] + a[j] * b[i]);
    [
        a[0] * b[0],
        a[1] * b[1],
        a[2] * b[2],
        mixed(0, 1),
        mixed(0, 2),
        mixed(1, 2),
    ]
}

impl Integrals {
    /// Adds the integrals of a part.
    pub(crate) fn add(&mut self, whole: f64, first: [f64; 3], second: [f64; 6]) {
        self.whole += whole;
        for (sum, x) in self.first.iter_mut().zip(first) {
            *sum += x;
        }
        for (sum, x) in self.second.iter_mut().zip(second) {
            *sum += x;
        }
    }

    /// Adds those of another part.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.add(other.whole, other.first, other.second);
    }

    /// The same of the body moved by `by`.
    pub(crate) fn moved(&self, by: [f64; 3]) -> Self {
        let (mixed, own) = (products(self.first, by), products(by, by));
        Self {
            whole: self.whole,
            first: std::array::from_fn(|a| self.first[a] + self.whole * by[a]),
            second: std::array::from_fn(|k| self.second[k] + 2.0 * mixed[k] + self.whole * own[k]),
        }
    }

    /// The center (mesh units), and the inertia about it (kg · mesh unit²) where `whole` weighs `mass_kg`.
    pub(crate) fn center_and_inertia(&self, frame: Frame, mass_kg: f64) -> ([f64; 3], [f64; 6]) {
        let mean = self.first.map(|x| x / self.whole);
        let center = std::array::from_fn(|a| frame.about[a] + frame.length * mean[a]);
        let of_center = products(mean, mean);
        let unit = mass_kg * frame.length * frame.length;
        let [xx, yy, zz, xy, xz, yz] =
            std::array::from_fn(|k| unit * (self.second[k] / self.whole - of_center[k]));
        // −0 where bodies are symmetric would only look odd.
        let off = |x: f64| 0.0 - x;
        (
            center,
            [yy + zz, xx + zz, xx + yy, off(xy), off(xz), off(yz)],
        )
    }

    /// The properties of a body of this volume and mass.
    pub(crate) fn properties(
        &self,
        frame: Frame,
        (mass_kg, volume): (f64, f64),
        (density_kg_m3, scale_m): (f64, f64),
        source: MassSource,
    ) -> MassProperties {
        let (center_of_mass, inertia) = self.center_and_inertia(frame, mass_kg);
        MassProperties {
            mass_kg,
            center_of_mass,
            inertia,
            density_kg_m3,
            scale_m,
            volume,
            source,
        }
    }
}

/// A sum that keeps what rounding takes (A. Neumaier, 1974).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() {
            (self.sum - sum) + x
        } else {
            (x - sum) + self.sum
        };
        self.sum = sum;
    }

    pub(crate) fn value(self) -> f64 {
        self.sum + self.lost
    }
}
