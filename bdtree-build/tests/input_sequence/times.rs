//! When frames are shown.

use std::fs;
use std::path::Path;

use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;

use crate::support::{FRAMES, fixture_folder, wave_mesh};

#[test]
fn times_come_from_the_file_or_the_rate() {
    let mesh = wave_mesh();
    let with = |path: &Path, fps| {
        let sequence = FrameSequence::open(path, Some(&mesh), fps, &Silent).expect("valid");
        (sequence.times_s.clone(), sequence.warnings.join("\n"))
    };
    let at = |fps: f64| Some((0..FRAMES).map(|t| t as f64 / fps).collect::<Vec<_>>());
    for name in ["wave.pc2", "wave.npy"] {
        let path = models::path(name);
        assert_eq!(with(&path, None).0, None, "{name}");
        assert_eq!(with(&path, Some(30.0)).0, at(30.0), "{name}");
    }
    let folder = fixture_folder("wave");
    assert_eq!(with(&folder, None).0, None);
    assert_eq!(with(&folder, Some(24.0)).0, at(24.0));
    let mdd = models::path("wave.mdd");
    let own: Vec<f64> = (0..FRAMES).map(|t| f64::from(t as f32 / 25.0)).collect();
    assert_eq!(with(&mdd, None).0, Some(own));
    assert_eq!(with(&mdd, Some(50.0)).0, at(50.0));

    // Start and step of PC2, in frames.
    let temporary = tempfile::tempdir().expect("a folder");
    let changed = |name: &str, at: usize, value: [u8; 4]| {
        let mut bytes = fs::read(models::path(name)).expect("readable");
        bytes[at..at + 4].copy_from_slice(&value);
        let path = temporary.path().join(name);
        fs::write(&path, bytes).expect("writable");
        path
    };
    let path = changed("wave.pc2", 20, 100.0_f32.to_le_bytes());
    assert_eq!(with(&path, Some(10.0)).0.expect("times")[..2], [10.0, 10.1]);
    let path = changed("wave.pc2", 24, 0.0_f32.to_le_bytes());
    let (times, warning) = with(&path, Some(10.0));
    assert_eq!(times, None);
    assert!(
        warning.ends_with("with 0 frames per sample: the times are not known"),
        "{warning}"
    );
    let path = changed("wave.mdd", 8 + 4 * 3, 0.01_f32.to_be_bytes());
    let (times, warning) = with(&path, None);
    assert_eq!(times, None);
    assert!(warning.contains("frame 3 is at 0.0099"), "{warning}");
    assert!(warning.contains("before frame 2 at 0.0799"), "{warning}");
    let path = changed("wave.mdd", 8, f32::NAN.to_be_bytes());
    assert!(with(&path, None).1.contains("frame 0 is at NaN s"));

    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = FrameSequence::open(&mdd, Some(&mesh), Some(fps), &Silent).expect_err("fps");
        assert!(error.to_string().starts_with("--fps: "), "{error}");
    }
}
