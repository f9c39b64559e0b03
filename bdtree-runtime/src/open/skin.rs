//! The sections of a skin: their counts, against each other and the header.

use bdtree_format::{
    BONE_COUNT_MAX, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneRecord, Header, INFLUENCES_MAX,
    SKELETON_NODES_MAX, SectionKind, SkinRecord,
};
use core::mem::size_of;

use super::sections::view;
use crate::error::{Check, Datum, FormatError};
use crate::view::Skin;

/// The skin, if the file has one, with its counts checked.
pub(super) fn view_skin<'a>(
    header: &Header,
    slice: impl Fn(SectionKind) -> (usize, &'a [u8]) + Copy,
) -> Result<Option<Skin<'a>>, FormatError> {
    // The table made sure that the sections of a skin are all there or all absent, and that SKIN is one record long.
    let Some(record) = view::<SkinRecord>(SectionKind::SKIN, slice)?.first() else {
        return Ok(None);
    };
    let skin = Skin {
        record,
        influence_starts: view(SectionKind::INFLUENCE_STARTS, slice)?,
        influences: view(SectionKind::INFLUENCES, slice)?,
        bones: view::<BoneRecord>(SectionKind::BONES, slice)?,
        bone_fields: view(SectionKind::BONE_FIELDS, slice)?,
        list_starts: view(SectionKind::BONE_LIST_STARTS, slice)?,
        lists: view(SectionKind::BONE_LISTS, slice)?,
        rows: view(SectionKind::BONE_ROWS, slice)?,
        skeleton: view(SectionKind::SKELETON, slice)?,
        joints: view(SectionKind::JOINTS, slice)?,
        names: slice(SectionKind::SKELETON_NAMES).1,
        clips: view(SectionKind::CLIPS, slice)?,
        channels: view(SectionKind::CHANNELS, slice)?,
        keys: view(SectionKind::KEYS, slice)?,
    };
    check_counts(header, &skin, slice)?;
    Ok(Some(skin))
}

fn check_counts<'a>(
    header: &Header,
    skin: &Skin<'_>,
    slice: impl Fn(SectionKind) -> (usize, &'a [u8]),
) -> Result<(), FormatError> {
    let at = |kind: SectionKind| Check::at(kind, slice(kind).0 as u64);
    for (kind, count, most, rule) in [
        (
            SectionKind::BONES,
            skin.bones.len(),
            BONE_COUNT_MAX,
            "SPEC 4.2: a skin has 1 to 4096 bones",
        ),
        (
            SectionKind::JOINTS,
            skin.joints.len(),
            BONE_COUNT_MAX,
            "SPEC 4.2: a skin has 1 to 4096 joints",
        ),
        (
            SectionKind::SKELETON,
            skin.skeleton.len(),
            SKELETON_NODES_MAX,
            "SPEC 4.2: a skeleton has 1 to 16384 nodes",
        ),
    ] {
        at(kind).rule(rule).holds(
            (1..=most).contains(&count),
            Datum::Within(1.0, most as f64),
            count,
        )?;
    }
    let fields = skin.bones.len() * header.mode_count.get() as usize;
    at(SectionKind::BONE_FIELDS)
        .rule("SPEC 4.3: BFLD holds one number per bone and mode")
        .holds(
            skin.bone_fields.len() == fields,
            fields,
            skin.bone_fields.len(),
        )?;
    let rows = BONE_ROWS_FIXED as u64 * u64::from(header.node_count.get())
        + (BONE_ROWS_PER_ENTRY * skin.lists.len()) as u64;
    at(SectionKind::BONE_ROWS)
        .rule("SPEC 6.10: BROW holds two rows per node and two per entry of BLST")
        .holds(skin.rows.len() as u64 == rows, rows, skin.rows.len())?;
    check_record(skin.record, &at(SectionKind::SKIN))
}

/// The numbers that slack rests on.
fn check_record(record: &SkinRecord, at: &Check) -> Result<(), FormatError> {
    let (most, found) = (INFLUENCES_MAX, record.influences_max as usize);
    at.rule("SPEC 7.7: a vertex has at most 255 influences")
        .holds(found <= most, Datum::at_most(most), found)?;
    let (most, found) = (BONE_COUNT_MAX, record.node_bones_max as usize);
    at.rule("SPEC 7.7: a node has at most 4096 entries of bones")
        .holds(found <= most, Datum::at_most(most), found)?;
    let defect = record.weight_defect;
    at.rule("SPEC 7.7: weight_defect is 0 to 1").holds(
        (0.0..=1.0).contains(&defect),
        Datum::Within(0.0, 1.0),
        defect,
    )?;
    const _: () = assert!(size_of::<SkinRecord>() == 32);
    let share = record.minor_share;
    at.rule("SPEC 7.7: minor_share is 0 to 1").holds(
        (0.0..=1.0).contains(&share),
        Datum::Within(0.0, 1.0),
        share,
    )?;
    at.rule("SPEC 7.7: reserved numbers are zero")
        .holds(record.reserved == [0; 4], 0_u32, 1_u32)
}
