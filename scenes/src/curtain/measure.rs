//! Tests, times and tightness of all contenders.

use std::error::Error;
use std::rc::Rc;

use bdtree_measure::Place;
use bdtree_measure::deform::Deformer;
use bdtree_measure::paper_tree::{Layered, Memory, PaperTree, PlainTree, Step};
use bdtree_measure::peers::{LayeredPeer, Obvhs, Peer, Target};
use bdtree_runtime::{Asset, Contact, Transform};
use serde_json::{Value, json};

use super::Arguments;
use crate::contenders::spheres::{Counting, Tested, of_ball, sum_growths};
use crate::contenders::{paper, refitting};
use crate::report::{Cell, Report, Table};
use crate::workloads::curtain::Curtain;
use bdtree_measure::ours::{self, Ours};
use bdtree_measure::plot::{Axis, Line, Plot, sheet};
use bdtree_measure::turns::{Counts, Entry, Role, Rounds, Row, TOTAL, Turns, compare};

/// In tables.
const OURS: &str = "ours";
const LAYERED: &str = "layered, all vertices deformed and refitted";
const REFIT: &str = "boxes (obvhs), all vertices deformed and refitted";

/// What a contender tested in all frames: spheres or boxes, and R'/R where it has spheres.
type Tests = (u64, Option<f64>);

pub(super) fn measure(
    arguments: &Arguments,
    asset: &Asset<'_>,
    work: &Curtain,
    pca_error: f64,
) -> Result<Report, Box<dyn Error>> {
    let deformer = Deformer::new(&work.body);
    let tree = Rc::new(PaperTree::build(asset));
    let plain = PlainTree::of(&tree);
    let mut ours = Ours::new(*asset);
    let mut layered = LayeredPeer::new(Rc::clone(&tree), &deformer);
    let mut boxes = Obvhs::new(&work.body);
    let frames: Vec<usize> = (0..work.balls.len()).collect();
    let counted = count(asset, work, &tree, &plain, &deformer, &mut boxes)?;
    let entries = vec![
        Entry::new(OURS, Role::Ours, Counts::Same, |i| {
            ours::frame(|| ours.balls(work.q(i), [work.ball(i)].into_iter()))
        }),
        paper::plain_ball(&plain, *asset, work),
        paper::ball(&tree, *asset, work),
        refitting::ball(LAYERED, Role::Baseline, &mut layered, &deformer, work),
        refitting::ball(REFIT, Role::Peer, &mut boxes, &deformer, work),
    ];
    let rounds = Rounds {
        repeats: usize::from(arguments.repeat),
        turns: Turns::Contender,
        with: &[],
    };
    let rows = compare(entries, &frames, rounds)?;
    let contacts = rows.first().map_or(0, |row| row.found);
    let value = json!({
        "settings": {"triangles": arguments.triangles, "frames": frames.len(),
            "modes": asset.mode_count(), "radius_m": arguments.radius, "repeat": arguments.repeat},
        "mesh": {"vertices": asset.vertex_count(), "triangles": asset.triangle_count(),
            "pca_error_max_over_diagonal": pca_error},
        "contacts": contacts, "nodes_visited": counted.visits,
        "growth_of_all_spheres": {"ours": counted.spread[0], "paper": counted.spread[1]},
        "contenders": rows.iter().zip(&counted.tests).map(|(row, tests)| contender(row, tests, &rows[0]))
            .collect::<Vec<Value>>(),
    });
    Ok(Report {
        name: "curtain",
        tables: vec![table(asset, &rows, &counted)],
        pictures: vec![("", picture(&rows)?)],
        value,
    })
}

fn contender(row: &Row, tests: &Tests, ours: &Row) -> Value {
    let seconds = row.median[TOTAL];
    json!({"name": row.name, "tests": tests.0, "growth_of_tested": tests.1,
        "times": {"total_ms": 1e3 * seconds * row.frames as f64, "ms_per_frame": 1e3 * seconds,
            "over_ours": seconds / ours.median[TOTAL],
            "deform_ms": 1e3 * row.median[0], "refit_ms": 1e3 * row.median[1],
            "query_ms": 1e3 * row.median[2], "by_frame_s": row.by_frame}})
}

/// What is counted over all frames.
struct Counted {
    /// In the order of the entries.
    tests: [Tests; 5],
    /// Nodes that ours visits.
    visits: u64,
    /// Mean R'/R over all spheres above a thousandth of the largest, ours and the paper's.
    spread: [f64; 2],
}

fn count(
    asset: &Asset<'_>,
    work: &Curtain,
    tree: &PaperTree,
    plain: &PlainTree,
    deformer: &Deformer,
    boxes: &mut Obvhs,
) -> Result<Counted, Box<dyn Error>> {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut refitted = Layered::new(tree, deformer.count);
    let (mut step, mut stack, mut scratch) = (Step::default(), Vec::new(), Vec::new());
    let (mut found, mut visits, mut plainly, mut boxed) = (Vec::<Contact>::new(), 0, 0, 0);
    let [mut ours, mut wrapped, mut layered] = [Tested::default(); 3];
    let mut sums = [[0.0; 2]; 2];
    let mut lazy = Memory::new(tree, asset);
    let place = &Place::IDENTITY;
    for frame in 0..work.balls.len() {
        let (ball, q) = (work.ball(frame), work.q(frame));
        let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
        visits += of_ball(&pose, ball, &mut ours)?;
        step.prepare(&pose);
        let counts = plain.ball(&pose, &step, ball, &mut stack, &mut found);
        plainly += counts.spheres;
        lazy.begin_step(&pose);
        let (spheres, tested) = (&mut lazy.at(&pose), &mut wrapped);
        tree.walk_ball(&mut Counting { spheres, tested }, ball, &mut found);
        deformer.deform(q, &[], &mut refitted.vertices);
        refitted.refit(tree, place);
        let (spheres, tested) = (&mut refitted, &mut layered);
        tree.walk_ball(&mut Counting { spheres, tested }, ball, &mut found);
        boxes.update(Target::without_bones(deformer, q, place), &mut scratch);
        boxed += boxes.box_tests(ball.0, ball.1);
        for (sum, [growth, count]) in sums.iter_mut().zip(sum_growths(tree, &pose)?) {
            sum[0] += growth;
            sum[1] += count;
        }
    }
    let of = |tested: Tested| (tested.tests, Some(tested.mean_growth()));
    let plainly = (plainly, Some(wrapped.mean_growth()));
    Ok(Counted {
        tests: [of(ours), plainly, of(wrapped), of(layered), (boxed, None)],
        visits,
        spread: sums.map(|[growth, count]| growth / count),
    })
}

fn table(asset: &Asset<'_>, rows: &[Row], counted: &Counted) -> Table {
    let Counted {
        tests,
        visits,
        spread,
    } = counted;
    let frames = rows.first().map_or(0, |row| row.frames);
    let contacts = rows.first().map_or(0, |row| row.found);
    let title = format!(
        "Ball and curtain: {} triangles, {} modes, {frames} frames, {contacts} contacts. A test is one sphere or \
         box against the ball; ours tests the eight of a node at once ({visits} nodes visited). Mean R'/R of all \
         spheres above a thousandth of the largest: ours {:.3}, paper's bound {:.3}.",
        asset.triangle_count(),
        asset.mode_count(),
        spread[0],
        spread[1]
    );
    let ours = rows.first().map_or(f64::NAN, |row| row.median[TOTAL]);
    let both: Vec<(&Row, &Tests)> = rows.iter().zip(tests).collect();
    let mut table = Table::of(
        "",
        title,
        &both,
        &[
            ("method", &|(row, _)| row.name.as_str().into()),
            ("tests", &|(_, tests)| tests.0.into()),
            ("total, ms", &|(row, _)| {
                (1e3 * row.median[TOTAL] * row.frames as f64).into()
            }),
            ("per frame, ms", &|(row, _)| {
                (1e3 * row.median[TOTAL]).into()
            }),
            ("time over ours", &|(row, _)| {
                (row.median[TOTAL] / ours).into()
            }),
            ("mean R'/R of tested", &|(_, tests)| {
                tests.1.map_or(Cell::None, Cell::Number)
            }),
        ],
    );
    // Table 2 of the paper: Java, 3.0 GHz Xeon, another ball and another curtain.
    let papers = |name: &str, count: u64, total: f64, each: f64, growth| {
        let cells = [name.into(), count.into(), total.into(), each.into()];
        cells.into_iter().chain([Cell::None, growth]).collect()
    };
    table.rows.extend([
        papers("paper, 2004: BD-Tree", 3890, 2.4, 0.022, Cell::Number(1.51)),
        papers("paper, 2004: layered", 2150, 5400.0, 49.0, Cell::None),
    ]);
    table
}

fn picture(rows: &[Row]) -> Result<String, Box<dyn Error>> {
    let lines = rows.iter().map(|row| Line {
        name: row.name.clone(),
        points: (0..)
            .map(f64::from)
            .zip(row.by_frame.iter().map(|s| 1e6 * s))
            .collect(),
    });
    let title = "Ball and curtain: time of every frame";
    let (frame, micros) = (Axis::linear("frame"), Axis::log("µs"));
    Ok(sheet(&[Plot::new(
        title,
        &frame,
        &micros,
        lines.collect(),
    )])?)
}
