//! What an axis shows, and which part of it.

/// An axis: its text, where it begins and ends (`None`: with the values), and whether it may count in powers of ten.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it shows, with the unit.
    pub text: String,
    from: Option<f64>,
    to: Option<f64>,
    is_log: bool,
}

/// Values whose largest is less than this many times the smallest are shown evenly: powers of ten would hardly
/// mark them.
const LOG_SPAN: f64 = 30.0;

impl Axis {
    /// Even, from 0 on.
    pub fn linear(text: &str) -> Self {
        Self::from(text, 0.0)
    }

    /// Even, from a number on.
    pub fn from(text: &str, from: f64) -> Self {
        Self {
            text: text.to_string(),
            from: Some(from),
            to: None,
            is_log: false,
        }
    }

    /// The same up to a number at least, where it is even.
    #[must_use]
    pub fn to(self, to: f64) -> Self {
        Self {
            to: Some(to),
            ..self
        }
    }

    /// In powers of ten, if the values span some.
    pub fn log(text: &str) -> Self {
        Self {
            text: text.to_string(),
            from: None,
            to: None,
            is_log: true,
        }
    }

    /// Its text, and that zero is not shown, where it is not.
    pub(super) fn name(&self, leaves_zero_out: bool) -> String {
        let without = if leaves_zero_out {
            " (0 not shown)"
        } else {
            ""
        };
        format!("{}{without}", self.text)
    }

    /// Whether values are shown in powers of ten: where they are asked for, and those above 0 span some.
    pub(super) fn counts_in_powers(&self, values: impl Iterator<Item = f64>) -> bool {
        let (low, high) = ends(values.filter(|value| *value > 0.0));
        self.is_log && high > LOG_SPAN * low
    }

    /// From the least to the largest value, with room.
    pub(super) fn range(
        &self,
        values: impl Iterator<Item = f64>,
        is_log: bool,
    ) -> std::ops::Range<f64> {
        let (low, high) = ends(values);
        if is_log {
            return low / 1.25..high * 1.25;
        }
        let low = low.min(self.from.unwrap_or(0.0));
        let high = high.max(self.to.unwrap_or(high));
        let room = 0.05 * (high - low);
        let high = if room > 0.0 { high + room } else { low + 1.0 };
        low..high
    }
}

/// The least and the largest.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    })
}
