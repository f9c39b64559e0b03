//! The paper's layered hierarchy as one of those who refit.

use bdtree_runtime::{Contact, PairContact};
use std::rc::Rc;

use super::{PairPeer, Peer, Target};
use crate::Place;
use crate::deform::Deformer;
use crate::paper_tree::{Between, Layered, PaperTree};

/// A body with spheres that enclose their children's.
#[derive(Debug, Clone)]
pub struct LayeredPeer {
    tree: Rc<PaperTree>,
    spheres: Layered,
    place: Place,
}

impl LayeredPeer {
    /// On the paper's tree of a body.
    pub fn new(tree: Rc<PaperTree>, deformer: &Deformer) -> Self {
        Self {
            spheres: Layered::new(&tree, deformer.count),
            tree,
            place: Place::IDENTITY,
        }
    }
}

impl Peer for LayeredPeer {
    fn update_with(&mut self, to: Target<'_>, _: &mut Vec<f32>, deformed: &mut dyn FnMut()) {
        to.deformer
            .deform(to.q, to.bones, &mut self.spheres.vertices);
        deformed();
        self.place = *to.place;
        self.spheres.refit(&self.tree, to.place);
    }

    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
        self.tree
            .walk_ball(&mut self.spheres, (center, radius), found);
    }

    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        self.tree.walk_ray(&mut self.spheres, origin, direction)
    }
}

impl PairPeer for LayeredPeer {
    fn pair(&mut self, other: &mut Self, found: &mut Vec<PairContact>) {
        let between = Between::new(&self.place, &other.place);
        PaperTree::walk_pair(
            (&self.tree, &mut self.spheres),
            (&other.tree, &mut other.spheres),
            &between,
            found,
        );
    }
}
