//! What differences of numbers do to the mesh: how far vertices lie apart.

use bdtree_runtime::{Asset, VertexId};
use serde::Serialize;

use super::findings::Difference;
use crate::AssetFile;
use crate::error::ToolError;
use crate::info::{bounds, mode_name};

/// A mode counts as negated if negating it leaves at most this share of the distance. The sign of a vibration mode or of
/// a principal component is arbitrary, and small changes of the input can turn it.
const NEGATED_REL: f64 = 0.1;

/// The vertex that lies farthest apart in the two files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Effect {
    /// `rest positions`, or the mode that moves it, with its name.
    pub what: String,
    /// The vertex.
    pub vertex: u32,
    /// How far apart it is (mesh units): at rest, or by one mode at its q_range.
    pub distance: f64,
    /// The same over the diagonal of the box around the first file's rest positions.
    pub distance_rel: f64,
    /// The q at which that is; absent at rest.
    pub q: Option<f32>,
    /// Where the mode of the second file is nearly the negative of the first file's: the largest distance (mesh units)
    /// that remains if q is negated in one of the two files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub negated_distance: Option<f64>,
    /// The numbers that lead to it differ within the tolerance.
    pub tolerated: bool,
}

/// The effects that are not zero, of files with the same number of vertices; of their modes if `modes` is true. Those
/// whose numbers are not among `differences` are tolerated.
///
/// # Errors
/// Displacements outside their section, in the file that is named.
pub(super) fn effects(
    files: [&AssetFile; 2],
    modes: bool,
    differences: &[Difference],
) -> Result<Vec<Effect>, ToolError> {
    let [a, b] = files.map(AssetFile::asset);
    let diagonal = bounds(a).map_or(0.0, |bounds| bounds.diagonal());
    let counts = |whats: &[String]| differences.iter().any(|d| whats.contains(&d.what));
    let effect = |what: String, (vertex, distance): (u32, f64), q, from: &[String]| Effect {
        what,
        vertex,
        distance,
        distance_rel: if diagonal > 0.0 {
            distance / diagonal
        } else {
            0.0
        },
        q,
        negated_distance: None,
        tolerated: !counts(from),
    };
    let mut effects = Vec::new();
    let at_rest = farthest(a, |vertex| {
        Ok(apart(position(a, vertex), position(b, vertex)))
    })?;
    let from = ["header: origin", "section VERT: rest positions"].map(str::to_string);
    effects.extend(at_rest.map(|found| effect("rest positions".to_string(), found, None, &from)));
    let mode_count = if modes { a.mode_count() } else { 0 };
    for mode in 0..mode_count {
        let q = a.modes()[mode].q_range.get();
        let field = |file: &AssetFile, vertex| -> Result<[f64; 3], ToolError> {
            let asset = file.asset();
            let own = asset
                .displacements(vertex)
                .map_err(|error| file.error(error))?;
            Ok(own
                .of(mode)
                .map(|u| f64::from(u) * asset.unit() * f64::from(q)))
        };
        let moved = farthest(a, |vertex| {
            Ok(apart(field(files[0], vertex)?, field(files[1], vertex)?))
        })?;
        let Some((vertex, distance)) = moved else {
            continue;
        };
        let negated = farthest(a, |vertex| {
            let b = field(files[1], vertex)?.map(|u| -u);
            Ok(apart(field(files[0], vertex)?, b))
        })?;
        let negated = negated.map_or(0.0, |(_, distance)| distance);
        let name = mode_name(files[0], mode)?;
        let from = [format!("section DISP: displacements of mode {mode}")];
        let effect = effect(name, (vertex, distance), Some(q), &from);
        effects.push(Effect {
            negated_distance: (negated <= NEGATED_REL * distance).then_some(negated),
            ..effect
        });
    }
    Ok(effects)
}

/// The vertex of the largest distance above 0.
fn farthest(
    asset: &Asset<'_>,
    distance: impl Fn(VertexId) -> Result<f64, ToolError>,
) -> Result<Option<(u32, f64)>, ToolError> {
    let mut farthest: Option<(u32, f64)> = None;
    for vertex in 0..asset.vertex_count() as u32 {
        let distance = distance(VertexId(vertex))?;
        if distance > farthest.map_or(0.0, |(_, most)| most) {
            farthest = Some((vertex, distance));
        }
    }
    Ok(farthest)
}

fn position(asset: &Asset<'_>, vertex: VertexId) -> [f64; 3] {
    let stored = asset.positions()[vertex.0 as usize];
    let origin = asset.origin();
    [0, 1, 2].map(|k| origin[k] + asset.unit() * f64::from(stored[k]))
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = [0, 1, 2].map(|k| (a[k] - b[k]).powi(2));
    squares.iter().sum::<f64>().sqrt()
}
