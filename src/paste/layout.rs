//! The loop of pasting: draw seeds, lay pastes, update coverage, until nothing is uncovered (LT 3).
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, the overview of section 3.
//!
//! 1. Draw up to `BATCH` uncovered points far enough from each other that their pastes hardly meet, and a texture
//!    patch for each.
//! 2. Lay these pastes in parallel and find what each covers.
//! 3. Take them in, in the order drawn. Where two of a batch do meet, the later one's coverage is found again.
//!
//! The number of points in a batch never depends on the number of threads, so neither does the result. Every paste makes
//! its own seed opaque (alpha is 1 at the patch's centre, which lies on the seed), so the loop ends on every mesh.

use super::PasteError;
use super::coverage::{Lattice, Reach, Tile};
use super::coverage_backend::{CoverageDrawer, CoveredFace};
use super::grow::{PatchPlan, Predictor, Site, Stops};
use super::lapped::{AGREES, Paste};
use super::lay::{FitChoice, Laid, lay};
use super::order::{HardEdge, by_hard_edges, hard_edges, mask_pixels, permute};
use super::seed::WeightedDraw;
use super::statistics::Spread;
use super::stencil::Stencil;
use super::turn::Turn;
use crate::exemplar::{CoverageMask, TexturePatch};
use crate::field::Guide;
use crate::mesh::disc::Scratch;
use crate::mesh::{Mesh, SurfacePoint};
use crate::progress::Progress;
use crate::random::Random;
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;

/// Points drawn at a time: enough for many cores, few enough that early pastes still see most of each other.
const BATCH: usize = 32;

/// Draws tried for a batch, per point it may hold.
const DRAWS: usize = 3;

/// Two seeds of a batch are at least this share of the sum of their hulls' radii apart.
const APART: f64 = 0.9;

/// While less than this share of the surface is covered, difficult faces are favoured.
const EARLY: f64 = 0.25;

/// Then the most difficult of this many points drawn is taken.
const EARLY_DRAWS: usize = 4;

/// Steps of progress from nothing to everything covered.
const PROGRESS_PARTS: u64 = 1000;

/// Weights of faces are their areas in this many parts of the whole surface, times the uncovered share.
const AREA_PARTS: f64 = (1_u64 << 44) as f64;

/// What the loop works on.
#[derive(Clone, Copy)]
pub struct LayoutInput<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Field or scale.
    pub guide: &'a Guide,
    /// The texture patches.
    pub patches: &'a [TexturePatch],
    /// Their plans, in the same order.
    pub plans: &'a [PatchPlan],
    /// Their coverage masks, in the same order.
    pub masks: &'a [CoverageMask],
    /// Per face, the width of a coverage cell in world units.
    pub pitch: &'a [f32],
    /// Per face, 0 to 1: how hard a patch is to lay flat there.
    pub difficulty: &'a [f32],
    /// Distortion bound of growth; and of that of pastes that are free of the guide's direction.
    pub distortion: [f64; 2],
    /// How new vertices are placed.
    pub predictor: Predictor,
    /// How to fit.
    pub fit: FitChoice,
    /// Seed of all random choices.
    pub seed: u64,
    /// What draws coverage; `None`: the processor.
    pub drawer: Option<&'a dyn CoverageDrawer>,
}

/// Where a paste began: all that laying it again takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seeding {
    /// Its place in the order in which pastes were laid.
    pub laid: u32,
    /// Which texture patch.
    pub patch: u16,
    /// Where its centre went.
    pub at: SurfacePoint,
    /// The turn of the texture where the guide leaves it open, radians.
    pub angle: f64,
    /// Whether it is free of the guide's direction elsewhere than there.
    pub free: bool,
}

/// Pastes in the order laid, and what is known of each.
#[derive(Debug, Default)]
pub struct Layout {
    /// The pastes.
    pub pastes: Vec<Paste>,
    /// Where each began.
    pub seedings: Vec<Seeding>,
    /// Hard edges of each.
    pub edges: Vec<Vec<HardEdge>>,
    /// Totals over all pastes.
    pub totals: Totals,
}

/// Sums over all pastes laid.
#[derive(Debug, Clone, Default)]
pub struct Totals {
    /// Coverage samples on the whole surface.
    pub samples: u64,
    /// Faces of all surface patches as grown.
    pub grown_faces: u64,
    /// Conjugate gradient iterations.
    pub iterations: u64,
    /// Times a patch was grown again after a fit.
    pub regrowths: u64,
    /// Pastes whose own seed had to be marked by hand, because the texture patch is too thin to cover a whole cell.
    pub forced: u64,
    /// Pastes with a hard edge.
    pub pastes_with_hard_edges: u64,
    /// Why growth stopped inside the hull.
    pub stops: Stops,
    /// Deviations of all faces from the field, weighted by area.
    pub spread: Spread,
    /// Seconds of all threads together: growing and fitting, coverage.
    pub lay_seconds: f64,
    /// See above.
    pub cover_seconds: f64,
}

/// The state of the loop.
pub struct Loop<'a> {
    input: LayoutInput<'a>,
    tiles: Vec<Tile>,
    cells: Vec<u32>,
    area: Vec<f64>,
    whole: f64,
    draw: WeightedDraw,
    /// In which batch a face was last changed.
    changed: Vec<u32>,
    batch: u32,
    random: Random,
    scratch: Mutex<Vec<Scratch>>,
    layout: Layout,
}

/// A paste to lay.
#[derive(Debug, Clone, Copy)]
struct Order {
    patch: u16,
    seed: SurfacePoint,
    sample: Option<usize>,
    position: DVec3,
    reach: f64,
    angle: f64,
    free: bool,
}

impl Order {
    /// True if pastes laid at both hardly meet.
    fn clear_of(&self, other: &Self) -> bool {
        self.position.distance(other.position) > APART * (self.reach + other.reach)
    }
}

/// A paste laid, before it is taken in.
struct Candidate {
    paste: Paste,
    edges: Vec<HardEdge>,
    /// What the faces it reaches would become; none where something else draws coverage.
    tiles: Vec<Tile>,
    spread: Spread,
    grown_faces: usize,
    iterations: usize,
    regrowths: usize,
    stops: Stops,
    seconds: [f64; 2],
}

impl<'a> Loop<'a> {
    /// Nothing covered yet.
    #[must_use]
    pub fn new(input: LayoutInput<'a>) -> Self {
        let mesh = input.mesh;
        let cells: Vec<u32> = (0..mesh.face_count() as u32)
            .into_par_iter()
            .map(|f| Lattice::new(&mesh.corners(f), f64::from(input.pitch[f as usize])).cells() as u32)
            .collect();
        let area: Vec<f64> = (0..mesh.face_count() as u32).into_par_iter().map(|f| mesh.area(f)).collect();
        let whole = area.iter().sum();
        let weights = area.iter().map(|a| (a / whole * AREA_PARTS) as u64).map(|w| w.max(1)).collect();
        let totals = Totals { samples: cells.iter().map(|&c| u64::from(c)).sum(), ..Totals::default() };
        Self {
            input,
            tiles: vec![Tile::Bare; mesh.face_count()],
            draw: WeightedDraw::new(weights),
            changed: vec![0; mesh.face_count()],
            batch: 0,
            random: Random::new(input.seed, 0),
            scratch: Mutex::new(Vec::new()),
            layout: Layout { totals, ..Layout::default() },
            cells,
            area,
            whole,
        }
    }

    /// Draws and lays until everything is covered.
    ///
    /// # Errors
    /// If cancelled, or no paste can be laid at all.
    pub fn run(&mut self, progress: &dyn Progress) -> Result<(), PasteError> {
        progress.stage("pasting", PROGRESS_PARTS);
        while self.draw.total() > 0 {
            if progress.cancelled() {
                return Err(PasteError::Cancelled);
            }
            let orders = self.draw_batch();
            self.lay_batch(&orders)?;
            progress.done((self.covered() * PROGRESS_PARTS as f64) as u64);
        }
        Ok(())
    }

    /// Lays a paste at each of these points, one after the other.
    ///
    /// # Errors
    /// If no paste can be laid at one.
    pub fn patch_up(&mut self, points: &[SurfacePoint]) -> Result<(), PasteError> {
        for &seed in points {
            let order = self.order(seed, None, self.all());
            self.lay_batch(&[order])?;
        }
        Ok(())
    }

    /// Works on with more texture patches than before: these begin with those that it has.
    #[must_use]
    pub fn with<'b>(self, patches: &'b [TexturePatch], plans: &'b [PatchPlan], masks: &'b [CoverageMask]) -> Loop<'b>
    where
        'a: 'b,
    {
        let mut wider: Loop<'b> = self;
        wider.input = LayoutInput { patches, plans, masks, ..wider.input };
        wider
    }

    /// Lays a paste of the patches `among` at each of these points, if it and its hard edges are worth it. Those that a point and a patch
    /// are `free` for are laid free of the guide's direction, unless that is a whole basis. Points on faces that one of them reached, taken
    /// or not, are passed over. Returns how many were taken.
    ///
    /// # Errors
    /// If cancelled.
    pub fn lay_over(
        &mut self,
        points: &[SurfacePoint],
        among: &Range<usize>,
        free: &impl Fn(SurfacePoint, usize) -> bool,
        worth: &impl Fn(SurfacePoint, &Paste, &[HardEdge]) -> bool,
        progress: &dyn Progress,
    ) -> Result<usize, PasteError> {
        // A whole basis shears and stretches; only the field knows how.
        let may_be_free = self.input.guide.field().is_none_or(|field| field.right.is_none());
        let mut done = vec![false; self.input.mesh.face_count()];
        let mut left = points.iter().copied().peekable();
        let mut laid = 0;
        while left.peek().is_some() {
            if progress.cancelled() {
                return Err(PasteError::Cancelled);
            }
            let mut orders: Vec<Order> = Vec::new();
            while let Some(&seed) = left.peek().filter(|_| orders.len() < BATCH) {
                if done[seed.face as usize] {
                    left.next();
                    continue;
                }
                let mut order = self.order(seed, None, among.clone());
                order.free = may_be_free && free(seed, usize::from(order.patch));
                if !orders.iter().all(|o| o.clear_of(&order)) {
                    break;
                }
                left.next();
                orders.push(order);
            }
            self.batch += 1;
            let candidates: Vec<Option<Candidate>> = orders.par_iter().with_max_len(1).map(|o| self.candidate(o)).collect();
            let mut taken = Vec::new();
            for (order, candidate) in orders.into_iter().zip(candidates) {
                let Some(candidate) = candidate else { continue };
                candidate.paste.faces.iter().for_each(|&f| done[f as usize] = true);
                done[order.seed.face as usize] = true;
                if worth(order.seed, &candidate.paste, &candidate.edges) {
                    taken.push((order, candidate));
                }
            }
            laid += taken.len();
            for (order, candidate) in taken {
                self.take(&order, candidate);
            }
        }
        Ok(laid)
    }

    /// Puts the pastes with the longest hard edges to the bottom.
    pub fn sort_by_hard_edges(&mut self) {
        let order = by_hard_edges(&self.layout.edges);
        let Layout { pastes, seedings, edges, .. } = &mut self.layout;
        *pastes = permute(std::mem::take(pastes), &order);
        *seedings = permute(std::mem::take(seedings), &order);
        *edges = permute(std::mem::take(edges), &order);
    }

    /// What it works on.
    #[must_use]
    pub const fn input(&self) -> &LayoutInput<'a> {
        &self.input
    }

    /// Hard edges of the pastes so far.
    #[must_use]
    pub fn edges(&self) -> &[Vec<HardEdge>] {
        &self.layout.edges
    }

    /// Hands the result out.
    #[must_use]
    pub fn finish(self) -> Layout {
        self.layout
    }

    /// The pastes so far.
    #[must_use]
    pub fn pastes(&self) -> &[Paste] {
        &self.layout.pastes
    }

    /// Covered share of the surface.
    fn covered(&self) -> f64 {
        1.0 - (self.draw.total() as f64 / AREA_PARTS).min(1.0)
    }

    /// A face drawn by its uncovered area.
    fn draw_face(&mut self) -> Option<u32> {
        let draws = if self.covered() < EARLY { EARLY_DRAWS } else { 1 };
        let difficulty = |f: u32| self.input.difficulty[f as usize];
        let mut best = self.draw.draw(&mut self.random)?;
        for _ in 1..draws {
            let other = self.draw.draw(&mut self.random)?;
            if difficulty(other) > difficulty(best) {
                best = other;
            }
        }
        Some(best)
    }

    /// All texture patches.
    fn all(&self) -> Range<usize> {
        0..self.input.patches.len()
    }

    /// A paste of one of the patches `among`, which are some.
    fn order(&mut self, seed: SurfacePoint, sample: Option<usize>, among: Range<usize>) -> Order {
        let total: f64 = self.input.patches[among.clone()].iter().map(|p| f64::from(p.weight)).sum();
        let mut left = self.random.unit() * total;
        let mut patch = 0;
        for i in among {
            patch = i as u16;
            left -= f64::from(self.input.patches[i].weight);
            if left < 0.0 {
                break;
            }
        }
        let angle = self.random.range(0.0, std::f64::consts::TAU);
        let reach = self.input.plans[patch as usize].radius * f64::from(self.input.guide.scale(seed.face));
        Order { patch, seed, sample, position: self.input.mesh.position(seed), reach, angle, free: false }
    }

    fn draw_batch(&mut self) -> Vec<Order> {
        let mut orders: Vec<Order> = Vec::new();
        for _ in 0..BATCH * DRAWS {
            if orders.len() == BATCH {
                break;
            }
            let Some(face) = self.draw_face() else { break };
            let cells = self.cells[face as usize] as usize;
            let tile = &self.tiles[face as usize];
            let uncovered = tile.uncovered(|| cells);
            let n = self.random.below(uncovered as u64) as usize;
            let Some(sample) = tile.uncovered_sample(n) else { break };
            let bary = Lattice::new(&self.input.mesh.corners(face), self.pitch(face)).point(sample);
            let order = self.order(SurfacePoint { face, bary }, Some(sample), self.all());
            if orders.iter().all(|o| o.clear_of(&order)) {
                orders.push(order);
            }
        }
        orders
    }

    fn pitch(&self, face: u32) -> f64 {
        f64::from(self.input.pitch[face as usize])
    }

    fn lay_batch(&mut self, orders: &[Order]) -> Result<(), PasteError> {
        self.batch += 1;
        let candidates: Vec<Option<Candidate>> = orders.par_iter().with_max_len(1).map(|o| self.candidate(o)).collect();
        let named =
            |(order, candidate): (&Order, Option<Candidate>)| candidate.ok_or(PasteError::NoBasis { face: order.seed.face });
        let candidates = orders.iter().zip(candidates).map(named).collect::<Result<Vec<_>, _>>()?;
        if let Some(drawer) = self.input.drawer {
            self.draw_coverage(drawer, &candidates)?;
        }
        for (order, candidate) in orders.iter().zip(candidates) {
            self.take(order, candidate);
        }
        Ok(())
    }

    /// What the faces become under all pastes of a batch, drawn by a back-end.
    fn draw_coverage(&mut self, drawer: &dyn CoverageDrawer, candidates: &[Candidate]) -> Result<(), PasteError> {
        let begin = std::time::Instant::now();
        let mesh = self.input.mesh;
        let mut asked: BTreeMap<u32, CoveredFace> = BTreeMap::new();
        for Candidate { paste, .. } in candidates {
            let mask = &self.input.masks[paste.patch as usize];
            let size = self.input.patches[paste.patch as usize].mask.size();
            for (slot, &face) in paste.faces.iter().enumerate() {
                let f = face as usize;
                let pixels = mask_pixels(paste, slot as u32, size);
                let reach = Stencil::new(mask, None).reach_of_face(&pixels);
                if self.tiles[f] == Tile::Opaque || reach == Reach::None {
                    continue;
                }
                if reach == Reach::All {
                    self.tiles[f] = Tile::Opaque;
                    asked.remove(&face);
                    continue;
                }
                let lattice = Lattice::new(&mesh.corners(face), self.pitch(face));
                let so_far = || match &self.tiles[f] {
                    Tile::Partial(samples) => samples.to_vec(),
                    _ => vec![255; self.cells[f] as usize],
                };
                let asked = asked.entry(face).or_insert_with(|| CoveredFace::new(&lattice, so_far()));
                asked.lay(&lattice, u32::from(paste.patch), pixels);
            }
        }
        let (faces, asked): (Vec<u32>, Vec<CoveredFace>) = asked.into_iter().unzip();
        let drawn = drawer.cover(&asked).map_err(PasteError::Coverage)?;
        for (face, samples) in faces.into_iter().zip(drawn) {
            self.tiles[face as usize] = Tile::of_samples(samples);
        }
        self.layout.totals.cover_seconds += begin.elapsed().as_secs_f64();
        Ok(())
    }

    /// Lays one paste against the coverage as it was before the batch.
    fn candidate(&self, order: &Order) -> Option<Candidate> {
        let begin = std::time::Instant::now();
        let mesh = self.input.mesh;
        let mut scratch = self.scratch.lock().ok().and_then(|mut pool| pool.pop()).unwrap_or_else(|| Scratch::new(mesh));
        let plan = &self.input.plans[order.patch as usize];
        let mask = &self.input.masks[order.patch as usize];
        let site = Site {
            mesh,
            guide: self.input.guide,
            plan,
            seed: order.seed,
            distortion: self.input.distortion[usize::from(order.free)],
            predictor: self.input.predictor,
            free: order.free,
        };
        let laid = lay(site, order.angle, self.input.fit, &mut scratch);
        if let Ok(mut pool) = self.scratch.lock() {
            pool.push(scratch);
        }
        let laid = laid?;
        let lay_seconds = begin.elapsed().as_secs_f64();
        let (paste, place) = record(&laid, order.patch, plan, mask);
        let size = self.input.patches[order.patch as usize].mask.size();
        let pixels: Vec<_> = (0..paste.faces.len() as u32).map(|slot| mask_pixels(&paste, slot, size)).collect();
        let open: Vec<(usize, usize)> =
            laid.open.iter().filter_map(|&(i, edge)| place[i].map(|slot| (slot as usize, edge))).collect();
        let edges = hard_edges(mesh, mask, &paste.faces, &pixels, &open);
        let here = if self.input.drawer.is_none() { paste.faces.len() } else { 0 };
        let tiles = paste
            .faces
            .iter()
            .zip(&pixels)
            .take(here)
            .map(|(&face, &pixels)| {
                let mut tile = self.tiles[face as usize].clone();
                tile.cover(&Lattice::new(&mesh.corners(face), self.pitch(face)), &Stencil::new(mask, None), pixels);
                tile
            })
            .collect();
        let mut spread = Spread::default();
        for (i, deviation) in laid.deviations(mesh).enumerate() {
            if place[i].is_some() {
                spread.add(deviation);
            }
        }
        let cover_seconds = begin.elapsed().as_secs_f64() - lay_seconds;
        Some(Candidate {
            paste,
            edges,
            tiles,
            spread,
            grown_faces: laid.disc.faces.len(),
            iterations: laid.iterations,
            regrowths: laid.regrowths,
            stops: laid.stops,
            seconds: [lay_seconds, cover_seconds],
        })
    }

    /// Takes a paste in: its coverage, and its share of the totals.
    fn take(&mut self, order: &Order, candidate: Candidate) {
        let mesh = self.input.mesh;
        let size = self.input.patches[order.patch as usize].mask.size();
        let mut tiles = candidate.tiles.into_iter();
        for (slot, &face) in candidate.paste.faces.iter().enumerate() {
            let f = face as usize;
            let Some(tile) = tiles.next() else {
                self.reweigh(face);
                continue;
            };
            if self.changed[f] == self.batch {
                let lattice = Lattice::new(&mesh.corners(face), self.pitch(face));
                let pixels = mask_pixels(&candidate.paste, slot as u32, size);
                self.tiles[f].cover(&lattice, &Stencil::new(&self.input.masks[order.patch as usize], None), pixels);
            } else {
                self.tiles[f] = tile;
                self.changed[f] = self.batch;
            }
            self.reweigh(face);
        }
        if let Some(sample) = order.sample {
            let f = order.seed.face as usize;
            let cells = self.cells[f] as usize;
            let before = self.tiles[f].uncovered(|| cells);
            self.tiles[f].cover_sample(sample, cells);
            if self.tiles[f].uncovered(|| cells) < before {
                self.layout.totals.forced += 1;
                self.reweigh(order.seed.face);
            }
        }
        let totals = &mut self.layout.totals;
        totals.grown_faces += candidate.grown_faces as u64;
        totals.iterations += candidate.iterations as u64;
        totals.regrowths += candidate.regrowths as u64;
        totals.pastes_with_hard_edges += u64::from(!candidate.edges.is_empty());
        totals.stops.add(candidate.stops);
        totals.spread.merge(&candidate.spread);
        totals.lay_seconds += candidate.seconds[0];
        totals.cover_seconds += candidate.seconds[1];
        let laid = self.layout.pastes.len() as u32;
        self.layout.seedings.push(Seeding { laid, patch: order.patch, at: order.seed, angle: order.angle, free: order.free });
        self.layout.pastes.push(candidate.paste);
        self.layout.edges.push(candidate.edges);
    }

    /// Sets a face's chance to be drawn to its uncovered area.
    fn reweigh(&mut self, face: u32) {
        let f = face as usize;
        let uncovered = self.tiles[f].uncovered(|| self.cells[f] as usize);
        let share = uncovered as f64 / f64::from(self.cells[f]);
        let weight = (self.area[f] / self.whole * AREA_PARTS * share) as u64;
        self.draw.set(face, if uncovered == 0 { 0 } else { weight.max(1) });
    }
}

/// The paste of a laid patch: the faces that the mask reaches, and for each face of the disc its place among them.
pub(super) fn record(laid: &Laid, patch: u16, plan: &PatchPlan, mask: &CoverageMask) -> (Paste, Vec<Option<u32>>) {
    let mut paste =
        Paste { patch, faces: Vec::new(), uv: Vec::new(), offset: Vec2::ZERO, turn: Turn::NONE, cut: None, agreement: AGREES };
    let mut place = vec![None; laid.disc.faces.len()];
    for (i, &face) in laid.disc.faces.iter().enumerate() {
        let pixel = laid.disc.face_uv(i).map(|q| plan.mask_pixel(q));
        let middle = (pixel[0] + pixel[1] + pixel[2]) / 3.0;
        let radius = pixel.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        if mask.depth(middle.as_vec2()) > -(radius as f32) {
            place[i] = Some(paste.faces.len() as u32);
            paste.faces.push(face);
            paste.uv.push(laid.disc.face_uv(i).map(|q| plan.mask_uv(q).as_vec2()));
        }
    }
    (paste, place)
}
