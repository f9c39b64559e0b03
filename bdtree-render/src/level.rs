//! Spheres of a tree at q, where they are in the world.

use bdtree_format::{NodeRecord, ROW_RADIUS, SectionKind};
use bdtree_runtime::{Asset, Datum, FormatError, Pose, Transform};

/// The sphere of a node's lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeSphere {
    /// The node.
    pub node: u32,
    /// The node's level; 0 is the root's.
    pub level: usize,
    /// Its lane.
    pub lane: usize,
    /// The node that the lane leads to; `None` where triangles hang on it.
    pub child: Option<u32>,
    /// c' (world).
    pub center: [f64; 3],
    /// R', rounding slack included (world units); not a number where the bound says nothing.
    pub radius: f64,
    /// R, of the wrapped sphere at rest (world units); with bones, R' with q = 0 and the bones at rest, since bones may
    /// scale.
    pub rest_radius: f64,
}

/// The spheres of a level at a pose, and the leaves above it: together they hold the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// The level; 0 is the root's.
    pub level: usize,
    /// Its spheres and those of earlier levels that triangles hang on, in the order of the file.
    pub spheres: Vec<NodeSphere>,
}

impl Level {
    /// All spheres of `level`, and the leaves above it.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn of(pose: &Pose<'_>, level: usize) -> Result<Self, FormatError> {
        let asset = pose.asset();
        let nodes = asset.node_count_to(level) as u32;
        let above = level
            .checked_sub(1)
            .map_or(0, |above| asset.node_count_to(above)) as u32;
        let mut spheres = NodeSphere::of_nodes(pose, 0..above)?;
        spheres.retain(|sphere| sphere.child.is_none());
        spheres.extend(NodeSphere::of_nodes(pose, above..nodes)?);
        Ok(Self { level, spheres })
    }
}

impl NodeSphere {
    /// The spheres of some nodes' lanes, in their order.
    ///
    /// # Errors
    /// A node that is not there, a corrupt asset.
    pub fn of_nodes(
        pose: &Pose<'_>,
        nodes: impl IntoIterator<Item = u32>,
    ) -> Result<Vec<Self>, FormatError> {
        let asset = pose.asset();
        let map = pose.stored_to_world();
        let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
        let bones_at_rest = match asset.has_skin() {
            true => asset.pose(&q, Transform::IDENTITY, &mut memory).ok(),
            false => None,
        };
        let mut found = Vec::new();
        for index in nodes {
            let spheres = pose.node_spheres(index)?;
            let Some(node) = asset.nodes().get(index as usize) else {
                continue; // `node_spheres` has said so
            };
            let rest = match &bones_at_rest {
                Some(pose) => pose.node_spheres(index)?.radius,
                None => asset.node_rows(node)?.leading[ROW_RADIUS],
            };
            for lane in node.lanes() {
                found.push(Self {
                    node: index,
                    level: usize::from(node.level),
                    lane,
                    child: node.child(lane),
                    center: map.point([0, 1, 2].map(|k| spheres.center[k][lane])),
                    radius: f64::from(spheres.radius[lane]) * map.scale(),
                    rest_radius: f64::from(rest[lane]) * map.scale(),
                });
            }
        }
        Ok(found)
    }
}

/// The vertices of the triangles below a lane, each once, ascending.
///
/// # Errors
/// A corrupt asset.
pub fn below(asset: &Asset<'_>, node: u32, lane: usize) -> Result<Vec<u32>, FormatError> {
    let mut vertices = Vec::new();
    let mut visits = 0;
    let mut open = vec![(node, Some(lane))];
    while let Some((index, only)) = open.pop() {
        visits += 1;
        let node = asset.nodes().get(index as usize);
        // In a corrupt file a child may be one of its own ancestors.
        let (Some(node), true) = (node, visits <= asset.node_count()) else {
            return Err(bad_child(asset, index));
        };
        for lane in node
            .lanes()
            .filter(|lane| only.is_none_or(|only| only == *lane))
        {
            if let Some(child) = node.child(lane) {
                open.push((child, None));
                continue;
            }
            let Some(records) = asset.triangles().get(node.slots(lane)) else {
                return Err(bad_child(asset, index));
            };
            vertices.extend(records.iter().flat_map(|record| record.corners));
        }
    }
    vertices.sort_unstable();
    vertices.dedup();
    Ok(vertices)
}

fn bad_child(asset: &Asset<'_>, index: u32) -> FormatError {
    let of_nodes = asset
        .sections()
        .iter()
        .find(|s| s.kind == SectionKind::NODES);
    let start = of_nodes.map_or(0, |section| section.offset.get());
    FormatError {
        section: SectionKind::NODES,
        byte: start + u64::from(index) * size_of::<NodeRecord>() as u64,
        rule: "SPEC 6.8: a child is a node of the file",
        expected: Datum::Integer(asset.node_count() as u64),
        found: Datum::Integer(u64::from(index)),
    }
}
