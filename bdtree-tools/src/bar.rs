//! Progress on stderr: a bar where that is a terminal, else, if asked for, a line per stage.

#[cfg(feature = "report")]
use std::io::IsTerminal;
use std::io::{Write, stderr};
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar with the stage's name and the time left, or a spinner where the number of steps is not known.
pub(crate) struct Bar {
    bar: ProgressBar,
    /// The stage whose line was written last; `None` where lines are not wanted.
    told: Option<Mutex<String>>,
}

impl Bar {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar, told: None }
    }

    /// With a line for each stage where stderr is no terminal.
    #[cfg(feature = "report")]
    pub(crate) fn with_lines() -> Self {
        Self {
            told: (!stderr().is_terminal()).then(Mutex::default),
            ..Self::new()
        }
    }

    /// Begins a stage.
    pub(crate) fn stage(&self, name: &str, steps: Option<u64>) {
        if let Some(mut last) = self.told.as_ref().and_then(|told| told.lock().ok())
            && *last != name
        {
            name.clone_into(&mut last);
            let _ = writeln!(stderr(), "{name}");
        }
        let template = match steps {
            Some(_) => "{elapsed:>4} {msg:<24} {bar:32} {percent:>3} %, {eta} left",
            None => "{elapsed:>4} {msg:<24} {spinner}",
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

    /// So many steps more.
    pub(crate) fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }

    /// Removes what was drawn.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
