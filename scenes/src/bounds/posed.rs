//! A body at a pose, its lanes' shapes made when a query first asks for their node.

use bdtree_build::tree::LaneKind;
use bdtree_format::LANES;
use nalgebra::{Isometry3, Point3, Vector3};

use super::body::Body;
use super::bound::{Bound, Wrapped};
use super::shape::Shape;

/// A body at a pose in the frame of a query.
#[derive(Debug)]
pub struct Posed<'a> {
    /// The body.
    pub body: &'a Body,
    /// Its bounds.
    pub wrapped: &'a Wrapped,
    /// Nodes whose shapes were made: each once.
    pub updates: u64,
    /// All vertices in the frame of the query.
    pub vertices: Vec<Vector3<f64>>,
    q: &'a [f64],
    /// How often each node was asked for.
    asked: Vec<u32>,
    place: Isometry3<f64>,
    local: Vec<Vector3<f64>>,
    shapes: Vec<Shape>,
    reached: Vec<bool>,
    hulls: bool,
    refit: Option<(&'a Wrapped, Vec<bool>)>,
}

impl<'a> Posed<'a> {
    /// A body that stands at `place`; `hulls`: boxes become their hulls in the query's axes.
    pub fn new(
        body: &'a Body,
        wrapped: &'a Wrapped,
        q: &'a [f64],
        place: Isometry3<f64>,
        hulls: bool,
    ) -> Self {
        let local = body.deformed(q);
        let vertices = local.iter().map(|p| (place * Point3::from(*p)).coords);
        Self {
            body,
            wrapped,
            updates: 0,
            asked: vec![0; body.tree.nodes.len()],
            vertices: vertices.collect(),
            q,
            place,
            local,
            shapes: vec![Shape::default(); body.lane_count()],
            reached: vec![false; body.positions.len()],
            hulls,
            refit: None,
        }
    }

    /// Takes the shapes of another bound, which needs their vertices, for the marked nodes.
    pub fn with_refitted(mut self, other: &'a Wrapped, nodes: Vec<bool>) -> Self {
        for lane in 0..self.body.lane_count() {
            if nodes[lane / LANES] {
                self.reach(lane);
            }
        }
        self.refit = Some((other, nodes));
        self
    }

    /// Nodes that were asked for more than `limit` times.
    pub fn hot(&self, limit: u32) -> Vec<bool> {
        self.asked.iter().map(|count| *count > limit).collect()
    }

    /// Makes a node's shapes where this was not done before.
    pub fn visit(&mut self, node: usize) {
        self.asked[node] += 1;
        if self.asked[node] > 1 {
            return;
        }
        self.updates += 1;
        for lane in self.lanes(node) {
            self.shapes[lane] = self.shape_of(lane);
            if self.wrapped.bound == Bound::LeafWrapped && self.is_leaf(lane) {
                self.reach(lane);
            }
        }
    }

    /// A visited lane's shape in the frame of the query.
    pub fn shape(&self, lane: usize) -> &Shape {
        &self.shapes[lane]
    }

    /// A lane's shape in the frame of the query.
    pub fn shape_of(&self, lane: usize) -> Shape {
        let wrapped = match &self.refit {
            Some((other, nodes)) if nodes[lane / LANES] => other,
            _ => self.wrapped,
        };
        if wrapped.bound == Bound::RefittedBox {
            return wrapped.at(self.body, lane, self.q, &self.vertices);
        }
        let shape = wrapped.at(self.body, lane, self.q, &self.local);
        let mut shape = shape.moved(&self.place);
        if self.hulls {
            shape.cuboid = shape.cuboid.map(|cuboid| cuboid.hull());
        }
        shape
    }

    /// The lanes of a node that hold something.
    pub fn lanes(&self, node: usize) -> impl Iterator<Item = usize> + use<'a> {
        let body = self.body;
        (LANES * node..LANES * (node + 1)).filter(|lane| body.kind(*lane) != LaneKind::Empty)
    }

    /// Notes that the vertices below a lane are needed.
    pub fn reach(&mut self, lane: usize) {
        for v in self.body.vertices_below(lane) {
            self.reached[*v as usize] = true;
        }
    }

    /// How many vertices were needed.
    pub fn reached_count(&self) -> u64 {
        self.reached.iter().filter(|reached| **reached).count() as u64
    }

    /// Whether a lane holds triangles itself.
    pub fn is_leaf(&self, lane: usize) -> bool {
        self.body.kind(lane) == LaneKind::Leaf
    }

    /// A triangle's corners in the frame of the query.
    pub fn triangle(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.body.corners[triangle as usize].map(|v| self.vertices[v as usize].into())
    }

    /// The corners of the triangles of a leaf lane.
    pub fn triangles(&self, lane: usize) -> Vec<[[f64; 3]; 3]> {
        let below = self.body.triangles_below(lane).iter();
        below.map(|t| self.triangle(*t)).collect()
    }
}
