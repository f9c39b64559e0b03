//! Pictures and what they differ in.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use bevy_image::Image;

/// Where pictures lie: `bevy` in the target folder of this build.
pub fn folder() -> PathBuf {
    let program = std::env::current_exe().expect("a program");
    let target = program
        .ancestors()
        .find(|folder| folder.join("CACHEDIR.TAG").exists())
        .unwrap_or(Path::new("target"));
    let folder = target.join("bevy");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Pixels of red, green and blue (sRGB), row by row from the top.
#[derive(Clone, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// An image of eight bits a channel.
    pub fn of(image: &Image) -> Self {
        let bytes = image.data.as_deref().expect("an image with pixels");
        let (width, height) = (image.width(), image.height());
        let (pixels, rest) = bytes.as_chunks::<4>();
        assert!(rest.is_empty() && pixels.len() == (width * height) as usize);
        Self {
            width,
            height,
            pixels: pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        }
    }

    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixels[(y * self.width + x) as usize]
    }

    /// Writes `NAME.png` to [`folder`] and returns its path.
    pub fn save(&self, name: &str) -> PathBuf {
        let path = folder().join(name).with_extension("png");
        let file = BufWriter::new(File::create(&path).expect("a file"));
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().expect("a header");
        writer
            .write_image_data(self.pixels.as_flattened())
            .expect("pixels");
        path
    }

    /// How many pixels differ from those of another by more than so many levels in a channel.
    pub fn differing(&self, other: &Self, levels: u8) -> usize {
        assert_eq!((self.width, self.height), (other.width, other.height));
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs
            .filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > levels))
            .count()
    }

    /// How many pixels are not of the color of the upper left one.
    pub fn covered(&self) -> usize {
        let ground = self.pixels[0];
        let differs = |p: &&[u8; 3]| (0..3).any(|k| p[k].abs_diff(ground[k]) > 4);
        self.pixels.iter().filter(differs).count()
    }
}
