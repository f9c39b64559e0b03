//! What a picture shows, written into it.

use crate::image::Image;
use crate::text::TextSize;
use crate::tightness::{GROWTH_RED, Scale};

/// Text in the upper left corner, and the scale of tightness in the lower left one.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Legend {
    /// Lines of text; the first is the title.
    pub lines: Vec<String>,
    /// The scale of colors, the growth that it ends with, and what it means, `None`: no scale.
    pub scale: Option<(Scale, f64, String)>,
}

/// Titles, and all other text.
const DARK: [u8; 3] = [20, 24, 32];
const GREY: [u8; 3] = [80, 86, 96];

/// The part of a picture's height that is left to what it shows, at least.
const PICTURE_MIN: f64 = 0.6;

/// The width and height in pixels from which on a picture has a legend: in smaller ones it would hide what they show.
const LEGEND_MIN: u32 = 200;

/// The width in pixels from which on a picture says what the scale means.
const MEANING_MIN: u32 = 300;

/// Rows that a text takes at most: a list of many numbers ends there.
const ROWS_MAX: usize = 3;

impl Legend {
    /// Rows at the top and at the bottom of a picture that this legend fills; none where too little of the picture
    /// would be left: there it lies over what is shown.
    pub fn room(&self, size: [u32; 2]) -> [u32; 2] {
        let Some(laid_out) = LaidOut::new(self, size) else {
            return [0; 2];
        };
        let (top, bottom) = (laid_out.top(), laid_out.bottom());
        let left = f64::from(size[1]) - (top + bottom) as f64;
        if left < PICTURE_MIN * f64::from(size[1]) {
            return [0; 2];
        }
        [top as u32, bottom as u32]
    }

    /// Writes it into a picture; not into a small one.
    pub fn draw(&self, image: &mut Image) {
        let Some(laid_out) = LaidOut::new(self, image.size()) else {
            return;
        };
        let (size, margin) = (laid_out.size, laid_out.margin);
        let [width, height] = image.size().map(i64::from);
        let low = height - laid_out.bottom();
        for (k, (line, colour)) in (0..).zip(&laid_out.lines) {
            let y = margin + k * laid_out.apart();
            // Above all there is the scale.
            if y + size.line() > low {
                break;
            }
            clear(image, [margin, y], [size.width(line), size.line()]);
            image.text([margin, y], line, size, *colour);
        }
        if let Some((scale, end, _)) = &self.scale {
            let bar = [(width * 2 / 5).min(24 * size.line()), bar_height(size)];
            let meaning = laid_out.meaning.iter().map(|line| size.width(line)).max();
            let number = size.width(&scale_number(4, *end));
            let widest = meaning.unwrap_or(0).max(number + bar[0] + size.width("+"));
            clear(image, [margin, low], [widest, laid_out.bottom() - margin]);
            for (k, line) in (0..).zip(&laid_out.meaning) {
                image.text([margin, low + k * size.line()], line, size, GREY);
            }
            let below = laid_out.meaning.len() as i64 * size.line();
            draw_bar(image, [margin, low + below], bar, (*scale, *end), size);
        }
    }
}

/// A legend in rows that fit into a picture.
struct LaidOut {
    size: TextSize,
    margin: i64,
    /// With their colors.
    lines: Vec<(String, [u8; 3])>,
    /// What the scale means.
    meaning: Vec<String>,
    has_scale: bool,
}

impl LaidOut {
    /// `None` in a picture that is too small for it.
    fn new(legend: &Legend, [width, height]: [u32; 2]) -> Option<Self> {
        if width.min(height) < LEGEND_MIN {
            return None;
        }
        let size = TextSize::of_picture(height.min(width));
        let margin = size.line() * 3 / 4;
        let room = ((i64::from(width) - 2 * margin) / size.width("x").max(1)).max(1) as usize;
        let colours = std::iter::once(DARK).chain(std::iter::repeat(GREY));
        let lines = legend.lines.iter().zip(colours);
        let lines = lines.flat_map(|(line, colour)| {
            let rows = wrapped(line, room);
            rows.into_iter().map(move |row| (row, colour))
        });
        let meaning = legend.scale.as_ref().filter(|_| width >= MEANING_MIN);
        Some(Self {
            size,
            margin,
            lines: lines.collect(),
            meaning: meaning.map_or(Vec::new(), |(_, _, meaning)| wrapped(meaning, room)),
            has_scale: legend.scale.is_some(),
        })
    }

    /// From one line to the next.
    fn apart(&self) -> i64 {
        self.size.line() + self.size.line() / 8
    }

    fn top(&self) -> i64 {
        self.margin + self.lines.len() as i64 * self.apart()
    }

    fn bottom(&self) -> i64 {
        let meaning = self.meaning.len() as i64 * self.size.line();
        match self.has_scale {
            true => meaning + scale_height(self.size) + self.margin,
            false => 0,
        }
    }
}

fn bar_height(size: TextSize) -> i64 {
    size.line() * 3 / 4
}

/// Of the scale of tightness with its numbers.
fn scale_height(size: TextSize) -> i64 {
    bar_height(size) + size.line() + size.line() / 2
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
    let at = [x, y + size.line()];
    draw_bar(image, at, [width, height], (scale, GROWTH_RED), size);
}

/// The bar and the numbers below it.
fn draw_bar(
    image: &mut Image,
    [x, y]: [i64; 2],
    [width, height]: [i64; 2],
    (scale, end): (Scale, f64),
    size: TextSize,
) {
    let top = y + size.line() / 4;
    let widest = size.width(&scale_number(4, end));
    // Room for the first number, whose middle is where the bar begins.
    let x = x + widest / 2;
    for i in 0..width {
        let share = (i as f64 + 0.5) / width as f64;
        let colour = scale.colour_to(end, 1.0 + share * (end - 1.0));
        image.fill([x + i, top], [1, height], colour, 255);
    }
    for k in (0..=4).step_by(apart(width, widest, size)) {
        let number = scale_number(k, end) + if k == 4 { "+" } else { "" };
        let at = x + k * width / 4;
        image.fill(
            [at.min(x + width - 1), top + height],
            [1, size.line() / 4],
            GREY,
            255,
        );
        let below = top + height + size.line() / 4;
        image.text([at - widest / 2, below], &number, size, GREY);
    }
}

/// The most digits behind the point: f64 has no more for growths.
const DECIMALS_MAX: usize = 15;

/// What stands at a quarter of a scale from 1 to `end`: with two digits behind the point, or as many as keep each
/// number within a hundredth of a quarter, so that equal steps read as such.
fn scale_number(quarter: i64, end: f64) -> String {
    let step = (end - 1.0) / 4.0;
    let at = |k: i64| 1.0 + k as f64 * step;
    let is_near = |decimals: &usize| {
        (0..=4).all(|k| {
            let written: f64 = format!("{:.decimals$}", at(k)).parse().unwrap_or(f64::NAN);
            (written - at(k)).abs() <= 0.01 * step
        })
    };
    let decimals = (2..DECIMALS_MAX).find(is_near).unwrap_or(DECIMALS_MAX);
    format!("{:.decimals$}", at(quarter))
}

/// Every how many numbers of a scale of a width are written, of which the widest is so wide: all, or those that leave
/// room between them; 5 where only the first fits.
fn apart(width: i64, widest: i64, size: TextSize) -> usize {
    let needed = widest + size.width(" ");
    let fits = |apart: &usize| width * *apart as i64 / 4 >= needed;
    [1, 2, 4].into_iter().find(fits).unwrap_or(5)
}

/// A text in rows of at most `room` characters, cut between words where there are any; what is beyond the last row is
/// left out.
fn wrapped(text: &str, room: usize) -> Vec<String> {
    let mut rows = Vec::new();
    let mut row = String::new();
    for word in text.split(' ') {
        let mut word: Vec<char> = word.chars().collect();
        if !row.is_empty() {
            if row.chars().count() + 1 + word.len() <= room {
                row.push(' ');
            } else {
                rows.push(std::mem::take(&mut row));
            }
        }
        // One that is wider than all of it goes on in the next row.
        while word.len() > room {
            let rest = word.split_off(room);
            rows.push(word.into_iter().collect());
            word = rest;
        }
        row.extend(word);
    }
    rows.push(row);
    if rows.len() > ROWS_MAX {
        rows.truncate(ROWS_MAX);
        if let Some(last) = rows.last_mut() {
            *last = last
                .chars()
                .take(room.saturating_sub(3))
                .collect::<String>()
                + "...";
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::{Legend, apart, scale_number, wrapped};
    use crate::image::Image;
    use crate::text::TextSize;
    use crate::tightness::{GROWTH_RED, Scale};

    fn legend(lines: usize, has_scale: bool) -> Legend {
        let meaning = "growth: radius over that of the sphere at rest".to_string();
        Legend {
            lines: vec!["level 0: 8 spheres, growth mean 1.000, largest 1.000".to_string(); lines],
            scale: has_scale.then_some((Scale::Paper, GROWTH_RED, meaning)),
        }
    }

    #[test]
    fn a_legend_leaves_most_of_a_picture() {
        for size in [[64, 48], [320, 240], [800, 600], [1600, 1000], [300, 2000]] {
            for (lines, has_scale) in [(1, false), (3, true), (40, true)] {
                let [top, bottom] = legend(lines, has_scale).room(size);
                assert!(f64::from(top + bottom) <= 0.4 * f64::from(size[1]));
            }
        }
        assert_eq!(legend(3, true).room([64, 48]), [0; 2]);
        assert_eq!(legend(2, false).room([600, 240]), [12 + 2 * 18, 0]);
        // Each in two rows, the scale's meaning too.
        let bottom = 2 * 16 + (12 + 16 + 8) + 12;
        assert_eq!(legend(3, true).room([300, 2000]), [12 + 6 * 18, bottom]);
    }

    #[test]
    fn a_small_picture_has_no_legend_and_in_others_text_stays_above_the_scale() {
        let drawn = |size: [u32; 2], legend: &Legend| {
            let mut image = Image::filled(size, [255; 4]);
            legend.draw(&mut image);
            image
        };
        for size in [[100, 100], [199, 600], [600, 199]] {
            let image = drawn(size, &legend(3, true));
            assert!(image.pixels().iter().all(|p| *p == [255; 4]), "{size:?}");
        }
        let size = [200, 200];
        let with_text = drawn(size, &legend(9, true));
        let scale_alone = drawn(size, &legend(0, true));
        let scale = (200 - 12 - (12 + 16 + 8)) * 200;
        assert!(with_text.pixels()[..scale].iter().any(|p| *p != [255; 4]));
        assert_eq!(with_text.pixels()[scale..], scale_alone.pixels()[scale..]);
    }

    #[test]
    fn numbers_of_a_scale_leave_room_between_them() {
        let size = TextSize::Small;
        let [number, space] = ["1.00", " "].map(|text| size.width(text));
        for width in 20..600 {
            let apart = apart(width, number, size);
            assert!(apart > 4 || width * apart as i64 / 4 >= number + space);
        }
        let of = |width| apart(width, number, size);
        assert_eq!([of(400), of(128), of(64), of(20)], [1, 2, 4, 5]);
    }

    #[test]
    fn numbers_of_a_scale_are_as_far_apart_as_their_places() {
        for (end, numbers) in [
            (GROWTH_RED, ["1.00", "1.11", "1.22", "1.33", "1.44"]),
            (9.0, ["1.00", "3.00", "5.00", "7.00", "9.00"]),
            (1.01, ["1.0000", "1.0025", "1.0050", "1.0075", "1.0100"]),
            (1.05, ["1.0000", "1.0125", "1.0250", "1.0375", "1.0500"]),
            (1.3, ["1.000", "1.075", "1.150", "1.225", "1.300"]),
        ] {
            assert_eq!([0, 1, 2, 3, 4].map(|k| scale_number(k, end)), numbers);
        }
        // Hardly above 1 and far above it there are some, too.
        for end in [1.0 + 4.0 * f64::EPSILON, 1e6] {
            assert!(scale_number(4, end).len() < 20);
        }
    }

    #[test]
    fn the_first_number_of_a_scale_has_its_middle_where_the_bar_begins() {
        let mut image = Image::filled([400, 300], [255; 4]);
        legend(0, true).draw(&mut image);
        let drawn = |row: usize, is: &dyn Fn([u8; 4]) -> bool| {
            let columns = 0..400;
            columns
                .filter(|x| is(image.pixels()[row * 400 + x]))
                .collect::<Vec<_>>()
        };
        // From below: the margin, numbers, the bar.
        let bar = drawn(300 - 12 - 16 - 8 - 4, &|p| p != [255; 4]);
        let numbers = (300 - 12 - 16 - 4)..(300 - 12);
        let columns = numbers.flat_map(|row| drawn(row, &|p| p[0] < 160));
        let left = columns.min().expect("numbers");
        let width = TextSize::Small.width("1.00") as usize;
        assert_eq!(bar[0], 12 + width / 2);
        // A letter does not fill its width.
        assert!((12..12 + 4).contains(&left), "{left}");
    }

    #[test]
    fn long_text_goes_on_in_the_next_row() {
        for (text, rows) in [
            ("", &[""][..]),
            ("two words", &["two words"]),
            ("one two three", &["one two", "three"]),
            ("abcdefghijkl no", &["abcdefghij", "kl no"]),
            ("a abcdefghij", &["a", "abcdefghij"]),
            (
                "1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6",
                &["1 2 3 4 5", "6 7 8 9 0", "1 2 3 4..."],
            ),
        ] {
            assert_eq!(wrapped(text, 10), rows, "{text}");
        }
    }
}
