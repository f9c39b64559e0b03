//! The end of the file: what could only be checked with all vertices known.

use super::{Reader, face};
use crate::error::BakeError;
use crate::input::faces::{all_bad, out_of_range};
use crate::input::{GroupKind, RawMesh};

impl Reader<'_> {
    /// Checks the faces that referred ahead and that there is a mesh at all; hands it over.
    pub(super) fn finish(mut self) -> Result<RawMesh, BakeError> {
        for kind in [GroupKind::Object, GroupKind::Group, GroupKind::Material] {
            self.close(kind);
        }
        let count = self.positions.len();
        // After a limit nothing was read, so that nothing can be said about references ahead.
        let deferred = if self.full {
            Vec::new()
        } else {
            std::mem::take(&mut self.deferred)
        };
        for ahead in deferred {
            let first = ahead.triangles.start;
            let triangles = &self.triangles[ahead.triangles];
            // A fan has the corners 0 1 2, 0 2 3, …
            let corners = (0..)
                .zip(triangles)
                .flat_map(|(k, &[a, b, c])| [(0, a), (k + 1, b), (k + 2, c)]);
            let missing = corners.into_iter().find(|&(_, c)| c as usize >= count);
            if let Some((place, corner)) = missing {
                let index = u64::from(corner) + 1;
                let message = out_of_range(place, &index.to_string(), count);
                self.notes.problem(ahead.line, message);
            } else {
                let line = ahead.line;
                face::check_shape(triangles, first, &self.positions, line, &mut self.notes);
            }
        }
        if self.vertex_statements == 0 && !self.full {
            self.notes.problem(0, "no vertices (`v` lines)".into());
        }
        if self.face_statements == 0 && !self.full {
            let message = match self.notes.skipped() {
                Some(skipped) => format!("no faces (`f` lines), only {skipped}"),
                None => "no faces (`f` lines)".into(),
            };
            self.notes.problem(0, message);
        }
        let count = self.face_statements;
        if self.triangles.is_empty() && count > 0 && self.notes.has_skipped_all(count) {
            self.notes.problem(0, all_bad(count));
        }
        let warnings = self.notes.into_warnings()?;
        Ok(RawMesh {
            positions: self.positions,
            triangles: self.triangles,
            groups: self.groups,
            warnings,
            ..RawMesh::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::lines::Lines;
    use super::*;

    fn with_limit(text: &str, limit: u32) -> Result<RawMesh, BakeError> {
        let mut reader = Reader::new("m.obj", limit);
        let mut lines = Lines::new(text.as_bytes());
        while let Some((number, line)) = lines.next_line() {
            reader.statement(number, line);
            if reader.full {
                break;
            }
        }
        reader.finish()
    }

    #[test]
    fn counts_beyond_the_limit_are_errors_with_their_line() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\nf 1 2 3 4\n";
        assert!(with_limit(text, 4).is_ok());
        let error = with_limit(text, 3).unwrap_err().to_string();
        assert_eq!(error, "m.obj:4: more than 3 vertices");
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\nf 1 2 3 1\n";
        let error = with_limit(text, 3).unwrap_err().to_string();
        assert_eq!(error, "m.obj:6: more than 3 triangles");
    }
}
