//! Texture patches found without a hand: outlines that follow an exemplar's own lines, if it has any that close.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), section 3.1: patches whose outlines the user draws along features
//! of structured textures, and splotches for the others. Here the exemplar itself tells which it is, and where they run.
//!
//! 1. Lines: how strongly each pixel lies in grout, in a gap or on a border, dark or bright ([`lines`]).
//! 2. Closed paths that stay on them, around places spread over the exemplar ([`around`]); one that tiles has places everywhere.
//! 3. Whether the lines close: how much of a line such paths are on, by itself and beside what a path anywhere has, against the same in
//!    noise with the same spectrum. Noise has valleys too, and paths find them; only where most of the paths are better than the best of
//!    noise by one or the other are they taken.
//! 4. Of these paths a few are kept that use as much of the exemplar as they can, moved outwards by half the feather so that alpha is
//!    half on the line, and made simple polygons. Without them there are splotches.
//! 5. Symmetry and direction are those of [`crate::exemplar::symmetry`]; the size of a feature is the mean way between lines.

pub mod around;
pub mod lines;

use super::outline::{Outline, fill};
use super::patch::{PatchSource, PatchSpec};
use super::stack::{Stack, resized, tiles};
use super::symmetry::{Symmetry, exemplar_symmetry};
use super::{Channel, ChannelSet, Exemplar, OUTLINE_TOLERANCE, Wrap, opacity_is_outline};
use crate::random::Random;
use around::{Loop, closed};
use glam::Vec2;
use lines::{Lines, Tone, twin};
use rayon::prelude::*;
use serde::Serialize;

/// Longer side of the image that is looked at, pixels: grout of a fiftieth of it is still a few pixels wide.
const SIDE: u32 = 192;
/// An exemplar needs so many pixels a side for a path to have room.
const LEAST_SIDE: usize = 24;
/// Paths are looked for around so many places along each side; and fewer in each twin.
const PLACES: usize = 4;
const TWIN_PLACES: usize = 2;
/// Twins that tell what chance does, and the random stream of the first.
const TWINS: u64 = 5;
const STREAM: u64 = 0x4155_544F_0000_0000;
/// Room for a path around a place of an exemplar that does not tile, share of its sides to each side.
const ROOM: f32 = 0.44;
/// Outlines at most, and the share of the exemplar by which they differ at least: borders that look the same are one.
const MOST: usize = 4;
const DIFFER: f32 = 0.1;
/// Mean strength along paths below which lines do not close, however they compare with noise: a path that must cross stripes, boards or
/// patches of rust to come back is off lines for a quarter of its way.
const CLEAR: f32 = 0.75;
/// Share of the paths that must be better than noise: nine tenths are where there is grout, gravel and grass have up to six.
const USUAL: f32 = 0.75;

/// What an exemplar asks for.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Choice {
    /// The exemplar's name.
    pub exemplar: String,
    /// Outlines of its patches, pixels; none if its lines do not close: splotches then.
    #[serde(serialize_with = "counted")]
    pub outlines: Vec<Outline>,
    /// Its transparent parts bound its patches.
    pub opacity: bool,
    /// It goes on over its own edges.
    pub tiles: bool,
    /// Whether its lines are dark or bright.
    pub tone: Option<Tone>,
    /// How well paths lie on lines, on the mean.
    pub on_lines: Fit,
    /// The best of paths in noise with its spectrum.
    pub by_chance: Fit,
    /// Share of the paths that are better than that.
    pub better: f32,
    /// Share of the exemplar that the outlines use together.
    pub used: f32,
    /// Mean way between lines, share of the exemplar's width; 0 if it has none.
    pub feature: f32,
    /// How it looks when turned.
    pub symmetry: Option<Symmetry>,
    /// Why, a sentence each.
    pub reasons: Vec<String>,
}

/// How well a path lies on lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Fit {
    /// Mean strength of the lines along it.
    pub share: f32,
    /// The same in means of all pixels: what a path anywhere has.
    pub above: f32,
}

fn fits(lines: &Lines, paths: &[Loop]) -> Vec<Fit> {
    paths.iter().map(|path| Fit { share: path.share, above: lines.above(path.share) }).collect()
}

fn counted<S: serde::Serializer>(outlines: &[Outline], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_u64(outlines.len() as u64)
}

impl Choice {
    /// What an exemplar asks for; `feather` is that of its patches, pixels.
    #[must_use]
    pub fn of(exemplar: &Exemplar, feather: f32) -> Self {
        let mut choice = Self {
            exemplar: exemplar.name.clone(),
            outlines: Vec::new(),
            opacity: opacity_is_outline(exemplar, feather),
            tiles: exemplar.wrap == Wrap::Repeat || tiles(exemplar),
            tone: None,
            on_lines: Fit::default(),
            by_chance: Fit::default(),
            better: 0.0,
            used: 0.0,
            feature: 0.0,
            symmetry: exemplar_symmetry(exemplar),
            reasons: Vec::new(),
        };
        if !choice.opacity {
            choice.look(exemplar, feather);
        }
        choice.reasons = choice.told();
        choice
    }

    /// The patches; none where the usual ones do, which are the exemplar's own transparency or splotches.
    #[must_use]
    pub fn specs(&self) -> Vec<PatchSpec> {
        let source = PatchSource::Outlines { name: "found".to_owned(), outlines: self.outlines.clone() };
        if self.outlines.is_empty() { Vec::new() } else { vec![PatchSpec { source, weight: 1.0 }] }
    }

    /// Tells the exemplar that it tiles, if so: outlines may lie over its edges.
    pub const fn prepare(&self, exemplar: &mut Exemplar) {
        if self.tiles {
            exemplar.wrap = Wrap::Repeat;
        }
    }

    /// Looks for lines and for outlines along them.
    fn look(&mut self, exemplar: &Exemplar, feather: f32) {
        let stack = looked_at(exemplar, self.tiles);
        let Some(found) = Lines::of(&stack).filter(|_| stack.size.iter().all(|&s| s >= LEAST_SIDE)) else { return };
        let scale = exemplar.size()[0] as f32 / stack.size[0] as f32;
        let margin = 0.5 * feather / scale;
        let twins: Vec<[Lines; 2]> =
            (0..TWINS).into_par_iter().filter_map(|k| Lines::of(&twin(&stack, &mut Random::new(0, STREAM + k)))).collect();
        let mut kept = Vec::new();
        for (k, (tone, lines)) in Tone::ALL.into_iter().zip(&found).enumerate() {
            let of_twin = |lines: &[Lines; 2]| fits(&lines[k], &loops(&lines[k], TWIN_PLACES, margin));
            let chance: Vec<Fit> = twins.iter().flat_map(of_twin).collect();
            let most = chance.iter().fold(Fit::default(), |m, f| Fit { share: m.share.max(f.share), above: m.above.max(f.above) });
            let paths = loops(lines, PLACES, margin);
            let fits = fits(lines, &paths);
            let beats = |f: &Fit| f.share > most.share || f.above > most.above;
            let good: Vec<Loop> = paths.into_iter().zip(&fits).filter(|(_, f)| beats(f)).map(|(path, _)| path).collect();
            let count = fits.len().max(1) as f32;
            let mean = Fit {
                share: fits.iter().map(|f| f.share).sum::<f32>() / count,
                above: fits.iter().map(|f| f.above).sum::<f32>() / count,
            };
            let better = if mean.share >= CLEAR { good.len() as f32 / count } else { 0.0 };
            // Of tones that are as good the one whose paths lie on fewer and clearer lines.
            let rank = (better, mean.above - most.above);
            if self.tone.is_none() || rank > (self.better, self.on_lines.above - self.by_chance.above) {
                (self.tone, self.better, self.on_lines, self.by_chance) = (Some(tone), better, mean, most);
                self.feature = lines.apart();
                kept = good;
            }
        }
        if self.better > USUAL {
            self.keep(kept, stack.size, scale, feather, exemplar.size());
        }
    }

    /// Keeps a few of the paths that use the most of the exemplar.
    fn keep(&mut self, loops: Vec<Loop>, size: [usize; 2], scale: f32, feather: f32, pixels: [u32; 2]) {
        let mut left: Vec<(Outline, Vec<bool>)> = Vec::new();
        for path in &loops {
            let outline = outline(path, scale, 0.5 * feather);
            if outline.check(pixels).is_ok() {
                left.push((outline, inside(path, size)));
            }
        }
        let mut uses = vec![0_i32; size[0] * size[1]];
        while self.outlines.len() < MOST {
            // What has been used counts half as much each time.
            let gain =
                |l: &(Outline, Vec<bool>)| l.1.iter().zip(&uses).filter(|(i, _)| **i).map(|(_, &u)| 0.5_f32.powi(u)).sum::<f32>();
            let gains: Vec<f32> = left.iter().map(gain).collect();
            let Some(best) = (0..left.len()).rev().max_by(|&a, &b| gains[a].total_cmp(&gains[b])) else { break };
            let (outline, area) = left.remove(best);
            uses.iter_mut().zip(&area).for_each(|(u, &i)| *u += i32::from(i));
            left.retain(|(_, other)| other.iter().zip(&area).filter(|(a, b)| a != b).count() as f32 >= DIFFER * area.len() as f32);
            self.outlines.push(outline);
        }
        self.used = uses.iter().filter(|&&u| u > 0).count() as f32 / uses.len() as f32;
    }

    /// Why.
    fn told(&self) -> Vec<String> {
        let mut out = Vec::new();
        let tone = if self.tone == Some(Tone::Bright) { "bright" } else { "dark" };
        out.push(if self.opacity {
            "its own transparency is the outline of its patches".to_owned()
        } else if !self.outlines.is_empty() {
            format!(
                "{} along {tone} lines, which close: {:.0} % of the paths around it are better than the best of noise with its \
                 spectrum, and {:.0} % on lines; together the outlines use {:.0} % of it",
                if self.outlines.len() == 1 { "an outline".to_owned() } else { format!("{} outlines", self.outlines.len()) },
                100.0 * self.better,
                100.0 * self.on_lines.share,
                100.0 * self.used,
            )
        } else if self.tone.is_some() {
            format!(
                "splotches, for it has no lines that close: of the paths around it {:.0} % are better than the best of noise with its \
                 spectrum",
                100.0 * self.better
            )
        } else {
            "splotches, for it is too small or too even to have lines".to_owned()
        });
        if self.feature > 0.0 {
            out.push(format!("its features are about {:.0} % of its width apart", 100.0 * self.feature));
        }
        if self.tiles {
            out.push("it goes on over its own edges".to_owned());
        }
        out
    }
}

/// The exemplar as it is looked at.
fn looked_at(exemplar: &Exemplar, tiles: bool) -> Stack {
    let [w, h] = exemplar.size();
    let longer = w.max(h);
    let to = |n: u32| if longer > SIDE { (n * SIDE / longer).max(1) } else { n };
    let small = resized(exemplar, [to(w), to(h)]);
    let channels = Channel::ALL.into_iter().filter(|&c| c != Channel::Normal).fold(ChannelSet::default(), ChannelSet::with);
    Stack { wrap: if tiles { Wrap::Repeat } else { Wrap::Clamp }, ..Stack::new(&small, Some(channels)) }
}

/// Closed paths around places along a grid; `margin` is left free at the edges.
fn loops(lines: &Lines, per_side: usize, margin: f32) -> Vec<Loop> {
    let size = Vec2::new(lines.size[0] as f32, lines.size[1] as f32);
    let place = |i: usize| (Vec2::new((i % per_side) as f32, (i / per_side) as f32) + 0.5) / per_side as f32;
    let one = |i: usize| match lines.wrap {
        Wrap::Repeat => closed(lines, place(i) * size, size * 0.5 - 1.0 - margin),
        Wrap::Clamp => {
            let half = (size * ROOM).min(size * 0.5 - 1.0 - margin);
            let low = half + margin + 1.0;
            closed(lines, low + place(i) * (size - 2.0 * low), half)
        }
    };
    (0..per_side * per_side).into_par_iter().filter_map(one).collect()
}

/// Which pixels lie inside a path, of an image that repeats.
fn inside(path: &Loop, size: [usize; 2]) -> Vec<bool> {
    let low = path.points.iter().fold(Vec2::INFINITY, |m, &p| m.min(p)).floor();
    let high = path.points.iter().fold(Vec2::NEG_INFINITY, |m, &p| m.max(p)).ceil();
    let points: Vec<Vec2> = path.points.iter().map(|&p| p - low).collect();
    let [w, h] = (high - low).to_array().map(|s| s as usize);
    let filled = fill(&points, w, h);
    let wrapped = |i: usize| {
        let x = (low.x as i64 + (i % w) as i64).rem_euclid(size[0] as i64) as usize;
        let y = (low.y as i64 + (i / w) as i64).rem_euclid(size[1] as i64) as usize;
        y * size[0] + x
    };
    let mut out = vec![false; size[0] * size[1]];
    (0..w * h).filter(|&i| filled[i]).for_each(|i| out[wrapped(i)] = true);
    out
}

/// The outline of a path in pixels of the exemplar, so many further out.
fn outline(path: &Loop, scale: f32, out: f32) -> Outline {
    let n = path.points.len();
    let smooth = |from: &[Vec2]| -> Vec<Vec2> {
        (0..n).map(|i| 0.25 * from[(i + n - 1) % n] + 0.5 * from[i] + 0.25 * from[(i + 1) % n]).collect()
    };
    // Twice: the stairs of a path from pixel to pixel are gone, and corners of joints stay.
    let points = smooth(&smooth(&path.points));
    let turn: f32 = (0..n).map(|i| points[i].perp_dot(points[(i + 1) % n])).sum();
    let moved = |i: usize| {
        let along = (points[(i + 1) % n] - points[(i + n - 1) % n]).normalize_or_zero();
        points[i] * scale - along.perp() * out * turn.signum()
    };
    let line: Vec<Vec2> = (0..n).map(moved).collect();
    Outline::untangled(&line, OUTLINE_TOLERANCE)
}
