//! The libraries that answer single bodies: those built in, and Embree where it is found.

#[cfg(feature = "embree")]
use std::rc::Rc;

use bdtree_measure::Body;
#[cfg(feature = "embree")]
use bdtree_measure::peers::{Embree, embree};
use bdtree_measure::peers::{LayeredPeer, Peer};
#[cfg(feature = "peers")]
use bdtree_measure::peers::{Obvhs, Parry, TinyBvh};

use crate::prelude::*;

/// Those who refit: name, what it is to the comparison and how near its rays come, a body.
pub(crate) type Peers = Vec<(&'static str, (Role, Counts), Box<dyn Peer>)>;

/// Libraries test rays on their own.
#[cfg(feature = "peers")]
const PEER: (Role, Counts) = (Role::Peer, Counts::OwnTest);

/// What is there on this machine.
pub(crate) struct Libraries {
    #[cfg(feature = "embree")]
    embree: Option<Rc<embree::Device>>,
}

impl Libraries {
    /// Looks for those that are not built in.
    ///
    /// # Errors
    /// One that is named and cannot be used.
    pub(crate) fn find() -> Result<Self> {
        Ok(Self {
            #[cfg(feature = "embree")]
            embree: embree::Device::find()?,
        })
    }

    /// What was found of Embree, for the report.
    pub(crate) fn embree(&self) -> String {
        #[cfg(feature = "embree")]
        return match &self.embree {
            Some(device) => device.version(),
            None => format!("absent, {} names no library", embree::VARIABLE),
        };
        #[cfg(not(feature = "embree"))]
        "absent, built without the feature embree".to_string()
    }

    /// A body in the layered hierarchy and in all of them.
    ///
    /// # Errors
    /// A body that one of them refuses.
    pub(crate) fn and_layered(&self, body: &Body, layered: LayeredPeer) -> Result<Peers> {
        let mut all: Peers = vec![("layered", (Role::Baseline, Counts::Same), Box::new(layered))];
        all.extend(self.of(body)?);
        Ok(all)
    }

    /// A body in all of them.
    ///
    /// # Errors
    /// A body that one of them refuses.
    pub(crate) fn of(&self, body: &Body) -> Result<Peers> {
        #[allow(unused_mut)]
        let mut all = Peers::new();
        #[cfg(feature = "peers")]
        all.extend::<Peers>(vec![
            ("parry3d", PEER, Box::new(Parry::new(body))),
            ("obvhs", PEER, Box::new(Obvhs::new(body))),
            ("tinybvh", PEER, Box::new(TinyBvh::new(body))),
        ]);
        #[cfg(feature = "embree")]
        if let Some(device) = &self.embree {
            all.push(("embree4", PEER, Box::new(Embree::new(device, body)?)));
        }
        // Without features there is no other.
        let _ = body;
        Ok(all)
    }
}
