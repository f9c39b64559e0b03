//! From corners in file order to triangles.

use gltf::json::mesh::Mode;

/// The triangles of a primitive, as glTF 2.0, 3.7.2.1 orders their corners: the n-th triangle of a
/// strip is (n, n + 1, n + 2), every second one (n, n + 2, n + 1); that of a fan is
/// (n + 1, n + 2, 0).
///
/// # Errors
/// Too few corners for one triangle, or corners left over.
pub(super) fn triangles(mode: Mode, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let count = corners.len();
    if count < 3 {
        return Err(format!("{count} corners; a triangle has 3"));
    }
    Ok(match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(n, w)| {
                if n % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[0], w[2], w[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => corners[1..]
            .windows(2)
            .map(|w| [w[0], w[1], corners[0]])
            .collect(),
        _ if !count.is_multiple_of(3) => {
            return Err(format!("corner count is not a multiple of 3: {count}"));
        }
        _ => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let corners = [10, 11, 12, 13, 14];
        let strip = triangles(Mode::TriangleStrip, &corners);
        assert_eq!(strip, Ok(vec![[10, 11, 12], [11, 13, 12], [12, 13, 14]]));
        let fan = triangles(Mode::TriangleFan, &corners);
        assert_eq!(fan, Ok(vec![[11, 12, 10], [12, 13, 10], [13, 14, 10]]));
        assert!(triangles(Mode::Triangles, &corners).is_err());
        assert!(triangles(Mode::TriangleStrip, &corners[..2]).is_err());
        assert_eq!(
            triangles(Mode::Triangles, &corners[..3]),
            Ok(vec![[10, 11, 12]])
        );
    }
}
