//! Who takes part in each workload.

use std::rc::Rc;

use bdtree_measure::Body;
use bdtree_measure::deform::Deformer;
use bdtree_measure::ours::Posture;
use bdtree_measure::paper_tree::PaperTree;
use bdtree_measure::peers::LayeredPeer;
#[cfg(feature = "peers")]
use bdtree_measure::peers::{Parry, TinyBvh};
use bdtree_scenes::workloads::{bodies, characters, curtain, pile, rays};

use super::libraries::Libraries;
use super::report::Work;
use bdtree_measure::turns::{Rounds, compare};
use bdtree_runtime::BoneMatrices;
use bdtree_scenes::contenders::assets::baked;
use bdtree_scenes::contenders::ours::pair::OurPair;
use bdtree_scenes::contenders::ours::pile::{NODES, OurPile};
use bdtree_scenes::contenders::paper;
use bdtree_scenes::contenders::refitting::{self, Ask};

use crate::prelude::*;

/// What a body's contenders are made of.
struct Cast {
    model: Model,
    rigid: Model,
    deformer: Deformer,
    tree: Rc<PaperTree>,
}

impl Cast {
    fn of(body: &Body) -> Result<Self> {
        let model = baked(body)?;
        Ok(Self {
            tree: Rc::new(PaperTree::build(model.asset())),
            model,
            rigid: baked(&body.rigid())?,
            deformer: Deformer::new(body),
        })
    }

    fn layered(&self) -> LayeredPeer {
        LayeredPeer::new(Rc::clone(&self.tree), &self.deformer)
    }
}

/// All frames by everyone.
fn done(
    name: impl Into<String>,
    goals: [f64; 2],
    entries: Vec<Entry<'_>>,
    frames: impl Iterator<Item = usize>,
    rounds: Rounds<'_>,
) -> Result<Work> {
    let frames: Vec<usize> = frames.collect();
    Ok(Work {
        name: name.into(),
        goals,
        rows: compare(entries, &frames, rounds)?,
    })
}

/// W1 on one cloth.
pub(crate) fn ball(
    libraries: &Libraries,
    (size, goals): (usize, [f64; 2]),
    rounds: Rounds<'_>,
) -> Result<Work> {
    let (name, across, down) = curtain::SIZES[size];
    let work = curtain::curtain(name, across, down);
    let cast = Cast::of(&work.body)?;
    let (asset, rigid) = (*cast.model.asset(), *cast.rigid.asset());
    let (mut ours, mut still) = (Ours::new(asset), Ours::new(rigid));
    let mut others = libraries.and_layered(&work.body, cast.layered())?;
    let mut entries = vec![
        Entry::new("ours", Role::Ours, Counts::Same, |i| {
            frame(|| ours.balls(work.q(i), [work.ball(i)].into_iter()))
        }),
        Entry::new("ours rigid", Role::Rigid, Counts::Other, |i| {
            frame(|| still.balls(&[], [work.ball(i)].into_iter()))
        }),
        paper::ball(&cast.tree, asset, &work),
    ];
    entries.extend(others.iter_mut().map(|(name, (role, _), peer)| {
        refitting::ball(name, *role, peer.as_mut(), &cast.deformer, &work)
    }));
    // Every tenth frame of the largest.
    let frames = (0..curtain::FRAMES).step_by(if size == 2 { 10 } else { 1 });
    done(format!("W1 {name}"), goals, entries, frames, rounds)
}

/// W2.
pub(crate) fn pair(rounds: Rounds<'_>) -> Result<Work> {
    let work = bodies::bodies();
    let cast = Cast::of(&work.body)?;
    let (asset, deformer) = (*cast.model.asset(), &cast.deformer);
    let (mut ours, mut still) = (OurPair::new(asset), OurPair::new(*cast.rigid.asset()));
    let mut layered = [(); 2].map(|()| cast.layered());
    #[cfg(feature = "peers")]
    let mut parry = [(); 2].map(|()| Parry::new(&work.body));
    #[cfg(feature = "peers")]
    let mut tiny = [(); 2].map(|()| TinyBvh::new(&work.body));
    let entries = vec![
        Entry::new("ours", Role::Ours, Counts::Same, |frame| {
            ours.frame(work.q(frame), &work.places[frame])
        }),
        Entry::new("ours rigid", Role::Rigid, Counts::Other, |frame| {
            still.frame([&[], &[]], &work.rigid_places[frame])
        }),
        paper::pair(&cast.tree, asset, &work),
        refitting::pair("layered", Role::Baseline, &mut layered, deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pair("parry3d", Role::Peer, &mut parry, deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pair("tinybvh", Role::Peer, &mut tiny, deformer, &work),
    ];
    done("W2 blob36k", [2.5, 4.0], entries, 0..bodies::FRAMES, rounds)
}

/// W3 on one body, with each number of rays a frame and its goals.
pub(crate) fn ray(
    libraries: &Libraries,
    (size, goals): (usize, &[(usize, [f64; 2])]),
    rounds: Rounds<'_>,
) -> Result<Vec<Work>> {
    let (name, n) = rays::SIZES[size];
    let work = rays::rays(name, n);
    let cast = Cast::of(&work.body)?;
    let (asset, rigid) = (*cast.model.asset(), *cast.rigid.asset());
    let mut others = libraries.and_layered(&work.body, cast.layered())?;
    // Random rays seldom meet a leaf twice: keeping leaves costs more than it saves.
    let (mut ours, mut still) = (Ours::keeping(asset, 0), Ours::keeping(rigid, 0));
    let mut refined = Ours::refining(asset);
    let mut all = Vec::new();
    for (count, goals) in goals {
        let own = (&work, *count);
        let mut entries = vec![
            Entry::new("ours", Role::Ours, Counts::Same, |i| {
                frame(|| ours.rays(work.q(i), work.wide(i, *count)))
            }),
            Entry::new("ours rigid", Role::Rigid, Counts::Other, |i| {
                frame(|| still.rays(&[], work.wide(i, *count)))
            }),
            Entry::new("ours refined", Role::Variant, Counts::Same, |i| {
                frame(|| refined.rays(work.q(i), work.wide(i, *count)))
            }),
            paper::ray(&cast.tree, asset, own),
        ];
        entries.extend(others.iter_mut().map(|(name, kind, peer)| {
            refitting::ray(name, *kind, peer.as_mut(), &cast.deformer, own)
        }));
        let frames = 0..match *count {
            0..=100 => rays::FRAMES,
            101..10_000 => 10,
            _ => 2,
        };
        let name = format!("W3 {name}, {count} rays");
        all.push(done(name, *goals, entries, frames, rounds)?);
    }
    Ok(all)
}

/// W4.
pub(crate) fn pile(rounds: Rounds<'_>) -> Result<Work> {
    let work = pile::pile();
    let cast = Cast::of(&work.body)?;
    let (asset, deformer) = (*cast.model.asset(), &cast.deformer);
    let nodes = [NODES, 0, asset.node_count()];
    let [some, none, all] = nodes.map(|nodes| OurPile::new(asset, nodes));
    let rigid = OurPile::new(*cast.rigid.asset(), NODES);
    // Redundant updates as in the paper: q = 0, so that they change nothing.
    let rest = OurPile::new(asset, NODES).at_rest();
    let layered = vec![cast.layered(); pile::COUNT];
    #[cfg(feature = "peers")]
    let parry = vec![Parry::new(&work.body); pile::COUNT];
    #[cfg(feature = "peers")]
    let tiny = vec![TinyBvh::new(&work.body); pile::COUNT];
    let settings = [
        ("ours", Role::Ours, Counts::Same, some),
        ("ours rigid", Role::Rigid, Counts::Other, rigid),
        ("ours at rest", Role::Variant, Counts::Rigid, rest),
        ("ours none kept", Role::Variant, Counts::Same, none),
        ("ours all kept", Role::Variant, Counts::Same, all),
    ];
    let own = settings.map(|(name, role, counts, mut pile)| {
        let work = &work;
        Entry::new(name, role, counts, move |step| pile.frame(work, step))
    });
    let mut entries = Vec::from(own);
    entries.extend([
        paper::pile(&cast.tree, asset, &work),
        refitting::pile("layered", Role::Baseline, layered, deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pile("parry3d", Role::Peer, parry, deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pile("tinybvh", Role::Peer, tiny, deformer, &work),
    ]);
    let name = "W4 blob18k, 1000 bodies";
    done(name, [3.0, 6.0], entries, 0..pile::STEPS, rounds)
}

/// Must and aim.
type Goals = [f64; 2];

/// W5 on one character: a ball, then a ray, then many rays with their goals.
pub(crate) fn character(
    libraries: &Libraries,
    (size, goals, many): (usize, Goals, &[(usize, Goals)]),
    rounds: Rounds<'_>,
) -> Result<Vec<Work>> {
    let (name, detail) = characters::SIZES[size];
    let work = characters::character(name, detail)?;
    let asset = *work.model.asset();
    let deformer = Deformer::new(&work.body);
    let posture = |i: usize| {
        let frame: &characters::Frame = &work.frames[i];
        Posture {
            q: &frame.q,
            bones: BoneMatrices::Joints(&frame.joints),
        }
    };
    let (mut ours, mut others) = (Ours::keeping(asset, 0), libraries.of(&work.body)?);
    let mut all = Vec::new();
    let one = [Ask::Ball, Ask::Ray].map(|ask| (ask, goals));
    let many = many
        .iter()
        .map(|(count, goals)| (Ask::Rays(*count), *goals));
    for (ask, goals) in one.into_iter().chain(many) {
        let mut entries = vec![Entry::new("ours", Role::Ours, Counts::Same, |i| {
            let asked = &work.frames[i];
            frame(|| match ask {
                Ask::Ball => ours.balls(posture(i), [asked.ours.ball].into_iter()),
                Ask::Ray => ours.rays(posture(i), [asked.ours.ray].into_iter()),
                Ask::Rays(count) => ours.rays(posture(i), asked.rays(count)),
            })
        })];
        entries.extend(others.iter_mut().map(|(name, (role, counts), peer)| {
            let kind = (*role, *counts);
            refitting::character(name, kind, peer.as_mut(), &deformer, (&work, ask))
        }));
        let name = format!("W5 {name}, {}", ask.name());
        let frames = match ask {
            Ask::Rays(101..10_000) => 10,
            Ask::Rays(10_000..) => 2,
            _ => characters::FRAMES,
        };
        all.push(done(name, goals, entries, 0..frames, rounds)?);
    }
    Ok(all)
}
