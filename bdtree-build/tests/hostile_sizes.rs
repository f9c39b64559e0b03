//! Small files that ask for unbounded memory are refused, with their place, before it is taken.

use std::fs;
use std::io::Write;
use std::path::Path;

use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::elastic::Fix;
use bdtree_build::basis::given::given_basis;
use bdtree_build::basis::morph::morph_basis;
use bdtree_build::basis::pca::{About, Modes, PcaOptions, pca_basis};
use bdtree_build::basis::volume::{VolumeOptions, volume_modes};
use bdtree_build::error::BakeError;
use bdtree_build::input::gltf;
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::volume::{RawVolume, parse_volume, read_volume};
use bdtree_build::input::{RawMesh, RawMorphs, RawTarget};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models::fields::npy_with;

fn assert_says<T>(result: Result<T, BakeError>, parts: &[&str]) {
    let text = match result {
        Ok(_) => panic!("should be refused: {parts:?}"),
        Err(error) => error.to_string(),
    };
    println!("{text}");
    for part in parts {
        assert!(text.contains(part), "{text}\nlacks {part}");
    }
}

#[test]
fn frames_without_vertices_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let pc2 = folder.path().join("a.pc2");
    let mut bytes = b"POINTCACHE2\0".to_vec();
    for word in [1, 0, 0, 1.0_f32.to_bits(), i32::MAX as u32] {
        bytes.extend(word.to_le_bytes());
    }
    fs::write(&pc2, &bytes).expect("writable");
    let npy = folder.path().join("a.npy");
    fs::write(&npy, npy_with("<f4", false, "1000000000000, 0, 3", [])).expect("writable");
    let open = |path: &Path| FrameSequence::open(path, None, Some(30.0), &Silent);
    assert_says(open(&pc2), &["a.pc2", "2147483647 frames of 0 points"]);
    assert_says(open(&npy), &["a.npy", "1000000000000 frames of 0 points"]);
}

/// The products of all pairs of 100 000 fields would take 80 GB: dependent fields are not searched.
#[test]
fn many_fields_of_one_vertex_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("u.npy");
    let data = std::iter::repeat_n(1.0_f32.to_le_bytes(), 300_000).flatten();
    fs::write(&path, npy_with("<f4", false, "1, 3, 100000", data)).expect("writable");
    let given = given_basis(&path, None, None, 1).expect("sound");
    assert_eq!(given.basis.mode_count(), 100_000);
    assert_eq!(given.warnings, [""; 0]);
    // No vertices, and no data for any number of fields.
    for shape in ["0, 3, 1000000000000000000", "1000000000000000000, 0, 3"] {
        fs::write(&path, npy_with("<f4", false, shape, [])).expect("writable");
        let result = given_basis(&path, None, None, 0);
        assert_says(result, &["u.npy: shape", "for a mesh without vertices"]);
    }
}

/// Names are looked up once each, and a set that many regions name is written once.
#[test]
fn many_sets_and_regions_are_read() {
    let mut text = "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n".to_string();
    text += "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 4 5\n";
    text +=
        "*MATERIAL A\nENU, 1, 1, 0.3\n*MATERIAL B\nENU, 2, 1, 0.3\n*MATERIAL A\nENU, 3, 1, 0.3\n";
    text += "*SET both\n";
    text += &"1,2,".repeat(20_000);
    text += "\n*SET second\n2\n";
    for k in 0..20_000 {
        text += &format!("*SET s{k}\n1\n*REGION\ns{k}, B\n*REGION\nboth, A\n");
    }
    // Regions count in their order: `both` was last named before `second`.
    text += "*REGION\nsecond, B\n";
    let volume = parse_volume(text.as_bytes(), "v.veg").expect("sound");
    assert_eq!(volume.material_of, [0, 1]);
    assert_eq!(volume.node_sets.len(), 20_002);
    text += "*REGION\nallElements, B\n*REGION\nthird, A\n*REGION\nboth, C\n";
    let parts = ["no set is called `third`", "no material is called `C`"];
    assert_says(parse_volume(text.as_bytes(), "v.veg"), &parts);
}

/// 80 MiB of text in 80 kB of gzip: what is decompressed is bounded, whatever asks for it.
#[test]
fn compressed_files_are_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, line: &[u8], lines: usize| {
        let path = folder.path().join(name);
        let out = fs::File::create(&path).expect("writable");
        let mut gzip = flate2::write::GzEncoder::new(out, flate2::Compression::best());
        let block = line.repeat(1 << 15);
        for _ in 0..lines >> 15 {
            gzip.write_all(&block).expect("writable");
        }
        gzip.finish().expect("writable");
        path
    };
    let most = "more than 64 MiB of text in";
    let bomb = file("a.obj.gz", b"v 0 0 0\n", 10 << 20);
    assert_says(read_mesh(&bomb), &["a.obj.gz: ", most, "bytes of gzip"]);
    let bomb = file("a.veg.gz", b"# 5 7 9\n", 10 << 20);
    assert_says(read_volume(&bomb), &["a.veg.gz: ", most, "bytes of gzip"]);
    // Half of that is read, however well it was compressed.
    let large = file("b.obj.gz", b"# comment 0 0 0\n", 2 << 20);
    assert_says(read_mesh(&large), &["b.obj.gz: ", "no vertices"]);
}

#[test]
fn more_morph_targets_than_fit_are_refused() {
    let mesh = RawMesh {
        name: "m.glb".into(),
        positions: vec![[0.0; 3]; 1 << 20],
        ..RawMesh::default()
    };
    let target = RawTarget {
        displacements: vec![(0, [1.0, 0.0, 0.0])],
        ..RawTarget::default()
    };
    let morphs = RawMorphs {
        targets: vec![target; 40_000],
        clip: None,
    };
    let basis = |keep| morph_basis(&mesh, &morphs, keep, 4 << 30, &mut Vec::new());
    assert_says(basis(Keep::All), &["m.glb", "40000 morph targets", "512"]);
    let memory = ["m.glb", "960036 MiB", "4096 MiB (--memory-limit)"];
    assert_says(basis(Keep::First(1)), &memory);
    let auto = Keep::Auto { max_error_rel: 0.1 };
    assert_says(basis(auto), &["m.glb", "4096 MiB (--memory-limit)"]);
}

/// A glTF of `nodes` nodes with a triangle and a morph target; a channel for each, of `samplers`
/// samplers that all name the same cubic curve of `keys` steep keys.
fn steep_curves(nodes: usize, samplers: usize, keys: usize) -> Vec<u8> {
    let mut data: Vec<f32> = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    data.extend((0..keys).map(|key| key as f32));
    data.extend((0..keys).flat_map(|_| [1e9_f32, 0.0, 1e9]));
    let bytes: Vec<u8> = data.iter().flat_map(|x| x.to_le_bytes()).collect();
    let list = |count: usize, item: &dyn Fn(usize) -> String| {
        let items: Vec<String> = (0..count).map(item).collect();
        format!("[{}]", items.join(","))
    };
    let (input, output) = (36, 36 + 4 * keys);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":{}}}],"nodes":{},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":0}}]}}]}}],
        "buffers":[{{"byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteLength":{}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3,
            "min":[0,0,0],"max":[1,1,0]}},
          {{"bufferView":0,"byteOffset":{input},"componentType":5126,"type":"SCALAR","count":{keys},
            "min":[0],"max":[{}]}},
          {{"bufferView":0,"byteOffset":{output},"componentType":5126,"type":"SCALAR","count":{}}}],
        "animations":[{{"samplers":{},"channels":{}}}]}}"#,
        list(nodes, &|i| i.to_string()),
        list(nodes, &|_| r#"{"mesh":0}"#.into()),
        bytes.len(),
        bytes.len(),
        keys - 1,
        3 * keys,
        list(samplers, &|_| {
            r#"{"input":1,"output":2,"interpolation":"CUBICSPLINE"}"#.into()
        }),
        list(nodes, &|i| format!(
            r#"{{"sampler":{},"target":{{"node":{i},"path":"weights"}}}}"#,
            i % samplers
        )),
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bytes.len();
    for word in [2, total as u32, json.len() as u32] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((bytes.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bytes);
    glb
}

#[test]
fn curves_of_too_many_frames_are_refused() {
    let read = |bytes: &[u8]| gltf::parse(bytes, "m.glb", Path::new(""), None);
    // The same curves with fewer keys are read: 255 frames between two keys.
    let model = read(&steep_curves(200, 200, 2)).expect("sound");
    let clip = model.morphs.clip.expect("a clip");
    assert_eq!((clip.times_s.len(), clip.weights.len()), (257, 257 * 200));
    for samplers in [1, 200] {
        let frames = ["m.glb: animations[0]", "more than 134217728 weights"];
        assert_says(read(&steep_curves(200, samplers, 20_000)), &frames);
    }
    let copies = "animations[0].samplers: 160000000 times and values";
    assert_says(read(&steep_curves(2000, 2000, 20_000)), &[copies]);
}

/// A .msh 4.1 file of one tetrahedron, and `points` point elements of an entity that belongs to the
/// groups `tags`, of `names` groups.
fn gmsh(names: usize, tags: &[usize], points: usize) -> Vec<u8> {
    let mut text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n".to_string();
    text += &format!("$PhysicalNames\n{names}\n");
    for tag in 1..=names {
        text += &format!("0 {tag} \"g{tag}\"\n");
    }
    text += "$EndPhysicalNames\n$Entities\n1 0 0 0\n";
    text += &format!("1 0 0 0 {}", tags.len());
    for tag in tags {
        text += &format!(" {tag}");
    }
    text += "\n$EndEntities\n$Nodes\n";
    let nodes = points.max(4);
    text += &format!("1 {nodes} 1 {nodes}\n3 1 0 {nodes}\n");
    for n in 1..=nodes {
        text += &format!("{n}\n");
    }
    text += "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    for n in 4..nodes {
        text += &format!("{n} 0 0\n");
    }
    text += "$EndNodes\n$Elements\n";
    let all = points + 1;
    text += &format!("2 {all} 1 {all}\n3 1 4 1\n1 1 2 3 4\n0 1 15 {points}\n");
    for p in 1..=points {
        text += &format!("{} {p}\n", p + 1);
    }
    text += "$EndElements\n";
    text.into_bytes()
}

#[test]
fn entities_of_many_groups_are_bounded() {
    // One group named many times is one group.
    let volume = parse_volume(&gmsh(1, &[1; 40_000], 40_000), "m.msh").expect("sound");
    assert_eq!(volume.node_sets.len(), 1);
    assert_eq!(volume.node_sets[0].nodes.len(), 40_000);
    let two = parse_volume(&gmsh(3, &[3, 1, 3], 4), "m.msh").expect("sound");
    let nodes: Vec<&[u32]> = two.node_sets.iter().map(|s| s.nodes.as_slice()).collect();
    assert_eq!(nodes, [&[0, 1, 2, 3][..], &[], &[0, 1, 2, 3]]);
    let tags: Vec<usize> = (1..=20_000).collect();
    let text = gmsh(20_000, &tags, 20_000);
    assert_says(
        parse_volume(&text, "m.msh"),
        &["m.msh:", "block of 20000 nodes in 20000 groups"],
    );
}

#[test]
fn problems_beyond_the_first_hundred_are_counted() {
    let volume = RawVolume {
        name: "v.veg".into(),
        nodes: vec![[f64::NAN; 3]; 250],
        tetrahedra: vec![[0, 1, 2, 3]],
        ..RawVolume::default()
    };
    let modes = |volume: &RawVolume, options: &VolumeOptions| {
        let error = volume_modes(volume, options, &Silent, &mut Vec::new()).err();
        let error = error.expect("should be refused");
        // The hundred are alike: the first stands for them.
        assert_eq!(error.problems.len(), 2);
        assert!(
            error.problems[0]
                .message
                .contains("and 99 problems like it")
        );
        error.problems[1].to_string()
    };
    let options = VolumeOptions::default();
    assert_eq!(modes(&volume, &options), "v.veg: 150 more problems");

    let list = tempfile::NamedTempFile::new().expect("a file");
    fs::write(list.path(), "0\n".repeat(130)).expect("writable");
    let place = list.path().display().to_string();
    let fix: Fix = format!("xyz:@{place}").parse().expect("a fix");
    let options = VolumeOptions {
        fixes: vec![fix],
        ..options
    };
    let volume = RawVolume {
        nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ..volume
    };
    let said = modes(&volume, &options);
    assert_eq!(said, format!("{place}: 30 more problems"));
}

/// Every frame moves another vertex by the same length, so that all singular values are equal and
/// one mode takes as much memory as all.
#[test]
fn equal_singular_values_count_with_their_memory() {
    const N: usize = 4000;
    const T: usize = 50;
    let rest: Vec<[f64; 3]> = (0..N).map(|i| [i as f64, (i % 7) as f64, 0.0]).collect();
    let mesh = RawMesh {
        name: "m.obj".into(),
        positions: rest.clone(),
        triangles: vec![[0, 1, 2]],
        ..RawMesh::default()
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.pc2");
    let mut bytes = b"POINTCACHE2\0".to_vec();
    for word in [1, N as u32, 0, 1.0_f32.to_bits(), T as u32] {
        bytes.extend(word.to_le_bytes());
    }
    for t in 0..T {
        for (i, p) in rest.iter().enumerate() {
            let z = if i == t { 1.0 } else { 0.0 };
            let p = [p[0] as f32, p[1] as f32, z];
            bytes.extend(p.iter().flat_map(|x| x.to_le_bytes()));
        }
    }
    fs::write(&path, &bytes).expect("writable");
    let sequence = FrameSequence::open(&path, Some(&mesh), None, &Silent).expect("a sequence");
    let run = |limit| {
        let options = PcaOptions {
            modes: Modes::Count(1),
            about: About::Input,
            memory_limit_bytes: limit,
            ..PcaOptions::default()
        };
        pca_basis(&mesh, &sequence, &options, &Silent, &mut Vec::new())
    };
    // 50 fields, and the space that they span once more: 9.6 MB.
    let parts = ["with 1 modes (100 fields at a time", "limit is 8 MiB"];
    assert_says(run(8 << 20), &parts);
    let pca = run(32 << 20).expect("a basis");
    assert_eq!(pca.basis.mode_count(), 1);
}
