//! The mesh as Wavefront OBJ.

use std::io::{self, Write};

use bdtree_runtime::{Asset, Group, GroupKind, VertexId};

use crate::output::Shortest;

/// Writes one `v` line per vertex, one `f` line per triangle in the order of their ids, and the
/// source's groups as `o`, `g` and `usemtl`.
pub(super) fn write(
    asset: &Asset<'_>,
    positions: &[[f64; 3]],
    triangles: &[[VertexId; 3]],
    out: &mut dyn Write,
) -> io::Result<()> {
    for [x, y, z] in positions {
        writeln!(out, "v {} {} {}", Shortest(*x), Shortest(*y), Shortest(*z))?;
    }
    let mut groups: Vec<Group<'_>> = asset.groups().filter(|g| g.triangle_count > 0).collect();
    groups.sort_by_key(|group| group.first_triangle); // stable: the source's order within an id
    let mut groups = groups.into_iter().peekable();
    for (id, corners) in (0_u32..).zip(triangles) {
        while let Some(group) = groups.next_if(|g| g.first_triangle.0 <= id) {
            writeln!(out, "{}", statement(&group))?;
        }
        let [a, b, c] = corners.map(|vertex| u64::from(vertex.0) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

/// The statement that opens a group; what would end the line in its name is replaced.
fn statement(group: &Group<'_>) -> String {
    let keyword = match group.kind {
        GroupKind::Object => "o",
        GroupKind::Material => "usemtl",
        _ => "g",
    };
    let printable = |c: char| if c.is_control() { '_' } else { c };
    let name: String = group.name.chars().map(printable).collect();
    format!("{keyword} {name}").trim_end().to_string()
}
