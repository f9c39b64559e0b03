//! The questions, put to one asset.

use bdtree_runtime::{
    Asset, Contact, PairContact, PairStackEntry, Pose, RayHit, StackEntry, query,
};

use super::{RAYS, Work, Works, WorksError};

/// An asset that is posed at all samples, twice, with the memory that queries need.
pub(super) struct Asked<'a, 'p> {
    asset: &'a Asset<'a>,
    here: Vec<Pose<'p>>,
    beside: Vec<Pose<'p>>,
    stack: Vec<StackEntry>,
    pair_stack: Vec<PairStackEntry>,
    contacts: Vec<Contact>,
    hits: [Option<RayHit>; RAYS],
    pairs: Vec<PairContact>,
}

impl<'a, 'p> Asked<'a, 'p> {
    pub(super) fn new(asset: &'a Asset<'a>, here: Vec<Pose<'p>>, beside: Vec<Pose<'p>>) -> Self {
        Self {
            asset,
            here,
            beside,
            stack: vec![StackEntry::default(); asset.stack_len()],
            pair_stack: vec![PairStackEntry::default(); asset.pair_stack_len(asset)],
            contacts: Vec::new(),
            hits: [None; RAYS],
            pairs: Vec::new(),
        }
    }

    /// All questions: of balls, of rays, of pairs. `seconds` stay 0.
    pub(super) fn all(&mut self, works: &Works) -> Result<[Work; 3], WorksError> {
        Ok([
            self.one(works, 0)?,
            self.one(works, 1)?,
            self.one(works, 2)?,
        ])
    }

    /// All questions of one kind: 0 balls, 1 rays, 2 pairs.
    pub(super) fn one(&mut self, works: &Works, kind: usize) -> Result<Work, WorksError> {
        match kind {
            0 => self.balls(works),
            1 => self.rays(works),
            _ => self.touching(),
        }
    }

    fn balls(&mut self, works: &Works) -> Result<Work, WorksError> {
        let mut work = Work::default();
        for (pose, centers) in self.here.iter().zip(&works.balls) {
            for center in centers {
                self.contacts.clear();
                let (stack, contacts) = (&mut self.stack, &mut self.contacts);
                let outcome =
                    query::ball(self.asset, pose, *center, works.radius, stack, contacts)?;
                work.questions += 1;
                work.found += self.contacts.len() as u64;
                work.nodes_visited += outcome.nodes_visited;
            }
        }
        Ok(work)
    }

    fn rays(&mut self, works: &Works) -> Result<Work, WorksError> {
        let mut work = Work::default();
        for (pose, rays) in self.here.iter().zip(&works.rays) {
            let outcome = query::rays(self.asset, pose, rays, &mut self.stack, &mut self.hits)?;
            work.questions += RAYS as u64;
            work.found += self.hits.iter().flatten().count() as u64;
            work.nodes_visited += outcome.nodes_visited;
        }
        Ok(work)
    }

    fn touching(&mut self) -> Result<Work, WorksError> {
        let mut work = Work::default();
        for (sample, pose) in self.here.iter().enumerate() {
            let Some(other) = self.beside.get(Works::partner(sample, self.here.len())) else {
                continue;
            };
            self.pairs.clear();
            let (asset, stack) = (self.asset, &mut self.pair_stack);
            let outcome = query::pair((asset, pose), (asset, other), 0.0, stack, &mut self.pairs)?;
            work.questions += 1;
            work.found += self.pairs.len() as u64;
            work.nodes_visited += outcome.nodes_visited;
        }
        Ok(work)
    }
}
