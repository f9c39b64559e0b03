//! Points that stiff springs hold.

use crate::elastic::element::spline::FUNCTIONS;

/// A point in a component, and the weight of each node there.
#[derive(Debug, Clone)]
pub(crate) struct Anchor {
    /// Component.
    pub component: usize,
    /// Nodes of that component.
    pub nodes: [u32; FUNCTIONS],
    /// The functions' values; they add up to 1.
    pub weights: [f64; FUNCTIONS],
}

/// A point of a component that is held along some axes by a stiff spring.
#[derive(Debug, Clone)]
pub(crate) struct Constraint {
    /// Where.
    pub anchor: Anchor,
    /// Whether x, y, z are held.
    pub axes: [bool; 3],
    /// Share of the spring that its cell gets; the shares of a fix add up to 1 in each cell.
    pub share: f64,
}
