//! The VegaFEM reader, section by section.

use super::shapes::parse;
use bdtree_build::input::volume::RawVolume;

const CORNERS: &str = "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n";
const ELEMENTS: &str = "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 5 3 4\n";

fn veg(text: &str) -> Result<RawVolume, String> {
    parse("m.veg", text)
}

fn error(text: &str) -> String {
    veg(text).expect_err("an error")
}

#[test]
fn numbering_begins_at_0_or_1() {
    let one = veg(&format!("{CORNERS}{ELEMENTS}")).unwrap();
    assert_eq!(one.tetrahedra, [[0, 1, 2, 3], [1, 4, 2, 3]]);
    assert!(one.warnings.is_empty() && one.materials.is_empty() && one.material_of.is_empty());
    let zero = "*VERTICES\n5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1 1 1\n\
                *ELEMENTS\nTET\n2 4 0\n0 0 1 2 3\n1 1 4 2 3\n*SET a\n1\n";
    let zero = veg(zero).unwrap();
    assert_eq!(zero.tetrahedra, one.tetrahedra);
    assert_eq!(zero.node_sets[0].nodes, [1, 2, 3, 4]);

    let from_two = CORNERS.replace("\n1 0", "\n2 0");
    let text = error(&format!("{from_two}{ELEMENTS}"));
    let expected = "m.veg:3: the first vertex is number 2, neither 0 nor 1";
    assert!(text.starts_with(expected), "{text}");
    let gap = CORNERS.replace("\n4 0", "\n7 0");
    let text = error(&format!("{gap}{ELEMENTS}"));
    assert_eq!(text, "m.veg:6: expected vertex 4, found 7");
    let gap = ELEMENTS.replace("\n2 2", "\n3 2");
    assert_eq!(
        error(&format!("{CORNERS}{gap}")),
        "m.veg:12: expected element 2, found 3"
    );
}

#[test]
fn commas_comments_blank_lines_and_line_ends_are_free() {
    let text = "\u{feff}# a comment\r\n\r\n  *VERTICES\r\n5, 3, 0, 0 # five\r\n1,0,0,0\r2\t1 0 0\n\
                # between\n3 0 1e0 0\n4 0 0 +1.\n5 1 1 1\n*elements\nTet\n2 4 0\n1, 1,2,3,4\n2 2 5 3 4";
    let volume = veg(text).unwrap();
    assert_eq!(volume.tetrahedra, [[0, 1, 2, 3], [1, 4, 2, 3]]);
    assert_eq!(volume.nodes[3], [0.0, 0.0, 1.0]);
}

#[test]
fn materials_sets_and_regions_say_what_each_element_is_of() {
    let text = format!(
        "{CORNERS}{ELEMENTS}*MATERIAL soft wood\nENU, 600, 1e9, 0.3\n*MATERIAL lead\n\
         ENU , 11340 , 1.6e10 , 0.44\n*SET top\n2,\n*REGION\nallElements, softwood\n*REGION\n\
         top, le ad\n"
    );
    let volume = veg(&text).unwrap();
    let names: Vec<_> = volume.materials.iter().map(|m| m.name.as_deref()).collect();
    assert_eq!(names, [Some("softwood"), Some("lead")]);
    let lead = &volume.materials[1];
    assert_eq!(
        (lead.density_kg_m3, lead.young_pa, lead.poisson),
        (11340.0, 1.6e10, 0.44)
    );
    assert_eq!(volume.material_of, [0, 1]);
    assert_eq!(volume.node_sets.len(), 1);
    assert_eq!(volume.node_sets[0].name, "top");
    assert_eq!(volume.node_sets[0].nodes, [1, 2, 3, 4]);
    assert!(volume.warnings.is_empty());

    // Without a region the last material is for all, as VegaFEM does it; that is said.
    let text = text.replace("*REGION\nallElements, softwood\n", "");
    let volume = veg(&text).unwrap();
    assert_eq!(volume.material_of, [1, 1]);
    assert_eq!(
        volume.warnings,
        [
            "m.veg: 1 of 2 elements are in no region; they get the last material, lead, as VegaFEM has it"
        ]
    );
}

#[test]
fn every_mistake_is_named_with_its_line() {
    let text = format!(
        "{CORNERS}{ELEMENTS}*MATERIAL a\nMOONEYRIVLIN, 1000, 1, 2, 3\n*MATERIAL b\nENU, 1000, 1, 0.5\n\
         *MATERIAL c\nENU, 0, 1, 0.3\n*MATERIAL d\nENU, 1, x, 0.3\n*MATERIAL e\n*SET s\n1 9 x\n\
         *REGION\nnone, b\n*REGION\nallElements\n*INCLUDE more.veg\n"
    );
    let expected = "m.veg:14: material a: `MOONEYRIVLIN` is not read, only linear isotropic ones: ENU, \
                    density, E, nu\n\
                    m.veg:16: material b: nu 0.5 is not between -1 and 0.5\n\
                    m.veg:18: material c: density 0 and E 1 must be above 0\n\
                    m.veg:20: material d: E `x` is not a number\n\
                    m.veg:22: material e has no line of values\n\
                    m.veg:23: `x` is not an element's number\n\
                    m.veg:23: element 9 is not one of the 2\n\
                    m.veg:25: no material is called `b`\n\
                    m.veg:27: *REGION needs a line `set, material`\n\
                    m.veg:28: *INCLUDE is not read: put the file's text in its place";
    assert_eq!(error(&text), expected);

    let text = error(&format!(
        "{CORNERS}{ELEMENTS}*MATERIAL b\nENU 1 1 0\n*REGION\nnone, b\n"
    ));
    assert_eq!(text, "m.veg:16: no set is called `none`");
}

#[test]
fn vertices_and_elements_are_checked_line_by_line() {
    let text = CORNERS
        .replace("1 0 0\n", "1 nan 0\n")
        .replace("0 0 1", "0 0")
        + &ELEMENTS
            .replace("1 2 3 4", "1 2 3")
            .replace("2 5 3 4", "2 0 3 4");
    let expected = "m.veg:4: y `nan` is not a finite number\nm.veg:6: z is missing\n\
                    m.veg:11: corner 4 is missing\n\
                    m.veg:12: corner 2: vertex 0 is not one of the 5";
    assert_eq!(error(&text), expected);
    let text = ELEMENTS.replace("1 2 3 4", "1 2 3 4 5");
    assert_eq!(
        error(&format!("{CORNERS}{text}")),
        "m.veg:11: has more than 4 corners"
    );

    let count = |text: &str| error(&text.replace("5 3 0 0", "6 3 0 0"));
    let text = count(&format!("{CORNERS}{ELEMENTS}"));
    assert_eq!(text, "m.veg:2: 6 vertices declared, 5 found");
    let text = error(&format!("{CORNERS}{ELEMENTS}").replace("2 4 0", "1 4 0"));
    assert_eq!(text, "m.veg:10: 1 elements declared, 2 found");
    let text = error(&CORNERS.replace("5 3 0 0", "5000000000000 3 0 0"));
    assert!(
        text.starts_with("m.veg:2: the number of vertices 5000000000000 is more than the rest")
    );
    assert!(error(&CORNERS.replace("5 3 0 0", "-5 3 0 0")).contains("-5 is negative"));

    let extra = CORNERS.replace("1 0 0\n", "1 0 0 7\n");
    assert_eq!(
        veg(&format!("{extra}{ELEMENTS}")).unwrap().warnings,
        ["m.veg:4: 1 vertices have more than three coordinates; the first three are used"]
    );
}

#[test]
fn sections_may_be_missing_double_or_unknown() {
    assert_eq!(error(""), "m.veg: no *VERTICES section");
    assert_eq!(error(CORNERS), "m.veg: no *ELEMENTS section");
    assert_eq!(error(ELEMENTS), "m.veg:1: *ELEMENTS before *VERTICES");
    assert_eq!(
        error("v 0 0 0\n"),
        "m.veg:1: `v` before any section: no .veg text"
    );
    let text = error(&format!("{CORNERS}{CORNERS}{ELEMENTS}"));
    assert!(text.starts_with("m.veg:8: a second *VERTICES section"));
    let text = error(&format!(
        "{CORNERS}*ELEMENTS\nPRISM\n1 6 0\n1 1 2 3 4 5 1\n"
    ));
    assert_eq!(
        text,
        "m.veg:9: elements of type `PRISM`; TET and CUBIC are read"
    );
    let volume = veg(&format!("{CORNERS}*NORMALS\n1 2 3\n{ELEMENTS}")).unwrap();
    assert_eq!(
        volume.warnings,
        ["m.veg:8: ignored unknown section *NORMALS"]
    );
}

#[test]
fn problems_beyond_a_hundred_are_counted() {
    let lines: String = (1..=250).map(|i| format!("{i} x 0 0\n")).collect();
    let text = error(&format!("*VERTICES\n250 3 0 0\n{lines}{ELEMENTS}"));
    assert_eq!(text.lines().count(), 2);
    assert!(
        text.contains("(and 99 problems like it, at line 4; "),
        "{text}"
    );
    assert!(text.ends_with("m.veg: 150 more problems"));
}
