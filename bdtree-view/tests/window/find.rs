//! Where things are on the screen, by their colours.

use crate::CONTROLS;
use crate::display::Picture;

/// A rectangle: left, top, right, bottom, the last two beyond it.
pub(crate) type Rect = [u32; 4];

pub(crate) fn middle([left, top, right, bottom]: Rect) -> [u32; 2] {
    [u32::midpoint(left, right), u32::midpoint(top, bottom)]
}

/// Where pixels as asked touch each other, from top to bottom; specks are left out.
fn patches(picture: &Picture, area: Rect, is: impl Fn([u8; 3]) -> bool) -> Vec<Rect> {
    const SPECK: u32 = 3;
    let [left, top, right, bottom] = area;
    let width = (right - left) as usize;
    let mut seen = vec![false; width * (bottom - top) as usize];
    let mut found = Vec::new();
    for (x, y) in (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y))) {
        let mut patch = [x, y, x + 1, y + 1];
        let mut open = vec![[x, y]];
        while let Some([x, y]) = open.pop() {
            let is_inside = (left..right).contains(&x) && (top..bottom).contains(&y);
            if !is_inside {
                continue;
            }
            let place = (y - top) as usize * width + (x - left) as usize;
            if seen[place] || !is(picture.at(x, y)) {
                continue;
            }
            seen[place] = true;
            patch = [
                patch[0].min(x),
                patch[1].min(y),
                patch[2].max(x + 1),
                patch[3].max(y + 1),
            ];
            open.extend([
                [x + 1, y],
                [x, y + 1],
                [x.wrapping_sub(1), y],
                [x, y.wrapping_sub(1)],
            ]);
        }
        let [a, b, c, d] = patch;
        if c - a > SPECK && d - b > SPECK {
            found.push(patch);
        }
    }
    found
}

/// Buttons, while the pointer is elsewhere.
pub(crate) fn buttons(screen: &Picture) -> Vec<Rect> {
    patches(screen, CONTROLS, |c| c == [254; 3])
}

/// Fields with numbers to drag and lists to choose from, while the pointer is elsewhere.
pub(crate) fn fields(screen: &Picture) -> Vec<Rect> {
    patches(screen, CONTROLS, |c| c == [226, 229, 236])
}
