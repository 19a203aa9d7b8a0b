//! Progress on a terminal: a bar for stages of known length, a spinner for the others, nothing when stderr is a file.

use crate::progress::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// Work that ends sooner shows no bar at all.
const QUIET_FOR: Duration = Duration::from_millis(700);

/// How often a spinner turns.
const TICK: Duration = Duration::from_millis(120);

/// A progress bar on stderr.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    begin: std::time::Instant,
}

impl Bar {
    /// A bar, hidden if asked for quiet or if stderr is no terminal.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self { bar: ProgressBar::with_draw_target(None, target), begin: std::time::Instant::now() }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn stage(&self, name: &str, total: u64) {
        let template = if total > 0 { "{msg:24} [{bar:36}] {percent:>3} %  {elapsed}" } else { "{msg:24} {spinner}  {elapsed}" };
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style.progress_chars("=> "));
        }
        self.bar.set_length(total.max(1));
        self.bar.set_position(0);
        self.bar.set_message(name.to_owned());
        if self.begin.elapsed() > QUIET_FOR {
            self.bar.enable_steady_tick(TICK);
        }
    }

    fn done(&self, done: u64) {
        if self.begin.elapsed() > QUIET_FOR {
            self.bar.set_position(done);
        }
    }
}
