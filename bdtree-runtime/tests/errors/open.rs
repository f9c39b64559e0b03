//! What opening a file refuses.

use std::mem::{offset_of, size_of};

use bdtree_fixtures::mutate::{get_u32, put, record, section, table};
use bdtree_format::{FrameRecord, Header, ModeRecord, SectionKind, SectionRecord};

use crate::edits::{Change, body, field, frame, header, u32_at};

/// Changes of a sound file, checksums repaired afterwards.
pub(crate) fn changes() -> Vec<Change> {
    let bits = |x: f32| x.to_bits();
    let mode = size_of::<Header>();
    let kind = offset_of!(SectionRecord, kind);
    let name = |n: &[u8; 4]| u32::from_le_bytes(*n);
    vec![
        Box::new(|b| b.clear()),
        Box::new(|b| *b = b"a text file, long enough for a header. ".repeat(10)),
        Box::new(header(offset_of!(Header, version_major), 1)),
        Box::new(|b| b.push(0)),
        Box::new(header(offset_of!(Header, features_required), 4)),
        Box::new(header(offset_of!(Header, mode_count), 513)),
        Box::new(header(offset_of!(Header, section_count), 65)),
        Box::new(header(offset_of!(Header, header_bytes), 64)),
        Box::new(|b| b.truncate(130)),
        Box::new(|b| {
            let count = get_u32(b, offset_of!(Header, section_count)) as usize;
            let at = table(b) + count * size_of::<SectionRecord>();
            assert!(at < get_u32(b, offset_of!(Header, header_bytes)) as usize);
            b[at] = 1;
        }),
        Box::new(header(offset_of!(Header, reserved), 1)),
        Box::new(|b| put(b, offset_of!(Header, origin), &f64::NAN.to_le_bytes())),
        Box::new(header(offset_of!(Header, unit_exponent), i32::MIN as u32)),
        Box::new(header(offset_of!(Header, depth), 33)),
        Box::new(header(offset_of!(Header, leaf_triangles_max), 0)),
        Box::new(header(offset_of!(Header, vertex_count), 0)),
        Box::new(header(mode + offset_of!(ModeRecord, q_range), 0)),
        Box::new(|b| {
            let at = size_of::<Header>() + offset_of!(ModeRecord, modal_mass_kg);
            put(b, at, &0.0_f64.to_le_bytes());
        }),
        Box::new(header(offset_of!(Header, position_norm_max), 1)),
        Box::new(header(offset_of!(Header, position_norm_max), bits(1e30))),
        Box::new(field(
            SectionKind::ROWS,
            offset_of!(SectionRecord, offset),
            64,
        )),
        Box::new(field(
            SectionKind::METADATA,
            offset_of!(SectionRecord, length),
            1 << 30,
        )),
        Box::new(field(
            SectionKind::NODES,
            offset_of!(SectionRecord, required),
            2,
        )),
        Box::new(field(SectionKind::GROUP_NAMES, kind, name(b"GRPS"))),
        Box::new(field(SectionKind::NODES, kind, name(b"NODX"))),
        Box::new(|b| {
            let (nodes, rows) = (record(b, SectionKind::NODES), record(b, SectionKind::ROWS));
            // Each with its layout.
            put(b, nodes, b"ROWS\x03");
            put(b, rows, b"NODE\x02");
        }),
        Box::new(field(
            SectionKind::METADATA,
            offset_of!(SectionRecord, required),
            1,
        )),
        Box::new(field(
            SectionKind::TRIANGLES,
            offset_of!(SectionRecord, layout),
            2,
        )),
        Box::new(header(offset_of!(Header, triangle_count), 1)),
        Box::new(|b| {
            let at = record(b, SectionKind::ROWS) + offset_of!(SectionRecord, length);
            let length = get_u32(b, at) - 4;
            u32_at(b, at, length);
        }),
        Box::new(|b| {
            let at = record(b, SectionKind::DISPLACEMENTS);
            put(b, at, b"DISX");
            u32_at(b, at + offset_of!(SectionRecord, required), 0);
        }),
        Box::new(field(SectionKind::GROUP_NAMES, kind, name(b"GNAX"))),
        Box::new(field(SectionKind::MASS_PROPERTIES, kind, name(b"MASX"))),
        Box::new(field(SectionKind::FRAMES, kind, name(b"FRMX"))),
        Box::new(|b| {
            // No frames: FRMS shrinks to nothing, and the rest of its place becomes a section that
            // nobody knows.
            let at = record(b, SectionKind::FRAMES);
            let start = section(b, SectionKind::FRAMES).start;
            let q = record(b, SectionKind::FRAME_Q);
            put(
                b,
                at + offset_of!(SectionRecord, length),
                &0_u64.to_le_bytes(),
            );
            put(
                b,
                q + offset_of!(SectionRecord, offset),
                &(start as u64).to_le_bytes(),
            );
            let end = section(b, SectionKind::GROUPS).start;
            let length = (end - start) as u64;
            put(
                b,
                q + offset_of!(SectionRecord, length),
                &length.to_le_bytes(),
            );
        }),
        Box::new(field(
            SectionKind::FRAME_Q,
            offset_of!(SectionRecord, length),
            76, // instead of 3 frames × 6 modes × 4 bytes, up to the same multiple of 64
        )),
        Box::new(|b| frame(b, 2, offset_of!(FrameRecord, time_s), 0.01)),
        Box::new(|b| frame(b, 1, offset_of!(FrameRecord, rotation), f64::NAN)),
        Box::new(|b| frame(b, 1, offset_of!(FrameRecord, translation) + 8, 1e25)),
        Box::new(body(SectionKind::FRAME_Q, 4, bits(f32::NAN))),
        Box::new(body(SectionKind::FRAME_Q, 4, bits(-1e30))),
        Box::new(|b| {
            b.push(0);
            let length = (b.len() as u64).to_le_bytes();
            put(b, offset_of!(Header, file_bytes), &length);
        }),
    ]
}
