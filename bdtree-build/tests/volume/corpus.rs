//! Real volumes. Reads the corpus from the folder in `BDTREE_CORPUS`.

use super::shapes::{enclosed, is_closed, volumes};
use bdtree_build::basis::embed::embed;
use bdtree_build::input::read_mesh;
use bdtree_build::input::volume::{read_volume, surface};
use bdtree_fixtures::corpus;

#[test]
fn counts_and_volumes_are_as_they_should_be() {
    // Nodes, tetrahedra, hexahedra: the corpus's own table.
    let files = [
        ("beam3_tet.veg", 208, 450, 0),
        ("bridge_hex.veg", 3923, 0, 1736),
        ("bullet_torus.vtk", 1036, 4436, 0),
    ];
    for (name, nodes, tetrahedra, hexahedra) in files {
        let Some(path) = corpus::path("volume_counts", &format!("modal/{name}")) else {
            return;
        };
        let volume = read_volume(&path).unwrap();
        let found = (
            volume.nodes.len(),
            volume.tetrahedra.len(),
            volume.hexahedra.len(),
        );
        assert_eq!(found, (nodes, tetrahedra, hexahedra), "{name}");
        assert!(volume.warnings.is_empty(), "{:?}", volume.warnings);
        let volumes = volumes(&volume);
        assert!(volumes.iter().all(|&v| v > 0.0));
        let mesh = surface(&volume);
        assert!(is_closed(&mesh), "{name}");
        let sum: f64 = volumes.iter().sum();
        let around = enclosed(&mesh);
        println!(
            "{name}: volume {sum}, surface {} triangles",
            mesh.triangles.len()
        );
        assert!((around - sum).abs() < 1e-12 * sum, "{name}: {around} {sum}");
        if name.ends_with(".veg") {
            let material = &volume.materials[0];
            let values = (material.density_kg_m3, material.young_pa, material.poisson);
            assert_eq!(values, (1000.0, 1e7, 0.45), "{name}");
            assert!(volume.material_of.iter().all(|&m| m == 0));
        }
        if hexahedra > 0 {
            // Cubes of one size, in VTK's order.
            let most = volumes.iter().fold(0.0_f64, |m, &v| m.max(v));
            let least = volumes.iter().fold(f64::INFINITY, |m, &v| m.min(v));
            assert!(most - least < 1e-10 * most, "{least} {most}");
        }
    }
}

/// The beam's quads have the nodes of its tetrahedra.
#[test]
fn the_beams_surface_embeds_exactly() {
    let name = "beam_surface_embeds";
    let (Some(volume), Some(mesh)) = (
        corpus::path(name, "modal/beam3_tet.veg"),
        corpus::path(name, "modal/beam3_surface.obj"),
    ) else {
        return;
    };
    let (volume, mesh) = (read_volume(&volume).unwrap(), read_mesh(&mesh).unwrap());
    let mut warnings = Vec::new();
    let embedding = embed(&mesh.positions, &volume, &mut warnings).unwrap();
    assert!(warnings.is_empty() && embedding.outside == 0);
    assert_eq!(embedding.point_count(), 208);
    let same = mesh.positions.iter().zip(&volume.nodes);
    let same = same.filter(|(p, q)| p == q).count();
    println!("{same} vertices have the position of their node to the last bit");
    assert!(same > 150);
    // The others differ in the last of 15 digits; elements are 0.04 long.
    let moved = embedding.apply(&volume.nodes);
    for (i, p) in mesh.positions.iter().enumerate() {
        let own = embedding
            .weights(i)
            .iter()
            .find(|&&(node, _)| node as usize == i);
        assert!(own.is_some_and(|&(_, weight)| weight > 1.0 - 1e-12), "{i}");
        assert!((0..3).all(|a| (moved[i][a] - p[a]).abs() < 1e-14), "{i}");
    }
}

/// The cage is said to be enlarged so as to hold the bridge.
#[test]
fn the_bridge_embeds_in_its_cage() {
    let name = "bridge_embeds";
    let (Some(volume), Some(mesh)) = (
        corpus::path(name, "modal/bridge_hex.veg"),
        corpus::path(name, "modal/bridge_rest.obj.gz"),
    ) else {
        return;
    };
    let (volume, mesh) = (read_volume(&volume).unwrap(), read_mesh(&mesh).unwrap());
    assert_eq!(mesh.positions.len(), 16085);
    let mut warnings = Vec::new();
    let start = std::time::Instant::now();
    let embedding = embed(&mesh.positions, &volume, &mut warnings).unwrap();
    println!("{:?} {warnings:?}", start.elapsed());
    let moved = embedding.apply(&volume.nodes);
    let mut exact = 0;
    for (p, q) in mesh.positions.iter().zip(&moved) {
        let off = (0..3).fold(0.0_f64, |m, a| m.max((p[a] - q[a]).abs()));
        exact += usize::from(off < 1e-13);
    }
    assert_eq!(exact + embedding.outside, 16085);
}
