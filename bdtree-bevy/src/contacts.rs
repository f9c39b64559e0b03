//! Which deforming entities touch each other.

use bdtree_runtime::{BoundingSphere, Pose, QueryError, Workspace, broad};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_log::error_once;
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_tasks::ComputeTaskPool;
use std::collections::BTreeSet;

use crate::bounds::{DeformedBounds, DeformedSphere};
use crate::pose::DeformedInstance;

/// The entity's deforming mesh takes part in contacts between deforming meshes: [`ContactStarted`], [`ContactStopped`],
/// [`TouchingPairs`]. Meshes are surfaces: one wholly inside another touches nothing.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct DeformingCollider {
    /// Bits of the groups that it is in; all by default. Goes to the instance's `collision_group`.
    pub group: u32,
    /// Bits of the groups that it meets; all by default. Two entities meet if each one's group shares a bit with the
    /// other's mask. Goes to the instance's `collision_mask`.
    pub mask: u32,
    /// Two meshes touch that are at most the sum of their margins apart (world units, not negative); 0 by default.
    pub margin: f64,
}

impl Default for DeformingCollider {
    fn default() -> Self {
        Self {
            group: u32::MAX,
            mask: u32::MAX,
            margin: 0.0,
        }
    }
}

impl DeformingCollider {
    fn may_meet(&self, other: &Self) -> bool {
        self.group & other.mask != 0 && other.group & self.mask != 0
    }
}

/// Two entities with a [`DeformingCollider`] touch that did not in the frame before. Written in
/// [`BdtreeSystems::Contacts`](crate::BdtreeSystems::Contacts), sorted.
#[derive(Message, Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactStarted {
    /// In ascending order.
    pub entities: [Entity; 2],
}

/// Two entities touch no longer, or one of them is no longer there, has no collider or no mesh any more.
#[derive(Message, Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactStopped {
    /// In ascending order.
    pub entities: [Entity; 2],
}

/// The pairs of entities that touch, as of this frame's [`BdtreeSystems::Contacts`](crate::BdtreeSystems::Contacts).
#[derive(Resource, Debug, Default)]
pub struct TouchingPairs {
    pairs: BTreeSet<[Entity; 2]>,
}

impl TouchingPairs {
    /// Whether two entities touch, in any order.
    pub fn contains(&self, a: Entity, b: Entity) -> bool {
        self.pairs.contains(&[a.min(b), a.max(b)])
    }

    /// All pairs, each in ascending order, sorted.
    pub fn iter(&self) -> impl Iterator<Item = [Entity; 2]> {
        self.pairs.iter().copied()
    }
}

/// Pairs or colliders that a task takes at least, so that handing them out costs less than the work.
const CHUNK: usize = 16;

/// What one collider is this frame.
struct Collider<'w> {
    entity: Entity,
    options: DeformingCollider,
    bounds: DeformedBounds,
    sphere: BoundingSphere,
    pose: Pose<'w>,
    has_changed: bool,
}

/// Memory that is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Memory {
    workspace: Workspace<'static>,
    near: Vec<[usize; 2]>,
    /// Whether the last frame's pairs could not be asked: then what has not changed since is not known either.
    is_behind: bool,
}

/// Groups of colliders are those of their instances.
pub(crate) fn set_groups(
    mut colliders: Query<
        (&DeformingCollider, &mut DeformedInstance),
        Or<(Changed<DeformingCollider>, Added<DeformedInstance>)>,
    >,
) {
    for (options, mut body) in &mut colliders {
        // Neither pose nor box depend on them.
        let instance = &mut body.bypass_change_detection().instance;
        instance.collision_group = options.group;
        instance.collision_mask = options.mask;
    }
}

/// Finds the pairs that touch and tells what has changed.
pub(crate) fn find_contacts(
    colliders: Query<(
        Entity,
        Ref<DeformingCollider>,
        &DeformedBounds,
        &DeformedSphere,
        Ref<DeformedInstance>,
    )>,
    mut touching: ResMut<TouchingPairs>,
    mut started: MessageWriter<ContactStarted>,
    mut stopped: MessageWriter<ContactStopped>,
    mut memory: Local<Memory>,
) {
    // Poses borrow from these.
    let found: Vec<_> = colliders.iter().collect();
    let bodies: Vec<Collider<'_>> = (found.iter())
        .map(|(entity, options, bounds, sphere, body)| Collider {
            entity: *entity,
            options: **options,
            bounds: **bounds,
            sphere: sphere.0,
            pose: body.instance.snapshot(),
            has_changed: memory.is_behind || options.is_changed() || body.is_changed(),
        })
        .collect();
    let found = touching_pairs(&bodies, &touching, &mut memory);
    memory.is_behind = found.is_err();
    let now = match found {
        Ok(pairs) => pairs,
        Err(why) => {
            error_once!("contacts of deforming meshes: {why}");
            return;
        }
    };
    if now == touching.pairs {
        return;
    }
    for entities in now.difference(&touching.pairs).copied() {
        started.write(ContactStarted { entities });
    }
    for entities in touching.pairs.difference(&now).copied() {
        stopped.write(ContactStopped { entities });
    }
    touching.pairs = now;
}

fn touching_pairs(
    bodies: &[Collider<'_>],
    before: &TouchingPairs,
    memory: &mut Memory,
) -> Result<BTreeSet<[Entity; 2]>, QueryError> {
    // A margin that is NaN or negative is none.
    let margin = |body: &Collider<'_>| body.options.margin.max(0.0);
    let spheres: Vec<_> = (bodies.iter())
        .map(|body| {
            let mut sphere = body.sphere;
            sphere.radius += margin(body);
            sphere
        })
        .collect();
    memory.near.clear();
    broad::pairs(&spheres, 0.0, &mut memory.workspace, &mut memory.near)?;
    let mut now = BTreeSet::new();
    let entities = |[i, j]: [usize; 2]| {
        let (a, b) = (bodies[i].entity, bodies[j].entity);
        [a.min(b), a.max(b)]
    };
    memory.near.retain(|[i, j]| {
        let (a, b) = (&bodies[*i], &bodies[*j]);
        let may_touch =
            a.options.may_meet(&b.options) && a.bounds.is_near(&b.bounds, margin(a) + margin(b));
        if may_touch && !a.has_changed && !b.has_changed {
            // As before.
            let pair = entities([*i, *j]);
            if before.pairs.contains(&pair) {
                now.insert(pair);
            }
            return false;
        }
        may_touch
    });
    let ask = |pairs: &[[usize; 2]]| -> Result<Vec<[Entity; 2]>, QueryError> {
        let mut workspace = Workspace::new();
        let mut touch = Vec::new();
        for [i, j] in pairs.iter().copied() {
            let (a, b) = (&bodies[i], &bodies[j]);
            let distance = margin(a) + margin(b);
            if a.pose
                .against(&b.pose, &mut workspace)
                .is_within(distance)?
            {
                touch.push(entities([i, j]));
            }
        }
        Ok(touch)
    };
    let answers = if memory.near.len() <= CHUNK {
        vec![ask(&memory.near)]
    } else {
        let chunk = chunk(memory.near.len());
        ComputeTaskPool::get().scope(|scope| {
            for pairs in memory.near.chunks(chunk) {
                let ask = &ask;
                scope.spawn(async move { ask(pairs) });
            }
        })
    };
    for answer in answers {
        now.extend(answer?);
    }
    Ok(now)
}

/// How many of `count` things a task takes: a few tasks for each thread, so that all end at about the same time.
fn chunk(count: usize) -> usize {
    let threads = ComputeTaskPool::get().thread_num().max(1);
    count.div_ceil(4 * threads).max(CHUNK)
}
