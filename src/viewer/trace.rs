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

/// A frame for which the interface stood still too long.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Stall {
    /// When, seconds since the window was opened.
    pub at: f64,
    /// How long.
    pub seconds: f64,
    /// How long it worked of these seconds, where the system tells; for the rest others had the processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub working: Option<f64>,
    /// Its parts that took longest, in the order in which they were done.
    pub parts: Vec<(&'static str, f64)>,
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
    /// Frames that took too long, the first ones.
    pub stalls: Vec<Stall>,
    parts: Vec<(&'static str, f64)>,
    /// Seconds that the thread had worked when the frame began.
    worked: Option<f64>,
}

impl Default for Trace {
    fn default() -> Self {
        let (pending, longest) = (None, Duration::ZERO);
        let (edits, frames, stalls, parts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { begin: Instant::now(), pending, edits, frames, count: 0, longest, over: 0, stalls, parts, worked: None }
    }
}

/// Longer than this the interface must not stand still.
pub const STALL: Duration = Duration::from_millis(16);
/// Stalls that are kept.
const STALLS: usize = 1000;
/// Parts of a stall that took less, seconds, are not told.
const PART: f64 = 0.001;

/// Seconds that this thread has had a processor, where the system tells.
fn thread_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split_ascii_whitespace().next()?.parse::<u64>().ok()? as f64 * 1e-9)
}

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

    /// A frame begins.
    pub fn begin_frame(&mut self) {
        self.parts.clear();
        self.worked = thread_seconds();
    }

    /// A part of the frame took so long.
    pub fn part(&mut self, name: &'static str, took: Duration) {
        self.parts.push((name, took.as_secs_f64()));
    }

    /// The interface worked for so long for one frame.
    pub fn frame(&mut self, worked: Duration) {
        if worked > STALL && self.stalls.len() < STALLS {
            let working = thread_seconds().zip(self.worked).map(|(now, then)| now - then);
            let parts = self.parts.iter().copied().filter(|(_, seconds)| *seconds > PART).collect();
            let at = self.begin.elapsed().as_secs_f64();
            self.stalls.push(Stall { at, seconds: worked.as_secs_f64(), working, parts });
        }
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
            "stalls": self.stalls,
            "edits": self.edits,
        })
    }
}
