//! Faces of files that list corners by number: fans of triangles, and what is wrong with the others.

use super::degenerate::{Oddity, outside};
use super::{BadFaces, RawMesh};
use crate::error::{BakeError, Part, Place, Problem, Problems};
use crate::figures::counted;

/// Most odd or skipped faces of one kind that are listed one by one.
pub(super) const LISTED_MAX: u64 = 5;

/// Triangles of the faces read so far.
pub(super) struct Faces<'a> {
    place: &'a str,
    bad: BadFaces,
    triangles: Vec<[u32; 3]>,
    problems: Problems,
    warnings: Vec<String>,
    oddities: [u64; Oddity::ALL.len()],
    skipped: u64,
}

impl<'a> Faces<'a> {
    /// None yet; `place` is the file's name in problems and warnings.
    pub(super) fn new(place: &'a str, bad: BadFaces) -> Self {
        Self {
            place,
            bad,
            triangles: Vec::new(),
            problems: Problems::new("input"),
            warnings: Vec::new(),
            oddities: Default::default(),
            skipped: 0,
        }
    }

    /// Face number `face` of the file, from 0: a fan around its first corner.
    pub(super) fn add(&mut self, face: usize, corners: &[i64], positions: &[[f64; 3]]) {
        let known = positions.len();
        let outside = corners
            .iter()
            .position(|&c| !usize::try_from(c).is_ok_and(|c| c < known));
        let wrong = if corners.len() < 3 {
            format!("a face needs 3 corners or more, found {}", corners.len())
        } else if let Some(corner) = outside {
            let text = out_of_range(corner, &corners[corner].to_string(), known);
            format!("{text}, numbered from 0")
        } else if self.triangles.len() + corners.len() > u32::MAX as usize {
            format!("more than {} triangles", u32::MAX)
        } else {
            return self.fan(face, corners, positions);
        };
        let place = Place::file(self.place).at(Part::Face(face));
        match self.bad {
            BadFaces::Refuse => self.problems.add(|| (place, wrong)),
            BadFaces::Skip => {
                self.skipped += 1;
                if self.skipped <= LISTED_MAX {
                    self.warnings.push(format!("{place}: skipped: {wrong}"));
                }
            }
        }
    }

    fn fan(&mut self, face: usize, corners: &[i64], positions: &[[f64; 3]]) {
        // No truncation: below the number of positions, which is limited to u32.
        let corner = |c: i64| c as u32;
        let first = self.triangles.len();
        for pair in corners[1..].windows(2) {
            let triangle = [corner(corners[0]), corner(pair[0]), corner(pair[1])];
            if let Some(oddity) = Oddity::of(triangle, positions) {
                self.oddity(oddity, face, self.triangles.len());
            }
            self.triangles.push(triangle);
        }
        if let Some(found) = outside(&self.triangles[first..], positions) {
            self.oddity(Oddity::OutsidePolygon, face, first + found);
        }
    }

    fn oddity(&mut self, oddity: Oddity, face: usize, triangle: usize) {
        let count = &mut self.oddities[oddity as usize];
        *count += 1;
        if *count <= LISTED_MAX {
            let (place, what) = (self.place, oddity.one());
            self.warnings
                .push(format!("{place}: face {face}: triangle {triangle} {what}"));
        }
    }

    /// The mesh, if nothing is wrong; name and hash are left empty.
    pub(super) fn finish(mut self, positions: Vec<[f64; 3]>) -> Result<RawMesh, BakeError> {
        let file = || Place::file(self.place);
        if self.triangles.is_empty() && self.problems.is_empty() {
            let message = match self.skipped {
                0 => "no faces".to_string(),
                skipped => all_bad(skipped),
            };
            self.problems.add(|| (file(), message));
        }
        self.problems.into_result(file())?;
        for kind in Oddity::ALL {
            let more = self.oddities[kind as usize].saturating_sub(LISTED_MAX);
            if more > 0 {
                self.warnings
                    .push(format!("{}: {more} more {}", self.place, kind.many()));
            }
        }
        self.warnings
            .extend(skipped_in_all(self.place, self.skipped));
        Ok(RawMesh {
            positions,
            triangles: self.triangles,
            warnings: self.warnings,
            ..RawMesh::default()
        })
    }
}

/// That skipping leaves nothing.
pub(super) fn all_bad(skipped: u64) -> String {
    match skipped {
        1 => "its only face is bad: nothing is left without it".to_string(),
        _ => format!("all {skipped} faces are bad: nothing is left without them"),
    }
}

/// What is wrong with corner number `corner` of a face, from 0, of a file with `known` vertices.
pub(super) fn out_of_range(corner: usize, token: &str, known: usize) -> String {
    let known = counted(known, "vertex");
    let number = corner + 1;
    format!("corner {number} `{token}` is out of range: the file has {known}")
}

/// The failure, with the option that leaves bad faces out behind its first problem with a face.
pub(super) fn with_option(mut error: BakeError) -> BakeError {
    let is_face = |problem: &&mut Problem| {
        let starts = ["corner ", "a face needs "];
        // Skipping faces gives no vertices.
        let is_hopeless = problem.message.ends_with("has 0 vertices");
        let is_of_face = starts
            .iter()
            .any(|start| problem.message.starts_with(start));
        is_of_face && !is_hopeless
    };
    if let Some(problem) = error.problems.iter_mut().find(is_face) {
        problem.message += " (--skip-bad-faces leaves such faces out)";
    }
    error
}

/// How many faces were skipped and what that does to ids; `None` for none.
pub(super) fn skipped_in_all(place: &str, skipped: u64) -> Option<String> {
    let faces = if skipped == 1 {
        "bad face"
    } else {
        "bad faces"
    };
    (skipped > 0)
        .then(|| format!("{place}: skipped {skipped} {faces}: triangle ids count the others"))
}
