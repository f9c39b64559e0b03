//! Numbers and words as the page shows them.

pub(super) use crate::plot::escaped;

/// A number with three digits that count, for columns: zeros at its end are among them.
pub(super) fn figure(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{x:.2e}").replace("e-", "e\u{2212}");
    }
    if size >= 1e4 {
        let sign = if x < 0.0 { "-" } else { "" };
        return sign.to_string() + &count(size);
    }
    let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
    format!("{x:.digits$}")
}

/// A number with up to three digits that count, for sentences.
pub(super) fn number(x: f64) -> String {
    let text = figure(x);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

/// How many: a whole number, its digits in threes where there are more than four.
pub(super) fn count(x: f64) -> String {
    let n = x.round() as u64;
    match n {
        0..10_000 => n.to_string(),
        n => grouped(n),
    }
}

/// A share in per cent; what is not 0 is never said to be.
pub(super) fn percent(x: f64) -> String {
    match is_tiny(x) {
        true => "below 0.001 %".to_string(),
        false => format!("{} %", number(100.0 * x)),
    }
}

/// The same in a column.
pub(super) fn share(x: f64) -> String {
    match is_tiny(x) {
        true => "< 0.001 %".to_string(),
        false => format!("{} %", figure(100.0 * x)),
    }
}

fn is_tiny(x: f64) -> bool {
    x > 0.0 && x < 1e-5
}

/// With a capital at its beginning.
pub(super) fn capitalised(text: &str) -> String {
    let first = text.chars().take(1).flat_map(char::to_uppercase);
    first.chain(text.chars().skip(1)).collect()
}

/// Digits in threes.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{count, escaped, figure, grouped, number, percent, share};

    #[test]
    fn numbers_are_short_and_text_is_escaped() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(1234.56), "1235");
        assert_eq!(number(0.012_345_6), "0.0123");
        assert_eq!(number(2.0), "2");
        assert_eq!(number(1e-7), "1.00e\u{2212}7");
        assert_eq!(number(-18_782.3), "-18\u{202f}782");
        assert_eq!(percent(0.125), "12.5 %");
        assert_eq!(
            (percent(0.0), percent(0.05)),
            ("0 %".to_string(), "5 %".to_string())
        );
        assert_eq!(percent(2.9e-8), "below 0.001 %");
        assert_eq!(
            (count(3.6), count(4096.0)),
            ("4".to_string(), "4096".to_string())
        );
        for (x, text) in [
            (0.0, "0"),
            (0.8, "0.800"),
            (1.0, "1.00"),
            (12.0, "12.0"),
            (144.4, "144"),
        ] {
            assert_eq!(figure(x), text);
        }
        assert_eq!(
            (share(0.0033), share(1e-9)),
            ("0.330 %".to_string(), "< 0.001 %".to_string())
        );
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped(12), "12");
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
