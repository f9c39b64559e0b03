//! Contenders in turns: times of every frame, kept per part.

use std::str::FromStr;

use bdtree_runtime::Stats;

use crate::peers::Update;
use crate::stats;

/// What a contender is to the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The product.
    Ours,
    /// The product on the same body without modes.
    Rigid,
    /// The product in another setting, for its own comparisons.
    Variant,
    /// The paper's structures.
    Baseline,
    /// A library in use today.
    Peer,
}

/// How many contacts may differ from the product's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counts {
    /// The same vertices and the same test: none.
    Same,
    /// Vertices rounded once more on their way to the world: one in five thousand, and two.
    Rounded,
    /// The contender's own triangle test: one in two hundred, and two.
    OwnTest,
    /// Another scene.
    Other,
    /// The scene of the body without modes, if that takes part: none.
    Rigid,
}

impl Counts {
    fn allow(self, ours: u64, rigid: Option<u64>, theirs: u64) -> bool {
        let off = ours.abs_diff(theirs);
        match self {
            Self::Same => off == 0,
            Self::Rounded => off <= 2 + ours / 5000,
            Self::OwnTest => off <= 2 + ours / 200,
            Self::Other => true,
            Self::Rigid => rigid.is_none_or(|rigid| rigid == theirs),
        }
    }
}

/// Nodes of the product's trees; none for whoever does not count.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nodes {
    /// Whose spheres were tested, each time.
    pub visited: u64,
    /// Whose spheres were evaluated, each time.
    pub updated: u64,
}

impl Nodes {
    /// Counts a query's.
    pub fn add(&mut self, stats: Stats) {
        self.visited += stats.nodes_visited;
        self.updated += stats.nodes_updated;
    }
}

/// One frame: seconds, and how many contacts or hits.
#[derive(Debug, Clone, Copy, Default)]
pub struct Frame {
    /// Bringing the body up to date (s).
    pub update: Update,
    /// Asking (s).
    pub query: f64,
    /// Contacts or hits.
    pub found: u64,
    /// For whoever counts.
    pub nodes: Nodes,
}

/// Who takes part.
pub struct Entry<'a> {
    /// For tables.
    pub name: String,
    /// What it is to the comparison.
    pub role: Role,
    /// What it must find.
    pub counts: Counts,
    /// Answers a frame.
    pub frame: Box<dyn FnMut(usize) -> Frame + 'a>,
}

impl<'a> Entry<'a> {
    /// Whoever answers a frame.
    pub fn new(
        name: &str,
        role: Role,
        counts: Counts,
        frame: impl FnMut(usize) -> Frame + 'a,
    ) -> Self {
        Self {
            name: name.to_string(),
            role,
            counts,
            frame: Box::new(frame),
        }
    }
}

/// Deform, refit, query and their sum.
pub const PARTS: [&str; 4] = ["deform", "refit", "query", "total"];

/// The place of the sum in [`PARTS`].
pub const TOTAL: usize = 3;

/// What a contender took per frame, in seconds.
#[derive(Debug, Clone)]
pub struct Row {
    /// Of the contender.
    pub name: String,
    /// What it is to the comparison.
    pub role: Role,
    /// Over all frames.
    pub found: u64,
    /// Over all frames.
    pub nodes: Nodes,
    /// Number of frames.
    pub frames: usize,
    /// Each frame's median over the repetitions, all parts together.
    pub by_frame: Vec<f64>,
    /// Each repetition's sum over the frames, all parts together.
    pub by_repeat: Vec<f64>,
    /// Mean over frames of each frame's median over the repetitions, by part.
    pub median: [f64; 4],
    /// Mean over frames of each frame's least, by part.
    pub floor: [f64; 4],
}

impl Row {
    fn of(entry: &Entry<'_>, (found, nodes): (u64, Nodes), times: &[Vec<[f64; 4]>]) -> Self {
        let by_frame = |part: usize, of_frame: fn(&[f64]) -> f64| -> Vec<f64> {
            let frames = times.iter().map(|repeats| {
                let part: Vec<f64> = repeats.iter().map(|t| t[part]).collect();
                of_frame(&part)
            });
            frames.collect()
        };
        let mean = |of_frame| {
            let mean = |part| by_frame(part, of_frame).iter().sum::<f64>() / times.len() as f64;
            std::array::from_fn(mean)
        };
        let repeats = times.first().map_or(0, Vec::len);
        let of_repeat = |k: usize| times.iter().map(|repeats| repeats[k][TOTAL]).sum();
        Self {
            by_repeat: (0..repeats).map(of_repeat).collect(),
            name: entry.name.clone(),
            role: entry.role,
            found,
            nodes,
            frames: times.len(),
            by_frame: by_frame(TOTAL, stats::median),
            median: mean(stats::median),
            floor: mean(|part| part.iter().copied().fold(f64::INFINITY, f64::min)),
        }
    }
}

/// Who comes after whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turns {
    /// After each pass over the frames the next contender's: each finds the caches as the others left them.
    Pass,
    /// Each contender does all its passes: its own data may still be near.
    Contender,
}

impl FromStr for Turns {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "pass" => Ok(Self::Pass),
            "contender" => Ok(Self::Contender),
            _ => Err("is neither pass nor contender".to_string()),
        }
    }
}

/// How often, and in which order.
#[derive(Debug, Clone, Copy)]
pub struct Rounds<'a> {
    /// Passes of each contender over all frames.
    pub repeats: usize,
    /// Who comes after whom.
    pub turns: Turns,
    /// Who takes part beside the product; everybody if nobody is named.
    pub with: &'a [String],
}

/// Lets all who take part run all frames, `repeats` times.
///
/// # Errors
/// Two contenders that do not find the same, or one that does not find the same again.
pub fn compare(
    mut entries: Vec<Entry<'_>>,
    frames: &[usize],
    rounds: Rounds<'_>,
) -> Result<Vec<Row>, String> {
    let Rounds {
        repeats,
        turns,
        with,
    } = rounds;
    entries.retain(|e| e.role == Role::Ours || with.is_empty() || with.contains(&e.name));
    let mut times = vec![vec![Vec::with_capacity(repeats); frames.len()]; entries.len()];
    let mut found = vec![None; entries.len()];
    let mut nodes = vec![Nodes::default(); entries.len()];
    let order: Vec<usize> = match turns {
        Turns::Pass => (0..repeats)
            .flat_map(|repeat| (0..entries.len()).map(move |turn| (repeat, turn)))
            .map(|(repeat, turn)| (repeat + turn) % entries.len())
            .collect(),
        Turns::Contender => (0..entries.len())
            .flat_map(|who| std::iter::repeat_n(who, repeats))
            .collect(),
    };
    for who in order {
        let mut sum = 0;
        nodes[who] = Nodes::default();
        for (i, frame) in frames.iter().enumerate() {
            let Frame {
                update,
                query,
                found,
                nodes: own,
            } = (entries[who].frame)(*frame);
            let total = update.deform + update.refit + query;
            times[who][i].push([update.deform, update.refit, query, total]);
            sum += found;
            nodes[who].visited += own.visited;
            nodes[who].updated += own.updated;
        }
        let before = *found[who].get_or_insert(sum);
        if before != sum {
            return Err(format!("{}: {before}, then {sum}", entries[who].name));
        }
    }
    let found: Vec<u64> = found.into_iter().map(Option::unwrap_or_default).collect();
    let rigid = entries.iter().position(|e| e.role == Role::Rigid);
    let rigid = rigid.map(|i| found[i]);
    for (entry, theirs) in entries.iter().zip(&found) {
        if !entry.counts.allow(found[0], rigid, *theirs) {
            let ours = &entries[0].name;
            return Err(format!(
                "{} finds {theirs}, {ours} {}",
                entry.name, found[0]
            ));
        }
    }
    let counts = found.into_iter().zip(nodes);
    let rows = entries.iter().zip(counts).zip(&times);
    Ok(rows.map(|((e, c), t)| Row::of(e, c, t)).collect())
}
