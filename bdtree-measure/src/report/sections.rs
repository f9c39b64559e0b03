//! Bytes by section, and what scenes that ask less never read.

use bdtree_format::SectionKind;
use bdtree_runtime::Asset;

use super::content::{SectionRow, Unneeded};

/// In file order; what is not in a section (header, tables, padding) is the last row.
pub(super) fn sections(asset: &Asset<'_>) -> Vec<SectionRow> {
    let total = asset.header().file_bytes.get();
    let row = |kind: String, purpose: &str, bytes: u64| SectionRow {
        kind,
        purpose: purpose.to_string(),
        bytes,
        share: bytes as f64 / total.max(1) as f64,
    };
    let mut rows: Vec<SectionRow> = asset
        .sections()
        .iter()
        .map(|s| row(s.kind.to_string(), purpose(s.kind), s.length.get()))
        .collect();
    let inside: u64 = rows.iter().map(|r| r.bytes).sum();
    let rest = total.saturating_sub(inside);
    rows.push(row("-".to_string(), "header, tables, padding", rest));
    rows
}

fn purpose(kind: SectionKind) -> &'static str {
    match kind {
        SectionKind::NODES => "nodes of the tree",
        SectionKind::ROWS => "their spheres: rest, and what each mode does to them",
        SectionKind::MODE_LISTS => "which modes act on a node or vertex",
        SectionKind::TRIANGLES => "triangles, in the order of the leaves",
        SectionKind::TRIANGLE_SLOTS => "where each triangle id is",
        SectionKind::POSITIONS => "vertices at rest",
        SectionKind::DISPLACEMENTS => "displacement of each vertex by each mode",
        SectionKind::VERTEX_MODES => "modes of each vertex",
        SectionKind::SKIN => "what holds for the whole skin",
        SectionKind::INFLUENCE_STARTS => "where the bones of each vertex begin",
        SectionKind::INFLUENCES => "bones of each vertex, with weights",
        SectionKind::BONES => "inverse bind matrices, and where bones are at rest",
        SectionKind::BONE_FIELDS => "how far each mode moves what a bone carries",
        SectionKind::BONE_LIST_STARTS => "where the bones of each node begin",
        SectionKind::BONE_LISTS => "which bones act on a node",
        SectionKind::BONE_ROWS => "what spheres have of their bones",
        SectionKind::SKELETON => "nodes that joints hang from",
        SectionKind::JOINTS => "which nodes are joints",
        SectionKind::SKELETON_NAMES => "names of joints and clips",
        SectionKind::CLIPS => "animations of the skeleton (clips)",
        SectionKind::CHANNELS => "what moves in each clip",
        SectionKind::KEYS => "times and values of the clips",
        SectionKind::MASS_PROPERTIES => "mass, center of mass, inertia",
        SectionKind::MODE_MOMENTA => "momentum of the body in each mode",
        SectionKind::FRAMES => "animation frames",
        SectionKind::FRAME_Q => "q of the frames",
        SectionKind::GROUPS => "groups of the source",
        SectionKind::GROUP_NAMES => "their names",
        SectionKind::METADATA => "source, settings, names, warnings",
        _ => "not known to this version",
    }
}

/// What is never read by scenes that only ask so much.
pub(super) fn unneeded(asset: &Asset<'_>) -> Vec<Unneeded> {
    let bytes = |kinds: &[SectionKind]| {
        let sections = asset.sections().iter();
        let of = sections.filter(|s| kinds.contains(&s.kind));
        of.map(|s| s.length.get()).sum::<u64>()
    };
    let surface = bytes(&[
        SectionKind::TRIANGLES,
        SectionKind::TRIANGLE_SLOTS,
        SectionKind::POSITIONS,
        SectionKind::DISPLACEMENTS,
        SectionKind::VERTEX_MODES,
        SectionKind::INFLUENCE_STARTS,
        SectionKind::INFLUENCES,
    ]);
    let animation = bytes(&[SectionKind::FRAMES, SectionKind::FRAME_Q]);
    let skeleton = bytes(&[
        SectionKind::SKELETON,
        SectionKind::SKELETON_NAMES,
        SectionKind::CLIPS,
        SectionKind::CHANNELS,
        SectionKind::KEYS,
    ]);
    let words = bytes(&[
        SectionKind::GROUPS,
        SectionKind::GROUP_NAMES,
        SectionKind::METADATA,
    ]);
    let row = |scene: &str, without: &str, bytes| Unneeded {
        scene: scene.to_string(),
        without: without.to_string(),
        bytes,
    };
    let mut rows = Vec::new();
    if let Some(level) = first_leaf_level(asset).checked_sub(1) {
        let limit = match level {
            0 => "with a level limit of 0".to_string(),
            level => format!("with a level limit of {level} or less"),
        };
        let surface_parts = match asset.mode_count() {
            0 => "triangles, vertices",
            _ => "triangles, vertices, displacements",
        };
        rows.push(row(&limit, surface_parts, surface));
    }
    rows.push(row(
        "with any limit that stops before the deepest level",
        "nodes of the deepest level and their rows",
        deepest_bytes(asset),
    ));
    rows.push(row(
        "with q from the program",
        "animation frames",
        animation,
    ));
    rows.push(row(
        "with joints from the program",
        "skeleton, clips",
        skeleton,
    ));
    rows.push(row(
        "where groups and names are not asked for",
        "groups, names, metadata",
        words,
    ));
    rows.retain(|row| row.bytes > 0);
    rows
}

/// The level of the first node that holds triangles; nodes stand by level.
fn first_leaf_level(asset: &Asset<'_>) -> usize {
    let first = asset.nodes().iter().find(|node| node.leaf_mask != 0);
    first.map_or(0, |node| usize::from(node.level))
}

/// Bytes of the deepest level's nodes and of their rows, which end their sections; none where it is the only level.
fn deepest_bytes(asset: &Asset<'_>) -> u64 {
    const RECORD: u64 = 32;
    let Some(above) = asset.depth().checked_sub(2) else {
        return 0;
    };
    let first = asset.node_count_to(above);
    let nodes = asset.nodes().len().saturating_sub(first) as u64;
    let rows = asset
        .sections()
        .iter()
        .find(|s| s.kind == SectionKind::ROWS);
    let rows = rows.map_or(0, |rows| rows.length.get() / RECORD);
    let start = asset
        .nodes()
        .get(first)
        .map_or(rows, |node| u64::from(node.row_start));
    RECORD * (nodes + rows.saturating_sub(start))
}
