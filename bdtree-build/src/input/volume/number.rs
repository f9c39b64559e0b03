//! Binary numbers: their types, sizes and byte orders.

/// The order of the bytes of a binary number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

/// What a binary number is; text spells all of them the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// How many bytes it takes.
    pub(super) fn bytes(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }
    /// The integer in `bytes`; what lies beyond i64 becomes its end. `None` for F32 and F64.
    pub(super) fn integer(self, bytes: &[u8], order: ByteOrder) -> Option<i64> {
        let value = u64::from_le_bytes(little(bytes, order));
        Some(match self {
            Kind::I8 => i64::from(value as u8 as i8),
            Kind::I16 => i64::from(value as u16 as i16),
            Kind::I32 => i64::from(value as u32 as i32),
            Kind::I64 => value as i64,
            Kind::U8 | Kind::U16 | Kind::U32 | Kind::U64 => {
                i64::try_from(value).unwrap_or(i64::MAX)
            }
            Kind::F32 | Kind::F64 => return None,
        })
    }

    /// The number in `bytes`, finite or not.
    pub(super) fn real(self, bytes: &[u8], order: ByteOrder) -> f64 {
        let little = little(bytes, order);
        match self.integer(bytes, order) {
            Some(integer) => integer as f64,
            None if self == Kind::F32 => {
                f64::from(f32::from_bits(u64::from_le_bytes(little) as u32))
            }
            None => f64::from_le_bytes(little),
        }
    }
}

/// At most eight bytes, least significant first, then zeros.
fn little(bytes: &[u8], order: ByteOrder) -> [u8; 8] {
    let mut number = [0; 8];
    let count = bytes.len().min(8);
    number[..count].copy_from_slice(&bytes[..count]);
    if order == ByteOrder::Big {
        number[..count].reverse();
    }
    number
}
