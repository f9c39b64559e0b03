//! Whoever refits, on each workload.

use crate::workloads::bodies::Bodies;
use crate::workloads::curtain::Curtain;
use crate::workloads::pile::{COUNT, Pile};
use crate::workloads::rays::Rays;
use bdtree_measure::clock::Clock;
use bdtree_measure::deform::Deformer;
use bdtree_measure::peers::{PairPeer, Peer, Update};
use bdtree_measure::place::Place;
use bdtree_runtime::{Contact, PairContact};

use bdtree_measure::turns::{Counts, Entry, Frame, Role};

/// W1.
pub fn ball<'a>(
    name: &str,
    role: Role,
    peer: &'a mut dyn Peer,
    deformer: &'a Deformer,
    work: &'a Curtain,
) -> Entry<'a> {
    let mut found: Vec<Contact> = Vec::new();
    let mut scratch = Vec::new();
    Entry::new(name, role, Counts::Same, move |frame| {
        found.clear();
        let update = peer.update(deformer, work.q(frame), &Place::IDENTITY, &mut scratch);
        let (center, radius) = work.ball(frame);
        let start = Clock::start();
        peer.ball(center, radius, &mut found);
        Frame {
            update,
            query: start.seconds(),
            found: found.len() as u64,
            ..Frame::default()
        }
    })
}

/// W2.
pub fn pair<'a, P: PairPeer>(
    name: &str,
    role: Role,
    [a, b]: &'a mut [P; 2],
    deformer: &'a Deformer,
    work: &'a Bodies,
) -> Entry<'a> {
    let mut found: Vec<PairContact> = Vec::new();
    let mut scratch = Vec::new();
    Entry::new(name, role, Counts::Rounded, move |frame| {
        found.clear();
        let [qa, qb] = work.q(frame);
        let one = a.update(deformer, qa, &Place::IDENTITY, &mut scratch);
        let two = b.update(deformer, qb, &work.places[frame], &mut scratch);
        let start = Clock::start();
        a.pair(b, &mut found);
        Frame {
            update: sum(one, two),
            query: start.seconds(),
            found: found.len() as u64,
            ..Frame::default()
        }
    })
}

/// W3 with `count` rays a frame.
pub fn ray<'a>(
    name: &str,
    (role, counts): (Role, Counts),
    peer: &'a mut dyn Peer,
    deformer: &'a Deformer,
    (work, count): (&'a Rays, usize),
) -> Entry<'a> {
    let mut scratch = Vec::new();
    Entry::new(name, role, counts, move |frame| {
        let update = peer.update(deformer, work.q(frame), &Place::IDENTITY, &mut scratch);
        let start = Clock::start();
        let mut found = 0;
        for [origin, direction] in work.of(frame, count) {
            found += u64::from(peer.ray(origin, direction).is_some());
        }
        Frame {
            update,
            query: start.seconds(),
            found,
            ..Frame::default()
        }
    })
}

/// W4: all bodies are brought up to date, then the given neighbours are tested.
pub fn pile<'a, P: PairPeer + 'a>(
    name: &str,
    role: Role,
    mut peers: Vec<P>,
    deformer: &'a Deformer,
    work: &'a Pile,
) -> Entry<'a> {
    let mut found: Vec<PairContact> = Vec::new();
    let mut scratch = Vec::new();
    Entry::new(name, role, Counts::Rounded, move |step| {
        found.clear();
        let mut update = Update::default();
        for (i, peer) in peers.iter_mut().enumerate().take(COUNT) {
            let (q, place) = (work.q(step, i), work.place(step, i));
            update = sum(update, peer.update(deformer, q, place, &mut scratch));
        }
        let start = Clock::start();
        for [i, j] in &work.pairs {
            // Neighbours are listed with the lower number first.
            let (low, high) = peers.split_at_mut(*j as usize);
            low[*i as usize].pair(&mut high[0], &mut found);
        }
        Frame {
            update,
            query: start.seconds(),
            found: found.len() as u64,
            ..Frame::default()
        }
    })
}

fn sum(a: Update, b: Update) -> Update {
    Update {
        deform: a.deform + b.deform,
        refit: a.refit + b.refit,
    }
}
