//! Principal components of sequences: optimal, orthonormal, and off by what they say.

use crate::pca_support::*;
use bdtree_build::basis::pca::{About, Modes, Pca, PcaOptions};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_build::wrap;
use faer::{Mat, MatRef};

/// The fields as a 3N × M matrix.
fn fields(pca: &Pca) -> Mat<f64> {
    let rows = 3 * pca.mesh.positions.len();
    let flat = pca.basis.fields.as_flattened();
    MatRef::from_column_major_slice(flat, rows, pca.basis.mode_count()).to_owned()
}

/// Largest entry of UᵀU − 1.
fn off_orthonormal(u: &Mat<f64>) -> f64 {
    let gram = u.transpose() * u;
    let mut worst = 0.0_f64;
    for i in 0..gram.nrows() {
        for j in 0..gram.ncols() {
            worst = worst.max((gram[(i, j)] - f64::from(i == j)).abs());
        }
    }
    worst
}

#[test]
fn the_error_is_the_optimal_one() {
    let (n, t) = (300, 40);
    let frames = cloth(n, t);
    let made = make(frames.clone(), &frames[0], Precision::Double);
    let rest = mean(&frames);
    let values = singular_values(&snapshots(&frames, &rest));
    let size = diagonal(&rest);
    let all = pca(&made, &count(t - 1));
    // What f32 leaves when no mode is missing.
    let floor = all.error.rms_rel;
    assert!(floor < 1e-7, "{floor}");
    let mut compared = 0;
    let mut before = f64::INFINITY;
    for modes in 0..t {
        let found = pca(&made, &count(modes));
        assert_eq!(found.basis.mode_count(), modes);
        let optimal = optimal_rms(&values, modes, n * t) / size;
        let rms = found.error.rms_rel;
        // Rounding adds its square to the optimal square, and is not quite orthogonal to it.
        assert!(
            rms <= (optimal * optimal + 4.0 * floor * floor).sqrt() + 1e-6 * optimal,
            "{modes}: {rms:e} {optimal:e} {floor:e}"
        );
        if optimal > 300.0 * floor {
            assert!(
                (rms - optimal).abs() < 1e-5 * optimal,
                "{modes}: {rms} {optimal}"
            );
            compared += 1;
        }
        assert!(
            rms < before || optimal < 10.0 * floor,
            "{modes}: {rms} after {before}"
        );
        before = rms;
        assert!(off_orthonormal(&fields(&found)) < 1e-14, "{modes}");
        if modes % 13 == 0 {
            assert_error_is_true(&found, &made.frames, &format!("{modes} modes"));
        }
    }
    assert!(compared > 15, "only {compared} compared");
    for (j, (a, b)) in all.singular_values.iter().zip(&values).enumerate() {
        assert!((a - b).abs() < 1e-13 * values[0], "{j}: {a} {b}");
    }
}

#[test]
fn stored_fields_are_orthonormal_to_rounding_and_ranges_are_those_of_q() {
    let frames = cloth(500, 30);
    let made = make(frames.clone(), &frames[0], Precision::Single);
    let found = pca(&made, &count(12));
    let shape = wrap::store(&found.mesh, &found.basis, &mut Vec::new()).expect("stores");
    assert_eq!(shape.unit_exponent, 0);
    let stored = Mat::from_fn(1500, 12, |i, j| {
        f64::from(shape.displacements[i / 3 * 12 + j][i % 3])
    });
    assert!(off_orthonormal(&stored) < 1e-7);
    let animation = found.basis.animation.as_ref().expect("an animation");
    assert_eq!((animation.frame_count, animation.q.len()), (30, 360));
    assert!(animation.motions.is_empty());
    for (j, mode) in found.basis.modes.iter().enumerate() {
        let q = animation.q.iter().skip(j).step_by(12);
        let range = q.fold(0.0_f64, |m, q| m.max(q.abs()));
        assert_eq!(mode.q_range, Some(range));
    }
    // The leading component of every field is positive.
    for field in found.basis.fields.chunks_exact(500) {
        let lead = field
            .iter()
            .flatten()
            .copied()
            .fold(0.0_f64, |m, x| if x.abs() > m.abs() { x } else { m });
        assert!(lead > 0.0);
    }
}

#[test]
fn about_the_input_the_rest_positions_are_the_inputs() {
    let frames = cloth(200, 25);
    let rest: Vec<V3> = frames[3].iter().map(|p| [p[0], p[1] + 0.3, p[2]]).collect();
    let made = make(frames.clone(), &rest, Precision::Double);
    let values = singular_values(&snapshots(&frames, &rest));
    for modes in [1, 3, 6, 25] {
        let options = PcaOptions {
            about: About::Input,
            ..count(modes)
        };
        let found = pca(&made, &options);
        assert_eq!(found.mesh.positions, rest);
        let optimal = optimal_rms(&values, modes, 200 * 25) / diagonal(&rest);
        let rms = found.error.rms_rel;
        assert!(
            (rms - optimal).abs() < 1e-5 * optimal + 1e-7,
            "{modes}: {rms} {optimal}"
        );
        assert_error_is_true(&found, &made.frames, &format!("{modes} about input"));
    }
}

#[test]
fn few_frames_and_many_frames() {
    // More frames than coordinates: as many modes as coordinates at most.
    let frames = cloth(4, 100);
    let made = make(frames.clone(), &frames[0], Precision::Double);
    let (found, warnings) = pca_with_warnings(&made, &count(30));
    assert_eq!(found.basis.mode_count(), 12);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with(
        "frames.npy: 12 of up to 30 modes are stored: the 100 frames have 12 independent"
    ));
    assert!(found.error.max_rel < 1e-6);
    assert_error_is_true(&found, &made.frames, "many frames");

    // Two frames: half of their difference, up and down.
    let frames = cloth(50, 2);
    let made = make(frames.clone(), &frames[0], Precision::Double);
    let (found, warnings) = pca_with_warnings(&made, &count(5));
    assert_eq!(found.basis.mode_count(), 1);
    let told = "1 of up to 5 modes is stored: 2 frames have at most 1 independent component";
    assert!(warnings[0].ends_with(told), "{warnings:?}");
    let q = &found.basis.animation.as_ref().expect("an animation").q;
    assert!((q[0] + q[1]).abs() < 1e-14 * q[0].abs(), "{q:?}");
    assert_error_is_true(&found, &made.frames, "two frames");

    // One frame, which is the mean.
    let frames = cloth(50, 1);
    let made = make(frames.clone(), &frames[0], Precision::Single);
    let (found, warnings) = pca_with_warnings(&made, &count(5));
    assert_eq!(found.basis.mode_count(), 0);
    assert_eq!(
        warnings,
        ["frames.npy: one frame, no modes: the shape is rigid"]
    );
    let animation = found.basis.animation.as_ref().expect("an animation");
    assert_eq!((animation.frame_count, animation.q.len()), (1, 0));
    assert!(found.error.max_rel < 1e-7);
    assert_error_is_true(&found, &made.frames, "one frame");

    // One frame that is not the input.
    let rest: Vec<V3> = frames[0].iter().map(|p| [p[0], 2.0 * p[1], p[2]]).collect();
    let made = make(frames.clone(), &rest, Precision::Double);
    let options = PcaOptions {
        about: About::Input,
        ..count(5)
    };
    let (found, _) = pca_with_warnings(&made, &options);
    assert_eq!(found.basis.mode_count(), 1);
    assert_error_is_true(&found, &made.frames, "one frame about the input");
}

#[test]
fn equal_frames_make_a_rigid_shape() {
    let frame = cloth(60, 1).remove(0);
    for precision in [Precision::Single, Precision::Double] {
        let frame: Vec<V3> = match precision {
            Precision::Single => frame
                .iter()
                .map(|p| p.map(|x| f64::from(x as f32)))
                .collect(),
            Precision::Double => frame.clone(),
        };
        let made = make(vec![frame.clone(); 7], &frame, precision);
        for options in [count(3), auto(1e-3)] {
            let (found, warnings) = pca_with_warnings(&made, &options);
            assert_eq!(found.basis.mode_count(), 0);
            assert_eq!(found.mesh.positions, frame);
            let animation = found.basis.animation.as_ref().expect("an animation");
            assert_eq!((animation.frame_count, animation.q.len()), (7, 0));
            assert!(
                warnings.len() == 1 && warnings[0].contains("the 7 frames differ by rounding only"),
                "{warnings:?}"
            );
        }
    }
}

/// Three components, in f64 and rounded to f32: noise makes no modes.
#[test]
fn rounding_makes_no_modes() {
    for (n, t) in [(20, 200), (2000, 40), (7, 8)] {
        let base = &cloth(n, 1)[0];
        let frames: Frames = (0..t)
            .map(|t| {
                let s = t as f64 * 0.7;
                let q = [s.sin(), 0.2 * (1.7 * s).cos(), 0.01 * (2.3 * s).sin()];
                base.iter()
                    .map(|p| {
                        let u = [
                            [p[1], p[0] * p[1], 0.0],
                            [0.0, p[0], 1.0],
                            [p[2], 0.0, p[0]],
                        ];
                        [0, 1, 2].map(|k| p[k] + (0..3).map(|j| q[j] * u[j][k]).sum::<f64>())
                    })
                    .collect()
            })
            .collect();
        for precision in [Precision::Single, Precision::Double] {
            let made = make(frames.clone(), base, precision);
            let (found, warnings) = pca_with_warnings(&made, &count(12));
            assert_eq!(found.basis.mode_count(), 3, "{n} {t}: {warnings:?}");
            assert!(
                warnings[0].contains("3 of up to 12 modes are stored"),
                "{warnings:?}"
            );
            assert!(found.error.max_rel < 5e-7, "{:?}", found.error);
        }
    }
}

/// One vertex of many moves, by a little and once: no noise of others hides it.
#[test]
fn a_single_small_motion_is_a_mode() {
    let base = &cloth(3000, 1)[0];
    let base: Vec<V3> = base
        .iter()
        .map(|p| p.map(|x| f64::from(x as f32)))
        .collect();
    let mut frames = vec![base.clone(); 50];
    frames[20][77][1] += 1.0 / 65536.0;
    for precision in [Precision::Single, Precision::Double] {
        let made = make(frames.clone(), &base, precision);
        let (found, _) = pca_with_warnings(&made, &count(2));
        assert_eq!(found.basis.mode_count(), 1);
        assert!(found.error.max_rel < 1e-7, "{:?}", found.error);
    }
}

#[test]
fn the_size_of_chunks_and_the_run_do_not_matter() {
    let frames = cloth(331, 60);
    let made = make(frames.clone(), &frames[0], Precision::Single);
    for align in [false, true] {
        let with = |chunk_vertices| {
            let options = PcaOptions {
                chunk_vertices,
                align,
                ..count(10)
            };
            pca(&made, &options)
        };
        let whole = with(None);
        assert!(whole == with(None), "another run");
        for chunk in [1, 7, 100] {
            let other = with(Some(chunk));
            let size = 2.0;
            let pairs = whole.mesh.positions.iter().flatten();
            for (a, b) in pairs.zip(other.mesh.positions.iter().flatten()) {
                assert!((a - b).abs() < 1e-13 * size, "{chunk}");
            }
            for (a, b) in whole.singular_values.iter().zip(&other.singular_values) {
                assert!((a - b).abs() < 1e-13 * whole.singular_values[0], "{chunk}");
            }
            // Vectors turn by rounding over the gap between their values, here 1e-3 and more.
            for (a, b) in whole.basis.fields.iter().zip(&other.basis.fields) {
                assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-10), "{chunk}");
            }
            let off = (whole.error.rms_rel - other.error.rms_rel).abs();
            assert!(off < 1e-9 * whole.error.rms_rel, "{chunk}: {off}");
        }
    }
}

#[test]
fn files_are_the_same_bytes_for_any_number_of_threads() {
    let frames = cloth(400, 20);
    let made = make(frames.clone(), &frames[0], Precision::Single);
    let file = |threads| {
        let found = pca(&made, &count(8));
        let settings = BakeSettings {
            threads,
            ..BakeSettings::default()
        };
        bake_fields(
            &found.mesh,
            &found.basis,
            &settings,
            &Provenance::default(),
            &Silent,
        )
        .expect("bakes")
        .bytes
    };
    let first = file(1);
    assert!(first == file(1) && first == file(2) && first == file(5));
}

/// A wave that runs around: sine and cosine are equally strong, and any moment may come first.
#[test]
fn equally_strong_modes_do_not_depend_on_when_the_wave_begins() {
    let frames = |phase: f64| -> Frames {
        (0..24)
            .map(|t| {
                let time = std::f64::consts::TAU * (t as f64 / 24.0) + phase;
                (0..90)
                    .map(|i| {
                        let angle = std::f64::consts::TAU * i as f64 / 90.0;
                        let high = 0.2 * (2.0 * angle - time).cos();
                        [angle.cos(), angle.sin(), high]
                    })
                    .collect()
            })
            .collect()
    };
    let of = |phase| {
        let frames = frames(phase);
        make(frames.clone(), &frames[0], Precision::Double)
    };
    let (first, second) = (of(0.0), of(0.4));
    let whole = pca(&first, &count(2));
    let values = &whole.singular_values;
    assert!(
        (values[0] - values[1]).abs() < 1e-10 * values[0],
        "{values:?}"
    );
    for modes in [1, 2] {
        let (a, b) = (pca(&first, &count(modes)), pca(&second, &count(modes)));
        for (a, b) in a.basis.fields.iter().zip(&b.basis.fields) {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-9), "{modes}");
        }
        assert_eq!(a.basis.fields, whole.basis.fields[..modes * 90], "{modes}");
        assert!(off_orthonormal(&fields(&a)) < 1e-14);
    }
}

#[test]
fn auto_takes_the_fewest_modes_that_reach_the_error() {
    let frames = cloth(300, 80);
    let made = make(frames.clone(), &frames[0], Precision::Single);
    for bound in [0.5, 0.05, 1e-2, 1e-3, 1e-4, 1e-6] {
        let found = pca(&made, &auto(bound));
        let modes = found.basis.mode_count();
        let size = diagonal(&found.mesh.positions);
        let checked = error_of(&played_back(&found), &made.frames, size);
        assert!(checked.max_rel <= bound, "{bound}: {checked:?}");
        assert!(found.error.max_rel <= bound);
        assert_error_is_true(&found, &made.frames, &format!("{bound}"));
        // The same as if this many had been asked for; and none below is good enough.
        assert!(pca(&made, &count(modes)).basis == found.basis, "{bound}");
        for fewer in 0..modes {
            let error = pca(&made, &count(fewer)).error;
            assert!(error.max_rel > bound, "{bound}: {fewer} are enough");
            if let Some(point) = found.curve.iter().find(|point| point.modes == fewer) {
                assert_eq!(point.error, error);
            }
        }
    }
    let text = refused(&made, &auto(1e-9)).to_string();
    assert!(
        text.contains("--max-error-rel 1e-9 cannot be reached: with all "),
        "{text}"
    );
    assert!(
        text.contains("frames.npy: frame ") && text.contains(" of the diagonal (vertex "),
        "{text}"
    );
}

#[test]
fn far_and_tiny_shapes_keep_their_precision() {
    // Offset in diagonals, size, error of all modes that f32 positions allow.
    for (offset, size) in [(0.0, 1e-6), (1e4, 1.0), (0.0, 1e6), (300.0, 1e-3)] {
        let frames: Frames = cloth(100, 20)
            .iter()
            .map(|f| {
                let moved = |p: &V3| p.map(|x| size * (x + offset));
                f.iter().map(moved).collect()
            })
            .collect();
        let made = make(frames.clone(), &frames[0], Precision::Double);
        let found = pca(&made, &count(19));
        assert!(
            found.error.max_rel < 1e-6,
            "{offset} {size}: {:?}",
            found.error
        );
        assert_error_is_true(&found, &made.frames, &format!("{offset} {size}"));
    }
}

#[test]
fn points_and_needles_have_modes() {
    // All rest positions equal: errors are in mesh units then.
    for n in [1, 2, 5] {
        let at = |t: usize, i: usize| [(t as f64 + 1.0).sin() * (i + 1) as f64, 0.0, 0.0];
        let frames: Frames = (0..4).map(|t| (0..n).map(|i| at(t, i)).collect()).collect();
        let rest = vec![[0.0; 3]; n];
        let made = make(frames.clone(), &rest, Precision::Double);
        for about in [About::Mean, About::Input] {
            for align in [false, true] {
                let options = PcaOptions {
                    about,
                    align,
                    ..count(2)
                };
                let (found, _) = pca_with_warnings(&made, &options);
                assert!(
                    found.error.max_rel < 1e-6,
                    "{n} {about:?} {align}: {:?}",
                    found.error
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let frames = cloth(30, 5);
    let mut made = make(frames.clone(), &frames[0], Precision::Double);
    let text = refused(&made, &count(513)).to_string();
    assert_eq!(text, "--modes: 513 modes: a file holds at most 512");
    for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let text = refused(&made, &auto(bound)).to_string();
        assert!(text.starts_with("--max-error-rel: "), "{text}");
    }
    let options = PcaOptions {
        memory_limit_bytes: 1000,
        ..count(2)
    };
    let text = refused(&made, &options).to_string();
    assert!(
        text.contains("the limit is 0 MiB (--memory-limit)"),
        "{text}"
    );
    made.mesh.positions.pop();
    let text = refused(&made, &count(2)).to_string();
    assert_eq!(text, "frames.npy: 30 vertices per frame, the mesh has 29");
}

/// A walk of many diagonals: its translation is a mode whose q raises the limit, with a warning.
#[test]
fn walks_raise_the_limit_unless_aligned() {
    let body = &cloth(40, 1)[0];
    let frames: Frames = (0..9)
        .map(|t| {
            body.iter()
                .map(|p| [p[0] + 300.0 * t as f64, p[1], p[2]])
                .collect()
        })
        .collect();
    let made = make(frames.clone(), &frames[0], Precision::Double);
    let (found, _) = pca_with_warnings(&made, &count(1));
    let mut warnings = Vec::new();
    let shape = wrap::store(&found.mesh, &found.basis, &mut warnings).expect("stored");
    let animation = found.basis.animation.as_ref().expect("frames");
    let largest = animation.q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
    assert!(f64::from(shape.limits[0].q_limit) >= largest);
    let warning = warnings.iter().find(|w| w.contains("limit of q raised"));
    let warning = warning.expect("a warning");
    assert!(
        warning.contains("--align takes rigid motion out"),
        "{warning}"
    );
    let options = PcaOptions {
        align: true,
        ..auto(1e-6)
    };
    let (found, _) = pca_with_warnings(&made, &options);
    assert_eq!(found.basis.mode_count(), 0);
    assert_error_is_true(&found, &made.frames, "walk");
    assert!(matches!(options.modes, Modes::Auto { .. }));
}
