//! The Gmsh reader: groups, entities, and what it refuses.

use super::shapes::parse;
use bdtree_build::input::volume::{RawVolume, parse_volume};
use bdtree_fixtures::models::volume::{Format, beam};

const FORMATS: [Format; 4] = [
    Format::Msh2,
    Format::Msh2Binary,
    Format::Msh4,
    Format::Msh4Binary,
];

fn msh(text: &str) -> Result<RawVolume, String> {
    parse("m.msh", text)
}

fn error(text: &str) -> String {
    msh(text).expect_err("an error")
}

fn beam_text(format: Format) -> String {
    String::from_utf8(beam().to_file(format)).unwrap()
}

#[test]
fn named_groups_become_node_sets() {
    let end: Vec<u32> = (0..9).map(|i| 9 * i).collect();
    for format in FORMATS {
        let volume = parse_volume(&beam().to_file(format), "m.msh").unwrap();
        let names: Vec<&str> = volume.node_sets.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["tips", "fixed end", "body"], "{format:?}");
        assert_eq!(volume.node_sets[0].nodes, [0, 80]);
        assert_eq!(volume.node_sets[1].nodes, end);
        assert_eq!(volume.node_sets[2].nodes, (0..81).collect::<Vec<u32>>());
    }
}

const SMALL: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"a \"\n3 2 \"b\"\n\
    $EndPhysicalNames\n$Comments\nfree text\n$EndComments\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n\
    30 0 1 0\n4 0 0 1\n500 1 1 1\n$EndNodes\n$Elements\n3\n1 4 2 1 9 1 2 30 4\n2 4 2 2 9 2 500 30 4\n\
    7 4 2 -2 9 1 2 30 4\n$EndElements\n";

/// Version 2 writes an element once for every group it is in.
#[test]
fn an_element_of_two_groups_is_one_element() {
    let volume = msh(SMALL).unwrap();
    assert_eq!(volume.tetrahedra, [[0, 1, 2, 3], [1, 4, 2, 3]]);
    assert_eq!(volume.node_sets[0].name, "a ");
    assert_eq!(volume.node_sets[0].nodes, [0, 1, 2, 3]);
    assert_eq!(volume.node_sets[1].nodes, [0, 1, 2, 3, 4]);
    let warning = "m.msh:24: 1 tetrahedra have the corners of an earlier one and are left out";
    assert_eq!(volume.warnings, [warning]);
}

/// Blocks of elements belong to partitions, and these to the groups.
#[test]
fn partitions_keep_the_groups() {
    let plain = beam_text(Format::Msh4);
    let entities = &plain[plain.find("$Entities").unwrap()..plain.find("$Nodes").unwrap()];
    let partitioned = format!(
        "{entities}$PartitionedEntities\n2\n1\n9 1\n0 0 1 1\n17 2 1 1 2 0 0 0 1 1 1 1 2 0\n\
         18 3 1 2 1 2 0 0 0 1 1 1 1 1 2 5 -6\n$EndPartitionedEntities\n"
    );
    let text = plain
        .replace(entities, &partitioned)
        .replace("\n2 1 2 8\n", "\n2 17 2 8\n")
        .replace("\n3 1 4 192\n", "\n3 18 4 192\n");
    let volume = msh(&text).unwrap();
    assert_eq!(volume.node_sets, msh(&plain).unwrap().node_sets);
}

#[test]
fn parametric_nodes_are_read_without_their_parameters() {
    let plain = beam_text(Format::Msh4);
    let block = "\n3 1 0 81\n";
    assert!(plain.contains(block));
    let mut lines: Vec<String> = plain.lines().map(str::to_string).collect();
    let at = lines.iter().position(|line| line == "3 1 0 81").unwrap();
    lines[at] = "3 1 1 81".into();
    for line in &mut lines[at + 82..at + 163] {
        line.push_str(" 0.5 0.25 0.125");
    }
    assert_eq!(msh(&lines.join("\n")).unwrap(), msh(&plain).unwrap());

    let binary = beam().to_file(Format::Msh4Binary);
    let header: Vec<u8> = [3_i32, 1, 0].iter().flat_map(|n| n.to_le_bytes()).collect();
    let start = binary.windows(6).position(|w| w == b"$Nodes").unwrap();
    let at = start
        + binary[start..]
            .windows(12)
            .position(|w| w == header)
            .unwrap();
    let mut with = binary[..at].to_vec();
    with.extend([3_i32, 1, 1].iter().flat_map(|n| n.to_le_bytes()));
    let tags = at + 12;
    let positions = tags + 8 + 81 * 8;
    with.extend_from_slice(&binary[tags..positions]);
    for point in binary[positions..positions + 81 * 24].chunks(24) {
        with.extend_from_slice(point);
        with.extend_from_slice(&[7; 24]);
    }
    with.extend_from_slice(&binary[positions + 81 * 24..]);
    let read = |bytes: &[u8]| parse_volume(bytes, "m.msh").unwrap();
    assert_eq!(read(&with), read(&binary));
}

#[test]
fn other_versions_and_kinds_are_refused() {
    let starts = |text: &str, message: &str| {
        let found = error(text);
        assert!(found.starts_with(message), "{found}");
    };
    starts("", "m.msh:1: no .msh file: it begins with ``");
    starts(
        "$NOD\n1\n",
        "m.msh:1: MSH version 1; versions 2 and 4.1 are read",
    );
    starts(
        &SMALL.replace("2.2 0", "4 0"),
        "m.msh:2: MSH version 4; versions 2 and 4.1 are read",
    );
    starts(
        &SMALL.replace("2.2 0", "2.2 1"),
        "m.msh:2: the byte order is not marked by the number 1",
    );
    starts(
        &SMALL.replace("2.2 0", "2.2 7"),
        "m.msh:2: file type 7 is neither 0",
    );
    starts(
        &SMALL.replace("2.2 0 8", "2.2 0 6"),
        "m.msh:2: data size 6 is neither 4 nor 8",
    );
    starts(
        &SMALL.replace("2 4 2 2 9 2 500 30 4", "2 11 2 2 9 1 1 1 1 1 1 1 1 1 1"),
        "m.msh:23: 1 second-order tetrahedra (type 11); only tetrahedra of 4 nodes",
    );
    starts(
        &SMALL.replace("2 4 2 2 9", "2 1234 2 2 9"),
        "m.msh:23: 1 elements of unknown type (type 1234)",
    );
    starts(
        &SMALL.replace("$Nodes", "$ParametricNodes"),
        "m.msh:12: $ParametricNodes is not read",
    );
    let volume = msh(&SMALL.replace("Comments", "Poems")).unwrap();
    assert_eq!(
        volume.warnings[0],
        "m.msh:9: ignored unknown section $Poems"
    );
}

#[test]
fn every_mistake_is_named_with_its_line() {
    let with = |from: &str, to: &str| {
        assert!(SMALL.contains(from));
        error(&SMALL.replacen(from, to, 1))
    };
    assert_eq!(
        with("2 1 0 0", "2 1 x 0"),
        "m.msh:15: node 2: y `x` is not a number"
    );
    assert_eq!(
        with("2 1 0 0", "2 1 inf 0"),
        "m.msh:15: node 2: y `inf` is not a finite number"
    );
    assert_eq!(
        with("2 1 0 0", "1 1 0 0"),
        "m.msh:15: a second node 1\nm.msh:22: element 1: there is no node 2\nm.msh:23: element 2: there is no node 2\nm.msh:24: element 7: there is no node 2"
    );
    assert_eq!(
        with("2 500 30 4", "2 501 30 4"),
        "m.msh:23: element 2: there is no node 501"
    );
    assert_eq!(
        with("2 500 30 4", "2 500 30"),
        "m.msh:23: element 2: a node is missing"
    );
    assert_eq!(
        with("$Nodes\n5", "$Nodes\n4"),
        "m.msh:18: expected $EndNodes, found `500`"
    );
    assert_eq!(
        with("$Nodes\n5", "$Nodes\n6"),
        "m.msh:19: the tag of a node `$EndNodes` is not an integer"
    );
    assert_eq!(
        with("$Elements\n3", "$Elements\n2"),
        "m.msh:24: expected $EndElements, found `7`"
    );
    assert_eq!(
        with("$EndElements\n", ""),
        "m.msh:25: the file ends before $EndElements"
    );
    assert_eq!(
        with("$EndComments", "x"),
        "m.msh:9: the file ends before $EndComments"
    );
    let headless = &SMALL[SMALL.find("$Elements").unwrap()..];
    let text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{headless}");
    assert_eq!(error(&text), "m.msh:4: $Elements before $Nodes");
    let nodes = &SMALL[..SMALL.find("$Elements").unwrap()];
    assert_eq!(error(nodes), "m.msh: no $Elements section");

    let plain = beam_text(Format::Msh4);
    let text = error(&plain.replace("\n1 81 5 165\n", "\n1 80 5 165\n"));
    assert!(
        text.ends_with("80 nodes declared, 81 in the blocks"),
        "{text}"
    );
    let text = error(&plain.replace("\n4 202 1 202\n", "\n4 203 1 203\n"));
    assert!(
        text.ends_with("203 elements declared, 202 in the blocks"),
        "{text}"
    );
}
