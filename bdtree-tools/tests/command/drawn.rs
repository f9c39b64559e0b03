//! Pictures that the command has drawn.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::Folder;

/// A decoded picture.
pub(crate) struct Picture {
    pub(crate) size: [usize; 2],
    pub(crate) pixels: Vec<[u8; 3]>,
}

impl Picture {
    pub(crate) fn read(path: &Path) -> Self {
        let file = std::io::BufReader::new(fs::File::open(path).expect("a picture"));
        let mut reader = png::Decoder::new(file).read_info().expect("PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("of a small picture")];
        let info = reader.next_frame(&mut bytes).expect("a whole picture");
        assert_eq!(
            (info.color_type, info.bit_depth),
            (png::ColorType::Rgb, png::BitDepth::Eight)
        );
        Self {
            size: [info.width as usize, info.height as usize],
            pixels: bytes.as_chunks::<3>().0.to_vec(),
        }
    }

    pub(crate) fn at(&self, x: f64, y: f64) -> [u8; 3] {
        self.pixels[y as usize * self.size[0] + x as usize]
    }

    /// Part of the pixels for which something holds.
    pub(crate) fn share(&self, of: impl Fn([u8; 3]) -> bool) -> f64 {
        let count = self.pixels.iter().filter(|p| of(**p)).count();
        count as f64 / self.pixels.len() as f64
    }

    /// The box around all that is drawn: left, top, and right and bottom beyond it.
    pub(crate) fn drawn_box(&self) -> [f64; 4] {
        let drawn = self.pixels.iter().enumerate().filter(|(_, p)| **p != WHITE);
        let places = drawn.map(|(i, _)| [i % self.size[0], i / self.size[0]]);
        let nothing = [usize::MAX, usize::MAX, 0, 0];
        let all = places.fold(nothing, |[a, b, c, d], [x, y]| {
            [a.min(x), b.min(y), c.max(x + 1), d.max(y + 1)]
        });
        all.map(|n| n as f64)
    }

    /// Part of the pixels that are drawn on.
    pub(crate) fn covered(&self) -> f64 {
        self.share(|p| p != WHITE)
    }
}

pub(crate) const WHITE: [u8; 3] = [255; 3];

impl Folder {
    /// Draws a picture, which must succeed; small, so that it takes little time.
    pub(crate) fn render(&self, arguments: &[&str]) -> String {
        self.render_at("320x240", arguments)
    }

    pub(crate) fn render_at(&self, size: &str, arguments: &[&str]) -> String {
        let ran = self.run(&[&["render"], arguments, &["--size", size]].concat());
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{arguments:?}");
        ran.out
    }

    pub(crate) fn picture(&self, arguments: &[&str]) -> Picture {
        self.render(&[arguments, &["-o", "out.png"]].concat());
        Picture::read(&self.path("out.png"))
    }

    /// A picture without text around it, as bytes of its file.
    pub(crate) fn plain(&self, arguments: &[&str]) -> Vec<u8> {
        self.picture(&[arguments, &["--no-legend"]].concat());
        self.read("out.png")
    }

    /// A picture and its report.
    pub(crate) fn reported(&self, arguments: &[&str]) -> (Picture, Value) {
        let text = self.render(&[arguments, &["-o", "out.png", "--json"]].concat());
        let report = serde_json::from_str(&text).expect("one JSON object");
        (Picture::read(&self.path("out.png")), report)
    }

    /// Draws what queries of a scene visit: a picture and its report.
    pub(crate) fn asked(&self, asset: &str, scene: &Value, options: &[&str]) -> (Picture, Value) {
        self.write("scene.json", scene.to_string());
        self.reported(&[&[asset, "--query", "scene.json"], options].concat())
    }

    /// What `render` says when it refuses, with code 1 and nothing on its standard output.
    pub(crate) fn refusal(&self, arguments: &[&str]) -> String {
        let ran = self.run(&[&["render"], arguments].concat());
        let said = ran.err.trim_end().to_string();
        assert_eq!(
            (ran.code, ran.out.as_str()),
            (1, ""),
            "{arguments:?}: {said}"
        );
        said
    }
}

/// Every vertex lies in one of the spheres of a report.
pub(crate) fn spheres_hold(spheres: &[Value], vertices: &[[f64; 3]]) {
    assert!(!spheres.is_empty() && !vertices.is_empty());
    for p in vertices {
        let holds = |sphere: &Value| {
            let c = numbers(&sphere["center"]);
            let square: f64 = (0..3).map(|k| (p[k] - c[k]).powi(2)).sum();
            square.sqrt() <= sphere["radius"].as_f64().expect("a number") * (1.0 + 1e-9)
        };
        assert!(spheres.iter().any(holds), "{p:?}");
    }
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    let all = value.as_array().expect("a list");
    all.iter().map(|x| x.as_f64().expect("a number")).collect()
}
