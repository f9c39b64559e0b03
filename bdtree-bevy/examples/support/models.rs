//! What examples and tests draw: bakes of files in `fixtures/`.

use std::path::{Path, PathBuf};

use bdtree_build::basis::elastic::ElasticOptions;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Morphs, Motion, Recipe};
use bdtree_runtime::{Model, SkeletonPose};
use bevy_math::{Affine3A, Mat3A, Vec3A};

/// A folder for files that examples bake and load.
pub fn folder() -> PathBuf {
    let folder = super::picture::folder().join("models");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Writes a model as a `.bdt` file to [`folder`], as `bdtree-build` would.
pub fn write(model: &Model, name: &str) {
    let bytes = model.asset().bytes();
    std::fs::write(folder().join(name), bytes).expect("a file");
}

/// The folder of meshes beside the crate.
pub fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures")
}

/// A mesh of the fixtures with so many vibration modes, or with its skin and morph targets where it has any.
pub fn baked(name: &str, mode_count: usize) -> Model {
    baked_file(&fixtures().join(name), mode_count)
}

/// The same of any file.
pub fn baked_file(path: &Path, mode_count: usize) -> Model {
    let elastic = Elastic {
        options: ElasticOptions {
            mode_count,
            ..Default::default()
        },
        range_rel: None,
    };
    let motion = Motion::MorphsElseSkin(Morphs::default(), elastic);
    let recipe = Recipe::of_surface(path, motion);
    let baked = bdtree_build::bake(&recipe, &Silent).expect("a bake");
    Model::from_bytes(&baked.bytes).expect("an asset")
}

/// Joints of a file's clip as a `Deformation` has them.
pub fn joints(pose: &SkeletonPose) -> Vec<Affine3A> {
    let column = |m: &[[f64; 4]; 3], c: usize| Vec3A::from_array(m.map(|row| row[c] as f32));
    pose.joints()
        .iter()
        .map(|m| Affine3A {
            matrix3: Mat3A::from_cols(column(m, 0), column(m, 1), column(m, 2)),
            translation: column(m, 3),
        })
        .collect()
}
