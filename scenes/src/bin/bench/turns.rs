//! Contenders in turns, and the rows that are made of what they took.

use std::hint::black_box;
use std::time::Instant;

use bdtree_measure::MeasureError;
use bdtree_measure::ours::{Answer, frame};
use bdtree_measure::turns::{self, Entry, Frame, Rounds, TOTAL, Turns};
use bdtree_scenes::report::{Cell, Row};
use bdtree_scenes::row;

/// All frames by everyone, in turns, so often.
pub(crate) fn compare(
    entries: Vec<Entry<'_>>,
    frames: usize,
    repeats: usize,
) -> Result<Vec<turns::Row>, String> {
    let frames: Vec<usize> = (0..frames).collect();
    let (turns, with) = (Turns::Pass, &[]);
    let rounds = Rounds {
        repeats,
        turns,
        with,
    };
    turns::compare(entries, &frames, rounds)
}

/// A frame of so many questions; one clock for all of them, since reading it takes as long as a few nodes.
pub(crate) fn pass<Q>(
    questions: &[Q],
    mut ask: impl FnMut(&Q) -> Result<Answer, MeasureError>,
) -> Frame {
    frame(|| {
        let mut all = Answer::default();
        for question in questions {
            let answer = ask(black_box(question))?;
            all.found += answer.found;
            all.nodes.visited += answer.nodes.visited;
            all.nodes.updated += answer.nodes.updated;
        }
        Ok(all)
    })
}

/// A row for each contender, which begins with what they were asked `about`: medians, floors and counts per question, of which all frames together ask so many.
/// `unit` names that time, which is in `1 / per_second` seconds.
pub(crate) fn rows(
    about: &[(String, Cell)],
    all: &[turns::Row],
    questions: usize,
    unit: &str,
) -> Vec<Row> {
    let each = |count: u64| count as f64 / questions as f64;
    let per_second = if unit.starts_with("ns") { 1e9 } else { 1e6 };
    let of = |row: &turns::Row| {
        let time = |seconds: f64| seconds * row.frames as f64 / questions as f64 * per_second;
        let mut cells = about.to_vec();
        cells.extend(row! {
            "contender" => row.name.as_str(),
            unit => time(row.median[TOTAL]), "floor" => time(row.floor[TOTAL]), "to the first" => row.median[TOTAL] / all[0].median[TOTAL],
            "found" => each(row.found),
            "visits" => each(row.nodes.visited), "updates" => each(row.nodes.updated),
        });
        cells
    };
    all.iter().map(of).collect()
}

/// Nanoseconds per call on each of `0..count`, so often in a row: the best of several runs.
pub(crate) fn least_ns(times: usize, count: usize, mut evaluate: impl FnMut(usize)) -> f64 {
    let runs = (0..50).map(|_| {
        let start = Instant::now();
        for _ in 0..times {
            (0..count).for_each(&mut evaluate);
        }
        start.elapsed().as_nanos() as f64 / (times * count) as f64
    });
    runs.fold(f64::INFINITY, f64::min)
}
