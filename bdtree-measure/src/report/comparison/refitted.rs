//! The contender: deforms all vertices, carries them by their bones, refits its tree and asks it. Questions and places are converted to its
//! coordinates before its time begins.

use crate::Body;
use crate::MeasureError;
use crate::deform::Deformer;
use crate::peers::{Obvhs, PairPeer, Peer, Target, Update};
use crate::place::{Place, matrix};
use bdtree_runtime::{Asset, Contact, PairContact, Transform};

use super::{Cost, Sample, timed};

/// An instance that is refitted, in stored units about the asset's origin.
pub(super) struct Contender {
    deformer: Deformer,
    tree: Obvhs,
    scratch: Vec<f32>,
    origin: [f64; 3],
    unit: f64,
}

impl Contender {
    pub(super) fn new(asset: &Asset<'_>) -> Result<Self, MeasureError> {
        let body = Body::of_asset(asset)?;
        Ok(Self {
            deformer: Deformer::new(&body),
            tree: Obvhs::new(&body),
            scratch: Vec::new(),
            origin: asset.origin(),
            unit: asset.unit(),
        })
    }

    /// Brings it up to date where the mesh stands; its parts timed.
    pub(super) fn update(&mut self, sample: &Sample) -> Update {
        let to = Target {
            deformer: &self.deformer,
            q: &sample.q,
            bones: &sample.maps,
            place: &Place::IDENTITY,
        };
        self.tree.update(to, &mut self.scratch)
    }

    /// The same without a clock.
    fn follow(&mut self, sample: &Sample, place: &Place) {
        let to = Target {
            deformer: &self.deformer,
            q: &sample.q,
            bones: &sample.maps,
            place,
        };
        self.tree.update_untimed(to, &mut self.scratch);
    }

    /// A step of so many balls.
    pub(super) fn balls(&mut self, sample: &Sample, amount: usize) -> Result<Cost, MeasureError> {
        let balls = sample.balls(amount);
        let balls: Vec<_> = balls
            .map(|(center, radius)| (self.point(center), radius / self.unit))
            .collect();
        let mut found: Vec<Contact> = Vec::new();
        timed(|| {
            self.follow(sample, &Place::IDENTITY);
            for (center, radius) in &balls {
                found.clear();
                self.tree.ball(*center, *radius, &mut found);
            }
            Ok(Cost::default())
        })
    }

    /// A step of so many rays.
    pub(super) fn rays(&mut self, sample: &Sample, amount: usize) -> Result<Cost, MeasureError> {
        let rays = sample.rays(amount);
        let rays: Vec<_> = rays
            .map(|[origin, along]| [self.point(origin), along].map(|v| v.map(|x| x as f32)))
            .collect();
        timed(|| {
            self.follow(sample, &Place::IDENTITY);
            for [origin, direction] in &rays {
                std::hint::black_box(self.tree.ray(*origin, *direction));
            }
            Ok(Cost::default())
        })
    }

    /// Two instances, the other one at a place of the sample's.
    pub(super) fn pair(
        &mut self,
        other: &mut Self,
        sample: &Sample,
        which: usize,
    ) -> Result<Cost, MeasureError> {
        let place = self.place(&sample.places[which]);
        let mut found: Vec<PairContact> = Vec::new();
        timed(|| {
            found.clear();
            self.follow(sample, &Place::IDENTITY);
            other.follow(sample, &place);
            self.tree.pair(&mut other.tree, &mut found);
            Ok(Cost {
                amount: found.len() as f64,
                ..Cost::default()
            })
        })
    }

    /// A point of the mesh in its coordinates.
    fn point(&self, x: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (x[k] - self.origin[k]) / self.unit)
    }

    /// A placement (mesh units, scale 1) in its coordinates.
    fn place(&self, transform: &Transform) -> Place {
        let rows = matrix(transform.rotation);
        let turned = rows.map(|row| (0..3).map(|k| row[k] * self.origin[k]).sum::<f64>());
        let t = [0, 1, 2].map(|k| turned[k] + transform.translation[k] - self.origin[k]);
        Place::new(transform.rotation, t.map(|x| x / self.unit))
    }
}
