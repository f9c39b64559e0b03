//! What two files must share exactly: counts, sections, tree, triangles, groups.

use bdtree_format::{NodeRecord, SECTION_ORDER, SectionKind};
use bdtree_runtime::Asset;

use super::findings::Findings;

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
    let (ha, hb) = (a.header(), b.header());
    let mut count = |what: &str, x: u32, y: u32| {
        findings.compare(&format!("header: {what}"), x, y);
        x == y
    };
    let version = |h: &bdtree_format::Header| {
        u32::from(h.version_major.get()) << 16 | u32::from(h.version_minor.get())
    };
    count("version", version(ha), version(hb));
    count(
        "features_optional",
        ha.features_optional.get(),
        hb.features_optional.get(),
    );
    let vertices = count("vertex_count", ha.vertex_count.get(), hb.vertex_count.get());
    let triangles = count(
        "triangle_count",
        ha.triangle_count.get(),
        hb.triangle_count.get(),
    );
    let modes = count("mode_count", ha.mode_count.get(), hb.mode_count.get());
    let nodes = count("node_count", ha.node_count.get(), hb.node_count.get());
    count("depth", ha.depth.get(), hb.depth.get());
    count(
        "leaf_triangles_max",
        ha.leaf_triangles_max.get(),
        hb.leaf_triangles_max.get(),
    );
    let (unit_a, unit_b) = (ha.unit_exponent.get(), hb.unit_exponent.get());
    findings.compare("header: unit_exponent", unit_a, unit_b);

    sections(a, b, findings);
    let mut rows = vertices && modes && nodes && unit_a == unit_b;
    if nodes {
        // What the rows count belongs to their numbers.
        let linked = |asset: &Asset<'_>| -> Vec<NodeRecord> {
            let plain = |node: &NodeRecord| NodeRecord {
                scale_exponents: [0; 3],
                ..*node
            };
            asset.nodes().iter().map(plain).collect()
        };
        rows &= findings.compare_records("section NODE: nodes", "node", &linked(a), &linked(b));
        rows &= mode_lists(a, b, findings);
    }
    if vertices {
        findings.compare_records(
            "section VMOD: modes of vertices",
            "vertex",
            a.vertex_modes(),
            b.vertex_modes(),
        );
    }
    if triangles {
        findings.compare_records(
            "section TRIS: triangles in leaf order",
            "slot",
            a.triangles(),
            b.triangles(),
        );
        findings.compare_records(
            "section SLOT: triangle slots",
            "triangle",
            a.triangle_slots(),
            b.triangle_slots(),
        );
    }
    let (groups_a, groups_b): (Vec<_>, Vec<_>) = (a.groups().collect(), b.groups().collect());
    findings.compare(
        "section GRPS: number of groups",
        groups_a.len(),
        groups_b.len(),
    );
    findings.compare_records("section GRPS: groups", "group", &groups_a, &groups_b);
    let (frames_a, frames_b) = (a.frame_count(), b.frame_count());
    findings.compare("section FRMS: number of frames", frames_a, frames_b);
    Comparable {
        vertices: vertices && unit_a == unit_b,
        modes: vertices && modes && unit_a == unit_b,
        rows,
        frames: modes && frames_a == frames_b,
    }
}

/// Kinds, layouts and flags; the bytes of sections that this version does not know.
fn sections(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let table = |asset: &Asset<'_>| -> Vec<(String, u32, u32)> {
        let sections = asset.sections().iter();
        sections
            .map(|s| (s.kind.to_string(), s.layout.get(), s.required.get()))
            .collect()
    };
    let (table_a, table_b) = (table(a), table(b));
    findings.compare("section table (kind, layout, required)", &table_a, &table_b);
    if table_a != table_b {
        return;
    }
    for (x, y) in a.sections().iter().zip(b.sections()) {
        if !SECTION_ORDER.contains(&x.kind) {
            let bytes = |asset: &Asset<'_>, s: &bdtree_format::SectionRecord| {
                let start = s.offset.get() as usize;
                let end = start.saturating_add(s.length.get() as usize);
                asset.bytes().get(start..end).unwrap_or_default().to_vec()
            };
            let what = format!("section {}: length", x.kind);
            findings.compare(&what, x.length.get(), y.length.get());
            let what = format!("section {}: bytes", x.kind);
            findings.compare_records(&what, "byte", &bytes(a, x), &bytes(b, y));
        }
    }
}

/// The mode-list section, found as bytes: nodes only see their part of it.
fn mode_lists(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) -> bool {
    let list = |asset: &Asset<'_>| -> Vec<u16> {
        let sections = asset.sections();
        let Some(s) = sections.iter().find(|s| s.kind == SectionKind::MODE_LISTS) else {
            return Vec::new();
        };
        let start = s.offset.get() as usize;
        let end = start.saturating_add(s.length.get() as usize);
        let bytes = asset.bytes().get(start..end).unwrap_or_default();
        let pairs = bytes.chunks_exact(2);
        pairs.map(|x| u16::from_le_bytes([x[0], x[1]])).collect()
    };
    let (a, b) = (list(a), list(b));
    findings.compare("section LIST: length", a.len(), b.len());
    findings.compare_records("section LIST: mode lists", "entry", &a, &b) && a.len() == b.len()
}
