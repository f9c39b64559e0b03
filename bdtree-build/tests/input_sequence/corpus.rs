//! Sequences of the corpus.

use bdtree_fixtures::corpus;

use crate::support::{all, open, refusal, wave_mesh};

/// `data/animations/README.md`: the OBJ sequences take every 4th (curtain_wind) or 2nd (elephant)
/// frame of the cache.
#[test]
fn corpus_folders_agree_with_their_caches() {
    for (name, cache, step) in [
        ("curtain_wind", "curtain_wind.pc2", 4),
        ("elephant", "elephant.mdd", 2),
    ] {
        let relative = format!("animations/{name}");
        let Some(folder) = corpus::path("sequence_corpus_folders", &relative) else {
            return;
        };
        let frames = open(&folder, None);
        let cache = open(&folder.join(cache), frames.first_mesh.as_ref());
        let n = frames.vertex_count();
        assert_eq!(frames.frame_count(), cache.frame_count().div_ceil(step));
        let (frames, cache) = (all(&frames, n), all(&cache, n));
        for (t, frame) in frames.chunks_exact(n).enumerate() {
            let other = &cache[t * step * n..][..n];
            for (p, q) in frame.iter().zip(other) {
                for k in 0..3 {
                    // The texts have at least six digits.
                    let off = (p[k] - q[k]).abs();
                    assert!(off <= 1e-6 * p[k].abs().max(1.0), "{name} {t}: {p:?} {q:?}");
                }
            }
        }
    }
}

#[test]
fn corpus_damaged_caches_are_named() {
    let mesh = wave_mesh();
    for (name, expected) in [
        ("curtain_truncated.pc2", "which is 3 whole frames"),
        (
            "cube_mangled.mdd",
            "has bytes after its last frame: 4 frames of 24 points",
        ),
    ] {
        let relative = format!("messy/{name}");
        let Some(path) = corpus::path("sequence_corpus_damaged", &relative) else {
            return;
        };
        let text = refusal(&path, Some(&mesh));
        assert!(text.starts_with(name) && text.contains(expected), "{text}");
    }
}
