//! The libraries that answer single bodies: those built in, and Embree where it is found.

use std::error::Error;
#[cfg(feature = "embree")]
use std::rc::Rc;

use bdtree_measure::Body;
use bdtree_measure::peers::Peer;
#[cfg(feature = "embree")]
use bdtree_measure::peers::{Embree, embree};
#[cfg(feature = "peers")]
use bdtree_measure::peers::{Obvhs, Parry, TinyBvh};

/// Bodies by the name of their library.
pub(crate) type Peers = Vec<(&'static str, Box<dyn Peer>)>;

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
    pub(crate) fn find() -> Result<Self, Box<dyn Error>> {
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

    /// A body in all of them.
    ///
    /// # Errors
    /// A body that one of them refuses.
    pub(crate) fn of(&self, body: &Body) -> Result<Peers, Box<dyn Error>> {
        let all: Peers = vec![
            #[cfg(feature = "peers")]
            ("parry3d", Box::new(Parry::new(body))),
            #[cfg(feature = "peers")]
            ("obvhs", Box::new(Obvhs::new(body))),
            #[cfg(feature = "peers")]
            ("tinybvh", Box::new(TinyBvh::new(body))),
        ];
        #[cfg(feature = "embree")]
        let all = match &self.embree {
            Some(device) => {
                let embree: Box<dyn Peer> = Box::new(Embree::new(device, body)?);
                all.into_iter().chain([("embree4", embree)]).collect()
            }
            None => all,
        };
        // Without features there are none.
        let _ = body;
        Ok(all)
    }
}
