//! The reduced model and the tree at rest.

use super::super::shown::Shown::{Page, Program, Test};
use super::{Row, says, whole};
use crate::report::digits;

pub(super) const MODEL: &[Row] = &[
    whole(
        "P01",
        "p' = p + U q, q from anywhere",
        "Eq. 1",
        says!(
            "deformed vertices have the bits of the f32 sum, in every kernel; frames play as baked"
        ),
        &[
            Test("scenes/tests/workloads.rs", "deformation_is_the_products"),
            Test(
                "bdtree-runtime/tests/frames.rs",
                "playback_is_what_was_baked",
            ),
        ],
    ),
    whole(
        "P02",
        "bases: vibration modes, principal components, key shapes",
        "used, not compared",
        says!("all three, and given fields; errors are stated in the file"),
        &[
            Test(
                "bdtree-build/src/elastic/volume/tests.rs",
                "free_bodies_meet_the_dense_solution",
            ),
            Test("bdtree-build/tests/pca.rs", "the_error_is_the_optimal_one"),
            Test("bdtree-build/tests/gltf/morph.rs", "weights_become_q"),
            Page("docs/elastic.md"),
            Page("docs/animation.md"),
        ],
    ),
    whole(
        "P03",
        "any hierarchy at rest",
        "a binary tree like Quinlan's",
        says!(
            "two builders for the product's tree (`tree::Split`), the paper's beside them, all tested alike"
        ),
        &[
            Test(
                "scenes/tests/paper_tree.rs",
                "balls_of_all_builders_equal_brute_force",
            ),
            Test(
                "bdtree-build/tests/encode.rs",
                "nodes_rows_and_triangles_stand_in_canonical_order",
            ),
        ],
    ),
    whole(
        "P04",
        "one triangle per leaf: 2 F − 1 spheres",
        "chair 35827, bridge 480631, fish 49551, curtain 24039",
        |m| m.each_mesh(|mesh| Some(mesh["spheres"].as_u64()?.to_string())),
        &[
            Test("scenes/tests/paper_tree.rs", "one_leaf_per_triangle"),
            Test(
                "fixtures/tests/obj_fixtures.rs",
                "the_papers_meshes_have_the_papers_sizes",
            ),
            Program("tables"),
        ],
    ),
    whole(
        "P05",
        "levels",
        "chair 19, bridge 26, fish 18, curtain 17",
        |m| {
            m.each_mesh(|mesh| {
                Some(format!(
                    "{} (ours, of eight: {})",
                    mesh["levels"].as_u64()?,
                    mesh["our_levels"].as_u64()?
                ))
            })
        },
        &[
            Test(
                "bdtree-build/tests/encode.rs",
                "any_input_stays_within_the_largest_depth",
            ),
            Program("tables"),
        ],
    ),
    whole(
        "P06",
        "wrapped spheres",
        "Eq. 2",
        says!("some vertex touches every sphere, to an ulp of its radius"),
        &[Test(
            "bdtree-build/tests/wrap_bounds.rs",
            "some_vertex_touches_every_sphere",
        )],
    ),
    whole(
        "P07",
        "or the smallest enclosing ball",
        "Welzl 1991",
        says!("the product's spheres; radius that of the best support set"),
        &[
            Test(
                "bdtree-build/tests/wrap_ball.rs",
                "radius_is_that_of_the_best_support_set",
            ),
            Test(
                "bdtree-build/tests/wrap_ball.rs",
                "symmetric_bodies_have_their_balls",
            ),
        ],
    ),
    whole(
        "P08",
        "wrapped spheres are smaller than layered ones",
        "figures 3 and 4",
        |m| {
            let least = m.each_mesh(|mesh| {
                Some(digits(
                    mesh["ratios"]["least_layered_over_wrapped_of_inner_levels"].as_f64()?,
                ))
            });
            format!("mean ratio layered / wrapped, the least of all inner levels: {least}")
        },
        &[
            Test(
                "scenes/tests/experiments.rs",
                "layered_spheres_are_larger_than_wrapped_ones",
            ),
            Program("tables"),
            Program("figures"),
        ],
    ),
    whole(
        "P09",
        "figure 6, at rest, level 6: layered / wrapped",
        "bridge: mean 1.31, max 1.77",
        |m| {
            m.each_mesh(|mesh| {
                let ratios = &mesh["ratios"]["levels"][6]["ratios"][0]["layered"];
                Some(format!(
                    "{} / {}",
                    digits(ratios["mean"].as_f64()?),
                    digits(ratios["max"].as_f64()?)
                ))
            })
        },
        &[Program("tables"), Program("figures")],
    ),
    whole(
        "P10",
        "figure 6, deformed",
        "bridge: layered 1.31 / 1.79, BD-Tree 1.25 / 1.56",
        |m| {
            let text = m.each_mesh(|mesh| {
                let all = mesh["ratios"]["levels"][6]["ratios"].as_array()?;
                let last = all.iter().rfind(|case| case["deformation"] == "natural")?;
                let pair = |who: &str| {
                    Some(format!(
                        "{} / {}",
                        digits(last[who]["mean"].as_f64()?),
                        digits(last[who]["max"].as_f64()?)
                    ))
                };
                Some(format!(
                    "layered {}, paper's bound {}, ours {}",
                    pair("layered")?,
                    pair("paper")?,
                    pair("ours")?
                ))
            });
            let as_figure = m.each_mesh(|mesh| {
                let there = &mesh["crossings"][0]["paper_as_in_its_figure"];
                Some(match there["amplitude"].as_f64() {
                    Some(share) => format!(
                        "layered {}, ours {} ({:.1} % of the diagonal)",
                        digits(there["layered"].as_f64()?),
                        digits(there["ours"].as_f64()?),
                        100.0 * share
                    ),
                    None => "at no amplitude measured".to_string(),
                })
            });
            format!(
                "where the paper's bound is 1.25 in the mean: {as_figure}; at the largest natural amplitude: {text}"
            )
        },
        &[
            Test(
                "scenes/tests/experiments.rs",
                "ours_is_tighter_than_layered_up_to_the_stated_amplitudes",
            ),
            Test(
                "scenes/tests/experiments.rs",
                "ours_is_tighter_where_the_papers_bound_is_as_in_its_figure",
            ),
            Program("tables"),
            Program("figures"),
        ],
    ),
    whole(
        "P11",
        "figure 4's colours: dark red from 1.44 × radius",
        "figure 4",
        says!("the same scale in every picture"),
        &[
            Test(
                "bdtree-render/src/tightness.rs",
                "the_scale_begins_dark_blue_and_ends_dark_red",
            ),
            Page("docs/pictures.md"),
        ],
    ),
];
