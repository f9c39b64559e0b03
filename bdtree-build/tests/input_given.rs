//! Given bases: every layout and dtype, and every way to be wrong.

use std::f64::consts::TAU;
use std::path::PathBuf;

use bdtree_build::basis::given::{GivenBasis, Layout, given_basis};
use npyz::{DType, Order, WriterBuilder};

/// Entry of axis k of vertex i in field j: all different.
fn u(i: usize, k: usize, j: usize) -> f64 {
    (1 + i * i) as f64 + 0.25 * k as f64 + (j * (i + 2 * k)) as f64 * 0.5 + (j * j * i * i) as f64
}

fn npy_bytes<T: npyz::Serialize>(
    shape: &[u64],
    dtype: &str,
    order: Order,
    values: impl Iterator<Item = T>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .dtype(DType::Plain(dtype.parse().unwrap()))
        .shape(shape)
        .order(order)
        .writer(&mut bytes)
        .begin_nd()
        .unwrap();
    writer.extend(values).unwrap();
    writer.finish().unwrap();
    bytes
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// An array written by npyz, the oracle.
    fn array(&self, shape: &[u64], dtype: &str, order: Order, values: &[f64]) -> PathBuf {
        let bytes = if dtype.ends_with('4') {
            npy_bytes(shape, dtype, order, values.iter().map(|&x| x as f32))
        } else {
            npy_bytes(shape, dtype, order, values.iter().copied())
        };
        self.file("U.npy", &bytes)
    }
}

/// The entries of an array of `shape` in file order; `at` is given the index.
fn values(shape: [usize; 3], order: Order, at: impl Fn([usize; 3]) -> f64) -> Vec<f64> {
    let count = shape.iter().product();
    let index = |n: usize| match order {
        Order::C => [
            n / (shape[1] * shape[2]),
            n / shape[2] % shape[1],
            n % shape[2],
        ],
        Order::Fortran => [
            n % shape[0],
            n / shape[0] % shape[1],
            n / (shape[0] * shape[1]),
        ],
    };
    (0..count).map(|n| at(index(n))).collect()
}

fn message(result: Result<GivenBasis, bdtree_build::error::BakeError>) -> String {
    let text = result.expect_err("should be refused").to_string();
    // The folder of a test is of no interest.
    let lines = text
        .lines()
        .map(|line| match line.find("U.npy").or(line.find("F.")) {
            Some(at) => &line[at..],
            None => line,
        });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn every_layout_dtype_and_order_gives_the_same_fields() {
    let (n, m) = (5, 4);
    for dtype in ["<f4", ">f4", "<f8", ">f8"] {
        for order in [Order::C, Order::Fortran] {
            let folder = Folder::new();
            let (n64, m64) = (n as u64, m as u64);
            let n3m = values([n, 3, m], order, |[i, k, j]| u(i, k, j));
            let mn3 = values([m, n, 3], order, |[j, i, k]| u(i, k, j));
            let flat = values([3 * n, m, 1], order, |[r, j, _]| u(r / 3, r % 3, j));
            let cases: [(&[u64], &[f64]); 3] = [
                (&[n64, 3, m64], &n3m),
                (&[m64, n64, 3], &mn3),
                (&[3 * n64, m64], &flat),
            ];
            for (shape, values) in cases {
                let path = folder.array(shape, dtype, order, values);
                let given = given_basis(&path, None, None, n).unwrap();
                assert_eq!(given.basis.mode_count(), m);
                for j in 0..m {
                    for (i, found) in given.basis.field(j).iter().enumerate() {
                        assert_eq!(
                            *found,
                            [u(i, 0, j), u(i, 1, j), u(i, 2, j)],
                            "{shape:?} {dtype}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn an_ambiguous_shape_asks_for_the_layout() {
    let folder = Folder::new();
    let entries: Vec<f64> = (0..27).map(|x| f64::from(x * x % 17)).collect();
    let path = folder.array(&[3, 3, 3], "<f8", Order::C, &entries);
    let text = message(given_basis(&path, None, None, 3));
    assert!(
        text.contains("--basis-layout n3m or --basis-layout mn3"),
        "{text}"
    );
    let n3m = given_basis(&path, Some("n3m".parse().unwrap()), None, 3).unwrap();
    let mn3 = given_basis(&path, Some(Layout::MN3), None, 3).unwrap();
    assert_eq!(n3m.basis.field(1)[0], [entries[1], entries[4], entries[7]]);
    assert_eq!(
        mn3.basis.field(1)[0],
        [entries[9], entries[10], entries[11]]
    );
    assert!("nm3".parse::<Layout>().is_err());
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let try_shape = |shape: &[u64], layout| {
        let count = shape.iter().product::<u64>() as usize;
        let path = folder.array(shape, "<f8", Order::C, &vec![1.0; count]);
        message(given_basis(&path, layout, None, 4))
    };
    let none = "is none of (N, 3, M), (3N, M), (M, N, 3) for the mesh's N = 4 vertices";
    for shape in [&[5_u64, 3, 2][..], &[12], &[2, 12], &[4, 2, 3, 1]] {
        assert_eq!(
            try_shape(shape, None),
            format!("U.npy: shape: {shape:?} {none}")
        );
    }
    assert_eq!(
        try_shape(&[4, 3, 0], None),
        "U.npy: shape: [4, 3, 0] holds no fields"
    );
    let text = try_shape(&[4, 3, 2], Some(Layout::ThreeNM));
    assert_eq!(
        text,
        "U.npy: shape: [4, 3, 2] is not of layout 3nm for a mesh of 4 vertices"
    );
}

#[test]
fn entries_that_are_not_finite_are_all_named() {
    let folder = Folder::new();
    let mut entries = values([4, 3, 2], Order::C, |[i, k, j]| u(i, k, j));
    entries[3] = f64::NAN;
    entries[22] = f64::INFINITY;
    let path = folder.array(&[4, 3, 2], "<f8", Order::C, &entries);
    let expected = "U.npy: mode 0, vertex 3, z: inf is not finite\n\
                    U.npy: mode 1, vertex 0, y: NaN is not finite";
    assert_eq!(message(given_basis(&path, None, None, 4)), expected);
    let path = folder.array(&[100, 3, 2], "<f8", Order::C, &[f64::NAN; 600]);
    let text = message(given_basis(&path, None, None, 100));
    assert_eq!(text.lines().last(), Some("U.npy: 500 more problems"));
}

#[test]
fn zero_and_dependent_fields_are_kept_with_a_warning() {
    let folder = Folder::new();
    let field = |i: usize, k: usize, j: usize| match j {
        1 => 0.0,
        3 => 2.0 * u(i, k, 0) - 0.5 * u(i, k, 2),
        _ => u(i, k, j),
    };
    let entries = values([30, 3, 5], Order::C, |[i, k, j]| field(i, k, j));
    let path = folder.array(&[30, 3, 5], "<f4", Order::C, &entries);
    let given = given_basis(&path, None, None, 30).unwrap();
    assert_eq!(given.basis.mode_count(), 5);
    // Warnings go into the file, which names no folders.
    let place = "U.npy";
    let expected = [
        format!("{place}: mode 1 is zero everywhere"),
        format!("{place}: mode 3 is a combination of the modes before it"),
    ];
    // Field 4 is quadratic in j and so a combination of 0 and 2 and the constant part.
    assert_eq!(given.warnings[..2], expected);
}

#[test]
fn damaged_files_are_refused_at_every_length() {
    let folder = Folder::new();
    let entries = values([4, 3, 2], Order::C, |[i, k, j]| u(i, k, j));
    let bytes = std::fs::read(folder.array(&[4, 3, 2], "<f8", Order::C, &entries)).unwrap();
    for end in 0..bytes.len() {
        let path = folder.file("U.npy", &bytes[..end]);
        assert!(given_basis(&path, None, None, 4).is_err(), "{end}");
    }
    for at in 0..128.min(bytes.len()) {
        for value in [0, b'(', b'9', b'\'', 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let _ = given_basis(&folder.file("U.npy", &damaged), None, None, 4);
        }
    }
    let longer = [&bytes[..], &[0]].concat();
    let text = message(given_basis(&folder.file("U.npy", &longer), None, None, 4));
    assert!(text.contains("has bytes after its data"), "{text}");
    for (descr, kind) in [
        ("<i4", "integer"),
        ("<c16", "complex"),
        ("|b1", "boolean"),
        ("<f2", "precision"),
    ] {
        let text = String::from_utf8_lossy(&bytes[10..]).replace("<f8", descr);
        let file = [&bytes[..10], text.as_bytes()].concat();
        let text = message(given_basis(&folder.file("U.npy", &file), None, None, 4));
        assert!(
            text.contains(kind) && text.contains("needs float32 or float64"),
            "{text}"
        );
    }
    for shape in ["9223372036854775808, 4, 3", "4294967296, 4294967296, 3"] {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
        let length = (header.len() as u16).to_le_bytes();
        let file = [&bytes[..8], &length, header.as_bytes()].concat();
        let text = message(given_basis(&folder.file("U.npy", &file), None, None, 4));
        assert!(text.contains("larger than any memory"), "{text}");
    }
    let missing = folder.0.path().join("missing.npy");
    assert!(message(given_basis(&missing, None, None, 4)).contains("cannot be read"));
}

#[test]
fn frequencies_come_in_hertz() {
    let folder = Folder::new();
    let entries = values([4, 3, 2], Order::C, |[i, k, j]| u(i, k, j));
    let path = folder.array(&[4, 3, 2], "<f8", Order::C, &entries);
    let with = |text: &str| {
        let file = folder.file("F.txt", text.as_bytes());
        given_basis(&path, None, Some(&file), 4)
    };
    for text in [
        "1.5 20",
        "1.5\n20\n",
        "# Hz\r\n1.5,20 # two\r\n",
        "1.5; 2e1",
    ] {
        let omegas: Vec<_> = with(text)
            .unwrap()
            .basis
            .modes
            .iter()
            .map(|m| m.omega_rad_s)
            .collect();
        assert_eq!(omegas, [Some(1.5 * TAU), Some(20.0 * TAU)]);
    }
    assert_eq!(message(with("1 2 3")), "F.txt: 3 frequencies for 2 fields");
    let text = message(with("1 x\n-2\nnan"));
    let expected = "F.txt:1: `x` is not a number\n\
                    F.txt:2: -2 is not a frequency in Hz (finite, 0 or more)\n\
                    F.txt:3: NaN is not a frequency in Hz (finite, 0 or more)";
    assert_eq!(text, expected);
}
