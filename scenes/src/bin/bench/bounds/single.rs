//! Balls against a curtain, rays against the bumpy sphere.

use bdtree_build::tree::Split;
use bdtree_fixtures::poses::rng;
use bdtree_scenes::bounds::body::Body;
use bdtree_scenes::bounds::bound::Wrapped;
use bdtree_scenes::bounds::contenders::contenders;
use bdtree_scenes::bounds::pair::Filter;
use bdtree_scenes::bounds::posed::Posed;
use bdtree_scenes::bounds::scene::{self, Mesh};
use bdtree_scenes::bounds::shape::Ball;
use bdtree_scenes::bounds::single::{Counts, ball, ray};
use nalgebra::Isometry3;
use rand::RngExt;

use super::contact::Bodies;
use super::table::Table;
use super::{Arguments, Costs, displacement_name};

/// Balls or rays per pose.
const PER_POSE: usize = 32;

const COLUMNS: [&str; 5] = [
    "numbers per lane",
    "visits",
    "triangles",
    "found",
    "updates µs",
];

/// A ball of 5 % of the curtain's width, its centre within a radius of the surface; 12 modes.
pub(super) fn balls(displacement: Option<f64>, arguments: &Arguments, costs: &Costs) -> Table {
    let mesh = scene::curtain(79);
    let fields = scene::smooth_fields(&mesh, 12, 3.0, &mut rng(arguments.seed));
    let body = mesh.body(&fields, Split::Cost, 4);
    let title = format!("ball, curtain, {}", displacement_name(displacement));
    compared(
        &title,
        &body,
        costs,
        |wrapped| {
            let mut rng = rng(arguments.seed + 2);
            let mut sum = Counts::default();
            for _ in 0..arguments.poses {
                let q = scene::pose(&body, mesh.diagonal(), displacement, &mut rng);
                let mut posed = Posed::new(&body, wrapped, &q, Isometry3::identity(), false);
                for _ in 0..PER_POSE {
                    let at = posed.vertices[rng.random_range(0..posed.vertices.len())];
                    let offset = scene::direction(&mut rng) * rng.random_range(0.0..0.1);
                    let found = ball(
                        &mut posed,
                        &Ball {
                            centre: at + offset,
                            radius: 0.1,
                        },
                    );
                    sum = added(sum, found);
                }
            }
            sum
        },
        arguments,
    )
}

/// Random rays from outside, nearest hit; 10 modes.
pub(super) fn rays(
    bodies: &Bodies,
    displacement: Option<f64>,
    arguments: &Arguments,
    costs: &Costs,
) -> Table {
    let title = format!("rays, bumpy sphere, {}", displacement_name(displacement));
    let all =
        |wrapped: &Wrapped| all_rays(&bodies.body, wrapped, &bodies.mesh, displacement, arguments);
    compared(&title, &bodies.body, costs, all, arguments)
}

/// Mean visits and triangles of a ray.
pub(super) fn ray_counts(
    body: &Body,
    wrapped: &Wrapped,
    mesh: &Mesh,
    displacement: Option<f64>,
    arguments: &Arguments,
) -> (f64, f64) {
    let sum = all_rays(body, wrapped, mesh, displacement, arguments);
    let count = (arguments.poses * PER_POSE) as f64;
    (sum.visits as f64 / count, sum.triangles as f64 / count)
}

fn all_rays(
    body: &Body,
    wrapped: &Wrapped,
    mesh: &Mesh,
    displacement: Option<f64>,
    arguments: &Arguments,
) -> Counts {
    let mut rng = rng(arguments.seed + 3);
    let mut sum = Counts::default();
    for _ in 0..arguments.poses {
        let q = scene::pose(body, mesh.diagonal(), displacement, &mut rng);
        let mut posed = Posed::new(body, wrapped, &q, Isometry3::identity(), false);
        for _ in 0..PER_POSE {
            let origin = scene::direction(&mut rng) * 3.0;
            let target = scene::direction(&mut rng) * (1.1 * rng.random_range(0.0..1.0_f64).cbrt());
            let line = (origin, (target - origin).normalize());
            sum = added(sum, ray(&mut posed, &line).0);
        }
    }
    sum
}

fn added(a: Counts, b: Counts) -> Counts {
    Counts {
        visits: a.visits + b.visits,
        triangles: a.triangles + b.triangles,
        found: a.found + b.found,
    }
}

/// A row per bound: tests of one body know no second frame.
fn compared(
    title: &str,
    body: &Body,
    costs: &Costs,
    query: impl Fn(&Wrapped) -> Counts,
    arguments: &Arguments,
) -> Table {
    let mut table = Table::new(title, &COLUMNS);
    let count = (arguments.poses * PER_POSE) as f64;
    let mut done = Vec::new();
    for contender in contenders() {
        let repeats = done.contains(&contender.bound) || contender.filter == Filter::None;
        if repeats || contender.hot.is_some() {
            continue;
        }
        done.push(contender.bound);
        let wrapped = Wrapped::new(body, contender.bound);
        let sum = query(&wrapped);
        let m = body.mode_count();
        let update = costs.update(contender.bound, m);
        let visits = sum.visits as f64 / count;
        table.push(
            contender.name,
            vec![
                contender.bound.numbers(m) as f64,
                visits,
                sum.triangles as f64 / count,
                sum.found as f64 / count,
                visits * update / 1e3,
            ],
        );
    }
    table
}
