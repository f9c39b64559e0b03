//! A thousand bodies that deform beside the same bodies without modes, and at q = 0 (P45, P46).

use std::error::Error;

use serde_json::{Value, json};

use crate::contenders::assets::baked;
use crate::contenders::ours::pile::{NODES, OurPile};
use crate::workloads::pile;
use bdtree_measure::turns::{Counts, Entry, Role, Rounds, TOTAL, Turns, compare};

/// Times over those of rigid bodies, in total and per contact.
pub(super) fn measure(repeats: usize) -> Result<Value, Box<dyn Error>> {
    let work = pile::pile();
    let (model, rigid) = (baked(&work.body)?, baked(&work.body.rigid())?);
    let (asset, rigid) = (*model.asset(), *rigid.asset());
    let mut ours = OurPile::new(asset, NODES);
    let mut still = OurPile::new(rigid, NODES);
    let mut rest = OurPile::new(asset, NODES).at_rest();
    let entries = vec![
        Entry::new("deforming", Role::Ours, Counts::Same, |step| {
            ours.frame(&work, step)
        }),
        Entry::new("rigid", Role::Rigid, Counts::Other, |step| {
            still.frame(&work, step)
        }),
        Entry::new("updated at rest", Role::Variant, Counts::Rigid, |step| {
            rest.frame(&work, step)
        }),
    ];
    let rounds = Rounds {
        repeats,
        turns: Turns::Pass,
        with: &[],
    };
    let frames: Vec<usize> = (0..pile::STEPS).collect();
    let rows = compare(entries, &frames, rounds)?;
    let [ours, rigid, rest] = [0, 1, 2].map(|k| &rows[k]);
    let over = |k: usize| rows[k].median[TOTAL] / rigid.median[TOTAL];
    // Of each frame the least time: what is left of it on a machine that does other work.
    let floor = |k: usize| rows[k].floor[TOTAL] / rigid.floor[TOTAL];
    let per_contact = over(0) * rigid.found as f64 / ours.found as f64;
    Ok(
        json!({"bodies": pile::COUNT, "steps": pile::STEPS, "triangles_each": work.body.triangles.len(),
        "contacts": ours.found, "contacts_rigid": rigid.found, "contacts_at_rest": rest.found,
        "times": {"ms_per_step": 1e3 * ours.median[TOTAL], "over_rigid": over(0),
            "per_contact_over_rigid": per_contact, "at_rest_over_rigid": over(2),
            "over_rigid_floors": floor(0), "at_rest_over_rigid_floors": floor(2)}}),
    )
}
