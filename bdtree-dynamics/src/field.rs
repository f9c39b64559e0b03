//! How the modes of a body move one of its points, or a contact sphere: a matrix of three rows.

use nalgebra::{Matrix3, Vector3};

/// Mode coefficients are padded to a multiple of this, so that loops over them need no remainder.
pub(crate) const PAD: usize = 4;

/// U of a point or Ū of a sphere, in the body's frame: x of all modes (padded), y, z.
#[derive(Debug, Clone, Copy)]
pub struct Field<'f>(pub(crate) &'f [f64]);

impl Field<'_> {
    /// Modes, padded.
    #[inline(always)]
    pub fn stride(self) -> usize {
        self.0.len() / 3
    }

    /// U q, in the body's frame; `q` is padded.
    #[inline(always)] // several hundred thousand calls a step
    pub fn displacement(self, q: &[f64]) -> Vector3<f64> {
        let [x, y, z] = self.rows();
        Vector3::new(dot(x, q), dot(y, q), dot(z, q))
    }

    /// Adds `D Uᵀ f` to `out`, D being diagonal: what a force in the body's frame does to q.
    #[inline(always)] // as above
    pub fn pull(self, force: Vector3<f64>, diagonal: &[f64], out: &mut [f64]) {
        let [x, y, z] = self.rows();
        let each = x.iter().zip(y).zip(z).zip(diagonal).zip(out);
        for ((((x, y), z), d), out) in each {
            *out += d * (x * force.x + y * force.y + z * force.z);
        }
    }

    /// U D Uᵀ, D being diagonal.
    #[inline]
    pub fn compliance(self, diagonal: &[f64]) -> Matrix3<f64> {
        let [x, y, z] = self.rows();
        let [mut xx, mut yy, mut zz, mut xy, mut xz, mut yz] = [0.0; 6];
        for (((x, y), z), d) in x.iter().zip(y).zip(z).zip(diagonal) {
            let (dx, dy) = (d * x, d * y);
            xx += dx * x;
            yy += dy * y;
            zz += d * z * z;
            xy += dx * y;
            xz += dx * z;
            yz += dy * z;
        }
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Largest singular value of U, or of what it differs from another one by.
    pub(crate) fn norm(self, from: Option<Self>) -> f64 {
        let [x, y, z] = self.rows();
        let others = from.map(Self::rows);
        let mut products = Matrix3::zeros();
        for j in 0..x.len() {
            let mut field = Vector3::new(x[j], y[j], z[j]);
            if let Some([x, y, z]) = others {
                field -= Vector3::new(x[j], y[j], z[j]);
            }
            products += field * field.transpose();
        }
        libm::sqrt(products.symmetric_eigenvalues().max().max(0.0))
    }
}

impl<'f> Field<'f> {
    #[inline(always)]
    fn rows(self) -> [&'f [f64]; 3] {
        let stride = self.0.len() / 3;
        let (x, rest) = self.0.split_at(stride);
        let (y, z) = rest.split_at(stride);
        [x, y, z]
    }
}

/// In four sums, which a compiler puts into lanes; the order is fixed, so that results are the same everywhere.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, _) = a.as_chunks::<PAD>();
    let (b, _) = b.as_chunks::<PAD>();
    let mut sums = [0.0; PAD];
    for (a, b) in a.iter().zip(b) {
        for k in 0..PAD {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
