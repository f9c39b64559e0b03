//! What a picture shows, written into it.

use crate::image::Image;
use crate::text::TextSize;
use crate::tightness::{GROWTH_RED, Scale};

/// Text in the upper left corner, and the scale of tightness in the lower left one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Legend {
    /// Lines of text; the first is the title.
    pub lines: Vec<String>,
    /// The scale of colors and what it means, `None`: no scale.
    pub scale: Option<(Scale, String)>,
}

/// Titles, and all other text.
const DARK: [u8; 3] = [20, 24, 32];
const GREY: [u8; 3] = [80, 86, 96];

/// The part of a picture's height that is left to what it shows, at least.
const PICTURE_MIN: f64 = 0.6;

/// The width in pixels from which on a picture says what the scale means.
const MEANING_MIN: u32 = 300;

impl Legend {
    /// Rows at the top and at the bottom of a picture that a legend of so many lines fills; none where too
    /// little of the picture would be left: there it lies over what is shown.
    pub fn room(lines: usize, has_scale: bool, size: [u32; 2]) -> [u32; 2] {
        let text = TextSize::of_picture(size[0].min(size[1]));
        let margin = text.line() * 3 / 4;
        let top = margin + lines as i64 * (text.line() + text.line() / 8);
        let bottom = if has_scale {
            margin + scale_height(text)
        } else {
            0
        };
        let left = f64::from(size[1]) - (top + bottom) as f64;
        if left < PICTURE_MIN * f64::from(size[1]) {
            return [0; 2];
        }
        [top as u32, bottom as u32]
    }

    /// Writes it into a picture.
    pub fn draw(&self, image: &mut Image) {
        let [width, height] = image.size();
        let size = TextSize::of_picture(height.min(width));
        let margin = size.line() * 3 / 4;
        let room = ((i64::from(width) - 2 * margin) / size.width("x").max(1)).max(0) as usize;
        for (k, line) in (0..).zip(&self.lines) {
            let colour = if k == 0 { DARK } else { GREY };
            let y = margin + k * (size.line() + size.line() / 8);
            let line = shortened(line, room);
            clear(image, [margin, y], [size.width(&line), size.line()]);
            image.text([margin, y], &line, size, colour);
        }
        if let Some((scale, meaning)) = &self.scale {
            let bar = [
                (i64::from(width) * 2 / 5).min(24 * size.line()),
                bar_height(size),
            ];
            let below = scale_height(size);
            let corner = [margin, i64::from(height) - margin - below];
            // Of a few words of it nobody would know what it means.
            let meaning = match width < MEANING_MIN {
                true => String::new(),
                false => shortened(meaning, room),
            };
            let width = size.width(&meaning).max(bar[0] + size.width("44+"));
            clear(image, corner, [width, below]);
            draw_scale(image, corner, bar, (*scale, &meaning), size);
        }
    }
}

fn bar_height(size: TextSize) -> i64 {
    size.line() * 3 / 4
}

/// Of the scale of tightness with its texts.
fn scale_height(size: TextSize) -> i64 {
    bar_height(size) + 2 * size.line() + size.line() / 2
}

/// Fades what is behind text, so that it can be read.
fn clear(image: &mut Image, [x, y]: [i64; 2], [width, height]: [i64; 2]) {
    image.fill([x - 4, y - 2], [width + 8, height + 4], [255; 3], 190);
}

/// Draws a scale of tightness, upper left corner given: what it means, below that a bar of the given
/// width and height, and numbers.
pub fn draw_scale(
    image: &mut Image,
    [x, y]: [i64; 2],
    [width, height]: [i64; 2],
    (scale, meaning): (Scale, &str),
    size: TextSize,
) {
    image.text([x, y], meaning, size, GREY);
    let top = y + size.line() + size.line() / 4;
    for i in 0..width {
        let share = (i as f64 + 0.5) / width as f64;
        let colour = scale.colour(1.0 + share * (GROWTH_RED - 1.0));
        image.fill([x + i, top], [1, height], colour, 255);
    }
    let numbers = ["1.00", "1.11", "1.22", "1.33", "1.44+"];
    let apart = apart(width, size);
    for (k, number) in (0..).zip(numbers).step_by(apart) {
        let at = x + k * width / 4;
        image.fill(
            [at.min(x + width - 1), top + height],
            [1, size.line() / 4],
            GREY,
            255,
        );
        // The first begins where the bar does, the others stand under their marks.
        let half = if k == 0 { 0 } else { size.width("1.00") / 2 };
        let below = top + height + size.line() / 4;
        image.text([at - half, below], number, size, GREY);
    }
}

/// Every how many numbers of a scale of a width are written: all, or those that leave room between them; 5 where only
/// the first fits.
fn apart(width: i64, size: TextSize) -> usize {
    // The first begins at its mark, the next has its middle there.
    let needed = size.width("1.00") * 3 / 2 + size.width(" ");
    let fits = |apart: &usize| width * *apart as i64 / 4 >= needed;
    [1, 2, 4].into_iter().find(fits).unwrap_or(5)
}

/// Text of at most `room` characters, the middle left out.
fn shortened(text: &str, room: usize) -> String {
    let count = text.chars().count();
    if count <= room {
        return text.to_string();
    }
    let keep = room.saturating_sub(3);
    let (head, tail) = (keep - keep / 3, keep / 3);
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!("{start}...{end}")
}

#[cfg(test)]
mod tests {
    use super::{Legend, apart, shortened};
    use crate::text::TextSize;

    #[test]
    fn a_legend_leaves_most_of_a_picture() {
        for size in [[64, 48], [320, 240], [800, 600], [1600, 1000], [300, 2000]] {
            for (lines, has_scale) in [(1, false), (3, true), (40, true)] {
                let [top, bottom] = Legend::room(lines, has_scale, size);
                assert!(f64::from(top + bottom) <= 0.4 * f64::from(size[1]));
            }
        }
        assert_eq!(Legend::room(3, true, [64, 48]), [0; 2]);
        assert_eq!(Legend::room(2, false, [320, 240]), [12 + 2 * 18, 0]);
    }

    #[test]
    fn numbers_of_a_scale_leave_room_between_them() {
        let size = TextSize::Small;
        let [number, space] = ["1.00", " "].map(|text| size.width(text));
        for width in 20..600 {
            let apart = apart(width, size);
            assert!(apart > 4 || width * apart as i64 / 4 - number / 2 >= number + space);
        }
        let of = |width| apart(width, size);
        assert_eq!([of(400), of(128), of(64), of(20)], [1, 2, 4, 5]);
    }

    #[test]
    fn long_text_loses_its_middle() {
        assert_eq!(shortened("abcdefghijkl", 12), "abcdefghijkl");
        assert_eq!(shortened("abcdefghijklm", 12), "abcdef...klm");
        assert_eq!(shortened("abcdef", 2), "...");
    }
}
