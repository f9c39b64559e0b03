//! Every file of the corpus's `messy/` folder bakes, with elastic modes, to an asset that is sound
//! and answers like brute force, or gives an error that names the file. None panics or hangs.

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::progress::Silent;
use bdtree_fixtures::{bake, corpus, models, oracle, poses};
use bdtree_runtime::{Ball, Contact, Transform, Workspace};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("folder")
        .map(|entry| entry.expect("entry").path())
        .collect();
    files.sort();
    let folders: Vec<PathBuf> = files.iter().filter(|p| p.is_dir()).cloned().collect();
    files.retain(|p| p.is_file());
    for folder in folders {
        files.extend(self::files(&folder));
    }
    files
}

/// Bakes a file; the error text if that is refused.
fn check(path: &Path) -> Result<(), String> {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let mesh = read_mesh(path).map_err(|e| e.to_string())?;
    let options = ElasticOptions {
        mode_count: 3,
        resolution: Some(8),
        ..ElasticOptions::default()
    };
    let mut warnings = Vec::new();
    let (basis, _) = match elastic_basis(&mesh, &options, &Silent, &mut warnings) {
        Ok(done) => done,
        Err(error) => {
            let text = error.to_string();
            assert!(!text.is_empty(), "{name}");
            // No modes are to be had; the rigid bake still is.
            (bake::rigid(&mesh), Default::default())
        }
    };
    let model = bake::baked(&mesh, &basis);
    let asset = model.asset();
    assert!(
        asset.verify(&mut |e| {
            println!("{name}: {e}");
            ControlFlow::Continue(())
        }),
        "{name}"
    );
    let mut rng = poses::rng(1);
    let mut memory = vec![0.0; asset.pose_len()];
    let q = poses::random_q(asset, 0.1, &mut rng);
    let pose = asset
        .pose(&q, Transform::IDENTITY, &mut memory)
        .expect("pose");
    let triangles = oracle::deformed_triangles(&pose);
    let mut workspace = Workspace::new();
    let size = poses::diagonal(asset) * asset.unit();
    for triangle in triangles.iter().step_by(1 + triangles.len() / 20) {
        let center = triangle[1];
        let mut found: Vec<Contact> = Vec::new();
        let ball = Ball::new(center, 0.05 * size);
        let coverage = pose.query(&mut workspace).contacts(ball, &mut found);
        coverage.expect("ball");
        let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
        ids.sort_unstable();
        let expected: Vec<u32> = oracle::ball(&triangles, center, 0.05 * size)
            .iter()
            .map(|e| e.0)
            .collect();
        assert_eq!(ids, expected, "{name}");
    }
    Ok(())
}

#[test]
fn messy_files_bake_or_say_why_not() {
    let test = "messy_files_bake_or_say_why_not";
    let Some(folder) = corpus::path(test, "messy") else {
        return;
    };
    let files = files(&folder);
    let share = |from: usize| {
        let mut baked = 0;
        for path in files.iter().skip(from).step_by(2) {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            match check(path) {
                Ok(()) => baked += 1,
                Err(text) => assert!(text.contains(&name), "{name}: {text}"),
            }
        }
        baked
    };
    let baked = std::thread::scope(|scope| {
        let others = scope.spawn(|| share(1));
        share(0) + others.join().expect("the other half")
    });
    println!("{baked} files baked");
    assert!(baked > 30);
}

#[test]
fn fixtures_bake_or_say_why_not() {
    for fixture in models::meshes().filter(|f| !f.is_large) {
        let path = models::path(fixture.name);
        let result = check(&path);
        assert_eq!(
            result.is_err(),
            fixture.is_broken,
            "{}: {result:?}",
            fixture.name
        );
    }
}
