//! Numbers of all sorts, most of them allowed.

use bdtree_capi::types::*;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::shared::vec3;

/// Where they come from.
pub(super) struct Values {
    pub(super) rng: Pcg64Mcg,
}

impl Values {
    pub(super) fn number(&mut self) -> f64 {
        const SPECIAL: [f64; 8] = [
            0.0,
            -0.0,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e-310,
            1e300,
            f64::MAX,
        ];
        match self.rng.random_range(0..30) {
            special @ 0..8 => SPECIAL[special],
            _ => self.rng.random_range(-2.0..2.0),
        }
    }

    pub(super) fn length(&mut self) -> f64 {
        if self.rng.random_range(0..20) == 0 {
            self.number()
        } else {
            self.rng.random_range(0.0..1.5)
        }
    }

    pub(super) fn vec3(&mut self) -> BdtVec3 {
        // Mostly finite, so that queries are asked.
        if self.rng.random_range(0..10) == 0 {
            return vec3(self.number(), self.number(), self.number());
        }
        let mut x = || self.rng.random_range(-2.0..2.0);
        vec3(x(), x(), x())
    }

    pub(super) fn quat(&mut self) -> BdtQuat {
        let turns = [
            [0.0, 0.0, 0.0, 1.0],
            [0.6, 0.0, 0.8, 0.0],
            [0.5; 4],
            [0.1; 4],
        ];
        turns[self.rng.random_range(0..turns.len())].into()
    }

    pub(super) fn place(&mut self) -> BdtTransform {
        BdtTransform {
            rotation: self.quat(),
            translation: self.vec3(),
            scale: if self.rng.random_range(0..8) == 0 {
                self.number()
            } else {
                1.0
            },
        }
    }

    pub(super) fn ray(&mut self) -> BdtRay {
        BdtRay {
            origin: self.vec3(),
            direction: self.vec3(),
            max_distance: self.length(),
        }
    }

    pub(super) fn shape(&mut self) -> BdtShape {
        let (a, b, size, turn) = (self.vec3(), self.vec3(), self.length(), self.quat());
        match self.rng.random_range(0..5) {
            0 => bdt_ball(a, size),
            1 => bdt_capsule(a, b, size),
            2 => bdt_cuboid(a, turn, b),
            3 => bdt_half_space(a, size),
            _ => BdtShape {
                kind: self.rng.random(),
                ..bdt_ball(a, size)
            },
        }
    }

    pub(super) fn small(&mut self) -> u32 {
        match self.rng.random_range(0..12) {
            0 => u32::MAX,
            1 => self.rng.random(),
            _ => self.rng.random_range(0..9),
        }
    }

    pub(super) fn matrix(&mut self) -> BdtMatrix {
        BdtMatrix {
            rows: [
                [1.0, 0.0, 0.0, 0.1],
                [0.0, 1.0, 0.0, self.number()],
                [0.0, 0.0, 1.0, 0.0],
            ],
        }
    }
}
