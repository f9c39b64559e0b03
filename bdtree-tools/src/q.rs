//! Reduced coordinates as people write them, checked against an asset.

use std::str::FromStr;

use bdtree_runtime::Asset;

/// Numbers separated by commas; the empty text is none.
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
                number
                    .parse()
                    .map_err(|_| format!("q[{j}]: \"{number}\" is not a number"))
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// A problem with q: of one entry, or of the whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct QProblem {
    /// Which entry.
    pub(crate) mode: Option<usize>,
    /// What is wrong.
    pub(crate) message: String,
}

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
        return Err(vec![QProblem {
            mode: None,
            message: format!(
                "q has {}, asset {asset_name} has {}",
                counted(q.len(), "number"),
                counted(modes.len(), "mode")
            ),
        }]);
    }
    let problems: Vec<QProblem> = q
        .iter()
        .zip(modes)
        .enumerate()
        .filter_map(|(j, (x, mode))| {
            let limit = mode.q_limit.get();
            let message = if !x.is_finite() {
                "not a finite number".to_string()
            } else if !((*x as f32).abs() <= limit) {
                format!("{x} is over the asset's limit of {limit}")
            } else {
                return None;
            };
            Some(QProblem {
                mode: Some(j),
                message,
            })
        })
        .collect();
    if problems.is_empty() {
        Ok(q.iter().map(|x| *x as f32).collect())
    } else {
        Err(problems)
    }
}

/// `1 number`, `2 numbers`.
pub(crate) fn counted(n: usize, what: &str) -> String {
    let plural = if n == 1 { "" } else { "s" };
    format!("{n} {what}{plural}")
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
        assert!("1,".parse::<QText>().is_err());
    }
}
