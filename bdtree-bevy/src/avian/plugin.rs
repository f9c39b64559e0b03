//! What a program adds in the place of avian's plugins.

use std::marker::PhantomData;

use avian3d::collider_tree::ColliderTreePlugin;
use avian3d::dynamics::solver::schedule::SubstepSolverSystems;
use avian3d::prelude::*;
use bevy_app::{App, FixedPostUpdate, Plugin, PluginGroup, PluginGroupBuilder};
use bevy_asset::AssetApp;
use bevy_ecs::intern::Interned;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::system::SystemParamItem;

use super::collider::BdtCollider;
use super::{flexible, follow, surface};
use crate::asset::BdtModel;
use crate::shape::{ShapeModels, forget_models};

/// avian's `PhysicsPlugins` for [`BdtCollider`]s: add them in its place, and [`BdtreePlugin`](crate::BdtreePlugin) beside.
///
/// They are avian's, except that these are not added for `Collider`:
///
/// | avian's | here |
/// |---|---|
/// | `ColliderBackendPlugin<Collider>` | `ColliderBackendPlugin<BdtCollider>` |
/// | `ColliderTreePlugin<Collider>` | `ColliderTreePlugin<BdtCollider>` |
/// | `NarrowPhasePlugin<Collider>` | `NarrowPhasePlugin<BdtCollider>` |
/// | `BodySizeMetricsPlugin<Collider>` | `BodySizeMetricsPlugin<BdtCollider>` |
/// | – | [`ColliderPlugin`] |
///
/// Entities with a `Collider` get a [`BdtCollider`] of the same shape, so that programs go on using it.
pub type BdtreePhysicsPlugins = BdtreePhysicsPluginsWithHooks<()>;

/// [`BdtreePhysicsPlugins`] with avian's collision hooks `H`, which its broad and narrow phases ask.
pub struct BdtreePhysicsPluginsWithHooks<H: CollisionHooks> {
    schedule: Interned<dyn ScheduleLabel>,
    length_unit: f32,
    hooks: PhantomData<H>,
}

impl<H: CollisionHooks> BdtreePhysicsPluginsWithHooks<H> {
    /// Physics that runs in a schedule. The default is `FixedPostUpdate`.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self {
            schedule: schedule.intern(),
            length_unit: 1.0,
            hooks: PhantomData,
        }
    }

    /// avian's `PhysicsLengthUnit`: units per meter; default 1.
    #[must_use]
    pub fn with_length_unit(mut self, unit: f32) -> Self {
        self.length_unit = unit;
        self
    }
}

impl<H: CollisionHooks> Default for BdtreePhysicsPluginsWithHooks<H> {
    fn default() -> Self {
        Self::new(FixedPostUpdate)
    }
}

impl<H: CollisionHooks + 'static> PluginGroup for BdtreePhysicsPluginsWithHooks<H>
where
    for<'w, 's> SystemParamItem<'w, 's, H>: CollisionHooks,
{
    fn build(self) -> PluginGroupBuilder {
        PhysicsPlugins::new(self.schedule)
            .with_length_unit(self.length_unit)
            .build()
            .disable::<ColliderBackendPlugin<Collider>>()
            .disable::<ColliderTreePlugin<Collider>>()
            .disable::<NarrowPhasePlugin<Collider>>()
            .disable::<BodySizeMetricsPlugin<Collider>>()
            .disable::<BvhBroadPhasePlugin>()
            .add(ColliderBackendPlugin::<BdtCollider>::new(self.schedule))
            .add(ColliderTreePlugin::<BdtCollider>::default())
            .add(NarrowPhasePlugin::<BdtCollider, H>::default())
            .add(BodySizeMetricsPlugin::<BdtCollider>::default())
            .add(BvhBroadPhasePlugin::<H>::default())
            .add(ColliderPlugin {
                schedule: self.schedule,
            })
    }
}

/// Keeps [`BdtCollider`]s: those of avian's `Collider`s and those of deforming meshes. [`BdtreePhysicsPlugins`] have it.
pub struct ColliderPlugin {
    schedule: Interned<dyn ScheduleLabel>,
}

impl Plugin for ColliderPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ShapeModels>()
            .init_asset::<BdtModel>()
            .register_type::<follow::DeformingCollider>()
            .add_observer(follow::take_collider)
            .add_observer(follow::drop_collider)
            .add_observer(follow::drop_mesh)
            .add_systems(
                self.schedule,
                (
                    forget_models,
                    (follow::follow_colliders, follow::follow_meshes),
                    flexible::make_modes,
                    follow::wake_touched,
                )
                    .chain()
                    .in_set(PhysicsSystems::First),
            )
            .add_systems(
                self.schedule,
                follow::scale_colliders
                    .after(PhysicsSystems::Prepare)
                    .before(PhysicsSystems::StepSimulation),
            )
            .init_resource::<flexible::Pushes>()
            .init_resource::<surface::Surfaces>()
            .add_systems(
                PhysicsSchedule,
                (
                    follow::renew_contacts.in_set(NarrowPhaseSystems::First),
                    (surface::find_speeds, flexible::begin_step)
                        .chain()
                        .in_set(NarrowPhaseSystems::Last),
                    surface::throw.in_set(SolverSystems::PostSubstep),
                    // In the place of nothing of avian's: what else ends a step may come before or after.
                    flexible::end_step
                        .in_set(PhysicsStepSystems::Finalize)
                        .ambiguous_with_all(),
                ),
            );
    }

    fn finish(&self, app: &mut App) {
        // By then avian's plugins have made the schedule.
        app.add_systems(
            SubstepSchedule,
            flexible::gather
                .after(SubstepSolverSystems::Relax)
                .before(SubstepSolverSystems::Damping)
                .ambiguous_with_all(),
        );
    }
}
