//! How much a glTF file shows, which may be far more than it holds.

use serde_json::Value;

use super::Format;

/// Bytes of the accessors of a glTF file's primitives, counted as often as primitives and nodes use them: a small file may
/// show a mesh a thousand times.
pub(super) fn written_out(format: Format, bytes: &[u8]) -> usize {
    let text = match format {
        Format::Gltf => Some(bytes),
        // The first chunk, behind twelve bytes of the file's header and eight of its own.
        Format::Glb => bytes.get(12..16).and_then(|length| {
            let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
            bytes.get(20..20_usize.checked_add(length)?)
        }),
        _ => None,
    };
    let document: Option<Value> = text.and_then(|text| serde_json::from_slice(text).ok());
    let Some(document) = document else {
        return 0;
    };
    let list = |key: &str| document[key].as_array().map_or(&[][..], Vec::as_slice);
    // Four numbers of four bytes at most; what claims more than the file holds is to be refused.
    let accessor = |index: &Value| -> usize {
        let found = index
            .as_u64()
            .and_then(|i| list("accessors").get(i as usize));
        let count = found.and_then(|found| found["count"].as_u64());
        count.map_or(0, |count| {
            16_usize.saturating_mul(count as usize).min(bytes.len())
        })
    };
    let values = |map: &Value| -> usize {
        map.as_object()
            .map_or(0, |map| map.values().map(accessor).sum())
    };
    let primitive = |of: &Value| {
        let targets = of["targets"].as_array().map_or(&[][..], Vec::as_slice);
        values(&of["attributes"])
            + accessor(&of["indices"])
            + targets.iter().map(values).sum::<usize>()
    };
    let meshes = list("meshes").iter().enumerate().map(|(i, mesh)| {
        let primitives = mesh["primitives"].as_array().map_or(&[][..], Vec::as_slice);
        let shows = |node: &&Value| node["mesh"].as_u64() == Some(i as u64);
        let uses = list("nodes").iter().filter(shows).count();
        uses * primitives.iter().map(primitive).sum::<usize>()
    });
    meshes.sum()
}
