//! Tangents of a program's mesh, so that normal maps go with the deformation.

use bevy_math::{Vec3, Vec4, Vec4Swizzles};
use bevy_mesh::{Mesh, PrimitiveTopology, VertexAttributeValues};

/// How each vertex's tangent follows from where the vertices around it went.
///
/// A triangle takes the part of the tangent that lies in its plane along, as its edges go. The vertex gets the sum over its
/// triangles, weighted by their angles there at rest: a sum Σ c (p' − p'₀) over the vertices around it, whose numbers c are
/// those of the mesh at rest. The pass that writes vertices takes from it what is along the normal, and the length.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Tangents {
    /// Of each vertex the word at which its pairs begin, and one behind the last; then the pairs: a vertex and its number c
    /// (f32).
    pub(crate) words: Vec<u32>,
}

/// What a triangle's edges span at least, as a share of their lengths' product, to take a tangent along.
const SMALLEST_SINE: f32 = 1e-4;

impl Tangents {
    /// `None` of a mesh without tangents as `Float32x4`, or that is no list of triangles.
    pub(crate) fn of(mesh: &Mesh) -> Option<Self> {
        let VertexAttributeValues::Float32x3(positions) =
            mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()?
        else {
            return None;
        };
        let VertexAttributeValues::Float32x4(tangents) =
            mesh.try_attribute(Mesh::ATTRIBUTE_TANGENT).ok()?
        else {
            return None;
        };
        let count = positions.len().min(tangents.len());
        let at = |vertex: usize| Vec3::from_array(positions[vertex]);
        // Of each vertex the vertices around it and their numbers.
        let mut around: Vec<Vec<(u32, f32)>> = vec![Vec::new(); count];
        for triangle in triangles(mesh)? {
            if triangle.iter().any(|vertex| *vertex >= count) {
                continue;
            }
            for k in 0..3 {
                let [vertex, next, last] = [0, 1, 2].map(|j| triangle[(k + j) % 3]);
                let tangent = Vec4::from_array(tangents[vertex]).xyz();
                let edges = [next, last].map(|other| at(other) - at(vertex));
                let Some(shares) = shares(tangent, edges) else {
                    continue;
                };
                let around = &mut around[vertex];
                for (other, share) in [next as u32, last as u32].into_iter().zip(shares) {
                    match around.iter_mut().find(|(known, _)| *known == other) {
                        Some((_, sum)) => *sum += share,
                        None => around.push((other, share)),
                    }
                }
            }
        }
        let mut words = vec![0; count + 1];
        for (vertex, around) in around.iter().enumerate() {
            words[vertex] = words.len() as u32;
            words.extend(
                around
                    .iter()
                    .flat_map(|(other, sum)| [*other, sum.to_bits()]),
            );
        }
        words[count] = words.len() as u32;
        Some(Self { words })
    }
}

/// The part of a tangent in the plane of two edges as multiples of them, times their angle.
fn shares(tangent: Vec3, [e, f]: [Vec3; 2]) -> Option<[f32; 2]> {
    let lengths = e.length() * f.length();
    let sine = e.cross(f).length() / lengths;
    // Not of edges without length, either, where it is no number.
    if !(sine > SMALLEST_SINE) {
        return None;
    }
    let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
    let (et, ft) = (e.dot(tangent), f.dot(tangent));
    let factor = e.angle_between(f) / (sine * lengths).powi(2);
    let shares = [ff * et - ef * ft, ee * ft - ef * et].map(|share| share * factor);
    shares
        .iter()
        .all(|share| share.is_finite())
        .then_some(shares)
}

/// The corners of the triangles of a list; `None` of another topology.
fn triangles(mesh: &Mesh) -> Option<Vec<[usize; 3]>> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let corners: Vec<usize> = match mesh.try_indices_option().ok()? {
        Some(indices) => indices.iter().collect(),
        None => (0..mesh.count_vertices()).collect(),
    };
    Some(corners.as_chunks().0.to_vec())
}
