//! Exemplars that change: with time, or with the side they are seen or lit from.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures", SIGGRAPH 2000, section 6, which names both as other types of texture
//! that the same pastes can carry.
//!
//! An exemplar's own channels are its first frame; the others are exemplars of the same size and channels. Pastes are laid, windows and
//! cuts chosen by the first frame alone, so what changes is what shows, never where.
//!
//! * Time shows one frame at a time, each for its own while, over and over.
//! * View and light mix the two frames whose angle is next to the one between the surface and the eye, or the main lamp: the first frame
//!   is for looking straight down on the surface, the last for grazing it, the others evenly between.

use super::{Channel, Exemplar, ExemplarError};
use std::f32::consts::FRAC_PI_2;

/// What an exemplar changes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FramesBy {
    /// Seconds.
    Time,
    /// The angle between the surface's normal and the eye.
    View,
    /// The angle between the surface's normal and the main lamp.
    Light,
}

/// The frames of an exemplar that changes, its first one left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    by: FramesBy,
    /// How long each frame is shown, the first one too; empty unless frames go by time.
    seconds: Vec<f64>,
    others: Vec<Exemplar>,
}

impl Frames {
    /// What they change with.
    #[must_use]
    pub const fn by(&self) -> FramesBy {
        self.by
    }

    /// How long each frame is shown, the exemplar's own first; empty unless frames go by time.
    #[must_use]
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// The frames after the first.
    #[must_use]
    pub fn others(&self) -> &[Exemplar] {
        &self.others
    }

    pub(super) fn others_mut(&mut self) -> &mut [Exemplar] {
        &mut self.others
    }

    /// How many frames there are, the first one counted.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.others.len() + 1
    }

    /// Seconds until the first frame comes back; 0 unless frames go by time.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// The number of the frame that shows at a time; 0 unless frames go by time.
    #[must_use]
    pub fn at(&self, seconds: f64) -> usize {
        self.moment(seconds).0
    }

    /// The same, and how many seconds it goes on showing: without end if it never changes.
    #[must_use]
    pub fn moment(&self, seconds: f64) -> (usize, f64) {
        let duration = self.duration();
        if !(duration > 0.0 && seconds.is_finite()) {
            return (0, f64::INFINITY);
        }
        let mut into = seconds.rem_euclid(duration);
        for (k, frame) in self.seconds.iter().enumerate() {
            if into < *frame {
                return (k, frame - into);
            }
            into -= frame;
        }
        (self.count() - 1, 0.0)
    }

    /// The lower of the two frames that show where the angle has this cosine, and the share of the one above it.
    #[must_use]
    pub fn between(&self, cosine: f32) -> (usize, f32) {
        let steps = self.others.len() as f32;
        let place = cosine.clamp(0.0, 1.0).acos() / FRAC_PI_2 * steps;
        let low = (place as usize).min(self.others.len().saturating_sub(1));
        (low, (place - low as f32).clamp(0.0, 1.0))
    }
}

impl Exemplar {
    /// Gives the exemplar frames after its own: `others`, in their order, each with the size and the channels of this one. `seconds`
    /// says how long each frame is shown, this one first; frames that do not go by time need none.
    ///
    /// # Errors
    /// If there are no others, they do not fit, or a duration is not above zero or has no end.
    pub fn set_frames(&mut self, by: FramesBy, others: Vec<Self>, seconds: Vec<f64>) -> Result<(), ExemplarError> {
        let fail = |what: String, remedy: &str| Err(ExemplarError::BadFrames { what, remedy: remedy.to_owned() });
        if others.is_empty() {
            return fail("there is only one frame".into(), "give at least two");
        }
        let names = |e: &Self| e.channels().iter().map(Channel::name).collect::<Vec<_>>().join(", ");
        for (k, other) in others.iter().enumerate() {
            let number = k + 2;
            if other.size() != self.size {
                let ([w, h], [ow, oh]) = (self.size, other.size());
                return fail(format!("frame {number} is {ow}x{oh}, the first {w}x{h}"), "give all frames one size");
            }
            if other.channels() != self.channels() {
                let what = format!("frame {number} has {}, the first {}", names(other), names(self));
                return fail(what, "give all frames the same channels");
            }
        }
        let needed = if by == FramesBy::Time { others.len() + 1 } else { 0 };
        if seconds.len() != needed {
            return fail(format!("there are durations for {} frames, not for {needed}", seconds.len()), "give one a frame");
        }
        if let Some(k) = seconds.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
            return fail(format!("frame {} is shown for {} seconds", k + 1, seconds[k]), "give durations above zero");
        }
        if !seconds.iter().sum::<f64>().is_finite() {
            return fail("together its frames are shown without end".into(), "give shorter durations");
        }
        // Frames of frames would never be shown.
        let others = others.into_iter().map(|e| Self { wrap: self.wrap, frames: None, ..e }).collect();
        self.frames = Some(Frames { by, seconds, others });
        Ok(())
    }

    /// Its frames, if it changes.
    #[must_use]
    pub const fn frames(&self) -> Option<&Frames> {
        self.frames.as_ref()
    }

    /// Leaves its own channels alone.
    pub fn remove_frames(&mut self) {
        self.frames = None;
    }

    /// What it is at a time: the frame that shows then, without the others. One that does not go by time is itself.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Self {
        match &self.frames {
            Some(frames) if frames.by == FramesBy::Time => {
                let shown = frames.at(seconds).checked_sub(1).map_or(self, |k| &frames.others[k]);
                Self { name: self.name.clone(), wrap: self.wrap, frames: None, ..shown.clone() }
            }
            _ => self.clone(),
        }
    }

    /// Changes the frames after the first as the first was changed.
    ///
    /// # Errors
    /// Those of `change`.
    pub(super) fn change_others<E>(&mut self, change: impl FnMut(&mut Self) -> Result<(), E>) -> Result<(), E> {
        self.frames.iter_mut().flat_map(Frames::others_mut).try_for_each(change)
    }
}

/// How long until all exemplars that go by time have shown all their frames: the longest of their durations. 0 if none does.
#[must_use]
pub fn duration(exemplars: &[Exemplar]) -> f64 {
    exemplars.iter().filter_map(Exemplar::frames).map(Frames::duration).fold(0.0, f64::max)
}
