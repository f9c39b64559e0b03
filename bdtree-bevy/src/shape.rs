//! What the colliders of both engines are made of.

use std::collections::HashMap;

use bdtree_parry::{DeformingModel, ShapeError};
use bevy_asset::{AssetEvent, AssetId, Assets};
use bevy_ecs::message::MessageReader;
use bevy_ecs::prelude::*;

use crate::asset::BdtModel;

/// Models as physics engines need them, one for all colliders of a file and scale.
#[derive(Resource, Debug, Default)]
pub(crate) struct ShapeModels {
    models: HashMap<(AssetId<BdtModel>, u64), DeformingModel>,
}

impl ShapeModels {
    /// The model of a file at a scale, once the file is loaded.
    pub(crate) fn get(
        &mut self,
        assets: &Assets<BdtModel>,
        id: AssetId<BdtModel>,
        scale: f64,
    ) -> Option<Result<DeformingModel, ShapeError>> {
        let key = (id, scale.to_bits());
        if let Some(model) = self.models.get(&key) {
            return Some(Ok(model.clone()));
        }
        let made = DeformingModel::new(&assets.get(id)?.model, scale);
        if let Ok(model) = &made {
            self.models.insert(key, model.clone());
        }
        Some(made)
    }
}

/// Forgets the models of files that changed or went.
pub(crate) fn forget_models(
    mut changes: MessageReader<AssetEvent<BdtModel>>,
    mut models: ResMut<ShapeModels>,
) {
    for change in changes.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = change {
            models.models.retain(|(of, _), _| of != id);
        }
    }
}
