//! The passes: level by level, vertex by vertex, the best match.
//!
//! Based on: Wei, Levoy 2001, table 3 and sec. 3.2.
//!
//! 1. The coarsest level starts with places drawn at random. Every finer one starts with a pass that matches coarser levels only.
//! 2. Passes follow that match the level's own neighbourhood too, in random order.
//!
//! Where we differ: the vertices of a pass are visited in batches drawn at random, each batch at once from what the ones before
//! left. So a pass runs on all cores, and gives the same whatever their number. With [`SynthOptions::batches`] as large as the
//! mesh it is the paper's order exactly. What a vertex shows is a place of the exemplar, not only a value: it is where the next
//! neighbour's continuation starts.

use super::batch::batches;
use super::levels::Levels;
use super::neighbourhood::{Neighbourhoods, Values, from_corner};
use super::search::{Between, Choice, Fast, Nearby, Search, SearchKind, Tsvq, Whole};
use super::source::{Candidates, Place, Source};
use super::{LevelStatistics, SynthError, SynthOptions, SynthStatistics};
use crate::numeric::pca::Pca;
use crate::numeric::rows::Rows;
use crate::progress::Progress;
use crate::random::Random;
use pulp::Arch;
use rayon::prelude::*;
use std::time::Instant;

/// Vertices that one task matches.
const CHUNK: usize = 64;

/// Neighbours whose frames are turned by more than this (its cosine) show their content turned, which continues nothing.
const ALIGNED: f32 = 0.85;

/// Candidates that principal components are taken of at most.
const LEARNED: usize = 2048;

/// What is synthesised: a place of the exemplar at each vertex.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// Places on the finest level of the source, one for each vertex of the finest level.
    pub places: Vec<Place>,
    /// What was done.
    pub statistics: SynthStatistics,
}

/// A level that is done.
#[derive(Debug, Clone, Copy)]
pub struct LevelDone<'a> {
    /// Its number; 0 is the finest.
    pub level: usize,
    /// The place at each of its vertices.
    pub places: &'a [Place],
}

/// One level under work.
struct Work<'a> {
    levels: &'a Levels,
    level: usize,
    candidates: &'a Candidates<'a>,
    around: &'a Neighbourhoods,
    /// Numbers of this level and all coarser ones, this one first.
    values: Vec<Values>,
    places: Vec<Place>,
    coarser_places: &'a [Place],
}

/// Synthesises on all levels.
///
/// # Errors
/// If there is nothing to synthesise on or from, or `progress` cancels.
pub fn synthesize(
    levels: &Levels,
    source: &Source,
    options: &SynthOptions,
    progress: &dyn Progress,
    seen: &mut dyn FnMut(LevelDone),
) -> Result<Synthesis, SynthError> {
    options.check()?;
    if levels.is_empty() || source.is_empty() {
        return Err(SynthError::Nothing);
    }
    let count = levels.len().min(source.len());
    let total = (0..count).map(|k| levels.levels()[k].mesh.vertex_count() * (1 + options.passes(count - 1 - k))).sum::<usize>();
    progress.stage("synthesising", total as u64);
    let mut done = 0_u64;
    let mut statistics = SynthStatistics::default();
    let mut coarser: Vec<Values> = Vec::new();
    let mut coarser_places: Vec<Place> = Vec::new();
    for level in (0..count).rev() {
        let from_coarsest = count - 1 - level;
        let mut window = options.window(from_coarsest);
        window.levels = window.levels.min(from_coarsest as u32 + 1);
        let begin = Instant::now();
        let around = levels.neighbourhoods(level, window, options.middle);
        let flattened = begin.elapsed().as_secs_f64();
        let candidates = Candidates::new(source, level, window, options.middle, options.soften);
        let vertices = levels.levels()[level].mesh.vertex_count();
        let mut values = vec![Values::new(vertices, &source.mean(level))];
        values.append(&mut coarser);
        let mut random = Random::new(options.seed, 0x5E7 + from_coarsest as u64);
        let places = (0..vertices).map(|_| candidates.place(random.below(candidates.len() as u64) as u32)).collect();
        let mut work =
            Work { levels, level, candidates: &candidates, around: &around, values, places, coarser_places: &coarser_places };
        work.show(source, 0..vertices as u32);
        let [whole, up] = around.lengths(source.components());
        let (mut built, mut continued) = (0.0, 0);
        let mut pass = |work: &mut Work, up_only: bool, times: usize, random: &mut Random| -> Result<(), SynthError> {
            let start = Instant::now();
            let search = search(&candidates, up_only, options.search);
            built += start.elapsed().as_secs_f64();
            for _ in 0..times {
                continued = 0;
                // A pass over coarser levels reads nothing that it writes.
                for batch in batches(vertices, if up_only { 1 } else { options.batches }, random) {
                    if progress.cancelled() {
                        return Err(SynthError::Cancelled);
                    }
                    continued += work.batch(source, &batch, up_only, search.as_ref());
                    done += batch.len() as u64;
                    progress.done(done);
                }
            }
            Ok(())
        };
        if up > 0 {
            pass(&mut work, true, 1, &mut random)?;
        }
        let times = options.passes(from_coarsest);
        if whole > up && times > 0 {
            pass(&mut work, false, times, &mut random)?;
        }
        seen(LevelDone { level, places: &work.places });
        statistics.levels.push(LevelStatistics {
            vertices,
            candidates: candidates.len(),
            window,
            passes: times,
            flipped_faces: around.met.flipped,
            uncovered_samples: around.met.uncovered,
            continued: continued as f64 / vertices.max(1) as f64,
            flatten_seconds: flattened,
            build_seconds: built,
            match_seconds: begin.elapsed().as_secs_f64() - flattened - built,
        });
        coarser = std::mem::take(&mut work.values);
        coarser_places = std::mem::take(&mut work.places);
    }
    Ok(Synthesis { places: coarser_places, statistics })
}

/// The search over a level's candidates.
fn search(candidates: &Candidates, up_only: bool, kind: SearchKind) -> Box<dyn Search> {
    match kind {
        SearchKind::Exhaustive => Box::new(Whole::new(candidates.matrix(up_only))),
        SearchKind::Tsvq => Box::new(Tsvq::new(&candidates.matrix(up_only))),
        SearchKind::Fast => {
            let step = candidates.len().div_ceil(LEARNED).max(1);
            let learned: Vec<Vec<f32>> =
                (0..candidates.len()).into_par_iter().step_by(step).map(|i| candidates.one(i, up_only)).collect();
            let mut rows = Rows::new(learned.first().map_or(1, Vec::len));
            learned.iter().for_each(|r| rows.push(r));
            let pca = Pca::new(&rows, super::search::KEPT);
            let mut projected = Rows::zeros(candidates.len(), pca.kept());
            let kept = pca.kept();
            projected.data_mut().par_chunks_exact_mut(kept).enumerate().with_min_len(64).for_each_init(
                Vec::new,
                |row, (i, out)| {
                    row.clear();
                    candidates.row(i, up_only, row);
                    Arch::new().dispatch(|| pca.project(row, out));
                },
            );
            Box::new(Fast::new(pca, projected))
        }
    }
}

impl Work<'_> {
    /// Writes what some vertices show.
    fn show(&mut self, source: &Source, vertices: impl Iterator<Item = u32>) {
        for v in vertices {
            source.value(self.level, self.places[v as usize], self.values[0].of_mut(v));
        }
    }

    /// Matches a batch of vertices and writes what they show; returns how many continue a neighbour.
    fn batch(&mut self, source: &Source, batch: &[u32], up_only: bool, search: &dyn Search) -> usize {
        let [whole, up] = self.around.lengths(source.components());
        let length = if up_only { up } else { whole };
        let this = &*self;
        let chosen: Vec<(Place, bool)> = batch
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| {
                let mut queries = Rows::new(length);
                let (mut nearby, mut nearby_places) = (Nearby::default(), Vec::new());
                let mut row = Vec::with_capacity(length);
                for &v in chunk {
                    row.clear();
                    if !up_only {
                        this.around.own.gather(v, &this.values[0], &mut row);
                    }
                    let coarser = this.around.coarser.iter().zip(&this.values[1..]);
                    coarser.for_each(|(samples, values)| samples.gather(v, values, &mut row));
                    queries.push(&row);
                    if search.wants_nearby() {
                        this.nearby(v, up_only, &mut nearby, &mut nearby_places);
                    }
                }
                let choices = search.choose(&queries, &nearby);
                choices.into_iter().map(move |choice| match choice {
                    Choice::Row(row) => (this.candidates.place(row), false),
                    Choice::Nearby(k) => (nearby_places[k as usize], true),
                })
            })
            .collect();
        for (&v, &(place, _)) in batch.iter().zip(&chosen) {
            self.places[v as usize] = place;
        }
        self.show(source, batch.iter().copied());
        chosen.iter().filter(|(_, continues)| *continues).count()
    }

    /// The places that continue what the neighbours and the parent face's corners show.
    fn nearby(&self, v: u32, up_only: bool, nearby: &mut Nearby, places: &mut Vec<Place>) {
        let ground = self.levels.ground(self.level);
        let mut add = |found: Option<(Place, Between)>| {
            if let Some((place, between)) = found {
                places.push(place);
                nearby.between.push(between);
            }
        };
        if !up_only {
            for spoke in ground.fans.of(v).iter().filter(|s| s.turn.x > ALIGNED) {
                add(self.candidates.shifted(self.places[spoke.to as usize], spoke.back));
            }
        }
        if !self.coarser_places.is_empty() {
            let coarse = self.levels.ground(self.level + 1);
            let parent = self.levels.parents(self.level)[v as usize];
            let point = coarse.mesh.position(parent);
            for w in coarse.mesh.faces[parent.face as usize] {
                if ground.frames[v as usize].turn(&coarse.frames[w as usize]).x > ALIGNED {
                    add(self.candidates.finer(self.coarser_places[w as usize], from_corner(&coarse, w, point)));
                }
            }
        }
        nearby.ends.push(nearby.between.len() as u32);
    }
}
