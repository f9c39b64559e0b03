//! Chairs of a checkpoint, for others than the run that wrote it.

use std::error::Error;
use std::path::Path;

use bdtree_runtime::Model;
use clap::Parser;

use super::Arguments;
use super::scene::Chairs;
use crate::falling::checkpoint;

/// Which chairs a checkpoint must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Deformable,
    Rigid,
    /// Rigid ones, to go on with redundant updates.
    Redundant,
}

impl Chairs {
    /// The chairs of a checkpoint as they were, of an asset.
    ///
    /// # Errors
    /// A file that is no checkpoint, or one of other chairs.
    pub(crate) fn of_checkpoint(
        path: &Path,
        kind: Kind,
        model: &Model,
        threads: u16,
    ) -> Result<Self, Box<dyn Error>> {
        let settings = checkpoint::settings::<Self>(path)?;
        if settings.rigid != (kind != Kind::Deformable) {
            let [found, other] = match settings.rigid {
                true => ["rigid chairs", "chairs that deform"],
                false => ["chairs that deform", "rigid chairs"],
            };
            let why = format!("is of {found}: name one of {other}");
            return Err(format!("{}: {why}", path.display()).into());
        }
        let mut arguments = Arguments::try_parse_from(["chairs"])?;
        arguments.bodies = settings.bodies;
        arguments.level = Some(settings.level);
        arguments.rigid = settings.rigid;
        arguments.redundant_updates = kind == Kind::Redundant;
        arguments.options.seed = settings.seed;
        arguments.options.threads = threads;
        let mut chairs = Self::new(arguments, model.clone())?;
        checkpoint::read(path, &mut chairs)?;
        Ok(chairs)
    }
}
