//! What two files must share exactly: counts, sections, tree, triangles, groups.

use bdtree_format::{Header, NodeRecord, SECTION_ORDER, SectionRecord};
use bdtree_runtime::Asset;

use super::findings::Findings;
use crate::q::counted;

/// Which arrays have the same shape, so that their numbers can be compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comparable {
    /// Rest positions: the same number of vertices and the same unit.
    pub(super) vertices: bool,
    /// Mode table and displacements: also the same number of modes.
    pub(super) modes: bool,
    /// Rows: also the same nodes and mode lists.
    pub(super) rows: bool,
    /// Frames: the same number of them and of modes.
    pub(super) frames: bool,
}

/// Compares everything but numbers and metadata.
pub(super) fn compare(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) -> Comparable {
    let both = [a, b];
    let mut count = |what: &str, of: &dyn Fn(&Header) -> i64| {
        let [x, y] = both.map(|asset| of(asset.header()));
        findings.compare(&format!("header: {what}"), [x, y]);
        x == y
    };
    count("features_optional", &|h| h.features_optional.get().into());
    let vertices = count("vertex_count", &|h| h.vertex_count.get().into());
    let triangles = count("triangle_count", &|h| h.triangle_count.get().into());
    let nodes = count("node_count", &|h| h.node_count.get().into());
    count("depth", &|h| h.depth.get().into());
    count("leaf_triangles_max", &|h| h.leaf_triangles_max.get().into());
    let units = count("unit_exponent", &|h| h.unit_exponent.get().into());

    let version = |asset: &Asset<'_>| {
        let header = asset.header();
        let (major, minor) = (header.version_major.get(), header.version_minor.get());
        format!("{major}.{minor}")
    };
    findings.compare("header: version", both.map(version));
    let told = both.map(|asset| counted(asset.mode_count(), "mode"));
    let modes = told[0] == told[1];
    findings.compare("header: mode_count", told);

    sections(a, b, findings);
    let vertices_and_units = vertices && units;
    let mut rows = vertices_and_units && modes && nodes;
    if nodes {
        // What the rows count belongs to their numbers, and what follows from the number of modes is told with it.
        let linked = both.map(|asset| {
            let plain = |node: &NodeRecord| {
                let mut node = *node;
                node.scale_exponents = [0; 3];
                if !modes {
                    (node.row_start, node.mode_list_start, node.mode_count) = (0, 0, 0);
                }
                node
            };
            asset.nodes().iter().map(plain).collect::<Vec<_>>()
        });
        let linked = linked.each_ref().map(Vec::as_slice);
        rows &= findings.compare_records("section NODE: nodes", "node", linked);
    }
    if nodes && modes {
        let lists = both.map(|asset| asset.mode_list_entries());
        let lengths = lists.map(<[u16]>::len);
        findings.compare("section LIST: length", lengths);
        rows &= findings.compare_records("section LIST: mode lists", "entry", lists);
        rows &= lengths[0] == lengths[1];
    }
    if vertices && modes {
        let modes = both.map(|asset| asset.vertex_modes());
        findings.compare_records("section VMOD: modes of vertices", "vertex", modes);
    }
    if triangles {
        let in_order = both.map(|asset| asset.triangles());
        findings.compare_records("section TRIS: triangles in leaf order", "slot", in_order);
        let slots = both.map(|asset| asset.triangle_slots());
        findings.compare_records("section SLOT: triangle slots", "triangle", slots);
    }
    let groups = both.map(|asset| asset.groups().collect::<Vec<_>>());
    let groups = groups.each_ref().map(Vec::as_slice);
    findings.compare("section GRPS: number of groups", groups.map(<[_]>::len));
    findings.compare_records("section GRPS: groups", "group", groups);
    let frames = both.map(Asset::frame_count);
    findings.compare("section FRMS: number of frames", frames);
    Comparable {
        vertices: vertices_and_units,
        modes: vertices_and_units && modes,
        rows,
        frames: modes && frames[0] == frames[1],
    }
}

/// A section's kind, layout and flag.
type Row = (String, u32, u32);

/// What two section tables differ in.
fn tables_apart([a, b]: &[Vec<Row>; 2]) -> Vec<String> {
    let other = |table: &'_ [Row], kind: &str| table.iter().find(|row| row.0 == kind).cloned();
    let mut lines = Vec::new();
    for (kind, layout, required) in a {
        match other(b, kind) {
            None => lines.push(format!("{kind}: only in the first file")),
            Some((_, l, _)) if l != *layout => {
                lines.push(format!("{kind}: layout {layout} and {l}"));
            }
            Some((_, _, r)) if r != *required => {
                lines.push(format!("{kind}: required {required} and {r}"));
            }
            Some(_) => {}
        }
    }
    let only_b = b.iter().filter(|row| other(a, &row.0).is_none());
    lines.extend(only_b.map(|row| format!("{}: only in the second file", row.0)));
    if lines.is_empty() {
        lines.push("another order".to_string());
    }
    lines
}

/// Kinds, layouts and flags; the bytes of sections that this version does not know.
fn sections(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let tables = [a, b].map(|asset| {
        let row = |s: &SectionRecord| (s.kind.to_string(), s.layout.get(), s.required.get());
        asset.sections().iter().map(row).collect::<Vec<_>>()
    });
    if tables[0] != tables[1] {
        findings.differ(
            "section table (kind, layout, required)",
            tables_apart(&tables),
        );
        return;
    }
    for (x, y) in a.sections().iter().zip(b.sections()) {
        if !SECTION_ORDER.contains(&x.kind) {
            let bytes = [(a, x), (b, y)].map(|(asset, s)| {
                let start = s.offset.get() as usize;
                let end = start.saturating_add(s.length.get() as usize);
                asset.bytes().get(start..end).unwrap_or_default()
            });
            let lengths = [x, y].map(|s| s.length.get());
            findings.compare(&format!("section {}: length", x.kind), lengths);
            findings.compare_records(&format!("section {}: bytes", x.kind), "byte", bytes);
        }
    }
}
