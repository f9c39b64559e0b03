//! What an axis shows, and which part of it.

/// An axis: its text, where it begins and ends (`None`: with the values), and whether it may count in powers, of ten
/// or of two.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it shows, with the unit.
    pub text: String,
    from: Option<f64>,
    to: Option<f64>,
    steps: Steps,
}

/// What equal lengths along an axis stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Steps {
    /// Equal differences.
    Even,
    /// Factors of ten, if the values span some; else equal differences.
    Tens,
    /// Factors of two.
    Twos,
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
            steps: Steps::Even,
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
            steps: Steps::Tens,
        }
    }

    /// In powers of two, for settings that are tried in doublings: of few such values a mark stands at each, which even
    /// steps and powers of ten would miss.
    pub fn doublings(text: &str) -> Self {
        Self {
            steps: Steps::Twos,
            ..Self::log(text)
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

    /// Whether values are shown in powers: where those of two are asked for, or those of ten and values above 0 span some.
    pub(super) fn counts_in_powers(&self, values: impl Iterator<Item = f64>) -> bool {
        let (low, high) = ends(values.filter(|value| *value > 0.0));
        match self.steps {
            Steps::Even => false,
            Steps::Tens => high > LOG_SPAN * low,
            Steps::Twos => high > 0.0,
        }
    }

    /// Where an axis that counts in powers has marks: at its powers, or every second, third … of them where that would be
    /// more than `most`.
    pub(super) fn powers(&self, range: &std::ops::Range<f64>, most: usize) -> Vec<f64> {
        let base: f64 = match self.steps {
            Steps::Twos => 2.0,
            Steps::Even | Steps::Tens => 10.0,
        };
        let first = range.start.log(base).ceil() as i32;
        let last = range.end.log(base).floor() as i32;
        let count = usize::try_from(last - first + 1).unwrap_or(0);
        let step = count.div_ceil(most).max(1);
        let powers = (first..=last).step_by(step);
        powers.map(|power| base.powi(power)).collect()
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

#[cfg(test)]
mod tests {
    use super::Axis;

    #[test]
    fn powers_are_marked_and_not_too_many() {
        let marks = |axis: &Axis, low: f64, high: f64| axis.powers(&(low..high), 4);
        let twos = Axis::doublings("triangles");
        assert_eq!(marks(&twos, 1.6, 10.0), [2.0, 4.0, 8.0]);
        assert_eq!(marks(&twos, 0.8, 80.0), [1.0, 4.0, 16.0, 64.0]);
        let tens = Axis::log("error");
        assert_eq!(marks(&tens, 0.8, 1250.0), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(marks(&tens, 0.8, 12500.0), [1.0, 100.0, 10000.0]);
        assert!(marks(&tens, 2.0, 7.0).is_empty());
    }

    /// However few they are: even steps from 0 on would mark none of 2, 4 and 8.
    #[test]
    fn doublings_are_never_even() {
        let values = || [2.0, 4.0, 8.0].into_iter();
        assert!(Axis::doublings("triangles").counts_in_powers(values()));
        assert!(!Axis::log("triangles").counts_in_powers(values()));
    }
}
