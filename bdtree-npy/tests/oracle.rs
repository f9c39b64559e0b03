//! What is written is what npyz reads, and the other way round.

use bdtree_npy::{Header, Number, parse, parse_integers, write};
use npyz::{DType, NpyFile, Order, WriterBuilder};

/// An array of two axes as npyz writes it.
fn written_by_npyz<T: npyz::Serialize>(
    shape: [u64; 2],
    dtype: &str,
    order: Order,
    values: impl Iterator<Item = T>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .dtype(DType::Plain(dtype.parse().expect("a dtype")))
        .shape(&shape)
        .order(order)
        .writer(&mut bytes)
        .begin_nd()
        .expect("a header");
    writer.extend(values).expect("values");
    writer.finish().expect("an end");
    bytes
}

#[test]
fn npyz_reads_what_is_written() {
    let shapes: [&[usize]; 5] = [&[], &[7], &[3, 4], &[0, 3], &[5, 3, 4]];
    for shape in shapes {
        let count = shape.iter().product();
        let values: Vec<f64> = (0..count).map(|n| (n as f64 - 2.5) / 3.0).collect();
        let mut bytes = Vec::new();
        write(shape, &values, &mut bytes).expect("memory takes all");

        let data_offset = bytes.len() - 8 * count;
        assert_eq!(data_offset % 64, 0, "as NumPy aligns it");
        assert_eq!(bytes[data_offset - 1], b'\n');
        let file = NpyFile::new(bytes.as_slice()).expect("a .npy file");
        let extents: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
        assert_eq!(file.shape(), extents);
        assert_eq!(file.order(), Order::C);
        assert_eq!(file.into_vec::<f64>().expect("f64"), values);

        let own = parse(&bytes).expect("a .npy file");
        assert_eq!((own.shape.as_slice(), &own.values), (shape, &values));
    }
}

#[test]
fn values_that_do_not_fill_the_shape_are_refused() {
    let mut bytes = Vec::new();
    let error = write(&[2, 3], &[0.0; 5], &mut bytes).expect_err("one is missing");
    assert_eq!(
        error.to_string(),
        "truncated: shape [2, 3] needs 48 bytes of data, found 40"
    );
    assert!(bytes.is_empty());
}

#[test]
fn entries_are_found_in_either_order_and_endianness() {
    let (rows, columns) = (3, 5);
    let at = |i: usize, k: usize| (10 * i + k) as f64 - 7.0;
    for order in [Order::C, Order::Fortran] {
        let index = |n: usize| match order {
            Order::C => (n / columns, n % columns),
            Order::Fortran => (n % rows, n / rows),
        };
        let values = || (0..rows * columns).map(index).map(|(i, k)| at(i, k));
        let shape = [rows as u64, columns as u64];
        for dtype in ["<f8", ">f8"] {
            let bytes = written_by_npyz(shape, dtype, order, values());
            let array = parse(&bytes).expect(dtype);
            for (i, k) in (0..rows * columns).map(index) {
                assert_eq!(array.get(&[i, k]), Some(at(i, k)), "{dtype} {order:?}");
            }
            assert_eq!(array.get(&[rows, 0]), None);
            assert_eq!(array.get(&[0]), None);
            let header = Header::parse(&bytes).expect(dtype);
            assert_eq!(header.fortran, order == Order::Fortran);
            let number = if dtype == "<f8" {
                Number::F8Le
            } else {
                Number::F8Be
            };
            assert_eq!(header.number, number);
        }
        for dtype in ["<f4", ">f4"] {
            let bytes = written_by_npyz(shape, dtype, order, values().map(|x| x as f32));
            assert_eq!(parse(&bytes).expect(dtype).get(&[2, 1]), Some(at(2, 1)));
        }
        for dtype in ["<i2", ">i2"] {
            let bytes = written_by_npyz(shape, dtype, order, values().map(|x| x as i16));
            let array = parse_integers(&bytes).expect(dtype);
            assert_eq!(
                array.get(&[0, 3]),
                Some(at(0, 3) as i64),
                "{dtype} {order:?}"
            );
        }
    }
}

#[test]
fn damaged_files_are_refused() {
    let mut sound = Vec::new();
    write(&[2, 3], &[0.0; 6], &mut sound).expect("memory takes all");
    let said = |bytes: &[u8]| parse(bytes).expect_err("damaged").to_string();
    assert_eq!(said(b"PK"), "is not a .npy file (no NumPy signature)");
    assert_eq!(said(&sound[..40]), "truncated in the header");
    let cut = &sound[..sound.len() - 1];
    assert_eq!(
        said(cut),
        "truncated: shape [2, 3] needs 48 bytes of data, found 47"
    );
    let huge = String::from_utf8_lossy(&sound[10..128]).replace("2, 3", "9999999999, 9999999999");
    let mut bytes = sound[..8].to_vec();
    bytes.extend((huge.len() as u16).to_le_bytes());
    bytes.extend(huge.as_bytes());
    assert!(said(&bytes).ends_with("is larger than any memory"));
}
