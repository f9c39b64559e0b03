//! Extensions: which ones a file may require.

use super::notes::Notes;

/// Integer positions.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Extensions that only change what a mesh looks like, by the start of their names.
const APPEARANCE: [&str; 9] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "EXT_materials_",
    "MSFT_texture_",
    "MSFT_packing_",
];

/// Extensions that place geometry; without them it is read where the nodes say.
const PLACING: [&str; 1] = ["EXT_mesh_gpu_instancing"];

/// Refuses required extensions that are not known, by name; warns of optional ones that place
/// geometry.
pub(super) fn check(required: &[String], used: &[String], notes: &mut Notes) {
    for (i, name) in required.iter().enumerate() {
        let known = name == QUANTIZATION || APPEARANCE.iter().any(|known| name.starts_with(known));
        if !known {
            let at = format!("extensionsRequired[{i}]");
            let remedy = match name.as_str() {
                "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => {
                    ": export without mesh compression"
                }
                _ => "",
            };
            notes.problem(at, format!("{name} is not supported{remedy}"));
        }
    }
    for name in used {
        if PLACING.contains(&name.as_str()) && !required.contains(name) {
            notes.warn("extensionsUsed", format!("{name} is ignored"));
        }
    }
}
