//! Watching: pastes laid one by one, and how one of them grew and was laid flat (LT 3.3, 3.4).
//!
//! [`Watch`] says how many pastes are to be seen and which moment of which paste's growth; it knows neither renderer nor clock,
//! and is told how much time has passed. [`flat`] shows the flattening beside the view, [`panel`] the sliders.

pub mod flat;
pub mod panel;
pub mod room;

use crate::paste::{Growth, Seeding, watch::Moment};

/// Pastes a second, slowest and fastest.
pub const SPEEDS: std::ops::RangeInclusive<f32> = 0.5..=200.0;

/// Moments of growth a second for one paste a second.
const MOMENTS_PER_PASTE: f64 = 40.0;

/// What runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Play {
    /// Nothing.
    #[default]
    Still,
    /// Pastes are laid one by one.
    Pastes,
    /// The chosen paste grows.
    Growth,
}

/// The player.
#[derive(Debug, Clone)]
pub struct Watch {
    /// What runs.
    pub play: Play,
    /// Pastes a second; a growth runs at the same pace.
    pub speed: f32,
    /// Pastes that there are.
    count: usize,
    /// Pastes to be seen, and the part of the next that has been waited for.
    shown: f64,
    /// The moment of growth.
    moment: f64,
    chosen: Option<usize>,
    growth: Option<Growth>,
}

impl Watch {
    /// All of so many pastes are seen.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { play: Play::Still, speed: 8.0, count, shown: count as f64, moment: 0.0, chosen: None, growth: None }
    }

    /// Pastes that there are.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Pastes to be seen.
    #[must_use]
    pub fn shown(&self) -> usize {
        (self.shown as usize).min(self.count)
    }

    /// Shows so many.
    pub fn show(&mut self, count: usize) {
        self.shown = count.min(self.count) as f64;
    }

    /// Lays pastes one by one from the first, or goes on where it stood.
    pub fn lay(&mut self) {
        if self.shown() == self.count {
            self.shown = 0.0;
        }
        self.play = Play::Pastes;
    }

    /// The paste whose growth is looked at.
    #[must_use]
    pub const fn chosen(&self) -> Option<usize> {
        self.chosen
    }

    /// Chooses a paste to look at; its growth is to be handed in ([`Watch::grow`]).
    pub fn choose(&mut self, paste: Option<usize>) {
        self.chosen = paste.filter(|&p| p < self.count);
        (self.growth, self.moment) = (None, 0.0);
    }

    /// True if a growth is to be handed in.
    #[must_use]
    pub const fn wants_growth(&self) -> bool {
        self.chosen.is_some() && self.growth.is_none()
    }

    /// Hands in the growth of a paste; it runs from its seed.
    pub fn grow(&mut self, paste: usize, growth: Growth) {
        if self.chosen == Some(paste) {
            (self.growth, self.moment, self.play) = (Some(growth), 0.0, Play::Growth);
        }
    }

    /// The growth that is looked at.
    #[must_use]
    pub const fn growth(&self) -> Option<&Growth> {
        self.growth.as_ref()
    }

    /// The moment of growth that is looked at, from 0, and how many there are.
    #[must_use]
    pub fn place(&self) -> [usize; 2] {
        let all = self.growth.as_ref().map_or(0, Growth::moments);
        [(self.moment as usize).min(all.saturating_sub(1)), all]
    }

    /// Goes to a moment of the growth.
    pub fn go_to(&mut self, moment: usize) {
        self.moment = moment as f64;
    }

    /// The disc at that moment.
    #[must_use]
    pub fn moment(&self) -> Option<Moment> {
        self.growth.as_ref().map(|growth| growth.at(self.place()[0]))
    }

    /// Time has passed. True if something runs still.
    pub fn pass(&mut self, seconds: f64) -> bool {
        let pastes = seconds.clamp(0.0, 1.0) * f64::from(self.speed);
        match self.play {
            Play::Still => {}
            Play::Pastes => {
                self.shown = (self.shown + pastes).min(self.count as f64);
                if self.shown() == self.count {
                    self.play = Play::Still;
                }
            }
            Play::Growth => {
                let [_, all] = self.place();
                self.moment = (self.moment + pastes * MOMENTS_PER_PASTE).min(all as f64);
                if self.moment as usize >= all {
                    self.play = Play::Still;
                }
            }
        }
        self.play != Play::Still
    }
}

/// The topmost of the lowest `shown` pastes that lies on a face, if any: what a click on the surface means. `of_face` are the pastes
/// on the face, bottom first.
#[must_use]
pub fn topmost(of_face: &[(u32, u32)], shown: usize) -> Option<usize> {
    of_face.iter().rev().map(|&(paste, _)| paste as usize).find(|&p| p < shown)
}

/// What to say of a paste.
#[must_use]
pub fn describe(paste: usize, count: usize, seeding: Option<&Seeding>) -> String {
    let laid = seeding.map_or_else(String::new, |s| format!(", laid as number {}", s.laid + 1));
    let free = if seeding.is_some_and(|s| s.free) { ", over a hard edge and free of the field" } else { "" };
    format!("paste {} of {count} from below{laid}{free}", paste + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pastes_are_laid_at_the_speed_asked_for_and_then_it_rests() {
        let mut watch = Watch::new(20);
        assert_eq!(watch.shown(), 20, "all are seen at first");
        watch.speed = 10.0;
        watch.lay();
        assert_eq!(watch.shown(), 0, "from the first");
        for _ in 0..50 {
            watch.pass(0.02);
        }
        assert!((9..=10).contains(&watch.shown()), "ten in a second: {}", watch.shown());
        watch.play = Play::Still;
        assert!(!watch.pass(1.0), "paused");
        watch.lay();
        assert!((9..=10).contains(&watch.shown()), "it goes on where it stood: {}", watch.shown());
        while watch.pass(0.5) {}
        assert_eq!((watch.shown(), watch.play), (20, Play::Still), "all, and at rest");
    }

    #[test]
    fn a_click_means_the_topmost_paste_that_is_seen() {
        let list = [(2, 0), (5, 3), (9, 1)];
        assert_eq!(topmost(&list, 20), Some(9), "all are seen");
        assert_eq!(topmost(&list, 9), Some(5), "the last is not laid yet");
        assert_eq!(topmost(&list, 2), None, "bare still");
    }

    #[test]
    fn only_pastes_that_are_there_can_be_chosen() {
        let mut watch = Watch::new(3);
        watch.choose(Some(3));
        assert!(!watch.wants_growth(), "there is no fourth");
        watch.choose(Some(2));
        assert!(watch.wants_growth() && watch.moment().is_none(), "its growth is to be handed in");
    }
}
