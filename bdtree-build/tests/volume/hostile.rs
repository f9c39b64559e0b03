//! Files cut and damaged anywhere: an error or a volume, never a panic, never much memory.

use bdtree_build::input::volume::{parse_volume, surface};
use bdtree_fixtures::models::math::Random;
use bdtree_fixtures::models::volume::{Format, Volume, hex_block, tet_block};

/// One file of every format, of a few hundred bytes.
fn small() -> Vec<(String, Vec<u8>)> {
    let tetrahedra = Volume::of_tetrahedra(tet_block(1, 1, 1, [1.0; 3]));
    let hexahedra = Volume::of_hexahedra(hex_block(2, 1, 1, [1.0; 3]));
    Format::ALL
        .into_iter()
        .flat_map(|format| {
            let name = format!("m{}", format.extension());
            [&tetrahedra, &hexahedra].map(|v| (name.clone(), v.to_file(format)))
        })
        .collect()
}

/// Reads it, and what it is read as is sound.
fn check(bytes: &[u8], name: &str) -> bool {
    match parse_volume(bytes, name) {
        Ok(volume) => {
            let count = volume.nodes.len() as u32;
            let corners = volume.tetrahedra.iter().flatten();
            assert!(
                corners
                    .chain(volume.hexahedra.iter().flatten())
                    .all(|&c| c < count)
            );
            assert!(volume.nodes.iter().flatten().all(|x| x.is_finite()));
            let elements = volume.tetrahedra.len() + volume.hexahedra.len();
            assert!(elements > 0);
            let materials = volume.material_of.len();
            assert!(materials == 0 || materials == elements);
            assert!(!surface(&volume).triangles.is_empty());
            true
        }
        Err(error) => {
            assert!(!error.problems.is_empty() && error.problems.len() <= 101);
            assert!(
                error
                    .problems
                    .iter()
                    .all(|p| p.place.file.as_deref() == Some(name)),
                "{error}"
            );
            false
        }
    }
}

#[test]
fn files_cut_anywhere_are_errors() {
    for (name, bytes) in small() {
        assert!(check(&bytes, &name));
        let read = (0..bytes.len())
            .filter(|&end| check(&bytes[..end], &name))
            .count();
        // What follows the elements may be missing: materials, values at cells, the last line's end.
        assert!(read < bytes.len() / 2, "{name}: {read} of {}", bytes.len());
    }
}

#[test]
fn files_with_one_byte_changed_never_panic() {
    for (name, bytes) in small() {
        let mut damaged = bytes.clone();
        for at in 0..bytes.len() {
            for value in [
                0,
                b'\n',
                b' ',
                b'-',
                b'9',
                b'*',
                b'$',
                0x7f,
                0xff,
                bytes[at] ^ 1,
            ] {
                damaged[at] = value;
                check(&damaged, &name);
            }
            damaged[at] = bytes[at];
        }
    }
}

#[test]
fn files_with_parts_moved_never_panic() {
    let mut random = Random::new(5);
    let mut below = |n: usize| (random.bits() % n as u64) as usize;
    for (name, bytes) in small() {
        for _ in 0..1500 {
            let mut damaged = bytes.clone();
            let (from, to) = (below(bytes.len()), below(bytes.len()));
            let length = below(24).min(bytes.len() - from);
            let part: Vec<u8> = damaged.drain(from..from + length).collect();
            let to = to.min(damaged.len());
            damaged.splice(to..to, part);
            check(&damaged, &name);
        }
    }
}

/// A count of 10¹⁸ is refused before anything is allocated for it.
#[test]
fn absurd_counts_are_refused() {
    for (name, bytes) in small() {
        let is_text = bytes.iter().all(u8::is_ascii) && !bytes.contains(&0);
        if !is_text {
            continue;
        }
        let text = String::from_utf8(bytes).unwrap();
        let words: Vec<(usize, &str)> = text.match_indices(|c: char| c.is_ascii_digit()).collect();
        for (at, digit) in words {
            let mut long = text.clone();
            long.replace_range(at..at + digit.len(), "999999999999999999");
            check(long.as_bytes(), &name);
        }
    }
}
