//! What bodies are made of: one kind per file.

use bdtree_dynamics::{
    BodyOptions, DynamicsError, Frame, LevelSpheres, MassProperties, ModelId, RigidMass, World,
};
use bdtree_runtime::{Model, Transform};
use bdtree_tools::{AssetFile, printable};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A file and what its bodies have in common.
#[derive(Debug)]
pub struct Kind {
    /// The file's name, without its folder.
    pub name: String,
    /// Its bytes, which bodies share.
    pub model: Model,
    /// What bodies of it need to fall, or what the file lacks.
    pub able: Result<Able, String>,
}

/// What is known of bodies that can fall.
#[derive(Debug, Clone)]
pub struct Able {
    /// Their model in the world.
    pub(super) model: ModelId,
    /// In mesh units.
    pub(super) mass: RigidMass,
    /// How far any contact sphere of an undeformed body reaches from the center of mass, m.
    pub reach: f64,
    /// Mean radius of its contact spheres, m.
    pub radius: f64,
}

impl Kind {
    /// Of a file, with its model added to `world`.
    pub(super) fn new(file: &AssetFile, options: &BodyOptions, world: &mut World) -> Self {
        let name = file.path().file_name().unwrap_or_default();
        Self {
            name: printable(&name.to_string_lossy()),
            model: file.model().clone(),
            able: Able::new(file.model(), options, world).map_err(|error| lacking(&error)),
        }
    }

    /// The placement of the mesh that is turned about its center of mass, and has that at a point.
    pub(super) fn placed(&self, center: [f64; 3], rotation: [f64; 4], scale: f64) -> Transform {
        let middle = (self.able.as_ref()).map_or(Vector3::zeros(), |able| able.mass.center);
        let [x, y, z, w] = rotation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Transform {
            rotation,
            translation: (Vector3::from(center) - turn * (middle * scale)).into(),
            scale,
        }
    }

    /// How far bodies reach; of those that cannot fall, nothing.
    pub fn reach(&self) -> f64 {
        self.able.as_ref().map_or(0.0, |able| able.reach)
    }
}

impl Able {
    fn new(model: &Model, options: &BodyOptions, world: &mut World) -> Result<Self, DynamicsError> {
        // What only bodies are refused for is better known before there are any.
        let mut trial = World::new(world.options().clone())?;
        let of = trial.add_model(model, options)?;
        let at = Transform {
            scale: options.scale,
            ..Transform::IDENTITY
        };
        trial.add_body(of, Frame::Free, at)?;
        let mass = MassProperties::of(model.asset()).ok_or(DynamicsError::NoMass)?;
        let spheres = trial.model(of)?.spheres();
        Ok(Self {
            model: world.add_model(model, options)?,
            mass: mass.rigid()?,
            reach: reach(spheres),
            radius: spheres.radii().iter().sum::<f64>() / spheres.len().max(1) as f64,
        })
    }
}

/// What would make bodies of a file fall, in the words of the programs.
fn lacking(error: &DynamicsError) -> String {
    match error {
        DynamicsError::NoMass => {
            "no mass properties: bake it from a closed mesh, or an open one as a shell with \
                                  bdtree-build --modes 10 --thickness METERS"
                .to_string()
        }
        DynamicsError::HeldMode { mode } => {
            format!("mode {mode} is one of a held body: bake it without bdtree-build --fix")
        }
        DynamicsError::NoFrequency { mode } => format!(
            "mode {mode} has no frequency: bake it with vibration modes, bdtree-build --modes 10, or start with --rigid"
        ),
        error => error.to_string(),
    }
}

fn reach(spheres: &LevelSpheres) -> f64 {
    let of = |k| spheres.rest_center(k).norm() + spheres.radius(k);
    (0..spheres.len()).map(of).fold(0.0, f64::max)
}
