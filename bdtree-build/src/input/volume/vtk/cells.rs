//! `CELLS` and `CELL_TYPES`: which points belong to which cell, and what each cell is.

use super::super::draft::{Draft, Element, Shape};
use super::super::notes::Notes;
use super::super::number::Kind;
use super::super::source::{Source, Stop};
use super::arrays::integers;
use super::{ends_early, kinds, start};

/// The cells as they stand in the file.
#[derive(Default)]
pub(super) struct Cells {
    /// Points of all cells, one after the other.
    points: Vec<i64>,
    /// Where each cell begins in `points`, and where the last one ends.
    starts: Vec<usize>,
    /// Line or byte of each cell.
    positions: Vec<u64>,
    types: Vec<i64>,
    pub(super) has_connectivity: bool,
    pub(super) has_types: bool,
}

impl Cells {
    /// After `CELLS`: either `count size` and for each cell the number of its points and these, or,
    /// from version 5 on, the lengths of the arrays `OFFSETS` and `CONNECTIVITY`, and these.
    pub(super) fn connectivity(
        &mut self,
        source: &mut Source<'_>,
        position: u64,
    ) -> Result<(), Stop> {
        if std::mem::replace(&mut self.has_connectivity, true) {
            return Err((position, "a second CELLS section".into()));
        }
        let mut lengths = || -> Result<(i64, i64), String> {
            let first = source.text_integer("the number of cells")?;
            let second = source.text_integer("the size of CELLS")?;
            Ok((first, second))
        };
        let (first, second) = lengths().map_err(|message| (position, message))?;
        let mut after = Source::new(source.rest(), super::Layout::Words);
        let is_new = after
            .word()
            .is_some_and(|w| w.eq_ignore_ascii_case(b"OFFSETS"));
        if is_new {
            self.arrays(source, first, second)
        } else {
            self.records(source, first, second, position)
        }
    }

    /// The form of versions before 5.
    fn records(
        &mut self,
        source: &mut Source<'_>,
        count: i64,
        size: i64,
        position: u64,
    ) -> Result<(), Stop> {
        let at = |message| (position, message);
        start(source);
        let each = if source.binary.is_some() { 4 } else { 2 };
        let size = source.fits("the size of CELLS", size, each).map_err(at)?;
        let count = source
            .fits("the number of cells", count, each)
            .map_err(at)?;
        let mut left = size;
        self.starts.push(0);
        for cell in 0..count {
            if ends_early(source) {
                return Err((position, format!("{count} cells declared, {cell} found")));
            }
            let here = source.position();
            let stop = |message| (here, format!("element {cell}: {message}"));
            let points = source
                .integer("the number of points", Kind::I32)
                .map_err(stop)?;
            let points = usize::try_from(points)
                .ok()
                .filter(|&points| points < left)
                .ok_or_else(|| {
                    stop(format!(
                        "{points} points, where CELLS has {left} numbers left"
                    ))
                })?;
            left -= points + 1;
            for _ in 0..points {
                self.points
                    .push(source.integer("a point", Kind::I32).map_err(stop)?);
            }
            self.starts.push(self.points.len());
            self.positions.push(here);
        }
        if left != 0 {
            let used = size - left;
            return Err(at(format!(
                "CELLS has {size} numbers, its {count} cells use {used}"
            )));
        }
        Ok(())
    }

    /// The form since version 5.
    fn arrays(&mut self, source: &mut Source<'_>, starts: i64, points: i64) -> Result<(), Stop> {
        let (starts, _) = integers(source, b"OFFSETS", starts)?;
        let (points, positions) = integers(source, b"CONNECTIVITY", points)?;
        let position = source.position();
        let mut last = 0;
        for &offset in &starts {
            let next = usize::try_from(offset)
                .ok()
                .filter(|&n| n >= last && n <= points.len());
            let Some(next) = next else {
                let message = format!(
                    "offset {offset} after {last}: offsets ascend from 0 to {}",
                    points.len()
                );
                return Err((position, message));
            };
            self.starts.push(next);
            last = next;
        }
        if self.starts.first().is_some_and(|&first| first != 0) || last != points.len() {
            let message = format!("offsets do not run from 0 to {}", points.len());
            return Err((position, message));
        }
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let count = self.starts.len() - 1;
        self.positions = (0..count)
            .map(|cell| {
                positions
                    .get(self.starts[cell])
                    .copied()
                    .unwrap_or(position)
            })
            .collect();
        self.points = points;
        Ok(())
    }

    /// After `CELL_TYPES`: the count and the types.
    pub(super) fn types(&mut self, source: &mut Source<'_>, position: u64) -> Result<(), Stop> {
        if std::mem::replace(&mut self.has_types, true) {
            return Err((position, "a second CELL_TYPES section".into()));
        }
        let at = |message| (position, message);
        let what = "the number of cell types";
        let count = source.text_integer(what).map_err(at)?;
        start(source);
        let each = if source.binary.is_some() { 4 } else { 1 };
        let count = source.fits(what, count, each).map_err(at)?;
        for cell in 0..count {
            if ends_early(source) {
                return Err((
                    position,
                    format!("{count} cell types declared, {cell} found"),
                ));
            }
            let here = source.position();
            let kind = source.integer("the type", Kind::I32);
            self.types
                .push(kind.map_err(|m| (here, format!("element {cell}: {m}")))?);
        }
        Ok(())
    }

    /// Hands tetrahedra and hexahedra to `draft`.
    pub(super) fn build(&self, draft: &mut Draft, notes: &mut Notes<'_>) {
        let (cells, types) = (self.positions.len(), self.types.len());
        if cells != types {
            notes.problem(0, format!("{cells} cells, but {types} cell types"));
            return;
        }
        for (cell, &kind) in self.types.iter().enumerate() {
            let points = &self.points[self.starts[cell]..self.starts[cell + 1]];
            let position = self.positions[cell];
            let number = cell as i64;
            let known = draft.nodes.len();
            let built = match kinds::cell(kind) {
                Shape::Lower(name) => {
                    draft.others.skip(name, 1);
                    Ok(())
                }
                Shape::Solid(name) => {
                    draft.others.refuse(kind, name, position);
                    Ok(())
                }
                Shape::Tetrahedron => corners::<4>(points, known).map(|corners| {
                    draft
                        .tetrahedra
                        .push(Element::new(corners, number, position));
                }),
                Shape::Hexahedron => corners::<8>(points, known).map(|corners| {
                    draft
                        .hexahedra
                        .push(Element::new(corners, number, position));
                }),
                Shape::Voxel => corners::<8>(points, known).map(|[a, b, c, d, e, f, g, h]| {
                    let corners = [a, b, d, c, e, f, h, g];
                    draft
                        .hexahedra
                        .push(Element::new(corners, number, position));
                }),
            };
            if let Err(message) = built {
                notes.problem(position, format!("element {cell}: {message}"));
            }
        }
    }
}

/// The points of a cell of N corners, checked against the number of points.
fn corners<const N: usize>(points: &[i64], known: usize) -> Result<[u32; N], String> {
    let points: &[i64; N] = points.try_into().map_err(|_| {
        let name = if N == 4 {
            "a tetrahedron"
        } else {
            "a hexahedron"
        };
        format!("{name} of {} points", points.len())
    })?;
    let mut corners = [0; N];
    for (corner, &point) in corners.iter_mut().zip(points) {
        *corner = u32::try_from(point)
            .ok()
            .filter(|&point| (point as usize) < known)
            .ok_or_else(|| format!("point {point} is not one of the {known} (from 0)"))?;
    }
    Ok(corners)
}
