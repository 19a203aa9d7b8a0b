//! The ways in which a texture patch may show its exemplar: turns that leave it looking the same, and how far it may slide then.
//!
//! Where an exemplar ends at its sides, a turned mask must lie inside of them.

use super::turn::{TURNS, Turn};
use crate::exemplar::{Exemplar, TexturePatch, Wrap};
use glam::Vec2;

/// Turns of exemplars that look the same every way are so many parts apart, once they are followed to finer levels.
const FINEST: u32 = 5;
/// And so many on the coarsest.
const COARSEST: u32 = 30;

/// Which turns leave an exemplar looking the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turns {
    /// None but full ones.
    None,
    /// Those by this part of a full turn.
    Parts(u32),
    /// All.
    Any,
}

/// The ways of one texture patch.
#[derive(Debug)]
pub(super) struct Ways {
    /// By turn, in steps of [`FINEST`]: least and greatest shift, if the mask fits in so.
    rooms: Vec<Option<[Vec2; 2]>>,
    /// Turns that are tried first.
    first: Vec<Turn>,
    /// Turns between those are followed.
    any: bool,
    /// The mask's middle, pixels of the exemplar.
    middle: Vec2,
}

impl Ways {
    pub(super) fn new(exemplar: &Exemplar, patch: &TexturePatch, turns: Turns) -> Self {
        let middle = 0.5 * Vec2::from(patch.mask.size().map(|s| s as f32)) + Vec2::from(patch.origin.map(|o| o as f32));
        let any = patch.slides && turns == Turns::Any;
        let step = match turns {
            _ if !patch.slides => TURNS,
            Turns::Any => COARSEST,
            Turns::Parts(n) if n > 0 && TURNS.is_multiple_of(n * FINEST) => TURNS / n,
            Turns::Parts(_) | Turns::None => TURNS,
        };
        let rim = if any || step < TURNS { rim(patch) } else { Vec::new() };
        let room = |parts: u32| match parts {
            0 => Some(straight(exemplar, patch)),
            _ if any || parts.is_multiple_of(step) => turned(exemplar, middle, &rim, Turn::new(parts)),
            _ => None,
        };
        let rooms: Vec<_> = (0..TURNS / FINEST).map(|k| room(k * FINEST)).collect();
        let first = (0..TURNS / step).map(|k| Turn::new(k * step)).filter(|t| rooms[(t.parts() / FINEST) as usize].is_some());
        Self { first: first.collect(), rooms, any, middle }
    }

    /// Least and greatest shift at a turn; `None` if it is no way of this patch.
    pub(super) fn room(&self, turn: Turn) -> Option<[Vec2; 2]> {
        if turn.parts().is_multiple_of(FINEST) { self.rooms[(turn.parts() / FINEST) as usize] } else { None }
    }

    /// The turns that are tried first; [`Turn::NONE`] is among them.
    pub(super) fn first(&self) -> &[Turn] {
        &self.first
    }

    /// A turn and those beside it, at the `refined`-th level after the coarsest.
    pub(super) fn beside(&self, turn: Turn, refined: usize) -> impl Iterator<Item = Turn> + use<> {
        let step = (COARSEST >> refined).max(FINEST) / FINEST * FINEST;
        let sides = if self.any { [0, step, TURNS - step].as_slice().to_vec() } else { vec![0] };
        sides.into_iter().map(move |parts| Turn::new(turn.parts() + parts))
    }

    /// A pixel of the exemplar under the mask, turned about the mask's middle.
    pub(super) fn turned(&self, turn: Turn, pixel: Vec2) -> Vec2 {
        if turn == Turn::NONE { pixel } else { turn.apply(pixel - self.middle) + self.middle }
    }
}

/// Least and greatest shift of a patch's content as it is.
fn straight(exemplar: &Exemplar, patch: &TexturePatch) -> [Vec2; 2] {
    let size = Vec2::from(exemplar.size().map(|s| s as f32));
    if !patch.slides {
        return [Vec2::ZERO; 2];
    }
    match exemplar.wrap {
        Wrap::Repeat => [Vec2::ZERO, size],
        Wrap::Clamp => {
            let origin = Vec2::from(patch.origin.map(|o| o as f32));
            let mask = Vec2::from(patch.mask.size().map(|s| s as f32));
            [(-origin).min(Vec2::ZERO), (size - origin - mask).max(Vec2::ZERO)]
        }
    }
}

/// The same once it is turned; `None` if the mask does not fit in.
fn turned(exemplar: &Exemplar, middle: Vec2, rim: &[Vec2], turn: Turn) -> Option<[Vec2; 2]> {
    let size = Vec2::from(exemplar.size().map(|s| s as f32));
    if exemplar.wrap == Wrap::Repeat {
        return Some([Vec2::ZERO, size]);
    }
    let extent = |(low, high): (Vec2, Vec2), &p: &Vec2| {
        let p = turn.apply(p) + middle;
        (low.min(p), high.max(p))
    };
    let (low, high) = rim.iter().fold((middle, middle), extent);
    let room = [-low, size - high].map(Vec2::round);
    room[0].cmple(room[1]).all().then_some(room)
}

/// The corners of the outermost pixels of each row of a mask that show something, from its middle.
fn rim(patch: &TexturePatch) -> Vec<Vec2> {
    let mask = patch.mask.finest();
    let [w, h] = mask.size().map(i64::from);
    let middle = 0.5 * Vec2::new(w as f32, h as f32);
    let row = |y: i64| {
        let shows = |x: &i64| mask.grey(*x, y) > 0.0;
        let (left, right) = ((0..w).find(shows)?, (0..w).rev().find(shows)? + 1);
        Some([left, right].into_iter().flat_map(move |x| [y, y + 1].map(|y| Vec2::new(x as f32, y as f32) - middle)))
    };
    (0..h).filter_map(row).flatten().collect()
}
