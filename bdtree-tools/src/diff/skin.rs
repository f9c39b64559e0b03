//! Skins: what bones, joints and clips there are exactly, their numbers within the tolerance.

use bdtree_format::{ChannelRecord, ClipRecord, InfluenceRecord, SectionKind, SkeletonNode};
use bdtree_runtime::{Asset, Clip};
use zerocopy::FromBytes;

use super::findings::{Findings, largest};
use super::numbers::mesh_size;
use crate::output::printable;

/// Compares the skins of two files, one of which may have none.
pub(super) fn compare(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let both = [a, b];
    if !both.iter().any(|asset| asset.has_skin()) {
        return;
    }
    type Count = fn(&Asset<'_>) -> usize;
    let counts: [(&str, Count); 5] = [
        ("skin: number of joints", |asset| asset.joint_count()),
        ("skin: number of bones", |asset| asset.bone_count()),
        ("skin: number of influences", |asset| {
            section(asset, SectionKind::INFLUENCES).len() / 8
        }),
        ("skin: number of nodes", |asset| {
            section(asset, SectionKind::SKELETON).len() / 64
        }),
        ("skin: number of clips", |asset| {
            section(asset, SectionKind::CLIPS).len() / 24
        }),
    ];
    let mut alike = true;
    for (what, count) in counts {
        let found = both.map(count);
        findings.compare(what, found);
        alike &= found[0] == found[1];
    }
    if !alike {
        return;
    }
    for (what, kind) in [
        (
            "section INFS: influences of vertices",
            SectionKind::INFLUENCE_STARTS,
        ),
        (
            "section BLSS: bones of nodes",
            SectionKind::BONE_LIST_STARTS,
        ),
        ("section BLST: bones of nodes", SectionKind::BONE_LISTS),
        ("section JNTS: nodes of joints", SectionKind::JOINTS),
        ("section SNAM: names", SectionKind::SKELETON_NAMES),
    ] {
        let [x, y] = both.map(|asset| section(asset, kind));
        if let Some(at) = first_difference(x, y) {
            findings.differ(what, vec![format!("first at byte {at} of the section")]);
        }
    }
    clips(both, findings);
    influences(both, findings);
    bones(both, findings);
    skeleton(both, findings);
    for (what, kind) in [
        (
            "section BFLD: displacements of bones",
            SectionKind::BONE_FIELDS,
        ),
        ("section BROW: weights of lanes", SectionKind::BONE_ROWS),
        ("section KEYS: times and values of clips", SectionKind::KEYS),
    ] {
        let values = both.map(|asset| numbers(section(asset, kind)));
        compare_numbers(
            what,
            "number",
            values.each_ref().map(Vec::as_slice),
            0.0,
            findings,
        );
    }
}

/// Clips and their channels exactly, but for the numbers.
fn clips(both: [&Asset<'_>; 2], findings: &mut Findings) {
    let skeletons = both.map(|asset| asset.skeleton());
    let [Some(a), Some(b)] = skeletons else {
        return;
    };
    let told = |clip: &Clip<'_>| (printable(clip.name()), clip.duration_s());
    let pairs = a.clips().zip(b.clips()).enumerate();
    let differ = pairs.filter_map(|(i, (a, b))| {
        let (a, b) = (told(&a), told(&b));
        let text = |(name, seconds): &(String, f64)| format!("\"{name}\", {seconds} s");
        (a != b).then(|| format!("clip {i}: {} and {}", text(&a), text(&b)))
    });
    let differ: Vec<String> = differ.collect();
    if !differ.is_empty() {
        findings.differ("section CLIP: clips", differ);
    }
    let [x, y] = both.map(|asset| section(asset, SectionKind::CHANNELS));
    let ranges = both.map(|asset| {
        let clips = <[ClipRecord]>::ref_from_bytes(section(asset, SectionKind::CLIPS));
        let ranges = clips.unwrap_or_default().iter();
        let ranges = ranges.map(|clip| (clip.first_channel.get(), clip.channel_count.get()));
        ranges.collect::<Vec<_>>()
    });
    let at = first_difference(x, y).map(|at| (at / size_of::<ChannelRecord>()) as u32);
    let clip = match at {
        Some(channel) => ranges[0]
            .iter()
            .position(|(first, count)| (*first..first.saturating_add(*count)).contains(&channel)),
        None => {
            let mut pairs = ranges[0].iter().zip(&ranges[1]);
            pairs.position(|(a, b)| a != b)
        }
    };
    if at.is_some() || clip.is_some() {
        let name = clip.and_then(|clip| a.clip(clip));
        let first = match name {
            Some(clip) => format!("first in \"{}\"", printable(clip.name())),
            None => "in their number".to_string(),
        };
        findings.differ("section CHAN: channels of clips", vec![first]);
    }
}

/// The first byte that differs, or where the shorter one ends.
fn first_difference(x: &[u8], y: &[u8]) -> Option<usize> {
    let at = x.iter().zip(y).position(|(x, y)| x != y);
    at.or_else(|| (x.len() != y.len()).then(|| x.len().min(y.len())))
}

/// The bones of each vertex exactly, their weights within the tolerance.
fn influences(both: [&Asset<'_>; 2], findings: &mut Findings) {
    let records = both.map(|asset| {
        let bytes = section(asset, SectionKind::INFLUENCES);
        <[InfluenceRecord]>::ref_from_bytes(bytes).unwrap_or_default()
    });
    let bones = records.map(|records| records.iter().map(|own| own.bone).collect::<Vec<_>>());
    if bones[0] != bones[1] {
        findings.differ("section INFL: bones of vertices", Vec::new());
    }
    let weights = records.map(|records| {
        let weights = records.iter().map(|own| f64::from(own.weight));
        weights.collect::<Vec<_>>()
    });
    let weights = weights.each_ref().map(Vec::as_slice);
    compare_numbers("section INFL: weights", "influence", weights, 1.0, findings);
}

/// Joints of bones exactly, their matrices and boxes within the tolerance.
fn bones(both: [&Asset<'_>; 2], findings: &mut Findings) {
    let joints = both.map(|asset| {
        asset
            .bones()
            .iter()
            .map(|bone| bone.joint.get())
            .collect::<Vec<_>>()
    });
    if joints[0] != joints[1] {
        findings.differ("section BONE: joints of bones", Vec::new());
    }
    let binds = both.map(|asset| {
        let rows = asset.bones().iter().flat_map(|bone| bone.inverse_bind);
        rows.flatten().map(|x| x.get()).collect::<Vec<_>>()
    });
    let binds = binds.each_ref().map(Vec::as_slice);
    compare_numbers(
        "section BONE: inverse bind matrices",
        "number",
        binds,
        1.0,
        findings,
    );
    let rest = both.map(|asset| {
        let rows = asset.bones().iter().flat_map(|bone| bone.rest);
        rows.flatten()
            .map(|x| f64::from(x.get()))
            .collect::<Vec<_>>()
    });
    let rest = rest.each_ref().map(Vec::as_slice);
    compare_numbers("section BONE: maps at rest", "number", rest, 1.0, findings);
    let boxes = both.map(|asset| {
        let corners = asset
            .bones()
            .iter()
            .flat_map(|bone| [bone.low, bone.high, bone.core_low, bone.core_high]);
        corners
            .flatten()
            .map(|x| f64::from(x.get()))
            .collect::<Vec<_>>()
    });
    let size = mesh_size(both[0]).max(mesh_size(both[1]));
    let boxes = boxes.each_ref().map(Vec::as_slice);
    compare_numbers("section BONE: boxes", "number", boxes, size, findings);
}

/// Parents, names and kinds exactly, transforms at rest within the tolerance.
fn skeleton(both: [&Asset<'_>; 2], findings: &mut Findings) {
    let nodes = both.map(|asset| {
        let bytes = section(asset, SectionKind::SKELETON);
        <[SkeletonNode]>::ref_from_bytes(bytes).unwrap_or_default()
    });
    let links = nodes.map(|nodes| {
        let links = nodes
            .iter()
            .map(|node| (node.parent, node.kind, node.name_bytes));
        links.collect::<Vec<_>>()
    });
    if links[0] != links[1] {
        findings.differ(
            "section SKEL: parents, kinds and names of nodes",
            Vec::new(),
        );
    }
    let locals = nodes.map(|nodes| {
        let locals = nodes.iter().flat_map(|node| node.local).map(f64::from);
        locals.collect::<Vec<_>>()
    });
    let locals = locals.each_ref().map(Vec::as_slice);
    compare_numbers(
        "section SKEL: transforms at rest",
        "number",
        locals,
        1.0,
        findings,
    );
}

fn compare_numbers(
    what: &str,
    element: &str,
    [a, b]: [&[f64]; 2],
    scale: f64,
    findings: &mut Findings,
) {
    if a.len() != b.len() {
        let what = what.replacen(": ", ": number of ", 1);
        findings.compare(&what, [a.len(), b.len()]);
        return;
    }
    let scale = largest(a.iter().chain(b).copied()).max(scale);
    let mut numbers = findings.numbers(what, scale);
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        numbers.compare(*x, *y, || format!("{element} {i}"));
    }
    numbers.finish(findings);
}

/// The f32 numbers of a section.
fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (chunks, _) = bytes.as_chunks::<4>();
    chunks
        .iter()
        .map(|x| f64::from(f32::from_le_bytes(*x)))
        .collect()
}

/// The bytes of a section; none where it is absent.
fn section<'a>(asset: &Asset<'a>, kind: SectionKind) -> &'a [u8] {
    let record = asset.sections().iter().find(|section| section.kind == kind);
    let range = record.and_then(|record| {
        let start = usize::try_from(record.offset.get()).ok()?;
        Some(start..start.checked_add(usize::try_from(record.length.get()).ok()?)?)
    });
    range
        .and_then(|range| asset.bytes().get(range))
        .unwrap_or_default()
}
