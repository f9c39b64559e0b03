//! Pictures in memory, and as PNG.

use std::borrow::Cow;
use std::io::{self, Write};

/// A picture: rows from the top, four bytes per pixel (red, green, blue, opacity; sRGB).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    size: [u32; 2],
    pixels: Vec<u8>,
}

impl Image {
    /// All pixels 0: black and clear.
    pub fn new(size: [u32; 2]) -> Self {
        let [width, height] = size.map(|n| n as usize);
        Self {
            size,
            pixels: vec![0; 4 * width * height],
        }
    }

    /// All pixels of one colour.
    pub fn filled(size: [u32; 2], colour: [u8; 4]) -> Self {
        let mut image = Self::new(size);
        image.pixels.as_chunks_mut::<4>().0.fill(colour);
        image
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The pixels, row after row.
    pub fn pixels(&self) -> &[[u8; 4]] {
        self.pixels.as_chunks().0
    }

    /// A pixel, `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        let [width, height] = self.size;
        if x >= width || y >= height {
            return None;
        }
        let at = y as usize * width as usize + x as usize;
        self.pixels().get(at).copied()
    }

    /// The bytes of every row.
    pub(crate) fn rows_mut(&mut self) -> impl Iterator<Item = &mut [u8]> {
        self.pixels
            .chunks_exact_mut(4 * self.size[0].max(1) as usize)
    }

    /// Lays a colour over a pixel: `coverage` of 255 covers it. Outside nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, colour: [u8; 3], coverage: u8) {
        let [width, height] = self.size.map(i64::from);
        if !(0..width).contains(&x) || !(0..height).contains(&y) {
            return;
        }
        let at = (y * width + x) as usize;
        let Some(pixel) = self.pixels.as_chunks_mut::<4>().0.get_mut(at) else {
            return;
        };
        let cover = u32::from(coverage);
        for k in 0..3 {
            let mixed = u32::from(pixel[k]) * (255 - cover) + u32::from(colour[k]) * cover;
            pixel[k] = ((mixed + 127) / 255) as u8;
        }
        pixel[3] = pixel[3].max(coverage);
    }

    /// Fills a rectangle, upper left corner and size given.
    pub fn fill(
        &mut self,
        [x, y]: [i64; 2],
        [width, height]: [i64; 2],
        colour: [u8; 3],
        coverage: u8,
    ) {
        for j in y..y + height {
            for i in x..x + width {
                self.blend(i, j, colour, coverage);
            }
        }
    }

    /// Puts another picture into this one, upper left corner given; what lies outside is cut off.
    pub fn paste(&mut self, [x, y]: [i64; 2], other: &Self) {
        let [width, _] = other.size;
        for (i, pixel) in (0..).zip(other.pixels()) {
            let [r, g, b, a] = *pixel;
            let (column, row) = (i % i64::from(width), i / i64::from(width));
            self.blend(x + column, y + row, [r, g, b], a);
        }
    }

    /// Writes the picture as PNG: the same bytes for the same picture.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        self.write_compressed(out, png::Compression::High)
    }

    /// Writes the picture as PNG, too, in a fraction of the time and somewhat larger: for films, whose frames are read once.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_png_fast(&self, out: impl Write) -> io::Result<()> {
        self.write_compressed(out, png::Compression::Fast)
    }

    fn write_compressed(&self, out: impl Write, compression: png::Compression) -> io::Result<()> {
        let [width, height] = self.size;
        let mut encoder = png::Encoder::new(out, width, height);
        // Opaque pictures need no fourth byte.
        let is_opaque = self.pixels().iter().all(|p| p[3] == 255);
        let (kind, bytes) = if is_opaque {
            let rgb = self.pixels().iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
            (png::ColorType::Rgb, Cow::Owned(rgb.collect()))
        } else {
            (png::ColorType::Rgba, Cow::Borrowed(&self.pixels[..]))
        };
        encoder.set_color(kind);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(compression);
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        writer.write_image_data(&bytes).map_err(io::Error::other)?;
        writer.finish().map_err(io::Error::other)
    }
}
