//! Options of `bdtree render` as people write them.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use bdtree_render::tightness::{Against, Scale};
use clap::ValueEnum;

/// What radii are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AgainstChoice {
    /// The wrapped sphere at rest.
    Rest,
    /// The smallest ball around the deformed vertices.
    Deformed,
}

impl From<AgainstChoice> for Against {
    fn from(choice: AgainstChoice) -> Self {
        match choice {
            AgainstChoice::Rest => Self::Rest,
            AgainstChoice::Deformed => Self::Deformed,
        }
    }
}

/// The colors of growth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ScaleChoice {
    /// The paper's: dark blue to dark red.
    Paper,
    /// Viridis: dark purple to yellow.
    Viridis,
}

impl From<ScaleChoice> for Scale {
    fn from(choice: ScaleChoice) -> Self {
        match choice {
            ScaleChoice::Paper => Self::Paper,
            ScaleChoice::Viridis => Self::Viridis,
        }
    }
}

/// Which axis points up in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
    /// x, downward
    #[value(name = "-x")]
    MinusX,
    /// y, downward
    #[value(name = "-y")]
    MinusY,
    /// z, downward
    #[value(name = "-z")]
    MinusZ,
}

impl UpAxis {
    /// The direction, unit.
    pub fn direction(self) -> [f32; 3] {
        match self {
            Self::X => [1.0, 0.0, 0.0],
            Self::Y => [0.0, 1.0, 0.0],
            Self::Z => [0.0, 0.0, 1.0],
            Self::MinusX => [-1.0, 0.0, 0.0],
            Self::MinusY => [0.0, -1.0, 0.0],
            Self::MinusZ => [0.0, 0.0, -1.0],
        }
    }
}

/// `A..B`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// The first frame.
    pub first: u64,
    /// The last one, not before it.
    pub last: u64,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            let wrong = |_| format!("\"{text}\" is not a whole number, 0 or more");
            text.parse::<u64>().map_err(wrong)
        };
        let (first, last) = text
            .split_once("..")
            .ok_or("two numbers as A..B are needed")?;
        let (first, last) = (number(first)?, number(last)?);
        if last < first {
            return Err(format!("frame {last} is before frame {first}"));
        }
        Ok(Self { first, last })
    }
}

/// `WxH` in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureSize(pub [u32; 2]);

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
        let both = text.split_once('x').map(|(w, h)| (number(w), number(h)));
        let Some((Some(width), Some(height))) = both else {
            return Err("width and height as 1280x960 are needed, both at least 1".to_string());
        };
        Ok(Self([width, height]))
    }
}

/// Finite numbers with commas between them.
///
/// # Errors
/// The first that is none.
pub fn numbers<T: FromStr + Copy + Into<f64>>(text: &str) -> Result<Vec<T>, String> {
    let number = |number: &str| {
        let number = number.trim();
        let value = number.parse().ok().filter(|x: &T| (*x).into().is_finite());
        value.ok_or_else(|| format!("\"{number}\" is not a number"))
    };
    text.split(',').map(number).collect()
}

/// `AZIMUTH,ELEVATION[,ZOOM]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Degrees around the up axis.
    pub azimuth_deg: f32,
    /// Degrees from above, −90 to 90.
    pub elevation_deg: f32,
    /// 1: all of it just fits; 2: twice as large.
    pub zoom: f32,
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f32> = numbers(text)?;
        let (azimuth_deg, elevation_deg, zoom) = match *numbers {
            [azimuth, elevation] => (azimuth, elevation, 1.0),
            [azimuth, elevation, zoom] => (azimuth, elevation, zoom),
            _ => return Err("two or three numbers are needed".to_string()),
        };
        if !(-90.0..=90.0).contains(&elevation_deg) {
            return Err(format!(
                "elevation: {elevation_deg} is not within -90 to 90"
            ));
        }
        if !(0.01..=100.0).contains(&zoom) {
            return Err(format!("zoom: {zoom} is not within 0.01 to 100"));
        }
        Ok(Self {
            azimuth_deg,
            elevation_deg,
            zoom,
        })
    }
}

/// The file of a frame's picture: `%d` or `%0Nd` in the name becomes its number. `None` where the name
/// has no such place, or more than one.
pub(super) fn numbered(path: &Path, frame: u64) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let (before, rest) = name.split_once('%')?;
    let (width, after) = rest.split_once('d')?;
    let digits = match width.strip_prefix('0') {
        _ if width.is_empty() => 0,
        Some(digits) => digits
            .parse::<usize>()
            .ok()
            .filter(|n| (1..=20).contains(n))?,
        None => return None,
    };
    if after.contains('%') {
        return None;
    }
    Some(path.with_file_name(format!("{before}{frame:0digits$}{after}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_options_or_say_why_not() {
        assert_eq!("3..7".parse(), Ok(FrameRange { first: 3, last: 7 }));
        assert_eq!(
            "7..3".parse::<FrameRange>(),
            Err("frame 3 is before frame 7".to_string())
        );
        assert!("3-7".parse::<FrameRange>().is_err());
        assert!("..7".parse::<FrameRange>().is_err());
        assert_eq!("640x480".parse(), Ok(PictureSize([640, 480])));
        for wrong in ["640", "0x480", "640x", "-1x5", "640x480x3"] {
            assert!(wrong.parse::<PictureSize>().is_err(), "{wrong}");
        }
        let view = View {
            azimuth_deg: -30.0,
            elevation_deg: 10.5,
            zoom: 1.0,
        };
        assert_eq!("-30, 10.5".parse(), Ok(view));
        assert_eq!("-30,10.5,2".parse(), Ok(View { zoom: 2.0, ..view }));
        for wrong in ["1", "1,2,3,4", "1,91", "nan,0", "1,2,0", "1,x"] {
            assert!(wrong.parse::<View>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_take_numbers() {
        let of = |name: &str| numbered(Path::new(name), 7);
        assert_eq!(of("a/out_%04d.png"), Some(PathBuf::from("a/out_0007.png")));
        assert_eq!(of("%d.png"), Some(PathBuf::from("7.png")));
        for wrong in [
            "out.png",
            "%s.png",
            "%4d.png",
            "%0d.png",
            "%d%d.png",
            "%099d.png",
        ] {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }
}
