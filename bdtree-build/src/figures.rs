//! Numbers in messages.

/// `x` with at most so many significant digits, without trailing zeros; very small and very large ones with an exponent.
pub fn digits(x: f64, count: usize) -> String {
    let precision = count.saturating_sub(1);
    let rounded: f64 = format!("{x:.precision$e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 | 1e-4..1e7 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// `1 node`, `2 nodes`; `1 entry`, `2 entries`.
pub fn counted(count: usize, what: &str) -> String {
    match (count, what.strip_suffix('y')) {
        (1, _) => format!("1 {what}"),
        (_, Some(stem)) => format!("{count} {stem}ies"),
        (_, None) if what == "vertex" => format!("{count} vertices"),
        (_, None) => format!("{count} {what}s"),
    }
}

/// Ascending numbers, three or more in a row as `2 to 4`.
pub fn numbers(all: &[usize]) -> String {
    let rows = all.chunk_by(|a, b| a + 1 == *b);
    let words = rows.flat_map(|row| match row {
        [first, _, .., last] => vec![format!("{first} to {last}")],
        few => few.iter().map(usize::to_string).collect(),
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_counts_agree() {
        assert_eq!(digits(345.123, 3), "345");
        assert_eq!(digits(12.39, 3), "12.4");
        assert_eq!(digits(0.0712, 3), "0.0712");
        assert_eq!(digits(1.8614e-7, 4), "1.861e-7");
        assert_eq!(digits(0.0, 3), "0");
        assert_eq!(counted(1, "entry"), "1 entry");
        assert_eq!(counted(2, "entry"), "2 entries");
        assert_eq!(counted(0, "vertex"), "0 vertices");
        assert_eq!(counted(57, "channel"), "57 channels");
        assert_eq!(numbers(&[0, 1, 2, 3, 5, 7, 8]), "0 to 3, 5, 7, 8");
    }
}
