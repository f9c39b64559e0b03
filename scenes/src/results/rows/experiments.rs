//! The paper's experiments.

use super::super::shown::Shown::{Program, Test};
use super::{BENCHMARKS, Row, not_yet, part, whole};
use crate::report::digits;

pub(super) const EXPERIMENTS: &[Row] = &[
    whole(
        "P38",
        "curtain and ball: tests and mean R'/R",
        "BD-Tree 3890 tests, layered 2150; R'/R 1.51",
        |m| {
            format!(
                "tests: ours {} (in {} nodes of eight), paper's tree {}, layered {}, boxes {}; R'/R of all spheres: ours {}, paper's bound {}",
                m.count("/curtain/contenders/0/tests"),
                m.count("/curtain/nodes_visited"),
                m.count("/curtain/contenders/1/tests"),
                m.count("/curtain/contenders/3/tests"),
                m.count("/curtain/contenders/4/tests"),
                m.digits("/curtain/growth_of_all_spheres/ours"),
                m.digits("/curtain/growth_of_all_spheres/paper")
            )
        },
        &[
            Test(
                "scenes/tests/experiments.rs",
                "curtain_counts_are_the_same_in_every_run",
            ),
            Program("curtain"),
        ],
    ),
    whole(
        "P39",
        "BD-Tree: time",
        "2.4 ms, 0.022 ms a frame",
        |m| {
            format!(
                "ours {} ms, {} ms a frame; paper's tree written plainly {} ms a frame",
                m.of("ours", "/times/total_ms"),
                m.of("ours", "/times/ms_per_frame"),
                m.of("paper's tree, plain", "/times/ms_per_frame")
            )
        },
        &[Program("curtain")],
    ),
    whole(
        "P40",
        "layered: time",
        "5400 ms, 49 ms a frame: 2250 times the BD-Tree's",
        |m| {
            format!(
                "layered {} ms a frame, {} times ours; boxes (obvhs), deformed and refitted, {} ms, {} times ours",
                m.of("layered", "/times/ms_per_frame"),
                m.of("layered", "/times/over_ours"),
                m.of("boxes", "/times/ms_per_frame"),
                m.of("boxes", "/times/over_ours")
            )
        },
        &[Program("curtain")],
    ),
    whole(
        "P41",
        "speed-up grows with the mesh",
        "stated",
        |m| {
            let rows =
                m.0.pointer("/growth/size/rows")
                    .and_then(serde_json::Value::as_array);
            let each = rows.into_iter().flatten().filter_map(|row| {
                Some(format!(
                    "{} at {}",
                    digits(row["times"]["speedup"].as_f64()?),
                    row["triangles"].as_u64()?
                ))
            });
            format!(
                "times faster than deforming and refitting boxes: {} triangles",
                each.collect::<Vec<_>>().join(", ")
            )
        },
        &[Program("growth")],
    ),
    whole(
        "P42",
        "time of a sphere's update",
        "750 ns at M = 10 (Java, 3.0 GHz Xeon)",
        |m| {
            format!(
                "ours {} ns, the paper's tree {} ns, from near caches, M = {}",
                m.digits("/updates/times/ours_ns_per_sphere"),
                m.digits("/updates/times/paper_ns_per_sphere"),
                m.count("/updates/modes")
            )
        },
        &[Program("results"), BENCHMARKS],
    ),
    not_yet(
        "P43",
        "12 chairs: share of updated spheres",
        "figure 7: a small fraction",
    ),
    not_yet(
        "P44",
        "3601 chairs, 5000 frames",
        "2.1 s a step, 14.7 h, 1.6e9 events",
    ),
    part(
        "P45",
        "deformable over rigid",
        "2",
        |m| {
            format!(
                "{} in total, {} per contact, on a pile of {} bodies; the chairs are not built yet",
                m.digits("/pile/times/over_rigid"),
                m.digits("/pile/times/per_contact_over_rigid"),
                m.count("/pile/bodies")
            )
        },
        &[Program("results"), BENCHMARKS],
    ),
    part(
        "P46",
        "updates that change nothing",
        "45 % more",
        |m| {
            let more = ["", "_floors"].map(|kind| {
                let over = m.number(&format!("/pile/times/at_rest_over_rigid{kind}"));
                over.map_or("?".to_string(), |x| digits(100.0 * (x - 1.0)))
            });
            let [median, floor] = more;
            format!("{median} % more than rigid, on the same pile ({floor} % by the least times)")
        },
        &[Program("results"), BENCHMARKS],
    ),
    part(
        "P47",
        "layered update of a chair",
        "55 ms: 57 days for the simulation",
        |m| {
            let layered = m.number("/updates/times/layered_ms");
            let days = layered.map(|ms| ms * 3601.0 * 25_000.0 / 86_400_000.0);
            format!(
                "{} ms, boxes {} ms: {} days extrapolated in the same way",
                layered.map_or("?".to_string(), digits),
                m.digits("/updates/times/boxes_ms"),
                days.map_or("?".to_string(), digits)
            )
        },
        &[Program("results")],
    ),
    not_yet("P48", "drawing 3601 chairs", "2.0 s a frame"),
    not_yet(
        "P49",
        "12000 fish on a bridge",
        "depth 7; 300 M triangles avoided",
    ),
    whole(
        "P50",
        "Table 1",
        "four meshes",
        |m| {
            m.each_mesh(|mesh| {
                Some(format!(
                    "{} V / {} F, M = {}",
                    mesh["vertices"].as_u64()?,
                    mesh["triangles"].as_u64()?,
                    mesh["modes"].as_u64()?
                ))
            })
        },
        &[
            Test(
                "fixtures/tests/obj_fixtures.rs",
                "the_papers_meshes_have_the_papers_sizes",
            ),
            Program("tables"),
        ],
    ),
];
