//! Windows: which part of the exemplar shows under the mask of each paste.
//!
//! Where the mask lies is decided by growth and fit; what shows under it is free as long as the exemplar goes on. So each paste
//! takes the window that agrees best with what already lies around it.
//!
//! Based on: the overlap error of Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001, section
//! 2, here on a surface and with the masks of Praun, Finkelstein, Hoppe 2000.
//!
//! 1. Pastes take their turn outwards from one of them, so that there are few places where windows chosen apart meet. Those
//!    that share no face are independent, and go wave by wave in parallel.
//! 2. Along the border of each mask lies a band: full weight in the feather, falling off inwards. A paste is sampled where its own
//!    band lies over pastes whose windows are known, and where bands of such pastes lie over it, as far as that shows.
//! 3. On a level of a few dozen pixels every window is tried; the best few are followed to finer levels, pixel by pixel.
//!
//! 4. Exemplars that look the same turned are tried so (`paste::ways`); a turn must be clearly better than none.
//!
//! An exemplar that tiles has all windows; any other those that keep the mask inside it. Colours and all other channels count as
//! [`crate::exemplar::stack`] weighs them.

use super::composite::paste_alpha;
use super::lapped::{FaceLists, LappedTexture};
use super::levels::Level;
use super::turn::Turn;
use super::waves::{LEAST_FACES, outwards, waves};
use super::ways::{Turns, Ways};
use crate::exemplar::distance::distance;
use crate::exemplar::{ChannelSet, Exemplar, TexturePatch, Wrap};
use crate::random::Random;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

/// Longest side of the finest level that is matched; a finer one moves a window by less than a feather.
pub const FINEST_WINDOW: u32 = 512;
/// Longest side of the level on which every window is tried.
const COARSEST: usize = 32;
/// Windows that are followed from each level to the next finer one.
const KEPT: usize = 4;
/// Samples of one border on the level where every window is tried, and on finer ones.
const COARSE_SAMPLES: usize = 96;
const FINE_SAMPLES: usize = 256;
/// Samples that are looked at before a window that is worse than others already is given up.
const PART: usize = 16;
/// Distance between neighbouring samples, as a share of the mask's longer side: some hundreds along a border.
const PITCH: f32 = 1.0 / 40.0;
/// How far inside the feather the weight falls to 1/e, as a share of the mask's longer side: a course of bricks that goes on
/// below is met by the one above, and a cut finds both sides alike farther in.
const BAND: f32 = 0.05;
/// Fewer samples than this say nothing.
const LEAST_SAMPLES: usize = 8;
/// Share of what lies below from which it is known.
const KNOWN: f32 = 0.5;
/// Samples that count less than this are left out.
const LEAST_WEIGHT: f32 = 0.05;
/// A turned window must differ by less than this share of what the best unturned one does.
const TURN_WORTH: f64 = 0.95;
/// Random stream of the windows of pastes without known neighbours.
const STREAM: u64 = 0x5749_4E44_4F57_0000;

/// What choosing windows did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WindowStatistics {
    /// Pastes whose window was chosen by what lies around them.
    pub matched: usize,
    /// Pastes whose window is turned.
    pub turned: usize,
    /// Root mean square difference along visible borders, in steps of encoded colour (0 to 1), with all windows at rest.
    pub border_before: f64,
    /// The same with the windows chosen.
    pub border_after: f64,
    /// Seconds.
    pub seconds: f64,
}

/// An exemplar's levels, finest first.
struct Levels(Vec<Level>);

impl Levels {
    fn new(exemplar: &Exemplar, channels: ChannelSet) -> Self {
        let [w, h] = exemplar.size();
        let count = exemplar.channel(crate::exemplar::Channel::BaseColor).map_or(1, |c| c.levels().len());
        let side = |level: usize| (w.max(h) >> level).max(1);
        let first = (0..count).find(|&l| side(l) <= FINEST_WINDOW).unwrap_or(0);
        let last = (first..count).find(|&l| side(l) as usize <= COARSEST).unwrap_or(count - 1).max(first);
        Self((first..=last).map(|l| Level::new(exemplar, channels, l)).collect())
    }
}

/// How much each pixel of a mask counts as border.
struct Border {
    width: usize,
    weight: Vec<f32>,
    pitch: f32,
}

impl Border {
    fn new(patch: &TexturePatch) -> Self {
        let mask = patch.mask.finest();
        let [w, h] = mask.size().map(|s| s as usize);
        let outside: Vec<bool> = mask.data().iter().map(|&a| a <= 0.02).collect();
        let depth = distance(&outside, w);
        // Half way through the feather.
        let middle = depth.iter().zip(mask.data()).filter(|(_, a)| **a < 0.5).map(|(d, _)| *d).fold(0.0, f32::max);
        let band = BAND * w.max(h) as f32;
        let of = |(d, a): (&f32, &f32)| if *a <= 0.02 { 0.0 } else { (-((d - middle).max(0.0) / band).powi(2)).exp() };
        let weight = depth.iter().zip(mask.data()).map(of).map(|w| if w < 0.02 { 0.0 } else { w }).collect();
        Self { width: w, weight, pitch: (PITCH * w.max(h) as f32).max(1.0) }
    }

    fn at(&self, pixel: Vec2) -> f32 {
        if pixel.min_element() < 0.0 || pixel.x >= self.width as f32 {
            return 0.0;
        }
        self.weight.get(pixel.y as usize * self.width + pixel.x as usize).copied().unwrap_or(0.0)
    }
}

/// A place where a paste meets another.
struct Sample {
    /// Pixel of its exemplar without any shift.
    pixel: Vec2,
    weight: f32,
    /// Numbers of the other side, level by level.
    other: Vec<f32>,
}

/// A paste at a point.
struct Mark {
    paste: u32,
    alpha: f32,
    /// Weight as border.
    border: f32,
    /// Pixel of its exemplar without any shift.
    pixel: Vec2,
}

/// What a paste shows under its mask.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shown {
    turn: Turn,
    offset: Vec2,
}

struct Matcher<'a> {
    lapped: &'a LappedTexture,
    lists: FaceLists,
    levels: Vec<Levels>,
    borders: Vec<Border>,
    /// Of each patch.
    ways: Vec<Ways>,
}

/// Chooses the windows of all pastes. Exemplars that tile must say so by their `wrap`, and may be turned as `turns` says of each.
pub(super) fn choose_windows(face_count: usize, lapped: &mut LappedTexture, turns: &[Turns], seed: u64) -> WindowStatistics {
    let begin = std::time::Instant::now();
    let channels = lapped.exemplars.iter().map(Exemplar::channels).reduce(ChannelSet::intersection).unwrap_or_default();
    let mut statistics = WindowStatistics::default();
    let ways = |p: &TexturePatch| Ways::new(&lapped.exemplars[p.exemplar as usize], p, turns[p.exemplar as usize]);
    let matcher = Matcher {
        lists: FaceLists::new(face_count, &lapped.pastes),
        levels: lapped.exemplars.iter().map(|e| Levels::new(e, channels)).collect(),
        borders: lapped.patches.par_iter().map(Border::new).collect(),
        ways: lapped.patches.par_iter().map(ways).collect(),
        lapped,
    };
    let order = outwards(&matcher.lists, &matcher.lapped.pastes);
    let waves = waves(face_count, &matcher.lapped.pastes, &order);
    let mut known = vec![false; order.len()];
    let mut shown: Vec<Shown> = matcher.lapped.pastes.iter().map(|p| Shown { turn: p.turn, offset: p.offset }).collect();
    let mut sums = [0.0_f64; 3];
    for wave in waves {
        let chosen: Vec<(Shown, bool, [f64; 3])> = wave
            .par_iter()
            .map(|&k| {
                let ways = matcher.ways_of(k);
                let free = |turn: &Turn| ways.room(*turn).is_some_and(|[low, high]| (high - low).max_element() >= 1.0);
                if ways.first().len() < 2 && !ways.first().iter().any(free) {
                    return (shown[k as usize], false, [0.0; 3]);
                }
                let samples = matcher.samples(k, &shown, &known);
                matcher.choose(k, &samples, seed)
            })
            .collect();
        for (&k, (now, found, [weight, before, after])) in wave.iter().zip(chosen) {
            shown[k as usize] = now;
            known[k as usize] = true;
            statistics.turned += usize::from(now.turn != Turn::NONE);
            statistics.matched += usize::from(found);
            sums = [sums[0] + weight, sums[1] + before, sums[2] + after];
        }
    }
    lapped.pastes.iter_mut().zip(shown).for_each(|(paste, now)| (paste.turn, paste.offset) = (now.turn, now.offset));
    let rms = |sum: f64| if sums[0] > 0.0 { (sum / sums[0]).sqrt() } else { 0.0 };
    (statistics.border_before, statistics.border_after) = (rms(sums[1]), rms(sums[2]));
    statistics.seconds = begin.elapsed().as_secs_f64();
    statistics
}

impl Matcher<'_> {
    /// Where a paste meets others whose windows are known, as far as it shows.
    fn samples(&self, k: u32, shown: &[Shown], known: &[bool]) -> Vec<Sample> {
        let paste = &self.lapped.pastes[k as usize];
        let patch = &self.lapped.patches[paste.patch as usize];
        let border = &self.borders[paste.patch as usize];
        let pitch = border.pitch;
        let size = Vec2::from(patch.mask.size().map(|s| s as f32));
        let on_face = |marks: &mut Vec<Mark>, (&face, uv): (&u32, &[Vec2; 3])| {
            let mut samples = Vec::new();
            let [a, b, c] = uv.map(|p| p * size);
            let (low, high) = (a.min(b).min(c).max(Vec2::ZERO), a.max(b).max(c).min(size));
            let turn = (b - a).perp_dot(c - a);
            let others = || self.lists.of(face).iter().map(|e| e.0).filter(|&p| p != k && known[p as usize]);
            let bordered = others().any(|p| p > k);
            if others().next().is_none() || turn == 0.0 || !low.cmplt(high).all() {
                return samples;
            }
            let [first, last] = [(low / pitch).ceil(), (high / pitch).floor()];
            for y in first.y as i32..=last.y as i32 {
                for x in first.x as i32..=last.x as i32 {
                    let p = Vec2::new(x as f32, y as f32) * pitch;
                    if !bordered && border.at(p) == 0.0 {
                        continue;
                    }
                    let bary = Vec3::new((c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)) / turn;
                    if bary.min_element() < 0.0 {
                        continue;
                    }
                    self.mark(face, bary, marks);
                    if let Some(own) = marks.iter().position(|m| m.paste == k) {
                        samples.extend(self.over(shown, known, marks, own));
                        samples.extend(self.under(shown, known, marks, own));
                    }
                }
            }
            samples
        };
        let faces = paste.faces.par_iter().zip(&paste.uv).with_min_len(LEAST_FACES);
        let found: Vec<Vec<Sample>> = faces.map_init(Vec::new, on_face).collect();
        found.into_iter().flatten().collect()
    }

    /// The pastes that have alpha at a point, from the top down.
    fn mark(&self, face: u32, bary: Vec3, marks: &mut Vec<Mark>) {
        marks.clear();
        for &(number, slot) in self.lists.of(face).iter().rev() {
            let paste = &self.lapped.pastes[number as usize];
            let alpha = paste_alpha(&self.lapped.patches, paste, slot, bary);
            if alpha > 0.0 {
                let patch = &self.lapped.patches[paste.patch as usize];
                let uv: Vec2 = (0..3).map(|i| paste.uv[slot as usize][i] * bary[i]).sum();
                let pixel = uv * Vec2::from(patch.mask.size().map(|s| s as f32));
                let border = self.borders[paste.patch as usize].at(pixel);
                marks.push(Mark { paste: number, alpha, border, pixel: pixel + Vec2::from(patch.origin.map(|o| o as f32)) });
            }
        }
    }

    /// The paste's own border over what is known below.
    fn over(&self, shown: &[Shown], known: &[bool], marks: &[Mark], own: usize) -> Option<Sample> {
        let seen: f32 = marks[..own].iter().map(|m| 1.0 - m.alpha).product();
        let weight = seen * marks[own].border;
        if weight < LEAST_WEIGHT {
            return None;
        }
        let mut other = Vec::new();
        let count = self.levels(marks[own].paste).len();
        let (mut left, mut covered) = (1.0_f32, 0.0);
        for mark in &marks[own + 1..] {
            let share = left * mark.alpha;
            left -= share;
            if known[mark.paste as usize] {
                covered += share;
                self.add(mark, shown, share, count, &mut other);
            }
        }
        if covered < KNOWN {
            return None;
        }
        other.iter_mut().for_each(|n| *n /= covered);
        Some(Sample { pixel: marks[own].pixel, weight: weight * covered, other })
    }

    /// The topmost known border over the paste.
    fn under(&self, shown: &[Shown], known: &[bool], marks: &[Mark], own: usize) -> Option<Sample> {
        let mut seen = 1.0;
        for (place, mark) in marks[..own].iter().enumerate() {
            let between: f32 = marks[place + 1..own].iter().map(|m| 1.0 - m.alpha).product();
            let weight = seen * mark.border * between * marks[own].alpha;
            if known[mark.paste as usize] && weight >= LEAST_WEIGHT {
                let mut other = Vec::new();
                self.add(mark, shown, 1.0, self.levels(marks[own].paste).len(), &mut other);
                return Some(Sample { pixel: marks[own].pixel, weight, other });
            }
            seen *= 1.0 - mark.alpha;
        }
        None
    }

    fn ways_of(&self, paste: u32) -> &Ways {
        &self.ways[self.lapped.pastes[paste as usize].patch as usize]
    }

    /// The levels of a paste's exemplar, finest first.
    fn levels(&self, paste: u32) -> &[Level] {
        let patch = self.lapped.pastes[paste as usize].patch;
        &self.levels[self.lapped.patches[patch as usize].exemplar as usize].0
    }

    /// Adds a share of what a paste shows, on as many levels as another has: they are counted from the coarsest, and a smaller exemplar
    /// gives its finest for those it lacks.
    fn add(&self, mark: &Mark, shown: &[Shown], share: f32, count: usize, to: &mut Vec<f32>) {
        let levels = self.levels(mark.paste);
        let now = shown[mark.paste as usize];
        let pixel = self.ways_of(mark.paste).turned(now.turn, mark.pixel) + now.offset;
        let mut next = 0;
        for number in 0..count {
            let level = &levels[(levels.len() + number).saturating_sub(count).min(levels.len() - 1)];
            let values = level.at(level.cell(pixel));
            to.resize(to.len().max(next + values.len()), 0.0);
            to[next..].iter_mut().zip(values).for_each(|(n, v)| *n += share * v);
            next += values.len();
        }
    }

    /// What a paste is to show; whether its border said anything; and weight and squared differences before and after.
    fn choose(&self, k: u32, samples: &[Sample], seed: u64) -> (Shown, bool, [f64; 3]) {
        let ways = self.ways_of(k);
        let straight = ways.room(Turn::NONE).unwrap_or_default();
        let patch = &self.lapped.patches[self.lapped.pastes[k as usize].patch as usize];
        let exemplar = &self.lapped.exemplars[patch.exemplar as usize];
        if samples.len() < LEAST_SAMPLES {
            let span = straight[1] - straight[0];
            let mut random = Random::new(seed, STREAM + u64::from(k));
            let mut part = |span: f32| (random.unit() as f32 * span).floor().min((span - 1.0).max(0.0));
            let offset = straight[0] + Vec2::new(part(span.x), part(span.y));
            return (Shown { turn: Turn::NONE, offset }, false, [0.0; 3]);
        }
        let levels = self.levels(k);
        let coarsest = levels.len() - 1;
        let fine = spread(samples, FINE_SAMPLES);
        let coarse = spread(samples, COARSE_SAMPLES);
        let on = |number: usize, turn: Turn, samples: &[&Sample]| {
            Points::new(&levels[number], number, samples, |p| ways.turned(turn, p))
        };
        // Unturned windows and turned ones each for themselves: a turn must be worth it.
        let best = |turned: bool| {
            let at_turn = |(turn, [low, high]): (Turn, [Vec2; 2])| {
                let mut best = Vec::new();
                let points = on(coarsest, turn, &coarse);
                let step = Vec2::ONE / levels[coarsest].scale;
                let count = ((high - low) / step).ceil().max(Vec2::ONE);
                for (x, y) in (0..count.y as u32).flat_map(|y| (0..count.x as u32).map(move |x| (x, y))) {
                    let offset = (low + Vec2::new(x as f32, y as f32) * step).min(high);
                    let error = points.error(offset, worst(&best));
                    keep(&mut best, error, Shown { turn, offset });
                }
                best
            };
            let turns = ways.first().par_iter().filter(|t| (**t != Turn::NONE) == turned).filter_map(|&t| Some((t, ways.room(t)?)));
            let mut best = best_of(turns.map(at_turn).collect());
            for number in (0..coarsest).rev() {
                let step = Vec2::ONE / levels[number].scale;
                let beside = |&(_, around): &(f64, Shown)| {
                    let mut next = Vec::new();
                    for turn in ways.beside(around.turn, coarsest - number).filter(|t| (*t != Turn::NONE) == turned) {
                        let Some([low, high]) = ways.room(turn) else { continue };
                        let points = on(number, turn, &fine);
                        for (dx, dy) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
                            let offset = around.offset + Vec2::new(dx as f32, dy as f32) * step;
                            let offset = match exemplar.wrap {
                                Wrap::Repeat => offset,
                                Wrap::Clamp => offset.clamp(low, high),
                            };
                            let now = Shown { turn, offset };
                            if next.iter().all(|&(_, other)| other != now) {
                                let error = points.error(offset, worst(&next));
                                keep(&mut next, error, now);
                            }
                        }
                    }
                    next
                };
                best = best_of(best.par_iter().map(beside).collect());
            }
            let found = best.first()?.1;
            Some((on(0, found.turn, &fine).error(found.offset, f64::INFINITY), found))
        };
        let at_rest = on(0, Turn::NONE, &fine).error(Vec2::ZERO, f64::INFINITY);
        let weight: f64 = fine.iter().map(|s| f64::from(s.weight)).sum();
        let (error, now) = match rayon::join(|| best(false), || best(true)) {
            (Some(straight), Some(turned)) if turned.0 < TURN_WORTH * straight.0 => turned,
            (Some(straight), _) => straight,
            (None, turned) => turned.unwrap_or((at_rest, Shown { turn: Turn::NONE, offset: Vec2::ZERO })),
        };
        let size = Vec2::from(exemplar.size().map(|s| s as f32));
        let whole = straight == [Vec2::ZERO, size];
        let offset = if whole { now.offset.rem_euclid(size) } else { now.offset };
        (Shown { offset: offset.round(), ..now }, true, [weight, at_rest, error])
    }
}

/// Samples on one level, side by side.
struct Points<'a> {
    level: &'a Level,
    /// Where each begins in the level's numbers while nothing is shifted.
    first: Vec<usize>,
    weight: Vec<f32>,
    /// Numbers of the other side.
    other: Vec<f32>,
}

impl<'a> Points<'a> {
    fn new(level: &'a Level, number: usize, samples: &[&Sample], place: impl Fn(Vec2) -> Vec2) -> Self {
        let from = number * level.components;
        Self {
            level,
            first: samples.iter().map(|s| level.first(level.cell(place(s.pixel)))).collect(),
            weight: samples.iter().map(|s| s.weight).collect(),
            other: samples.iter().flat_map(|s| &s.other[from..from + level.components]).copied().collect(),
        }
    }

    /// Weighted squared difference of a window; once it is more than `most`, the rest is not looked at.
    fn error(&self, offset: Vec2, most: f64) -> f64 {
        let shift = self.level.first(self.level.cell(offset));
        let count = self.level.components.max(1);
        let mut sum = 0.0_f32;
        let most = most as f32;
        let parts = self.first.chunks(PART).zip(self.weight.chunks(PART)).zip(self.other.chunks(PART * count));
        for ((first, weight), other) in parts {
            for ((&first, &weight), other) in first.iter().zip(weight).zip(other.chunks_exact(count)) {
                let own = &self.level.data[first + shift..][..count];
                sum += weight * own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
            }
            if sum > most {
                break;
            }
        }
        f64::from(sum)
    }
}

/// So many of the samples, evenly.
fn spread(samples: &[Sample], most: usize) -> Vec<&Sample> {
    let step = samples.len().div_ceil(most).max(1);
    samples.iter().step_by(step).collect()
}

/// The error from which on a window is none of the best few.
fn worst(best: &[(f64, Shown)]) -> f64 {
    best.get(KEPT - 1).map_or(f64::INFINITY, |&(error, _)| error)
}

/// The best few of several lists; of equal ones those that come first.
fn best_of(lists: Vec<Vec<(f64, Shown)>>) -> Vec<(f64, Shown)> {
    let mut best: Vec<(f64, Shown)> = Vec::new();
    for (error, shown) in lists.into_iter().flatten() {
        if best.iter().all(|&(_, other)| other != shown) {
            keep(&mut best, error, shown);
        }
    }
    best
}

/// Keeps the best few, best first.
fn keep(best: &mut Vec<(f64, Shown)>, error: f64, shown: Shown) {
    let place = best.partition_point(|(e, _)| *e <= error);
    if place < KEPT {
        best.truncate(KEPT - 1);
        best.insert(place, (error, shown));
    }
}
