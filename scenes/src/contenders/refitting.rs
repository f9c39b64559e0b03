//! Whoever refits, on each workload.

use crate::workloads::bodies::Bodies;
use crate::workloads::characters::Character;
use crate::workloads::curtain::Curtain;
use crate::workloads::pile::{COUNT, Pile};
use crate::workloads::rays::Rays;
use bdtree_measure::deform::Deformer;
use bdtree_measure::peers::{PairPeer, Peer, Target, Update};
use bdtree_measure::place::Place;
use bdtree_runtime::{Contact, PairContact};

use super::frame;
use bdtree_measure::turns::{Counts, Entry, Role};

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
    let place = &Place::IDENTITY;
    Entry::new(name, role, Counts::Same, move |i| {
        found.clear();
        let q = work.q(i);
        let update = peer.update(Target::without_bones(deformer, q, place), &mut scratch);
        let (center, radius) = work.ball(i);
        frame(update, || {
            peer.ball(center, radius, &mut found);
            found.len()
        })
    })
}

/// W2.
pub fn pair<'a, P: PairPeer>(
    name: &str,
    role: Role,
    peers: &'a mut [P; 2],
    deformer: &'a Deformer,
    work: &'a Bodies,
) -> Entry<'a> {
    let mut found: Vec<PairContact> = Vec::new();
    let mut scratch = Vec::new();
    Entry::new(name, role, Counts::Rounded, move |i| {
        found.clear();
        let mut update = Update::default();
        let places = [&Place::IDENTITY, &work.places[i]];
        for ((peer, q), place) in peers.iter_mut().zip(work.q(i)).zip(places) {
            update += peer.update(Target::without_bones(deformer, q, place), &mut scratch);
        }
        let [a, b] = peers;
        frame(update, || {
            a.pair(b, &mut found);
            found.len()
        })
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
    let place = &Place::IDENTITY;
    Entry::new(name, role, counts, move |i| {
        let q = work.q(i);
        let update = peer.update(Target::without_bones(deformer, q, place), &mut scratch);
        let hits = |[origin, direction]: &[[f32; 3]; 2]| peer.ray(*origin, *direction).is_some();
        frame(update, || work.of(i, count).filter(hits).count())
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
            update += peer.update(Target::without_bones(deformer, q, place), &mut scratch);
        }
        frame(update, || {
            for [i, j] in &work.pairs {
                // Neighbours are listed with the lower number first.
                let (low, high) = peers.split_at_mut(*j as usize);
                low[*i as usize].pair(&mut high[0], &mut found);
            }
            found.len()
        })
    })
}

/// What W5 asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// The contacts of a ball.
    Ball,
    /// The first hit of a ray.
    Ray,
    /// The first hits of many.
    Rays(usize),
}

impl Ask {
    /// For tables.
    pub fn name(self) -> String {
        match self {
            Self::Ball => "one ball".into(),
            Self::Ray => "one ray".into(),
            Self::Rays(count) => format!("{count} rays"),
        }
    }
}

/// W5.
pub fn character<'a>(
    name: &str,
    (role, counts): (Role, Counts),
    peer: &'a mut dyn Peer,
    deformer: &'a Deformer,
    (work, ask): (&'a Character, Ask),
) -> Entry<'a> {
    let mut found: Vec<Contact> = Vec::new();
    let mut scratch = Vec::new();
    Entry::new(name, role, counts, move |i| {
        found.clear();
        let (asked, place) = (&work.frames[i], &Place::IDENTITY);
        let to = Target {
            deformer,
            q: &asked.q,
            bones: &asked.maps,
            place,
        };
        let update = peer.update(to, &mut scratch);
        let (center, radius) = asked.stored.ball;
        let [origin, direction] = asked.stored.ray;
        frame(update, || match ask {
            Ask::Ball => {
                peer.ball(center, radius, &mut found);
                found.len()
            }
            Ask::Ray => usize::from(peer.ray(origin, direction).is_some()),
            Ask::Rays(count) => {
                let hits =
                    |[origin, direction]: &[[f32; 3]; 2]| peer.ray(*origin, *direction).is_some();
                asked.stored_rays(count).filter(hits).count()
            }
        })
    })
}
