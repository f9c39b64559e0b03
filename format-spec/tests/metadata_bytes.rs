//! The metadata section's bytes are those of SPEC 8, written here by hand.
#![cfg(feature = "metadata")]

use bdtree_format::{ErrorMetadata, Metadata, ModeMetadata};

fn example() -> Metadata {
    Metadata {
        builder: "b 1".into(),
        source_name: "é.obj".into(),
        source_hash: core::array::from_fn(|i| 0xA0 + i as u8),
        basis: "given".into(),
        settings: [("b".into(), "2".into()), ("a".into(), "".into())].into(),
        modes: vec![
            ModeMetadata {
                name: Some("up".into()),
                default_q: None,
            },
            ModeMetadata {
                name: None,
                default_q: Some(0.75),
            },
        ],
        basis_error_rel: Some(ErrorMetadata {
            max: 0.5,
            rms: 0.25,
            frame: Some(258),
            vertex: None,
        }),
        warnings: vec!["w".into()],
    }
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
}

fn count(bytes: &mut Vec<u8>, count: u64) {
    bytes.extend(count.to_le_bytes());
}

/// SPEC 8, field by field.
fn by_hand() -> Vec<u8> {
    let mut b = Vec::new();
    text(&mut b, "b 1");
    text(&mut b, "é.obj");
    b.extend(0xA0..0xC0_u8);
    text(&mut b, "given");
    count(&mut b, 2);
    for part in ["a", "", "b", "2"] {
        text(&mut b, part);
    }
    count(&mut b, 2);
    b.push(1);
    text(&mut b, "up");
    b.push(0);
    b.push(0);
    b.push(1);
    b.extend([0, 0, 0, 0, 0, 0, 0xE8, 0x3F]);
    b.push(1);
    b.extend([0, 0, 0, 0, 0, 0, 0xE0, 0x3F]);
    b.extend([0, 0, 0, 0, 0, 0, 0xD0, 0x3F]);
    b.push(1);
    b.extend([2, 1, 0, 0, 0, 0, 0, 0]);
    b.push(0);
    count(&mut b, 1);
    text(&mut b, "w");
    b
}

#[test]
fn written_bytes_are_those_of_the_spec() {
    assert_eq!(example().to_bytes().expect("small metadata"), by_hand());
    assert_eq!(
        Metadata::from_bytes(&by_hand()).expect("valid bytes"),
        example()
    );
}

#[test]
fn every_truncation_and_trailing_byte_is_refused() {
    let bytes = by_hand();
    for end in 0..bytes.len() {
        let error = Metadata::from_bytes(&bytes[..end]).expect_err("truncated");
        assert!(error.to_string().starts_with("section META: "));
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(Metadata::from_bytes(&longer).is_err());
}

#[test]
fn absurd_lengths_are_refused() {
    let mut bytes = by_hand();
    bytes[..8].fill(0xFF);
    assert!(Metadata::from_bytes(&bytes).is_err());
}
