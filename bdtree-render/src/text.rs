//! Text in pictures: Noto Sans Mono, smoothed.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::image::Image;

/// How high lines of text are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextSize {
    /// 16 pixels.
    Small,
    /// 20 pixels.
    Medium,
    /// 32 pixels.
    Large,
}

impl TextSize {
    /// What suits a picture of this height.
    pub fn of_picture(height: u32) -> Self {
        match height {
            0..640 => Self::Small,
            640..1200 => Self::Medium,
            _ => Self::Large,
        }
    }

    fn raster(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Medium => RasterHeight::Size20,
            Self::Large => RasterHeight::Size32,
        }
    }

    /// Height of a line in pixels.
    pub fn line(self) -> i64 {
        self.raster().val() as i64
    }

    /// Width of a text in pixels.
    pub fn width(self, text: &str) -> i64 {
        (text.chars().count() * get_raster_width(FontWeight::Regular, self.raster())) as i64
    }
}

impl Image {
    /// Writes a line of text, upper left corner given; characters beyond Latin 1 become question marks.
    pub fn text(&mut self, [x, y]: [i64; 2], text: &str, size: TextSize, colour: [u8; 3]) {
        let raster = |c| get_raster(c, FontWeight::Regular, size.raster());
        let mut x = x;
        for c in text.chars() {
            let Some(glyph) = raster(c).or_else(|| raster('?')) else {
                continue;
            };
            for (j, row) in (0..).zip(glyph.rows()) {
                for (i, coverage) in (0..).zip(row) {
                    self.blend(x + i, y + j, colour, *coverage);
                }
            }
            x += glyph.width() as i64;
        }
    }
}
