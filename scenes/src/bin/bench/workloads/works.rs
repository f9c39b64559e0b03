//! Who takes part in each workload.

use std::error::Error;
use std::rc::Rc;

use bdtree_measure::deform::Deformer;
use bdtree_measure::paper_tree::PaperTree;
use bdtree_measure::peers::LayeredPeer;
#[cfg(feature = "peers")]
use bdtree_measure::peers::{Parry, TinyBvh};
use bdtree_scenes::workloads::{bodies, curtain, pile, rays};

use super::libraries::Libraries;
use super::report::Work;
use bdtree_measure::ours::{Ours, frame};
use bdtree_measure::turns::{Counts, Entry, Role, Rounds, compare};
use bdtree_scenes::contenders::assets::baked;
use bdtree_scenes::contenders::ours::pair::OurPair;
use bdtree_scenes::contenders::ours::pile::{NODES, OurPile};
use bdtree_scenes::contenders::{paper, refitting};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// W1 on one cloth.
pub(crate) fn ball(
    libraries: &Libraries,
    (size, goals): (usize, [f64; 2]),
    rounds: Rounds<'_>,
) -> Result<Work> {
    let (name, across, down) = curtain::SIZES[size];
    let work = curtain::curtain(name, across, down);
    // Every tenth frame of the largest.
    let frames: Vec<usize> = (0..curtain::FRAMES)
        .step_by(if size == 2 { 10 } else { 1 })
        .collect();
    let (model, rigid) = (baked(&work.body)?, baked(&work.body.rigid())?);
    let (asset, rigid) = (*model.asset(), *rigid.asset());
    let deformer = Deformer::new(&work.body);
    let tree = Rc::new(PaperTree::build(&asset));
    let (mut ours, mut still) = (Ours::new(asset), Ours::new(rigid));
    let mut layered = LayeredPeer::new(Rc::clone(&tree), &deformer);
    let mut peers = libraries.of(&work.body)?;
    let mut entries = vec![
        Entry::new("ours", Role::Ours, Counts::Same, |i| {
            frame(|| ours.balls(work.q(i), [work.ball(i)].into_iter()))
        }),
        Entry::new("ours rigid", Role::Rigid, Counts::Other, |i| {
            frame(|| still.balls(&[], [work.ball(i)].into_iter()))
        }),
        paper::ball(&tree, asset, &work),
        refitting::ball("layered", Role::Baseline, &mut layered, &deformer, &work),
    ];
    for (name, peer) in &mut peers {
        entries.push(refitting::ball(
            name,
            Role::Peer,
            peer.as_mut(),
            &deformer,
            &work,
        ));
    }
    Ok(Work {
        name: format!("W1 {name}"),
        goals: Some(goals),
        rows: compare(std::mem::take(&mut entries), &frames, rounds)?,
    })
}

/// W2.
pub(crate) fn pair(rounds: Rounds<'_>) -> Result<Work> {
    let work = bodies::bodies();
    let frames: Vec<usize> = (0..bodies::FRAMES).collect();
    let (model, rigid) = (baked(&work.body)?, baked(&work.body.rigid())?);
    let (asset, rigid) = (*model.asset(), *rigid.asset());
    let deformer = Deformer::new(&work.body);
    let tree = Rc::new(PaperTree::build(&asset));
    let (mut ours, mut still) = (OurPair::new(asset), OurPair::new(rigid));
    let mut layered = [(); 2].map(|()| LayeredPeer::new(Rc::clone(&tree), &deformer));
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
        paper::pair(&tree, asset, &work),
        refitting::pair("layered", Role::Baseline, &mut layered, &deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pair("parry3d", Role::Peer, &mut parry, &deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pair("tinybvh", Role::Peer, &mut tiny, &deformer, &work),
    ];
    Ok(Work {
        name: "W2 blob36k".to_string(),
        goals: Some([2.5, 4.0]),
        rows: compare(entries, &frames, rounds)?,
    })
}

/// W3 on one body, with each number of rays a frame and its goals.
pub(crate) fn ray(
    libraries: &Libraries,
    (size, goals): (usize, &[(usize, [f64; 2])]),
    rounds: Rounds<'_>,
) -> Result<Vec<Work>> {
    let (name, n) = rays::SIZES[size];
    let work = rays::rays(name, n);
    let (model, rigid) = (baked(&work.body)?, baked(&work.body.rigid())?);
    let (asset, rigid) = (*model.asset(), *rigid.asset());
    let deformer = Deformer::new(&work.body);
    let tree = Rc::new(PaperTree::build(&asset));
    let mut layered = LayeredPeer::new(Rc::clone(&tree), &deformer);
    let mut peers = libraries.of(&work.body)?;
    // Random rays seldom meet a leaf twice: keeping leaves costs more than it saves.
    let (mut ours, mut still) = (Ours::keeping(asset, 0), Ours::keeping(rigid, 0));
    let mut all = Vec::new();
    for (count, goals) in goals {
        let frames: Vec<usize> = (0..if *count > 100 { 10 } else { rays::FRAMES }).collect();
        let own = (&work, *count);
        let mut entries = vec![
            Entry::new("ours", Role::Ours, Counts::Same, |i| {
                frame(|| ours.rays(work.q(i), work.wide(i, *count)))
            }),
            Entry::new("ours rigid", Role::Rigid, Counts::Other, |i| {
                frame(|| still.rays(&[], work.wide(i, *count)))
            }),
            paper::ray(&tree, asset, own),
            refitting::ray(
                "layered",
                (Role::Baseline, Counts::Same),
                &mut layered,
                &deformer,
                own,
            ),
        ];
        for (name, peer) in &mut peers {
            let kind = (Role::Peer, Counts::OwnTest);
            entries.push(refitting::ray(name, kind, peer.as_mut(), &deformer, own));
        }
        all.push(Work {
            name: format!("W3 {name}, {count} rays"),
            goals: Some(*goals),
            rows: compare(std::mem::take(&mut entries), &frames, rounds)?,
        });
    }
    Ok(all)
}

/// W4.
pub(crate) fn pile(rounds: Rounds<'_>) -> Result<Work> {
    let work = pile::pile();
    let frames: Vec<usize> = (0..pile::STEPS).collect();
    let (model, rigid) = (baked(&work.body)?, baked(&work.body.rigid())?);
    let (asset, rigid) = (*model.asset(), *rigid.asset());
    let deformer = Deformer::new(&work.body);
    let tree = Rc::new(PaperTree::build(&asset));
    let mut ours = OurPile::new(asset, NODES);
    let mut still = OurPile::new(rigid, NODES);
    // Redundant updates as in the paper: q = 0, so that they change nothing.
    let mut rest = OurPile::new(asset, NODES).at_rest();
    let mut forgetful = OurPile::new(asset, 0);
    let mut hoarding = OurPile::new(asset, asset.node_count());
    let layered = LayeredPeer::new(Rc::clone(&tree), &deformer);
    let layered = vec![layered; pile::COUNT];
    let entries = vec![
        Entry::new("ours", Role::Ours, Counts::Same, |step| {
            ours.frame(&work, step)
        }),
        Entry::new("ours rigid", Role::Rigid, Counts::Other, |step| {
            still.frame(&work, step)
        }),
        Entry::new("ours at rest", Role::Variant, Counts::Rigid, |step| {
            rest.frame(&work, step)
        }),
        Entry::new("ours none kept", Role::Variant, Counts::Same, |step| {
            forgetful.frame(&work, step)
        }),
        Entry::new("ours all kept", Role::Variant, Counts::Same, |step| {
            hoarding.frame(&work, step)
        }),
        paper::pile(&tree, asset, &work),
        refitting::pile("layered", Role::Baseline, layered, &deformer, &work),
        #[cfg(feature = "peers")]
        refitting::pile(
            "parry3d",
            Role::Peer,
            vec![Parry::new(&work.body); pile::COUNT],
            &deformer,
            &work,
        ),
        #[cfg(feature = "peers")]
        refitting::pile(
            "tinybvh",
            Role::Peer,
            vec![TinyBvh::new(&work.body); pile::COUNT],
            &deformer,
            &work,
        ),
    ];
    Ok(Work {
        name: "W4 blob18k, 1000 bodies".to_string(),
        goals: Some([3.0, 6.0]),
        rows: compare(entries, &frames, rounds)?,
    })
}
