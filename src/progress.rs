//! How long work tells what it is doing, and how it is asked to stop.

/// A sink for progress. All methods may be called from any thread.
pub trait Progress: Sync {
    /// A new stage begins; `total` steps are expected, or an unknown number if 0.
    fn stage(&self, name: &str, total: u64);
    /// The stage has done `done` steps so far.
    fn done(&self, done: u64);
    /// True once the work should stop at the next good moment with an error.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Says nothing, never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _name: &str, _total: u64) {}
    fn done(&self, _done: u64) {}
}
