//! Positions as a NumPy array.

use std::io::{self, Write};

use npyz::WriterBuilder;

/// Writes an array of shape (N, 3), `<f8`, C order.
pub(super) fn write(positions: &[[f64; 3]], out: &mut dyn Write) -> io::Result<()> {
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[positions.len() as u64, 3])
        .writer(out)
        .begin_nd()?;
    writer.extend(positions.as_flattened())?;
    writer.finish()
}
