//! A line's words, and the numbers they spell.

/// The words of a line up to a word that begins with `#`.
#[derive(Clone, Copy)]
pub(super) struct Tokens<'t> {
    rest: &'t [u8],
}

fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c)
}

impl<'t> Tokens<'t> {
    pub(super) fn new(line: &'t [u8]) -> Self {
        Self { rest: line }
    }

    /// What is left of the line, without the blanks around it; `#` is kept, for names.
    pub(super) fn rest(self) -> &'t [u8] {
        self.rest.trim_ascii()
    }
}

impl<'t> Iterator for Tokens<'t> {
    type Item = &'t [u8];

    fn next(&mut self) -> Option<&'t [u8]> {
        let begin = self.rest.iter().position(|&b| !is_blank(b))?;
        let rest = &self.rest[begin..];
        if rest[0] == b'#' {
            self.rest = &[];
            return None;
        }
        let end = rest.iter().position(|&b| is_blank(b)).unwrap_or(rest.len());
        self.rest = &rest[end..];
        Some(&rest[..end])
    }
}

/// The three coordinates of a `v` line: the f64 nearest to each decimal number.
pub(super) fn position(mut tokens: Tokens<'_>) -> Result<[f64; 3], String> {
    let mut position = [0.0; 3];
    for (k, x) in position.iter_mut().enumerate() {
        let axis = ["x", "y", "z"][k];
        let token = tokens
            .next()
            .ok_or_else(|| format!("a vertex needs 3 coordinates, found {k}"))?;
        let value = std::str::from_utf8(token)
            .ok()
            .and_then(|text| text.parse::<f64>().ok())
            .ok_or_else(|| format!("{axis} `{}` is not a number", show(token)))?;
        if !value.is_finite() {
            let token = show(token);
            return Err(format!("{axis} `{token}` is not a finite number"));
        }
        *x = value;
    }
    Ok(position)
}

/// A decimal integer with or without a sign; `None` for anything else. Values beyond i64 become
/// its ends: they are out of every range anyway.
pub(in crate::input) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value
            .saturating_mul(10)
            .saturating_add(i64::from(digit - b'0'));
    }
    Some(if negative { -value } else { value })
}

/// A word for a message: printable, at most 32 characters.
pub(in crate::input) fn show(token: &[u8]) -> String {
    let text = String::from_utf8_lossy(&token[..token.len().min(128)]);
    let mut shown: String = text.chars().take(32).flat_map(char::escape_debug).collect();
    if token.len() > 128 || text.chars().count() > 32 {
        shown.push('…');
    }
    shown
}
