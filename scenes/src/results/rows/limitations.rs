//! What the paper leaves open.

use super::super::shown::Shown::{Page, Program, Test};
use super::{BENCHMARKS, BOUNDS, DECISION, Row, not_yet, part, says, whole};

pub(super) const LIMITATIONS: &[Row] = &[
    whole(
        "P51",
        "R' always grows",
        "a body that shrinks to a point: 2 R",
        says!("the second-order radius shrinks with it"),
        &[
            Test(
                "bdtree-build/tests/wrap_bounds.rs",
                "uniform_scaling_is_exact",
            ),
            Test(
                "bdtree-runtime/tests/shrink_to_point.rs",
                "a_chair_that_shrinks",
            ),
            Page("docs/hard-cases.md"),
        ],
    ),
    part(
        "P52",
        "many or rough fields cost",
        "stated",
        says!("a bake of rough fields warns with the visits it expects"),
        &[
            Test(
                "bdtree-build/tests/visits.rs",
                "noise_is_warned_about_with_figures",
            ),
            Program("growth"),
        ],
    ),
    whole(
        "P53",
        "where a refit wins",
        "stated",
        says!(
            "for each asset in its report; over modes, displacement, contacts and balls a step below"
        ),
        &[Page("docs/report.md"), Program("growth"), BENCHMARKS],
    ),
    whole(
        "P54",
        "answers within a limit of time",
        "not offered",
        says!("queries within a number of visits say what they left out"),
        &[Test(
            "bdtree-runtime/tests/budget.rs",
            "bounds_are_true_and_rise_to_the_answer",
        )],
    ),
    whole(
        "P55",
        "other and mixed bounds",
        "future work",
        says!(
            "boxes for leaves or inner nodes alone gain nothing: `bench bounds` of commit c863d38, not adopted"
        ),
        &[BOUNDS, DECISION],
    ),
    whole(
        "P56",
        "top-down and bottom-up mixed",
        "future work",
        says!(
            "refitting hot nodes costs more vertices than it saves tests: `bench bounds` of commit c863d38, not adopted"
        ),
        &[BOUNDS, DECISION],
    ),
    whole(
        "P57",
        "trees made for what deforms",
        "future work",
        says!(
            "splits and leaf sizes counted on deformed meshes; the product's tree takes 0.85 to 0.97 of the node \
             tests of Quinlan's splits (`bench bounds` of commit c863d38)"
        ),
        &[Page("docs/decisions/tree-split-and-leaf-size.md"), BOUNDS],
    ),
    whole(
        "P58",
        "temporal coherence",
        "future work",
        says!(
            "fronts of pairs with the answers of a walk from the root; visits at most 1.05 times, down to a fifth (page)"
        ),
        &[
            Test(
                "bdtree-runtime/tests/fronts.rs",
                "answers_are_those_of_a_walk_from_the_root",
            ),
            Test(
                "bdtree-runtime/tests/fronts.rs",
                "slow_pairs_and_separate_ones_visit_few_nodes",
            ),
            BENCHMARKS,
        ],
    ),
    not_yet("P59", "continuous collision detection", "future work"),
    whole(
        "P60",
        "small changes to sphere trees: a reference implementation in the docs",
        "stated",
        says!("the update in 35 lines of plain Rust, compared with the kernel (page)"),
        &[
            Test(
                "bdtree-runtime/src/reference/mod.rs",
                "the_kernel_is_the_plain_update_within_the_slack",
            ),
            Page("docs/node-update.md"),
        ],
    ),
    whole(
        "P61",
        "distributed processing",
        "stated",
        says!("one asset serves instances on all threads, from q alone"),
        &[
            Test(
                "bdtree-runtime/tests/sharing.rs",
                "one_model_serves_instances_on_several_threads",
            ),
            Test(
                "bdtree-runtime/tests/sharing.rs",
                "what_instances_share_and_own_crosses_threads",
            ),
        ],
    ),
];
