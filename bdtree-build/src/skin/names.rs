//! Names of nodes and clips, one behind the other.

use crate::error::{BakeError, Place};

/// The bytes of all names.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub(super) bytes: Vec<u8>,
}

impl Names {
    /// Start and length of `name`, which is added.
    pub(super) fn add(&mut self, name: &str) -> Result<[u32; 2], BakeError> {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(name.as_bytes());
        if u32::try_from(self.bytes.len()).is_err() {
            let message = "names of joints and clips are longer than 4 GiB together";
            return Err(BakeError::one("skin", Place::NOWHERE, message));
        }
        Ok([start as u32, name.len() as u32])
    }
}
