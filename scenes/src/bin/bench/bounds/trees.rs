//! What the tree gives: leaf sizes and splits under the product's bound.

use bdtree_build::tree::Split;
use bdtree_scenes::bounds::bound::Wrapped;
use bdtree_scenes::bounds::contenders::contenders;

use super::contact::{Bodies, COLUMNS, Frame, exact_ns, measure, row, weights};
use super::table::Table;
use super::{Arguments, Costs, single};

pub(super) fn table(
    bodies: &Bodies,
    title: &str,
    frames: &[Frame],
    arguments: &Arguments,
    costs: &Costs,
) -> Table {
    let columns = [&COLUMNS[..], &["ray visits", "ray triangles", "node bytes"]].concat();
    let mut table = Table::new(&format!("trees, two bodies and rays, {title}"), &columns);
    // The product's ball with lanes filtered.
    let contender = contenders()[1];
    for split in [Split::Quinlan, Split::Cost] {
        for leaf_size in [1, 2, 4, 8] {
            let body = bodies.mesh.body(&bodies.fields, split, leaf_size);
            let wrapped = Wrapped::new(&body, contender.bound);
            let all = measure(&body, &wrapped, &wrapped, &contender, frames);
            let exact = exact_ns(&body, &wrapped, frames);
            let mut values = row(&all, &contender, &weights(&contender, costs, exact));
            let rays = single::ray_counts(&body, &wrapped, &bodies.mesh, None, arguments);
            let node_rows = 4 + 3 * body.mode_count() + 2;
            let bytes = body.tree.nodes.len() * (32 + 32 * node_rows);
            values.extend([rays.0, rays.1, bytes as f64]);
            table.push(format!("{split}, leaf size {leaf_size}"), values);
        }
    }
    table
}
