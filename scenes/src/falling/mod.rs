//! What programs of falling bodies share (`chairs`, `fish`): a `Scene` says what there is,
//! `run` steps it, keeps it and tells of it.
//!
//! | file | part |
//! |---|---|
//! | `options` | the options that all of them have |
//! | `run` | step after step, with all that is written meanwhile |
//! | `waves` | where and when bodies begin to fall |
//! | `checkpoint` | a run's state as a file, and going on from there |
//! | `check` | contacts against brute force |
//! | `log` | what every step did, and the sums |
//! | `report` | the figures of a run |
//! | `show` | pictures |
//! | `progress` | the time left |

pub(crate) mod check;
pub(crate) mod checkpoint;
pub(crate) mod log;
mod options;
mod progress;
pub(crate) mod report;
mod run;
pub(crate) mod show;
pub(crate) mod waves;

use std::error::Error;
use std::fmt::Debug;
use std::path::PathBuf;

use bdtree_dynamics::{BodyId, LevelSpheres, World};
use bdtree_runtime::{Model, Transform};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::report::Row;
use log::{Log, Numbers};
use show::{Show, View};

pub use options::Options;
pub(crate) use run::run;

/// A world in which bodies of one kind fall; there may be others, which are there from the beginning and come first.
pub(crate) trait Scene: Sized {
    /// The program's, which its files begin with.
    const NAME: &'static str;

    /// Steps from a film's picture to the next, of which 30 are a second.
    const STEPS_PER_FRAME: u64;

    /// What must be the same in a run that goes on from a checkpoint.
    type Settings: Debug + PartialEq + Serialize + DeserializeOwned;

    /// Columns of the steps' table that other programs do not have.
    type Own: Numbers;

    fn world(&self) -> &World;

    fn world_mut(&mut self) -> &mut World;

    fn settings(&self) -> Self::Settings;

    /// Bodies that fall in the end.
    fn count(&self) -> usize;

    /// Those that fall already; they are the last ones of the world.
    fn fallen(&self) -> usize;

    /// Adds a body that falls. Where the world is restored afterwards, its place does not matter.
    fn add(&mut self, at: Transform) -> Result<(), Box<dyn Error>>;

    /// The bodies that begin to fall before the step to come.
    fn due(&self) -> Result<Vec<Transform>, Box<dyn Error>>;

    /// Before each step: moves and pushes what the scene itself does.
    fn drive(&mut self) -> Result<(), Box<dyn Error>> {
        Ok(())
    }

    /// Contact spheres of the bodies that fall.
    fn spheres(&self) -> &LevelSpheres;

    /// How far any contact sphere of an undeformed one reaches from its center of mass.
    fn extent(&self) -> f64;

    /// Nodes of all trees, and of those the ones down to the level of the contact spheres.
    fn nodes(&self) -> [usize; 2];

    /// After a step: its own columns.
    fn own(&mut self) -> Result<Self::Own, Box<dyn Error>>;

    /// Why a run that has come to its end is wrong nevertheless.
    fn verdict(&self, log: &Log<Self::Own>) -> Result<(), Box<dyn Error>>;

    /// The assets of bodies in pictures.
    fn models(&self) -> Vec<Model>;

    /// Which of them a body is made of, and its colour.
    fn look(&self, body: usize) -> (usize, [u8; 3]);

    fn view(&self) -> View;

    /// Files of pictures of its own that are asked for.
    fn pictures(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Writes those; returns what is to be told of the last one.
    fn draw(&self, _show: &mut Show, _log: &Log<Self::Own>) -> Result<Value, Box<dyn Error>> {
        Ok(Value::Null)
    }

    /// What there is: for the report's settings, for its spheres, and as a table.
    fn about(&self) -> About;

    /// Sums over its own columns: for the report, and as cells of the table of contacts.
    fn totals(&self, log: &Log<Self::Own>) -> (Value, Row);

    /// The same of its own columns that are times.
    fn times(&self, _log: &Log<Self::Own>) -> (Value, Row) {
        (Value::Null, Row::new())
    }

    /// Adds those.
    fn add_due(&mut self) -> Result<(), Box<dyn Error>> {
        for at in self.due()? {
            self.add(at)?;
        }
        Ok(())
    }

    /// Numbers of the bodies that fall.
    fn falling(&self) -> std::ops::Range<usize> {
        let all = self.world().len();
        all - self.fallen()..all
    }

    /// Their centers of mass.
    fn positions(&self) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
        let of = |body| Ok(self.world().state(BodyId(body))?.position);
        self.falling().map(of).collect()
    }
}

/// What a scene says of itself.
pub(crate) struct About {
    pub(crate) settings: Value,
    pub(crate) spheres: Value,
    pub(crate) table: Row,
}

/// q of a body.
pub(crate) fn q(world: &World, body: usize) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut q = vec![0.0; world.model_of(BodyId(body))?.mode_count()];
    world.q(BodyId(body), &mut q)?;
    Ok(q)
}

/// FNV-1a of an asset's bytes, for the settings of a checkpoint.
pub(crate) fn hash(model: &Model) -> String {
    let add = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    let bytes = model.asset().bytes();
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, add))
}
