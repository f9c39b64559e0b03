//! What `--fix` says: axes and a region.

use std::path::PathBuf;
use std::str::FromStr;

use crate::elastic::assemble::constraint::Constraint;
use crate::elastic::constraint::node_list::read_list;
use crate::elastic::constraint::region::{Region, constrain};
use crate::elastic::lattice::{Lattice, Subject};
use crate::error::{BakeError, Part, Place};
use crate::input::RawGroup;

/// Holds part of the body along some axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// Whether x, y, z are held.
    pub axes: [bool; 3],
    /// Where.
    pub region: FixRegion,
}

/// The part of a body that is held.
#[derive(Debug, Clone, PartialEq)]
pub enum FixRegion {
    /// What lies in a box (mesh units, inclusive).
    Box {
        /// Lower corner.
        min: [f64; 3],
        /// Upper corner.
        max: [f64; 3],
    },
    /// The surface of all groups of this name; of a volume mesh, its node set of this name.
    Group(String),
    /// The vertices whose numbers, from 1, a file lists, with the triangles between them; of a
    /// volume mesh, those nodes.
    List(PathBuf),
}

impl FixRegion {
    /// What messages call it.
    pub(crate) fn place(&self) -> Part {
        let text = match self {
            Self::Box { min, max } => format!("box {min:?} to {max:?}"),
            Self::Group(name) => name.clone(),
            Self::List(path) => format!("@{}", path.display()),
        };
        Part::Option("--fix", Some(text))
    }
}

impl Fix {
    /// As [`Fix::from_str`] reads it, but files without their folders.
    pub fn without_folders(&self) -> Self {
        let mut own = self.clone();
        if let FixRegion::List(path) = &mut own.region {
            *path = path.file_name().map(PathBuf::from).unwrap_or_default();
        }
        own
    }
}

impl std::fmt::Display for Fix {
    /// As [`Fix::from_str`] reads it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (axis, held) in ["x", "y", "z"].iter().zip(self.axes) {
            if held {
                f.write_str(axis)?;
            }
        }
        match &self.region {
            FixRegion::Box { min, max } => write!(
                f,
                ":{},{},{},{},{},{}",
                min[0], min[1], min[2], max[0], max[1], max[2]
            ),
            FixRegion::Group(name) => write!(f, ":{name}"),
            FixRegion::List(path) => write!(f, ":@{}", path.display()),
        }
    }
}

impl FromStr for Fix {
    type Err = String;

    /// Reads `xyz:xmin,ymin,zmin,xmax,ymax,zmax`, `z:legs` or `z:@FILE`; six numbers are always a
    /// box, and what begins with `@` a file.
    fn from_str(text: &str) -> Result<Self, String> {
        let (letters, place) = text.split_once(':').ok_or_else(|| {
            format!("`{text}`: expected AXES:BOX, AXES:GROUP or AXES:@FILE, as in z:legs")
        })?;
        let mut axes = [false; 3];
        for letter in letters.chars() {
            let axis = "xyz"
                .find(letter)
                .filter(|&a| !axes[a])
                .ok_or_else(|| format!("`{text}`: axes are x, y, z, each at most once"))?;
            axes[axis] = true;
        }
        if letters.is_empty() {
            return Err(format!("`{text}`: no axis before the colon"));
        }
        if place.is_empty() {
            return Err(format!("`{text}`: no box, group or file after the colon"));
        }
        if let Some(path) = place.strip_prefix('@') {
            if path.is_empty() {
                return Err(format!("`{text}`: no file after the @"));
            }
            let region = FixRegion::List(PathBuf::from(path));
            return Ok(Self { axes, region });
        }
        let numbers: Result<Vec<f64>, _> = place.split(',').map(|n| n.trim().parse()).collect();
        let region = match numbers.as_deref() {
            Ok(&[a, b, c, d, e, f]) => {
                let (min, max) = ([a, b, c], [d, e, f]);
                if (0..3).any(|k| min[k].is_nan() || max[k].is_nan() || min[k] > max[k]) {
                    return Err(format!("`{text}`: a box is xmin,ymin,zmin,xmax,ymax,zmax"));
                }
                FixRegion::Box { min, max }
            }
            Ok(_) => {
                return Err(format!(
                    "`{text}`: a box is six numbers: xmin,ymin,zmin,xmax,ymax,zmax"
                ));
            }
            Err(_) => FixRegion::Group(place.to_owned()),
        };
        Ok(Self { axes, region })
    }
}

/// Names that are listed where a group is not found.
const NAMES_SHOWN: usize = 20;

/// Why a group was not found, with the names that there are.
fn no_such_group(groups: &[RawGroup]) -> String {
    let mut names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    if names.is_empty() {
        return "the mesh has no groups; name a box or a @FILE of vertices".to_string();
    }
    let shown = names.iter().take(NAMES_SHOWN);
    let shown: Vec<String> = shown.map(|name| format!("{name:?}")).collect();
    let more = match names.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let shown = shown.join(", ");
    format!("the mesh has no group of this name; its groups are {shown}{more}")
}

/// Per component, the points that the fixes hold together.
///
/// # Errors
/// A fix that holds nothing, an unknown group, a bad list, nothing left to move.
pub(crate) fn constrain_all(
    subject: &Subject<'_>,
    lattice: &Lattice,
    fixes: &[Fix],
) -> Result<Vec<Vec<Constraint>>, BakeError> {
    let mut constraints: Vec<Vec<Constraint>> = vec![Vec::new(); lattice.components.len()];
    let mut everything = [false; 3];
    for fix in fixes {
        let mut ranges = Vec::new();
        let vertices;
        let region =
            match &fix.region {
                FixRegion::Box { min, max } => Region::Box {
                    min: *min,
                    max: *max,
                },
                FixRegion::Group(name) => {
                    let groups = subject.mesh.groups.iter().filter(|g| g.name == *name);
                    ranges.extend(groups.map(|g| {
                        g.first_triangle..g.first_triangle.saturating_add(g.triangle_count)
                    }));
                    if ranges.is_empty() {
                        return Err(BakeError::one(
                            "basis",
                            fix.region.place(),
                            no_such_group(&subject.mesh.groups),
                        ));
                    }
                    Region::Triangles(&ranges)
                }
                FixRegion::List(path) => {
                    vertices = read_list(path, subject.mesh.positions.len(), "vertex")?;
                    Region::Vertices(&vertices)
                }
            };
        let held = constrain(subject, lattice, &region, fix.axes);
        if held.constraints.is_empty() {
            return Err(BakeError::one(
                "basis",
                fix.region.place(),
                "it holds no part of the body",
            ));
        }
        for (all, axis) in everything.iter_mut().zip(fix.axes) {
            *all |= held.everything && axis;
        }
        for constraint in held.constraints {
            constraints[constraint.anchor.component].push(constraint);
        }
    }
    if everything == [true; 3] {
        return Err(BakeError::one(
            "basis",
            Place::option("--fix"),
            "everything is held, so nothing can vibrate",
        ));
    }
    Ok(constraints)
}
