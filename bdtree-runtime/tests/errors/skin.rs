//! Skins: what opening a file refuses, and what only the deep check reads.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_fixtures::mutate::{get_f32, get_u32, put, record, repair, section};
use bdtree_fixtures::sections::{Part, put_together, take_apart};
use bdtree_fixtures::skin::skinned_bar;
use bdtree_format::{
    BONE_ROW_DEFECT, BONE_ROW_SPREAD, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneRecord,
    ChannelRecord, ClipRecord, FrameRecord, InfluenceRecord, LAYOUT_1, NodeRecord, Row,
    SectionKind, SectionRecord, SkeletonNode, SkinRecord, channel_path,
};
use bdtree_runtime::Model;

use crate::edits::{Change, body, node, node_count, u32_at};

/// A sound file with a skin.
pub(crate) fn file() -> Vec<u8> {
    skinned_bar()
}

/// Changes of it, checksums repaired afterwards.
pub(crate) fn changes() -> Vec<Change> {
    [
        opened(),
        influences(),
        bones(),
        nodes(),
        skeleton(),
        clips(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Changes the sections of a file.
fn parts(change: impl Fn(&mut Vec<Part>) + 'static) -> Change {
    Box::new(move |b| {
        let mut parts = take_apart(b);
        change(&mut parts);
        *b = put_together(b, parts);
    })
}

/// Changes what a section holds, and its length.
fn resized(kind: SectionKind, length: impl Fn(usize) -> usize + 'static) -> Change {
    parts(move |parts| {
        let part = parts.iter_mut().find(|part| part.kind() == kind);
        let body = &mut part.expect("a section").body;
        body.resize(length(body.len()), 0);
    })
}

/// The section becomes one that nobody knows and nobody needs.
fn unknown(kind: SectionKind) -> Change {
    Box::new(move |b| {
        let at = record(b, kind);
        put(b, at, b"XTRA");
        u32_at(b, at + offset_of!(SectionRecord, required), 0);
    })
}

/// A field of the i-th record of a section.
fn field(kind: SectionKind, size: usize, i: usize, offset: usize, value: u32) -> Change {
    Box::new(body(kind, i * size + offset, value))
}

fn opened() -> Vec<Change> {
    let skin = |offset, value| field(SectionKind::SKIN, 0, 0, offset, value);
    let part = |kind: SectionKind, length: usize| {
        let mut record = vec![0; size_of::<SectionRecord>()];
        put(&mut record, 0, &kind.0);
        let layout = offset_of!(SectionRecord, layout);
        put(&mut record, layout, &LAYOUT_1.to_le_bytes());
        Part {
            record,
            body: vec![0; length],
        }
    };
    vec![
        unknown(SectionKind::SKELETON_NAMES),
        unknown(SectionKind::CHANNELS),
        parts(|parts| {
            let first = parts.iter().position(|p| p.kind() == SectionKind::SKIN);
            let end = parts.iter().position(|p| p.kind() == SectionKind::CLIPS);
            parts.drain(first.expect("a skin")..end.expect("clips"));
        }),
        parts(move |parts| {
            let clips = parts.iter().position(|p| p.kind() == SectionKind::KEYS);
            let behind = clips.expect("clips") + 1;
            let frames = [
                part(SectionKind::FRAMES, size_of::<FrameRecord>()),
                part(SectionKind::FRAME_Q, 4),
            ];
            parts.splice(behind..behind, frames);
        }),
        resized(SectionKind::BONES, |_| 0),
        resized(SectionKind::JOINTS, |_| 0),
        resized(SectionKind::SKELETON, |_| 0),
        resized(SectionKind::BONE_FIELDS, |length| length + 4),
        resized(SectionKind::BONE_ROWS, |length| length + 32),
        skin(offset_of!(SkinRecord, influences_max), 256),
        skin(offset_of!(SkinRecord, node_bones_max), 4097),
        skin(offset_of!(SkinRecord, weight_defect), 1.5_f32.to_bits()),
        skin(offset_of!(SkinRecord, minor_share), 1.5_f32.to_bits()),
        skin(offset_of!(SkinRecord, reserved), 1),
    ]
}

fn influences() -> Vec<Change> {
    let influence = |i, offset, value| {
        let size = size_of::<InfluenceRecord>();
        field(SectionKind::INFLUENCES, size, i, offset, value)
    };
    let starts = |i, value| field(SectionKind::INFLUENCE_STARTS, 4, i, 0, value);
    let skin = |offset, value| field(SectionKind::SKIN, 0, 0, offset, value);
    let weight = offset_of!(InfluenceRecord, weight);
    vec![
        starts(0, 1),
        starts(3, u32::MAX),
        starts(20, 0),
        influence(0, weight, f32::NAN.to_bits()),
        influence(0, weight, 0),
        influence(4, weight, 1.999_f32.to_bits()),
        // The bone, and what is reserved behind it.
        influence(1, offset_of!(InfluenceRecord, bone), 0xffff),
        influence(1, offset_of!(InfluenceRecord, bone), 1 << 16),
        skin(offset_of!(SkinRecord, influences_max), 7),
        skin(offset_of!(SkinRecord, node_bones_max), 2),
        skin(offset_of!(SkinRecord, weight_defect), 0),
        skin(offset_of!(SkinRecord, weight_defect), 1),
        skin(offset_of!(SkinRecord, minor_share), 0),
        skin(offset_of!(SkinRecord, minor_share), 1),
    ]
}

fn bones() -> Vec<Change> {
    let size = size_of::<BoneRecord>();
    let bone = move |i: usize, offset, value| field(SectionKind::BONES, size, i, offset, value);
    let inverse = offset_of!(BoneRecord, inverse_bind);
    vec![
        bone(0, offset_of!(BoneRecord, joint), 3),
        bone(0, offset_of!(BoneRecord, reserved), 3),
        // The upper half of an f64.
        bone(0, inverse + 4, 0x7ff0_0000),
        bone(1, inverse + 12, 0x7000_0000),
        bone(2, offset_of!(BoneRecord, rest), f32::NAN.to_bits()),
        bone(1, offset_of!(BoneRecord, low), 1e9_f32.to_bits()),
        bone(1, offset_of!(BoneRecord, high) + 4, (-1e9_f32).to_bits()),
        bone(1, offset_of!(BoneRecord, core_low), 1e9_f32.to_bits()),
        bone(1, offset_of!(BoneRecord, core_high), f32::NAN.to_bits()),
        Box::new(body(SectionKind::BONE_FIELDS, 4, 0)),
        Box::new(body(SectionKind::BONE_FIELDS, 4, 1)),
        // Another bone, which moves nothing, with the box of the last one.
        parts(|parts| {
            for part in parts.iter_mut() {
                let (kind, body) = (part.kind(), &mut part.body);
                match kind {
                    SectionKind::BONES => body.extend_from_within(2 * size_of::<BoneRecord>()..),
                    SectionKind::BONE_FIELDS => body.extend([0; 4]),
                    _ => {}
                }
            }
        }),
    ]
}

/// Changes a number of the root's bone rows, in lane 0.
fn root_row(row: usize, change: impl Fn(f32) -> f32 + 'static) -> Change {
    Box::new(move |b| {
        let at = section(b, SectionKind::BONE_ROWS).start + row * size_of::<Row>();
        let value = change(get_f32(b, at));
        u32_at(b, at, value.to_bits());
    })
}

fn nodes() -> Vec<Change> {
    vec![
        field(SectionKind::BONE_LIST_STARTS, 4, 0, 0, 1),
        field(SectionKind::BONE_LIST_STARTS, 4, 1, 0, u32::MAX),
        // Two lanes of the root's first entry at once: bones that move nothing there, no bones of the file.
        Box::new(body(SectionKind::BONE_LISTS, 0, 0)),
        Box::new(body(SectionKind::BONE_LISTS, 0, u32::MAX)),
        // The second entry has the bones of the first.
        parts(|parts| {
            for part in parts.iter_mut() {
                if part.kind() == SectionKind::BONE_LISTS {
                    part.body.copy_within(0..16, 16);
                }
            }
        }),
        // The root has a bone that moves nothing in the place of one that moves something.
        parts(|parts| {
            for part in parts.iter_mut() {
                let (kind, body) = (part.kind(), &mut part.body);
                match kind {
                    SectionKind::BONES => {
                        body.extend_from_within(2 * size_of::<BoneRecord>()..);
                        let end = body.len();
                        // The box of a bone that moves nothing.
                        for (at, x) in (end - 48..end)
                            .step_by(4)
                            .zip([1.0, 1.0, 1.0, -1.0, -1.0, -1.0].into_iter().cycle())
                        {
                            put(body, at, &f32::to_le_bytes(x));
                        }
                    }
                    SectionKind::BONE_FIELDS => body.extend([0; 4]),
                    SectionKind::BONE_LISTS => put(body, 0, &[3, 0]),
                    _ => {}
                }
            }
        }),
        root_row(BONE_ROW_SPREAD, |x| -x),
        root_row(BONE_ROW_SPREAD, |x| 0.99 * x),
        Box::new(|b| {
            let row = section(b, SectionKind::BONE_ROWS).start + BONE_ROW_DEFECT * size_of::<Row>();
            b[row..row + size_of::<Row>()].fill(0);
        }),
        root_row(BONE_ROW_DEFECT, |_| f32::INFINITY),
        root_row(BONE_ROWS_FIXED, |x| 1.01 * x),
        root_row(BONE_ROWS_FIXED, |x| -x),
        root_row(BONE_ROWS_FIXED, |_| 0.0),
        root_row(BONE_ROWS_FIXED + 1, |x| x - 0.01),
        Box::new(|b| {
            // An empty lane of some node holds a number.
            let starts = section(b, SectionKind::BONE_LIST_STARTS).start;
            let place = (0..node_count(b)).find_map(|i| {
                let at = node(b, i);
                let used = b[at + offset_of!(NodeRecord, inner_mask)]
                    | b[at + offset_of!(NodeRecord, leaf_mask)];
                let row =
                    BONE_ROWS_FIXED * i + BONE_ROWS_PER_ENTRY * get_u32(b, starts + 4 * i) as usize;
                (used != 0xff).then(|| 32 * row + 4 * used.trailing_ones() as usize)
            });
            let at = section(b, SectionKind::BONE_ROWS).start + place.expect("an empty lane");
            u32_at(b, at, 1.0_f32.to_bits());
        }),
    ]
}

fn skeleton() -> Vec<Change> {
    let size = size_of::<SkeletonNode>();
    let node = move |i: usize, offset, value| field(SectionKind::SKELETON, size, i, offset, value);
    let local = offset_of!(SkeletonNode, local);
    vec![
        node(1, offset_of!(SkeletonNode, parent), 1),
        node(1, offset_of!(SkeletonNode, name_start), u32::MAX),
        Box::new(body(SectionKind::SKELETON_NAMES, 0, u32::MAX)),
        node(1, offset_of!(SkeletonNode, kind), 2),
        node(2, local, f32::NAN.to_bits()),
        node(2, local + 4 * 6, 1.01_f32.to_bits()),
        node(2, local + 4 * 11, 1.0_f32.to_bits()),
        field(SectionKind::JOINTS, 4, 1, 0, 4),
        field(SectionKind::JOINTS, 4, 1, 0, 1),
    ]
}

fn clips() -> Vec<Change> {
    let clip = |offset, value| {
        field(
            SectionKind::CLIPS,
            size_of::<ClipRecord>(),
            0,
            offset,
            value,
        )
    };
    let channel = |i, offset, value| {
        let size = size_of::<ChannelRecord>();
        field(SectionKind::CHANNELS, size, i, offset, value)
    };
    vec![
        // The upper half of an f64.
        clip(offset_of!(ClipRecord, duration_s) + 4, 0x7ff0_0000),
        clip(offset_of!(ClipRecord, name_bytes), 1000),
        clip(offset_of!(ClipRecord, channel_count), 1000),
        channel(0, offset_of!(ChannelRecord, target), 0), // of a matrix
        channel(2, offset_of!(ChannelRecord, target), 1),
        channel(2, offset_of!(ChannelRecord, target_count), u32::MAX),
        channel(0, offset_of!(ChannelRecord, path), 4),
        channel(0, offset_of!(ChannelRecord, interpolation), 3),
        channel(0, offset_of!(ChannelRecord, key_count), 0),
        channel(0, offset_of!(ChannelRecord, key_count), u32::MAX),
        channel(0, offset_of!(ChannelRecord, first_number), u32::MAX),
        channel(0, offset_of!(ChannelRecord, reserved), 1),
        Box::new(body(SectionKind::KEYS, 0, (-1.0_f32).to_bits())),
        Box::new(body(SectionKind::KEYS, 0, 1.0_f32.to_bits())),
        Box::new(body(SectionKind::KEYS, 8, f32::NAN.to_bits())),
    ]
}

/// The rule has other breaches as well: this one is asked for by name.
#[test]
fn a_channel_of_no_modes_is_refused() {
    let mut bytes = file();
    let channel = section(&bytes, SectionKind::CHANNELS).start + 2 * size_of::<ChannelRecord>();
    let count = channel + offset_of!(ChannelRecord, target_count);
    let path = get_u32(&bytes, channel + offset_of!(ChannelRecord, path));
    assert_eq!((path, get_u32(&bytes, count)), (channel_path::MODES, 1));
    u32_at(&mut bytes, count, 0);
    repair(&mut bytes);
    let model = Model::from_bytes(&bytes).expect("it opens");
    let mut found = Vec::new();
    model.asset().verify(&mut |error| {
        found.push(error.to_string());
        ControlFlow::Continue(())
    });
    let says = |text: &&String| text.contains("CHAN") && text.contains("at least 1 mode");
    assert_eq!(found.iter().filter(says).count(), 1, "{found:?}");
}
