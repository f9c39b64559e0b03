//! Progress on stderr, when that is a terminal.

use bdtree_build::progress::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// A spinner with the stage's name, or a bar where the number of steps is known.
pub(crate) struct Bar {
    bar: ProgressBar,
}

impl Bar {
    /// Draws on stderr unless `hidden` or stderr is no terminal.
    pub(crate) fn new(hidden: bool) -> Self {
        let target = if hidden {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar }
    }

    /// Removes what was drawn.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn stage(&self, name: &str, steps: Option<u64>) {
        let template = match steps {
            Some(_) => "{elapsed:>4} {msg:<12} {bar:32} {percent:>3} %, {eta} left",
            None => "{elapsed:>4} {msg:<12} {spinner}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style);
        }
        match steps {
            Some(steps) => self.bar.set_length(steps),
            None => self.bar.unset_length(),
        }
        self.bar.set_position(0);
        self.bar.reset_eta();
        self.bar.set_message(name.to_owned());
    }

    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}
