//! Mass properties in `info` and `diff`.

use bdtree_build::mass::Momentum;
use serde_json::Value;

use crate::support::{Folder, baked, ball_mesh, basis};

/// The file of a ball whose modes have momenta; the first along x with this one.
fn with_momenta(along_x: f64) -> Vec<u8> {
    let mesh = ball_mesh();
    let mut basis = basis(&mesh);
    for (j, mode) in basis.modes.iter_mut().enumerate() {
        mode.modal_mass_kg = Some(1.0 + j as f64);
        mode.momentum = Some(Momentum {
            about: [0.0; 3],
            linear: [along_x, 0.5, 0.0],
            angular: [0.0, 0.0, 0.25],
        });
    }
    baked(&mesh, &basis)
}

#[test]
fn info_tells_the_mass_of_closed_meshes() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let mass = &info["mass"];
    let number = |name: &str| mass[name].as_f64().expect("a number");
    assert_eq!((number("density_kg_m3"), number("scale_m")), (1000.0, 1.0));
    assert!((number("mass_kg") - 1000.0 * number("volume")).abs() < 1e-9 * number("mass_kg"));
    assert_eq!(mass["source"], "surface");
    assert_eq!(mass["center_of_mass"].as_array().map(Vec::len), Some(3));
    let inertia = mass["inertia"].as_array().expect("entries");
    assert_eq!(inertia.len(), 6);
    assert!(inertia[..3].iter().all(|x| x.as_f64() > Some(0.0)));
    let text = folder.run(&["info", "a.bdt"]).out;
    for line in ["mass         ", "center       ", "inertia      "] {
        assert!(text.contains(&format!("\n{line}")), "{text}");
    }
    assert!(
        text.contains(" kg of what the mesh encloses: 1000 kg/m³"),
        "{text}"
    );

    // An open mesh has none.
    let mut open = ball_mesh();
    open.triangles.pop();
    open.groups.clear();
    folder.write("open.bdt", baked(&open, &basis(&open)));
    let info = folder.json(&["info", "open.bdt", "--json"]);
    assert_eq!(info.get("mass"), Some(&Value::Null));
    assert!(!folder.run(&["info", "open.bdt"]).out.contains("\nmass "));
    for file in ["open.bdt", "a.bdt"] {
        let ran = folder.run(&["verify", file]);
        assert_eq!(ran.code, 0, "{}{}", ran.out, ran.err);
    }
}

#[test]
fn diff_compares_masses_and_momenta_within_the_tolerance() {
    let folder = Folder::new();
    for (name, along_x) in [("m.bdt", 1.0), ("same.bdt", 1.0), ("near.bdt", 1.0 + 1e-6)] {
        folder.write(name, with_momenta(along_x));
    }
    let ran = folder.run(&["diff", "m.bdt", "same.bdt"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "same\n"));
    let ran = folder.run(&["diff", "m.bdt", "near.bdt"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.out.contains("section MMOM: linear: 3 of 9 differ"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("mode 0 x"), "{}", ran.out);
    let ran = folder.run(&["diff", "m.bdt", "near.bdt", "--tolerance-rel", "1e-5"]);
    assert_eq!(ran.code, 0, "{}", ran.out);
    // A mesh that is larger by a hundredth: every number of the mass but density and scale.
    let mut larger = ball_mesh();
    for x in larger.positions.as_flattened_mut() {
        *x *= 1.01;
    }
    folder.write("larger.bdt", baked(&larger, &basis(&larger)));
    let ran = folder.run(&["diff", "a.bdt", "larger.bdt"]);
    for quantity in ["mass_kg", "center_of_mass", "inertia", "volume"] {
        let told = format!("section MASS: {quantity}: ");
        assert!(ran.out.contains(&told), "{told}: {}", ran.out);
    }
    for quantity in ["density_kg_m3", "scale_m", "source"] {
        assert!(!ran.out.contains(quantity), "{}", ran.out);
    }
    let ran = folder.run(&["diff", "a.bdt", "m.bdt"]);
    assert!(
        ran.out.contains("MMOM: only in the second file"),
        "{}",
        ran.out
    );
}
