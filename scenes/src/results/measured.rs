//! The figures of one run of all programs, by path.

use serde_json::Value;

use crate::report::digits;

/// Results of the programs: `curtain`, `tables`, `growth`, `updates`, `pile`.
pub(super) struct Measured(pub(super) Value);

impl Measured {
    /// The number at a JSON pointer.
    pub(super) fn number(&self, pointer: &str) -> Option<f64> {
        self.0.pointer(pointer)?.as_f64()
    }

    /// Three digits of it; `?` where it was not measured.
    pub(super) fn digits(&self, pointer: &str) -> String {
        self.number(pointer).map_or("?".to_string(), digits)
    }

    /// A whole number.
    pub(super) fn count(&self, pointer: &str) -> String {
        let number = self.0.pointer(pointer).and_then(Value::as_u64);
        number.map_or("?".to_string(), |n| n.to_string())
    }

    /// The results of `tables` for one mesh.
    pub(super) fn mesh(&self, name: &str) -> Option<&Value> {
        let meshes = self.0.pointer("/tables/meshes")?.as_array()?;
        meshes.iter().find(|mesh| mesh["mesh"] == name)
    }

    /// Names of the meshes that were measured.
    pub(super) fn meshes(&self) -> Vec<&str> {
        let meshes = self.0.pointer("/tables/meshes").and_then(Value::as_array);
        let all = meshes.into_iter().flatten();
        all.filter_map(|mesh| mesh["mesh"].as_str()).collect()
    }

    /// A text for each mesh, joined.
    pub(super) fn each_mesh(&self, text: impl Fn(&Value) -> Option<String>) -> String {
        let all = self.meshes();
        let all = all.iter().map(|name| {
            let own = self.mesh(name).and_then(&text);
            format!("{name} {}", own.unwrap_or("?".to_string()))
        });
        all.collect::<Vec<_>>().join(", ")
    }

    /// A contender of `curtain`, by the beginning of its name.
    pub(super) fn contender(&self, name: &str, pointer: &str) -> Option<f64> {
        let all = self.0.pointer("/curtain/contenders")?.as_array()?;
        let own = all
            .iter()
            .find(|c| c["name"].as_str().is_some_and(|n| n.starts_with(name)))?;
        own.pointer(pointer)?.as_f64()
    }

    /// Three digits of a contender's figure.
    pub(super) fn of(&self, name: &str, pointer: &str) -> String {
        self.contender(name, pointer)
            .map_or("?".to_string(), digits)
    }
}
