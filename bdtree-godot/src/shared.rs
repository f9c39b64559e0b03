//! Files that are open: nodes with the same file share one copy of its bytes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use bdtree_runtime::Model;

use crate::fault::Fault;

/// Files by path, as long as a node has them.
#[derive(Default)]
pub(crate) struct Files {
    open: Mutex<Option<HashMap<String, Weak<Model>>>>,
}

impl Files {
    pub(crate) const fn new() -> Self {
        Self {
            open: Mutex::new(None),
        }
    }

    /// The model of a file, which `read` reads unless another node has it.
    ///
    /// # Errors
    /// Those of `read`; bytes that are not a `.bdt` file.
    pub(crate) fn model(
        &self,
        path: &str,
        read: impl FnOnce() -> Result<Vec<u8>, Fault>,
    ) -> Result<Arc<Model>, Fault> {
        // A panic while it was locked has left it whole.
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let open = open.get_or_insert_default();
        open.retain(|_, model| model.strong_count() > 0);
        if let Some(model) = open.get(path).and_then(Weak::upgrade) {
            return Ok(model);
        }
        let model = Model::from_bytes(&read()?).map_err(|error| Fault::Format {
            path: path.to_string(),
            error,
        })?;
        let model = Arc::new(model);
        open.insert(path.to_string(), Arc::downgrade(&model));
        Ok(model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: &[u8] = include_bytes!("../../fixtures/golden/tetrahedron.bdt");

    #[test]
    fn a_file_is_read_once_while_it_is_used() {
        let files = Files::new();
        let mut reads = 0;
        let mut read = || {
            reads += 1;
            Ok(BYTES.to_vec())
        };
        let first = files.model("res://a.bdt", &mut read).expect("a file");
        let second = files.model("res://a.bdt", &mut read).expect("a file");
        assert!(Arc::ptr_eq(&first, &second));
        let other = files.model("res://b.bdt", &mut read).expect("a file");
        assert!(!Arc::ptr_eq(&first, &other));
        drop((first, second));
        files.model("res://a.bdt", &mut read).expect("a file");
        assert_eq!(reads, 3);
    }

    #[test]
    fn what_is_no_file_is_told_with_its_path() {
        let files = Files::new();
        let fault = files
            .model("res://a.bdt", || Ok(b"no".to_vec()))
            .expect_err("no file");
        let text = fault.to_string();
        assert!(text.starts_with("res://a.bdt: "), "{text}");
        // It is read again the next time.
        assert!(files.model("res://a.bdt", || Ok(BYTES.to_vec())).is_ok());
    }
}
