//! What holds a volume mesh, and what is refused.

use crate::volume_support::{bar, hertz, run, solve, steel};
use bdtree_build::basis::elastic::{Fix, FixRegion};
use bdtree_build::basis::volume::{MassMatrix, VolumeOptions};
use bdtree_build::input::volume::{RawMaterial, RawNodeSet, RawVolume};

fn with_fix(text: &str, modes: usize) -> VolumeOptions {
    VolumeOptions {
        fixes: vec![text.parse().unwrap()],
        ..steel(modes)
    }
}

fn list_file(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}

#[test]
fn box_set_and_list_hold_the_same_nodes() {
    let mut volume = bar();
    let end: Vec<u32> = (0..volume.nodes.len() as u32)
        .filter(|&n| volume.nodes[n as usize][0] == 0.0)
        .collect();
    let names: Vec<String> = end.iter().map(|n| (n + 1).to_string()).collect();
    volume.node_sets.push(RawNodeSet {
        name: "left end".into(),
        nodes: end.clone(),
    });
    // The box misses the nodes by the rounding of their coordinates.
    let by_box = with_fix("xyz:-1,0,0,-1e-9,1,1", 6);
    let (modes, report) = solve(&volume, &by_box);
    assert_eq!(report.dofs, 3 * (volume.nodes.len() - 9));
    for mode in &modes.modes {
        assert!(end.iter().all(|&n| mode.field[n as usize] == [0.0; 3]));
    }
    let want = hertz(&modes);
    assert_eq!(run(&volume, &with_fix("xyz:left end", 6)).unwrap(), want);
    for text in [
        names.join(","),
        names.join("\n"),
        format!("# held\r\n{},\r\n", names.join(", ")),
    ] {
        let file = list_file(&text);
        let fix = format!("xyz:@{}", file.path().display());
        assert_eq!(run(&volume, &with_fix(&fix, 6)).unwrap(), want);
    }
    // One axis after the other comes to the same.
    let axes = ["x:left end", "y:left end", "z:left end"];
    let options = VolumeOptions {
        fixes: axes.map(|f| f.parse().unwrap()).to_vec(),
        ..steel(6)
    };
    assert_eq!(run(&volume, &options).unwrap(), want);
}

#[test]
fn mass_is_read_from_text() {
    for mass in [MassMatrix::Consistent, MassMatrix::Lumped] {
        assert_eq!(mass.to_string().parse(), Ok(mass));
    }
    assert!("Lumped".parse::<MassMatrix>().is_err());
}

#[test]
fn lists_are_read_from_text_and_named_without_folders() {
    let fix: Fix = "yz:@data/held.bou".parse().unwrap();
    assert_eq!(fix.axes, [false, true, true]);
    assert_eq!(fix.region, FixRegion::List("data/held.bou".into()));
    assert_eq!(fix.to_string(), "yz:@data/held.bou");
    assert_eq!(fix.without_folders().to_string(), "yz:@held.bou");
    assert!("x:@".parse::<Fix>().is_err());
}

#[test]
fn bad_input_is_told_with_its_place() {
    let volume = bar();
    let fails = |volume: &RawVolume, options: &VolumeOptions, places: &[&str]| {
        let error = run(volume, options).expect_err("an error");
        println!("{error}");
        assert_eq!(error.problems.len(), places.len(), "{error}");
        for (problem, place) in error.problems.iter().zip(places) {
            assert!(problem.to_string().contains(place), "{problem}");
        }
    };
    let file = list_file("1, 2,x3\n0 4\n99999\n-1, 1.5\n");
    let list = format!("xyz:@{}", file.path().display());
    let name = file.path().display();
    let places = [1, 2, 3, 4, 4].map(|line| format!("{name}:{line}: "));
    let places: Vec<&str> = places.iter().map(String::as_str).collect();
    fails(&volume, &with_fix(&list, 4), &places);
    let empty = list_file("# nothing\n");
    let list = format!("xyz:@{}", empty.path().display());
    fails(&volume, &with_fix(&list, 4), &["names no node"]);
    fails(
        &volume,
        &with_fix("x:@/no/such/file", 4),
        &["cannot be read"],
    );
    fails(&volume, &with_fix("z:legs", 4), &["no node set"]);
    fails(
        &volume,
        &with_fix("z:9,9,9,10,10,10", 4),
        &["holds no part"],
    );
    fails(
        &volume,
        &with_fix("xyz:-9,-9,-9,9,9,9", 4),
        &["everything is held"],
    );
    let options = VolumeOptions {
        mode_count: 0,
        young_pa: Some(-1.0),
        poisson: Some(0.5),
        density_kg_m3: Some(f64::NAN),
        scale_m: f64::INFINITY,
        fixes: vec![Fix {
            axes: [false; 3],
            region: FixRegion::Group(String::new()),
        }],
        ..VolumeOptions::default()
    };
    let names = [
        "--young",
        "--density",
        "--scale",
        "--poisson",
        "--modes",
        "--fix",
    ];
    fails(&volume, &options, &names);
    fails(&volume, &steel(100_000), &["--modes"]);
    let small = VolumeOptions {
        memory_limit_bytes: 1 << 16,
        ..steel(4)
    };
    fails(&volume, &small, &["the limit is 0 MiB (--memory-limit)"]);
    fails(&RawVolume::default(), &steel(4), &["no elements"]);

    let mut broken = volume.clone();
    broken.hexahedra[3].swap(0, 6);
    broken.hexahedra[7].copy_within(0..4, 4);
    fails(&broken, &steel(4), &["element 4", "element 8"]);
    let mut broken = volume.clone();
    broken.hexahedra[2][1] = 12345;
    broken.nodes[5][1] = f64::NAN;
    fails(&broken, &steel(4), &["node 6", "element 3"]);
    let mut broken = volume.clone();
    broken.materials = vec![RawMaterial {
        name: Some("foam".into()),
        poisson: 0.7,
        ..RawMaterial::default()
    }];
    broken.material_of = vec![3; 32];
    let options = VolumeOptions::default();
    let error = run(&broken, &options).expect_err("an error");
    // Three of the material; those of the elements are alike and told once.
    assert_eq!(error.problems.len(), 3 + 1, "{error}");
    assert!(
        error
            .to_string()
            .contains("(and 31 problems like it, at element 2; ")
    );
    assert!(error.to_string().contains("material foam"));
    // The same materials are fine once the options say what they are.
    broken.material_of = vec![0; 32];
    assert_eq!(
        run(&broken, &steel(4)).unwrap(),
        run(&volume, &steel(4)).unwrap()
    );
    broken.material_of.pop();
    fails(&broken, &steel(4), &["not one material for each"]);
}
