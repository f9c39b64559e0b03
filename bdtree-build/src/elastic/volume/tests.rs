//! Small volumes against all their modes at once.

use super::*;
use crate::elastic::solve::rigid::rigid_motions;
use crate::elastic::solve::tests::dense::all_modes;
use crate::elastic::solve::{Limits, solve};
use crate::progress::Silent;

/// A block of cells whose inner and outer nodes are moved about, of hexahedra, of tetrahedra
/// (six per cell) or of both, in two materials.
fn jittered(n: [usize; 3], tetrahedra: impl Fn(usize) -> bool, lumped: bool) -> Model {
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    let mut model = Model {
        materials: vec![
            (Material::new(1.0, 0.3), 1.0),
            (Material::new(0.3, 0.45), 0.6),
        ],
        lumped,
        ..Model::default()
    };
    let at = |c: [usize; 3]| ((c[2] * (n[1] + 1) + c[1]) * (n[0] + 1) + c[0]) as u32;
    for i in 0..(n[0] + 1) * (n[1] + 1) * (n[2] + 1) {
        let c = [
            i % (n[0] + 1),
            i / (n[0] + 1) % (n[1] + 1),
            i / (n[0] + 1) / (n[1] + 1),
        ];
        model.positions.push(c.map(|x| x as f64 + 0.3 * random()));
    }
    for i in 0..n[0] * n[1] * n[2] {
        let [x, y, z] = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]];
        let c = [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
        ]
        .map(|c: [usize; 3]| at([x + c[0], y + c[1], z + c[2]]));
        let material = (i % 2) as u32;
        if tetrahedra(i) {
            for [a, b] in [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]] {
                model.elements.push([c[0], c[a], c[b], c[6]]);
                model.material_of.push(material);
            }
        } else {
            model.elements.push(c);
            model.material_of.push(material);
        }
    }
    model
}

/// The lowest modes against all of them, computed at once; the number of motions without
/// strain is known.
fn check(model: &Model, held: &[[bool; 3]], still: usize) {
    for e in 0..model.elements.len() {
        assert!(model.shape(e).1 > 1e-2, "element {e}");
    }
    let components = model.components().expect("few blocks");
    let limits = Limits {
        wanted: 12,
        bytes: 1 << 30,
        verify_dof_max: 70_000,
        threads: 2,
    };
    let sizes: Vec<usize> = components.iter().map(|p| p.nodes.len()).collect();
    let system = |c: usize| model.system(&components[c], held);
    let found = solve(&sizes, system, limits, &Silent).expect("modes");
    assert!(found.checked);
    let mut want = Vec::new();
    let mut motions = 0;
    for component in &components {
        let system = model.system(component, held).expect("a system");
        let rigid = rigid_motions(&system);
        let energy = rigid.transpose() * system.apply_stiffness(rigid.as_ref());
        for j in 0..rigid.ncols() {
            assert!(energy[(j, j)].abs() < 1e-12);
        }
        motions += rigid.ncols();
        want.extend(all_modes(&system, rigid.ncols()).expect("all").values);
    }
    assert_eq!(motions, still);
    want.sort_by(f64::total_cmp);
    assert!(want[0] > 1e-5, "a motion without strain was not found");
    assert_eq!(found.modes.len(), 12);
    for (mode, want) in found.modes.iter().zip(want) {
        assert!(
            (mode.value / want - 1.0).abs() < 1e-8,
            "{} {want}",
            mode.value
        );
        let own = &components[mode.component].nodes;
        for (i, u) in mode.vector.iter().enumerate() {
            if held[own[i / 3] as usize][i % 3] {
                assert_eq!(*u, 0.0);
            }
        }
    }
}

#[test]
fn free_bodies_meet_the_dense_solution() {
    let n = [4, 3, 2];
    for lumped in [false, true] {
        let kinds: [fn(usize) -> bool; 3] = [|_| false, |_| true, |i| i % 4 == 0];
        // Tetrahedra beside hexahedra leave gaps in the faces, but are one body all the same.
        for kind in kinds {
            let model = jittered(n, kind, lumped);
            check(&model, &vec![[false; 3]; model.positions.len()], 6);
        }
    }
}

#[test]
fn held_bodies_meet_the_dense_solution() {
    let n = [4, 3, 2];
    let model = jittered(n, |_| false, false);
    let none = vec![[false; 3]; model.positions.len()];
    let with = |nodes: &[usize], axes: [bool; 3]| {
        let mut held = none.clone();
        nodes.iter().for_each(|&n| held[n] = axes);
        held
    };
    let all = [true; 3];
    let z = [false, false, true];
    check(&model, &with(&[0], all), 3);
    check(&model, &with(&[0, 7], all), 1);
    check(&model, &with(&[0, 7, 31], all), 0);
    check(&model, &with(&[0, 7, 31], z), 3);
    check(&model, &with(&[3], z), 5);
    let face: Vec<usize> = (0..60).step_by(5).collect();
    check(&model, &with(&face, all), 0);
    check(&model, &with(&face, z), 3);
}

/// Three points on a line, but for the rounding of their coordinates, leave the body to turn.
#[test]
fn points_that_are_nearly_on_a_line_are_a_hinge() {
    let mut model = jittered([4, 2, 2], |_| true, false);
    for n in 0..5 {
        model.positions[n] = [n as f64, 1e-8 * (n * n) as f64, 0.0];
    }
    let mut held = vec![[false; 3]; model.positions.len()];
    held[..5].fill([true; 3]);
    check(&model, &held, 1);
}

/// Two cells with a common edge, and a third one that shares a corner with the second.
#[test]
fn joints_move_without_strain() {
    let mut model = jittered([4, 3, 2], |_| false, false);
    let kept = [0, 5, 6, 23];
    let elements: Vec<Vec<u32>> = kept.map(|e| model.elements.get(e).to_vec()).to_vec();
    model.elements = NodeLists::default();
    elements.into_iter().for_each(|e| model.elements.push(e));
    model.material_of.truncate(4);
    let components = model.components().expect("few blocks");
    // Cells 0 and 5 share an edge, 6 lies beside 5 and shares a corner with 23.
    assert_eq!(components.len(), 1);
    assert_eq!(components[0].blocks.further, 2);
    let mut held = vec![[false; 3]; model.positions.len()];
    check(&model, &held, 6 + 1 + 3);
    let first = model.elements.get(0)[0] as usize;
    held[first] = [true; 3];
    check(&model, &held, 3 + 1 + 3);
}

#[test]
fn parts_that_share_no_node_vibrate_apart() {
    let mut model = jittered([4, 3, 2], |_| false, false);
    let kept = [0, 1, 3];
    let elements: Vec<Vec<u32>> = kept.map(|e| model.elements.get(e).to_vec()).to_vec();
    model.elements = NodeLists::default();
    elements.into_iter().for_each(|e| model.elements.push(e));
    model.material_of.truncate(3);
    assert_eq!(model.components().expect("few blocks").len(), 2);
    check(&model, &vec![[false; 3]; model.positions.len()], 12);
}
