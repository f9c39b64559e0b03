//! The questions, put to one asset.

use bdtree_runtime::{Ball, Contact, PairContact, Pose, RayIntersection, Workspace};

use super::{RAYS, Work, Works, WorksError};

/// An asset that is posed at all samples, twice, with the memory that queries need.
pub(super) struct Asked<'p> {
    here: Vec<Pose<'p>>,
    beside: Vec<Pose<'p>>,
    workspace: Workspace<'static>,
    contacts: Vec<Contact>,
    hits: [Option<RayIntersection>; RAYS],
    pairs: Vec<PairContact>,
}

impl<'p> Asked<'p> {
    pub(super) fn new(here: Vec<Pose<'p>>, beside: Vec<Pose<'p>>) -> Self {
        Self {
            here,
            beside,
            workspace: Workspace::new(),
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
                let ball = Ball::new(*center, works.radius);
                let mut query = pose.query(&mut self.workspace);
                query.contacts(ball, &mut self.contacts)?;
                work.questions += 1;
                work.found += self.contacts.len() as u64;
                work.nodes_visited += self.workspace.stats().nodes_visited;
            }
        }
        Ok(work)
    }

    fn rays(&mut self, works: &Works) -> Result<Work, WorksError> {
        let mut work = Work::default();
        for (pose, rays) in self.here.iter().zip(&works.rays) {
            let mut query = pose.query(&mut self.workspace);
            query.cast_rays(rays, &mut self.hits)?;
            work.questions += RAYS as u64;
            work.found += self.hits.iter().flatten().count() as u64;
            work.nodes_visited += self.workspace.stats().nodes_visited;
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
            let mut query = pose.against(other, &mut self.workspace);
            query.contacts(0.0, &mut self.pairs)?;
            work.questions += 1;
            work.found += self.pairs.len() as u64;
            work.nodes_visited += self.workspace.stats().nodes_visited;
        }
        Ok(work)
    }
}
