//! Centers and radii under q.

use super::super::shown::Shown::{Page, Program, Test};
use super::{BENCHMARKS, Row, says, whole};
use crate::report::digits;

pub(super) const UPDATES: &[Row] = &[
    whole(
        "P12",
        "center c' = c + Ū q, Ū the mean",
        "6 M flops",
        says!(
            "the baseline's; the product takes the center of the displacements' smallest ball, linear in M"
        ),
        &[
            Test("scenes/tests/paper_tree.rs", "spheres_hold_their_vertices"),
            BENCHMARKS,
        ],
    ),
    whole(
        "P13",
        "radius R' = R + ΔR · |q|",
        "2 M flops",
        says!(
            "no vertex outside, at random, huge, tiny and sparse q; ours is never above the paper's"
        ),
        &[
            Test("scenes/tests/paper_tree.rs", "spheres_hold_their_vertices"),
            Test(
                "bdtree-build/tests/wrap_containment.rs",
                "spheres_contain_their_vertices_on_hard_meshes",
            ),
            Test(
                "bdtree-build/tests/wrap_bounds.rs",
                "second_order_bound_is_never_above_the_first",
            ),
        ],
    ),
    whole(
        "P14",
        "numbers of a node",
        "4 M beside c, R",
        says!(
            "c, R, Ū, ΔR, b± as SPEC.md says; a reader in another language, written from it alone, reads all files"
        ),
        &[
            Test("tests/tests/python_reader.rs", "golden_files_are_read"),
            Page("format-spec/SPEC.md"),
        ],
    ),
    whole(
        "P15",
        "updates in any order",
        "stated",
        says!("each node's spheres follow from its own rows and q; kept and fresh ones are equal"),
        &[
            Test(
                "bdtree-runtime/tests/epochs.rs",
                "answers_are_those_of_fresh_spheres",
            ),
            Test(
                "bdtree-runtime/tests/kernels.rs",
                "every_kernel_gives_the_same_bits",
            ),
        ],
    ),
    whole(
        "P16",
        "lazily, once per node and step",
        "stated",
        says!("updates never exceed visited nodes; nothing is allocated"),
        &[
            Test(
                "bdtree-tools/tests/command/render.rs",
                "visited_nodes_are_those_that_queries_count",
            ),
            Test(
                "bdtree-runtime/tests/allocation.rs",
                "queries_allocate_nothing",
            ),
        ],
    ),
    whole(
        "P17",
        "8 M flops per tested node",
        "8 M flops",
        says!("10 M per sphere, eight spheres at once; times over M = 1 to 64 on the page"),
        &[BENCHMARKS],
    ),
    whole(
        "P18",
        "R'' = R' + δR ‖δq‖",
        "1 flop",
        says!("holds along random paths; spheres follow a pose for one multiplication and one sum"),
        &[
            Test(
                "bdtree-build/tests/wrap_bounds.rs",
                "step_bounds_hold_and_are_tight_for_one_mode",
            ),
            BENCHMARKS,
        ],
    ),
    whole(
        "P19",
        "few, smooth fields give tight trees",
        "stated",
        says!("visits over M in `growth`; noise is warned of when it is baked"),
        &[
            Test(
                "bdtree-build/tests/visits.rs",
                "noise_is_warned_about_with_figures",
            ),
            Test("bdtree-build/tests/visits.rs", "smooth_fields_are_not"),
            Program("growth"),
        ],
    ),
    whole(
        "P20",
        "translations leave R as it is",
        "stated",
        says!("to the rounding of Ū"),
        &[Test(
            "bdtree-build/tests/wrap_bounds.rs",
            "translation_fields_hardly_grow_anything",
        )],
    ),
    whole(
        "P21",
        "‖ΔR‖ decays by level",
        "chair: 1.000 … 0.030 at level 10 … 0.003",
        |m| {
            let text = m.each_mesh(|mesh| {
                let means = mesh["decay"]["paper"]["by_level"].as_array()?;
                let falls = mesh["decay"]["paper"]["falls"] == true;
                let rises = if falls { "" } else { " (not on every level)" };
                Some(format!("{}{rises}", digits(means.get(10)?.as_f64()?)))
            });
            format!("at level 10: {text}")
        },
        &[
            Test(
                "scenes/tests/experiments.rs",
                "growth_decays_as_in_the_paper",
            ),
            Test("scenes/tests/paper_tree.rs", "growth_decays_by_level"),
            Program("tables"),
        ],
    ),
    whole(
        "P22",
        "Appendix A: ΔR ≤ 2 L R",
        "proved",
        |m| {
            let text = m.each_mesh(|mesh| {
                let all = mesh["appendix_a"].as_array()?;
                let of = |k: usize| Some(digits(all.get(k)?["largest"].as_f64()?));
                Some(format!("{} and {}", of(0)?, of(1)?))
            });
            format!(
                "largest ΔR / (L R), the mean tracked (at most 2) and ball centers (at most 1.22): {text}"
            )
        },
        &[
            Test("scenes/tests/experiments.rs", "appendix_a_holds"),
            Test(
                "bdtree-build/tests/wrap_bounds.rs",
                "growth_is_bounded_by_the_smoothness_of_the_field",
            ),
            Program("tables"),
        ],
    ),
    whole(
        "P23",
        "ΔR may exceed δR",
        "noted",
        |m| {
            let text = m.each_mesh(|mesh| {
                let share = mesh["appendix_a"][0]["share_above_common"].as_f64()?;
                Some(format!("{} %", digits(100.0 * share)))
            });
            format!("share of nodes and modes: {text}")
        },
        &[Program("tables")],
    ),
];
