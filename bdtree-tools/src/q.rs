//! Reduced coordinates as people write them, checked against an asset.

use std::str::FromStr;

use bdtree_format::ModeRecord;
use bdtree_runtime::Asset;

/// Finite numbers separated by commas; the empty text is none.
#[derive(Debug, Clone, PartialEq)]
pub struct QText(pub Vec<f64>);

impl FromStr for QText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().is_empty() {
            return Ok(Self(Vec::new()));
        }
        text.split(',')
            .enumerate()
            .map(|(j, number)| {
                let number = number.trim();
                match number.parse::<f64>() {
                    Ok(x) if x.is_finite() => Ok(x),
                    Ok(_) => Err(format!("q[{j}]: \"{number}\" is not a finite number")),
                    Err(_) => Err(not_a_number(j, number)),
                }
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// The entry that is no number; what was meant, where it looks like several.
fn not_a_number(j: usize, text: &str) -> String {
    let is_number = |part: &str| part.parse::<f64>().is_ok();
    let mut parts = text
        .split(|c: char| c == ';' || c.is_whitespace())
        .filter(|part| !part.is_empty());
    let several = parts.clone().count() > 1 && parts.all(is_number);
    let advice = if several {
        "; separate numbers with commas"
    } else {
        ""
    };
    format!("q[{j}]: \"{text}\" is not a number{advice}")
}

/// What is wrong with q, of one entry or of the whole.
pub(crate) type QProblem = (Option<usize>, String);

/// q as the runtime takes it: rounded to f32, as many as the asset has modes, finite and within
/// the asset's limits. Absent: zeros.
///
/// # Errors
/// Every problem.
pub(crate) fn checked_q(
    q: Option<&[f64]>,
    asset: &Asset<'_>,
    asset_name: &str,
) -> Result<Vec<f32>, Vec<QProblem>> {
    let modes = asset.modes();
    let Some(q) = q else {
        return Ok(vec![0.0; modes.len()]);
    };
    if q.len() != modes.len() {
        let (found, expected) = (counted(q.len(), "number"), counted(modes.len(), "mode"));
        let message = format!("q has {found}, asset {asset_name} has {expected}");
        return Err(vec![(None, message)]);
    }
    let wrong = |(j, (x, mode)): (usize, (&f64, &ModeRecord))| {
        let limit = mode.q_limit.get();
        let message = match x.is_finite() {
            true if (*x as f32).abs() <= limit => return None,
            true => format!("{x} exceeds the limit of {limit}"),
            false => "not a finite number".to_string(),
        };
        Some((Some(j), message))
    };
    let problems: Vec<QProblem> = q.iter().zip(modes).enumerate().filter_map(wrong).collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    Ok(q.iter().map(|x| *x as f32).collect())
}

/// `1 number`, `2 numbers`.
pub(crate) fn counted(n: usize, what: &str) -> String {
    match (n, what) {
        (1, _) => format!("1 {what}"),
        (_, "vertex") => format!("{n} vertices"),
        (_, "matrix") => format!("{n} matrices"),
        (_, "query") => format!("{n} queries"),
        (_, "leaf") => format!("{n} leaves"),
        _ => format!("{n} {what}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_numbers() {
        assert_eq!(
            "-0.1, 0,2e-3".parse(),
            Ok(QText(vec![-0.1, 0.0, 2e-3])),
            "a leading minus and spaces"
        );
        assert_eq!("".parse(), Ok(QText(vec![])));
        assert_eq!(
            "1,x".parse::<QText>(),
            Err("q[1]: \"x\" is not a number".to_string())
        );
        for number in ["nan", "-inf", "1e999"] {
            let message = format!("q[1]: \"{number}\" is not a finite number");
            assert_eq!(format!("1,{number},0").parse::<QText>(), Err(message));
        }
        assert!("1,".parse::<QText>().is_err());
        for text in ["0.5 0.5", "1;2;3", "1; 2"] {
            let message = format!("q[0]: \"{text}\" is not a number; separate numbers with commas");
            assert_eq!(text.parse::<QText>(), Err(message));
        }
    }
}
