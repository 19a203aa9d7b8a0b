//! The passes: the coarsest level vertex by vertex with the adaptive metric, finer ones from what the level above suggests.
//!
//! Based on: Chen, Dong 2008, sec. 3, 5.1 and 6.
//!
//! 1. On the coarsest level a vertex's candidates are the places that continue those of the synthesised vertices in its
//!    neighbourhood. Where there are none, since all lie beyond the exemplar's edge, all pixels are. A part's first vertex is drawn.
//! 2. On a finer level every vertex starts at the place that its place above is linked to, and is then matched once more: among that
//!    place, the pixels within a range of it, and the places that continue those of its neighbours.
//!
//! Where we differ. Places are between pixels: on the coarsest level one pixel covers several vertices, which would all show the
//! same. So the four pixels that one is linked to are one place, and the range lies around it. Candidates of the neighbours are
//! ours on finer levels; and since there every vertex shows something from the start, no sample is uncoloured, and vertices
//! are visited in batches drawn at random, each matched at once: the same for any number of threads.

use super::ground::Ground;
use super::metric::{Chooser, Query};
use super::template::Template;
use super::windows::Windows;
use super::{RoundError, RoundLevel, RoundOptions};
use crate::progress::Progress;
use crate::random::Random;
use glam::Vec2;
use rayon::prelude::*;

/// Vertices that one task matches.
const CHUNK: usize = 64;

/// Candidates nearer to each other than this, pixels, are one.
const SAME: f32 = 0.25;

/// A sample is coloured if all vertices with more than this share of it are.
const SHARE: f32 = 1e-3;

/// Vertices between two looks at the progress sink.
const LOOK: usize = 1024;

/// The numbers that vertices show, and the places they come from.
pub(super) struct Shown {
    components: usize,
    values: Vec<f32>,
    pub(super) places: Vec<[f32; 2]>,
}

impl Shown {
    fn new(vertices: usize, components: usize) -> Self {
        Self { components, values: vec![0.0; vertices * components], places: vec![[0.0; 2]; vertices] }
    }

    fn put(&mut self, vertex: u32, place: [f32; 2], windows: &Windows) {
        self.places[vertex as usize] = place;
        let out = &mut self.values[vertex as usize * self.components..][..self.components];
        out.fill(0.0);
        windows.stack.sample(place, out);
    }

    #[inline]
    fn of(&self, vertex: u32) -> &[f32] {
        &self.values[vertex as usize * self.components..][..self.components]
    }
}

/// One level under work.
pub(super) struct Work<'a, G> {
    pub(super) ground: &'a G,
    pub(super) windows: &'a Windows,
    pub(super) template: &'a Template,
    pub(super) options: &'a RoundOptions,
}

/// Room for one vertex, used again and again.
#[derive(Default)]
struct Room {
    query: Query,
    /// Vertices met already, and the candidates.
    met: Vec<u32>,
    candidates: Vec<[f32; 2]>,
    window: Vec<f32>,
    chooser: Chooser,
}

impl<G: Ground> Work<'_, G> {
    /// Collects what lies around a vertex, and the places that continue it. `done` says which vertices show something.
    fn look(&self, vertex: u32, shown: &Shown, done: impl Fn(u32) -> bool, room: &mut Room) {
        let per = self.windows.per;
        room.query.clear(per, shown.components);
        room.met.clear();
        if self.options.metric.candidates {
            self.ground.beside(vertex, &mut |w| {
                room.met.push(w);
                self.suggest(w, vertex, shown, &done, &mut room.candidates);
            });
        }
        for k in 0..per {
            let Some(tap) = self.ground.tap(vertex, k) else { continue };
            if (0..3).all(|c| tap.shares[c] <= SHARE || done(tap.vertices[c])) {
                room.query.coloured[k] = 1.0;
                for (v, share) in tap.vertices.into_iter().zip(tap.shares).filter(|(_, s)| *s > SHARE) {
                    let value = shown.of(v).iter().enumerate();
                    value.for_each(|(c, x)| room.query.values[c * per + k] += share * x);
                }
            }
            let main = tap.main();
            if self.options.metric.candidates && !room.met.contains(&main) {
                room.met.push(main);
                self.suggest(main, vertex, shown, &done, &mut room.candidates);
            }
        }
    }

    /// The place that continues a neighbour's, if it is none there is already.
    #[inline]
    fn suggest(&self, from: u32, to: u32, shown: &Shown, done: impl Fn(u32) -> bool, candidates: &mut Vec<[f32; 2]>) {
        if from == to || !done(from) {
            return;
        }
        if let Some(way) = self.ground.way(from, to) {
            let [x, y] = shown.places[from as usize];
            self.add([x + way.x, y - way.y], candidates);
        }
    }

    #[inline]
    fn add(&self, at: [f32; 2], candidates: &mut Vec<[f32; 2]>) {
        if let Some(place) = self.windows.place(at) {
            let near = |c: &[f32; 2]| Vec2::from(*c).distance_squared(place.into()) < SAME * SAME;
            if !candidates.iter().any(near) {
                candidates.push(place);
            }
        }
    }

    /// Synthesises the coarsest level in an order.
    pub(super) fn coarsest(
        &self,
        order: &[u32],
        statistics: &mut RoundLevel,
        progress: &dyn Progress,
        count: &mut u64,
    ) -> Result<Shown, RoundError> {
        let windows = self.windows;
        let mut shown = Shown::new(self.ground.len(), windows.stack.components);
        let mut random = Random::new(self.options.seed, 0xC0A5);
        let pixels: Vec<[f32; 2]> = windows.pixels().collect();
        let mut done = vec![false; self.ground.len()];
        let mut room = Room { window: vec![0.0; windows.room()], ..Room::default() };
        let (mut circles, mut candidates) = (0, 0);
        for (i, &v) in order.iter().enumerate() {
            if i % LOOK == 0 {
                if progress.cancelled() {
                    return Err(RoundError::Cancelled);
                }
                progress.done(*count + i as u64);
            }
            room.candidates.clear();
            self.look(v, &shown, |w| done[w as usize], &mut room);
            let coloured = room.query.coloured.contains(&1.0);
            if room.candidates.is_empty() {
                if !coloured {
                    // Nothing around it shows anything.
                    room.candidates.push(pixels[random.below(pixels.len() as u64) as usize]);
                    statistics.drawn += 1;
                } else if self.options.metric.candidates {
                    room.candidates.push(self.nearest_of_all(&pixels, &room.query, &mut room.window));
                    statistics.searched += 1;
                } else {
                    room.candidates.extend_from_slice(&pixels);
                }
            }
            candidates += room.candidates.len();
            let mut chosen = 0;
            if room.candidates.len() > 1 {
                let Room { query, candidates, window, chooser, .. } = &mut room;
                let ends = self.template.ends();
                let at = |c: usize, out: &mut [f32]| windows.at(candidates[c], out);
                let found = chooser.choose(query, ends, self.options.metric, candidates.len(), at, window);
                (chosen, circles) = (found.candidate, circles + found.circles);
                statistics.compared += 1;
            }
            shown.put(v, room.candidates[chosen], windows);
            done[v as usize] = true;
        }
        statistics.circles = circles as f64 / statistics.compared.max(1) as f64;
        statistics.candidates = candidates as f64 / order.len().max(1) as f64;
        *count += order.len() as u64;
        Ok(shown)
    }

    fn nearest_of_all(&self, pixels: &[[f32; 2]], query: &Query, window: &mut [f32]) -> [f32; 2] {
        let mut best = (f32::INFINITY, [0.5; 2]);
        for &at in pixels {
            self.windows.at(at, window);
            let mean = query.mean(window);
            if mean < best.0 {
                best = (mean, at);
            }
        }
        best.1
    }

    /// Synthesises a finer level from the places of the one above.
    pub(super) fn finer(
        &self,
        above: &[[f32; 2]],
        level: usize,
        statistics: &mut RoundLevel,
        progress: &dyn Progress,
        count: &mut u64,
    ) -> Result<Shown, RoundError> {
        let (windows, vertices) = (self.windows, self.ground.len());
        let mut shown = Shown::new(vertices, windows.stack.components);
        for v in 0..vertices as u32 {
            let (parent, way) = self.ground.parent(v);
            let [x, y] = above[parent as usize];
            shown.put(v, windows.nearest([2.0 * x + way.x, 2.0 * y - way.y]), windows);
        }
        let mut random = Random::new(self.options.seed, 0xF14E + level as u64);
        let mut candidates = 0;
        for _ in 0..self.options.passes {
            for batch in crate::synth::batch::batches(vertices, self.options.batches, &mut random) {
                if progress.cancelled() {
                    return Err(RoundError::Cancelled);
                }
                let this = &shown;
                let room = || Room { window: vec![0.0; windows.room()], ..Room::default() };
                let one = |room: &mut Room, chunk: &[u32]| -> Vec<([f32; 2], u32)> {
                    chunk.iter().map(|&v| self.refined(v, this, room)).collect()
                };
                let chosen: Vec<Vec<([f32; 2], u32)>> = batch.par_chunks(CHUNK).map_init(room, one).collect();
                for (&v, &(place, tried)) in batch.iter().zip(chosen.iter().flatten()) {
                    shown.put(v, place, windows);
                    candidates += u64::from(tried);
                }
                *count += batch.len() as u64;
                progress.done(*count);
            }
        }
        statistics.candidates = candidates as f64 / (vertices * self.options.passes).max(1) as f64;
        statistics.circles = self.template.circles() as f64;
        statistics.compared = vertices as u64;
        Ok(shown)
    }

    /// The best place for a vertex that shows something already, and how many were tried.
    fn refined(&self, vertex: u32, shown: &Shown, room: &mut Room) -> ([f32; 2], u32) {
        let own = shown.places[vertex as usize];
        room.candidates.clear();
        room.candidates.push(own);
        self.look(vertex, shown, |_| true, room);
        let range = self.options.range as i32;
        for (i, j) in (-range..=range).flat_map(|j| (-range..=range).map(move |i| (i, j))) {
            self.add([own[0] + i as f32, own[1] + j as f32], &mut room.candidates);
        }
        let mut best = (f32::INFINITY, own);
        for &place in &room.candidates {
            self.windows.at(place, &mut room.window);
            let mean = room.query.mean(&room.window);
            if mean < best.0 {
                best = (mean, place);
            }
        }
        (best.1, room.candidates.len() as u32)
    }
}
