/// A sphere of a tree at rest, and what each mode does to it.
pub(crate) struct Sphere<'a> {
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
    pub(crate) modes: &'a [Mode],
}

/// One mode at one sphere, found once, when the tree is built. With a vertex i at x_i from the center
/// and displaced by u_i per unit of the mode:
pub(crate) struct Mode {
    /// The mean of u_i over the sphere's vertices.
    pub(crate) shift: [f64; 3],
    /// The largest |u_i - shift|.
    pub(crate) growth: f64,
    /// The largest ±x_i·(u_i - shift) - √((radius² - |x_i|²) (growth² - |u_i - shift|²)).
    pub(crate) pushes: [f64; 2],
}

impl Sphere<'_> {
    /// Center and radius of a sphere around the same vertices when the mesh is deformed by q.
    pub(crate) fn update(&self, q: &[f64]) -> ([f64; 3], f64) {
        let mut center = self.center;
        let (mut growth, mut push) = (0.0, 0.0);
        for (mode, q) in self.modes.iter().zip(q) {
            for axis in 0..3 {
                center[axis] += mode.shift[axis] * q;
            }
            growth += mode.growth * q.abs();
            push += mode.pushes[usize::from(*q <= 0.0)] * q.abs();
        }
        // The paper's radius is `self.radius + growth`, which is what a push of radius · growth gives.
        let square = self.radius * self.radius + 2.0 * push + growth * growth;
        (center, square.sqrt())
    }
}
