//! How long it takes from a change to its picture, and how long the user interface stands still.

use serde::Serialize;
use std::time::{Duration, Instant};

/// Frames whose times are kept for the graph.
pub const KEPT: usize = 120;
/// Edits that are kept.
const EDITS: usize = 10_000;

/// A change and when it was seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Edit {
    /// What was changed.
    pub name: String,
    /// Faces of the model.
    pub faces: usize,
    /// Seconds until it was in the picture.
    pub seconds: f64,
}

/// Times of a session.
#[derive(Debug)]
pub struct Trace {
    begin: Instant,
    pending: Option<(String, u64, Instant)>,
    /// Changes that were seen.
    pub edits: Vec<Edit>,
    /// Seconds that the interface worked for each of the last frames, latest last.
    pub frames: Vec<f32>,
    count: u64,
    longest: Duration,
    over: u64,
}

impl Default for Trace {
    fn default() -> Self {
        let (pending, longest) = (None, Duration::ZERO);
        Self { begin: Instant::now(), pending, edits: Vec::new(), frames: Vec::new(), count: 0, longest, over: 0 }
    }
}

/// Longer than this the interface must not stand still.
pub const STALL: Duration = Duration::from_millis(16);

impl Trace {
    /// A change was made; what is shown of that revision or a later one shows it.
    pub fn edited(&mut self, name: &str, revision: u64) {
        self.pending = Some((name.to_owned(), revision, Instant::now()));
    }

    /// A revision is in the picture.
    pub fn shown(&mut self, revision: u64, faces: usize) {
        if let Some((name, _, at)) = self.pending.take_if(|(_, wanted, _)| revision >= *wanted)
            && self.edits.len() < EDITS
        {
            self.edits.push(Edit { name, faces, seconds: at.elapsed().as_secs_f64() });
        }
    }

    /// The interface worked for so long for one frame.
    pub fn frame(&mut self, worked: Duration) {
        self.count += 1;
        self.longest = self.longest.max(worked);
        self.over += u64::from(worked > STALL);
        if self.frames.len() >= KEPT {
            self.frames.remove(0);
        }
        self.frames.push(worked.as_secs_f32());
    }

    /// The longest that it stood still.
    #[must_use]
    pub const fn longest(&self) -> Duration {
        self.longest
    }

    /// All of it as JSON.
    #[must_use]
    pub fn report(&self) -> serde_json::Value {
        serde_json::json!({
            "seconds": self.begin.elapsed().as_secs_f64(),
            "frames": self.count,
            "longestStallSeconds": self.longest.as_secs_f64(),
            "framesOver16ms": self.over,
            "edits": self.edits,
        })
    }
}
