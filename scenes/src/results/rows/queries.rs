//! Boxes, and what is done with a tree.

use super::super::shown::Shown::{Page, Program, Test};
use super::{BENCHMARKS, BOUNDS, DECISION, Row, not_yet, part, says, whole};

pub(super) const BOXES: &[Row] = &[
    whole(
        "P24",
        "axis-parallel boxes",
        "12 M flops",
        says!(
            "the contacts of spheres for more time: measured with `bench bounds` of commit c863d38, not adopted"
        ),
        &[BOUNDS, DECISION],
    ),
    whole(
        "P25",
        "boxes in turned coordinates",
        "proposed",
        says!(
            "0.77 of the spheres' time at rest, 1.7 times at 20 %: `bench bounds` of commit c863d38, not adopted"
        ),
        &[BOUNDS, DECISION],
    ),
    whole(
        "P26",
        "boxes keep a tracked center",
        "proposed",
        says!(
            "intervals of coordinates about it, exact at rest (test `every_lane_holds_its_vertices` of commit c863d38)"
        ),
        &[BOUNDS],
    ),
];

pub(super) const TRAVERSAL: &[Row] = &[
    whole(
        "P27",
        "tree against tree",
        "as for rigid bodies",
        says!("pairs equal brute force"),
        &[Test(
            "bdtree-runtime/tests/queries.rs",
            "pairs_equal_brute_force",
        )],
    ),
    whole(
        "P28",
        "cost follows the answer, not the mesh",
        "stated",
        |m| {
            format!(
                "nodes visited grow as F^{}, time as F^{} (goal: below 0.3)",
                m.digits("/growth/size/exponent_nodes"),
                m.digits("/growth/size/times/exponent_ours")
            )
        },
        &[
            Test(
                "scenes/tests/experiments.rs",
                "visits_hardly_grow_with_the_mesh",
            ),
            Program("growth"),
        ],
    ),
    whole(
        "P29",
        "depth may be bounded",
        "used: 7 to 10",
        says!("every contact is reported or lies in a proxy; error over depth on the page"),
        &[
            Test(
                "bdtree-runtime/tests/bounded.rs",
                "every_contact_is_reported_or_lies_in_a_proxy",
            ),
            BENCHMARKS,
        ],
    ),
    whole(
        "P30",
        "coarse spheres wrap the finer ones",
        "a heuristic under q",
        says!(
            "proved and kept at every q with `--nested`; without it the share that sticks out is on the page"
        ),
        &[
            Test(
                "tests/tests/nested.rs",
                "spheres_hold_those_below_them_at_every_q",
            ),
            BENCHMARKS,
        ],
    ),
    whole(
        "P31",
        "root spheres cull against a view",
        "used",
        says!("a frustum query, exact inside and certain outside"),
        &[Test(
            "bdtree-tools/tests/command/shapes.rs",
            "frustums_say_where_the_mesh_is",
        )],
    ),
    whole(
        "P32",
        "root spheres in a grid",
        "used",
        says!("pairs of the broad phase equal all pairs"),
        &[
            Test("bdtree-runtime/tests/broad.rs", "pairs_equal_all_pairs"),
            Test(
                "bdtree-runtime/tests/broad.rs",
                "comparisons_grow_with_the_spheres",
            ),
        ],
    ),
    whole(
        "P33",
        "triangles at leaves, from q",
        "used for the bridge",
        says!("equal to brute force on the bridge"),
        &[Test(
            "bdtree-runtime/tests/queries.rs",
            "bridge_queries_equal_brute_force",
        )],
    ),
    whole(
        "P34",
        "deformation on a GPU",
        "used",
        says!("within a proved bound of the exact place; queries need no deformed mesh"),
        &[
            Test(
                "bdtree-gpu/tests/positions.rs",
                "positions_of_all_fixtures_are_within_their_bound",
            ),
            Page("docs/skinning.md"),
        ],
    ),
    part(
        "P35",
        "penalty forces",
        "used",
        says!("manifolds with depths; a falling body gains no energy"),
        &[Test(
            "bdtree-runtime/tests/manifold.rs",
            "penalty_forces_do_not_raise_the_energy_of_a_falling_body",
        )],
    ),
    not_yet("P36", "linear modal dynamics with limited strain", "used"),
    whole(
        "P37",
        "a ball against an animation",
        "Table 2",
        says!("see P38"),
        &[Program("curtain")],
    ),
];
