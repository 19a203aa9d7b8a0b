//! Seams: where the border of each paste runs through what lies below it.
//!
//! A paste overlaps others for a good part of its size, and shows nothing there that they could not show. So its border may run
//! anywhere through the overlap: along the joints between bricks, around stones, wherever the two agree.
//!
//! Based on: the minimum error boundary cut of Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH
//! 2001, section 2.1; here closed around the middle of a patch, on a surface.
//!
//! 1. Pastes take their turn from the bottom up, those that share no face in parallel: what lies below is final.
//! 2. A paste is compared with what lies below it on a grid over its mask, a few dozen cells a side. Cells that are not covered below
//!    must stay inside.
//! 3. What a border would show at a cell is the mean difference around it, not that of the cell alone: two textures that agree on a line and
//!    nowhere beside it meet in a seam there. (The paper takes the line's.)
//! 4. On each of the ways out of the middle ([`Cut`]) a border may lie at a few distances, from where the outermost such
//!    cell ends to where the mask does. Dynamic programming finds the closed path of least difference through them (`path.rs`).
//! 5. Where growth stopped inside the mask a paste ends in a hard edge. A border that leaves it to show pays for the step there, and
//!    for more than a soft one; so a paste with hard edges is cut before them, softly, wherever something lies below. A border that
//!    would uncover a hard edge of another paste pays as well (`hard.rs`).
//! 6. A path that is not clearly better than the mask's own border is given up.
//! 7. Where coverage finds a hole all the same, cuts are taken back ([`see_without_holes`]).
//!
//! Colours and all other channels count as [`crate::exemplar::stack`] weighs them. Only patches whose content may slide are cut:
//! other masks follow the exemplar.

mod agree;
mod hard;
mod mend;
mod path;

pub use agree::{ContrastStatistics, choose_agreements};
pub use mend::see_without_holes;

use super::composite::{exemplar_pixel, paste_alpha};
use super::cut::{CUT_STEPS, Cut};
use super::lapped::{FaceLists, LappedTexture};
use super::levels::Level;
use super::order::{EdgesByFace, HardEdge, shown_edges};
use super::stencil::Stencil;
use super::waves::{LEAST_FACES, waves};
use crate::exemplar::{ChannelSet, CoverageMask, Exemplar, TexturePatch};
use crate::mesh::Mesh;
use glam::{Vec2, Vec3};
use path::shortest;
use rayon::prelude::*;
use serde::Serialize;

/// Cells of the grid along a mask: two from way to way along its edge. More see nothing that a path could follow; the time is their square.
const GRID: usize = 64;
/// Longest side of the level of the exemplar that is compared: a pixel a cell or so.
const LEVEL_SIDE: u32 = 128;
/// How deep inside the edge of the mask borders may run, 1 being its middle.
const DEPTH: f32 = 0.8;
/// Distances that are tried on each way.
const RINGS: usize = 56;
/// The first of them for pastes without a hard edge: others overlap them by about the rest.
const SHALLOW: usize = 28;
/// How many cells around its own count for what a border there shows, each way: where both sides agree on a single line alone, that line is
/// a seam in what lies around it. With these coherence is 4 % better, on the mean and in its worst hundredth.
const AROUND: usize = 2;
/// How many rings a path may climb from one way to the next: at 8 it may run at 61 degrees to the mask's edge.
const CLIMB: usize = 8;
/// Length of a step outwards by one ring, as a share of one from way to way.
const RISE: f32 = (DEPTH / RINGS as f32) / (8.0 / CUT_STEPS as f32);
/// What a path costs where both sides agree: a difference of 32 of 255. A path that wanders for less cuts through more of what lies beside it
/// than it goes around. While cells alone counted, 4 of 255 drew a twentieth more, with three quarters more of steps that the exemplar hardly
/// has; since what lies [`AROUND`] counts, anything from 16 to 32 does as well.
const FLOOR: f32 = 0.016;
/// How much a place counts that pastes above hide: they may be cut there.
const HIDDEN: f32 = 0.1;
/// How much more a step without a feather shows than one with it.
const HARD: f32 = 4.0;
/// Cells whose alpha below, at its least within [`NEAR`], is less are not covered.
const COVERED: f32 = 0.997;
/// Radius of that, pixels of the mask below: as far as coverage looks around a sample.
const NEAR: f32 = 1.5;
/// Borders keep so many cells away from those that are not covered: half a cell, half the width over which alpha falls, and
/// what coverage looks around itself.
const MARGIN: f32 = 2.0;
/// A path must cost less than this share of what the mask's own border costs.
const WORTH: f32 = 0.9;
/// Width over which alpha falls along a cut, 1 being half a mask, and at least so many pixels: the usual feather.
const SOFT: f32 = 0.03;
const SOFT_PIXELS: f32 = 3.0;

/// What [`choose_cuts`] did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CutStatistics {
    /// Pastes with a cut.
    pub cut: usize,
    /// Pastes whose cuts were taken back, because coverage would have had holes.
    pub given_up: usize,
    /// Root mean square difference around visible borders, in steps of encoded colour (0 to 1), with all borders where masks end.
    pub border_before: f64,
    /// The same with the cuts.
    pub border_after: f64,
    /// Seconds.
    pub seconds: f64,
}

/// What all pastes of a patch share.
struct Plan {
    /// Alpha at the middle of each cell.
    alpha: Vec<f32>,
    /// For each way, the first ring that lies outside the mask's border.
    end: [usize; CUT_STEPS],
    /// The cell at each ring of each way.
    cell: Vec<u32>,
    soft: f32,
}

impl Plan {
    fn new(patch: &TexturePatch) -> Self {
        let size = Vec2::from(patch.mask.size().map(|s| s as f32));
        let image = patch.mask.finest();
        let at = |uv: Vec2| image.bilinear(uv * size).x;
        let middle = |i: usize| (Vec2::new((i % GRID) as f32, (i / GRID) as f32) + 0.5) / GRID as f32;
        let alpha = (0..GRID * GRID).map(|i| at(middle(i))).collect();
        let outside = |way: usize| {
            // From the edge inwards, so that dents of the outline do not end it.
            let inside = (0..RINGS).rev().find(|&ring| at(Cut::point(way, distance(ring))) >= 0.5);
            inside.map_or(0, |ring| ring + 1)
        };
        let end = std::array::from_fn(outside);
        let on_border = |way: usize, ring: usize| cell_of(Cut::point(way, distance(ring.min(end[way].saturating_sub(1)))));
        let cell = (0..CUT_STEPS).flat_map(|way| (0..RINGS).map(move |ring| on_border(way, ring))).collect();
        Self { alpha, end, cell, soft: SOFT.max(SOFT_PIXELS * 2.0 / size.max_element()) }
    }
}

/// Distance of a ring from the middle of the mask.
fn distance(ring: usize) -> f32 {
    1.0 - DEPTH * (1.0 - (ring as f32 + 0.5) / RINGS as f32)
}

fn cell_of(uv: Vec2) -> u32 {
    let cell = (uv * GRID as f32).clamp(Vec2::ZERO, Vec2::splat(GRID as f32 - 1.0));
    cell.y as u32 * GRID as u32 + cell.x as u32
}

/// The middles of the cells on a face whose corners lie there over the mask, and where on the face each lies.
fn cells(corners: &[Vec2; 3]) -> impl Iterator<Item = (Vec2, Vec3)> {
    let side = GRID as f32;
    let [a, b, c] = corners.map(|p| p * side);
    let low = (a.min(b).min(c) - 0.5).ceil().max(Vec2::ZERO);
    let high = (a.max(b).max(c) - 0.5).floor().min(Vec2::splat(side - 1.0));
    let turn = (b - a).perp_dot(c - a);
    let on_face = move |x: usize, y: usize| {
        let p = Vec2::new(x as f32, y as f32) + 0.5;
        let bary = Vec3::new((c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)) / turn;
        (bary.min_element() >= 0.0).then_some((p / side, bary))
    };
    // A face that shows nothing has no cells; neither has one whose bounds are not numbers.
    let rows = if turn != 0.0 && low.cmple(high).all() { low.y as usize..high.y as usize + 1 } else { 0..0 };
    rows.flat_map(move |y| (low.x as usize..=high.x as usize).filter_map(move |x| on_face(x, y)))
}

/// A paste against what lies below it, cell by cell.
struct Comparison {
    /// Squared difference times what the pastes above let through; and that share.
    error: Vec<[f32; 2]>,
    /// The same of the mean squared difference of the cells around each.
    around: Vec<f32>,
    /// Per way, the least distance of a border from the middle.
    least: [f32; CUT_STEPS],
    /// The first ring where a border may lie.
    first: usize,
    /// Per way and ring, the same as `error` for the hard edges that a border there lets show. Empty if there are none.
    hard: Vec<[[f32; 2]; RINGS]>,
}

/// The cut of a paste, if it is worth one, and the sums of its border.
#[derive(Default)]
struct Found {
    cut: Option<Box<Cut>>,
    sums: [f64; 3],
}

struct Matcher<'a> {
    lapped: &'a LappedTexture,
    lists: FaceLists,
    levels: Vec<Level>,
    masks: &'a [CoverageMask],
    /// Hard edges of each paste that show while nothing is cut.
    shown: Vec<Vec<HardEdge>>,
    hidden: EdgesByFace,
}

/// Cuts all pastes, once their windows are chosen. Exemplars that tile must say so by their `wrap`; `edges` are the hard edges of each
/// paste.
pub fn choose_cuts(mesh: &Mesh, lapped: &mut LappedTexture, masks: &[CoverageMask], edges: &[Vec<HardEdge>]) -> CutStatistics {
    let face_count = mesh.face_count();
    let begin = std::time::Instant::now();
    let matcher = Matcher::new(mesh, lapped, masks, edges);
    let plans: Vec<Option<Plan>> = matcher.lapped.patches.par_iter().map(|p| p.slides.then(|| Plan::new(p))).collect();
    let order: Vec<u32> = (0..matcher.lapped.pastes.len() as u32).collect();
    let mut cuts: Vec<Option<Box<Cut>>> = vec![None; order.len()];
    let mut statistics = CutStatistics::default();
    let mut sums = [0.0_f64; 3];
    for wave in waves(face_count, &matcher.lapped.pastes, &order) {
        let found: Vec<Found> = wave.par_iter().map(|&k| matcher.cut(k, plans[matcher.patch_of(k)].as_ref(), &cuts)).collect();
        for (&k, found) in wave.iter().zip(found) {
            statistics.cut += usize::from(found.cut.is_some());
            cuts[k as usize] = found.cut;
            sums = std::array::from_fn(|i| sums[i] + found.sums[i]);
        }
    }
    lapped.pastes.iter_mut().zip(cuts).for_each(|(paste, cut)| paste.cut = cut);
    let rms = |sum: f64| if sums[0] > 0.0 { (sum / sums[0]).sqrt() } else { 0.0 };
    (statistics.border_before, statistics.border_after) = (rms(sums[1]), rms(sums[2]));
    statistics.seconds = begin.elapsed().as_secs_f64();
    statistics
}

impl<'a> Matcher<'a> {
    fn new(mesh: &Mesh, lapped: &'a LappedTexture, masks: &'a [CoverageMask], edges: &[Vec<HardEdge>]) -> Self {
        let channels = lapped.exemplars.iter().map(Exemplar::channels).reduce(ChannelSet::intersection).unwrap_or_default();
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
        Self {
            shown: shown_edges(mesh, lapped, &lists, edges),
            hidden: EdgesByFace::new(edges),
            lists,
            levels: lapped.exemplars.iter().map(|e| Level::of_side(e, channels, LEVEL_SIDE)).collect(),
            masks,
            lapped,
        }
    }

    fn patch_of(&self, paste: u32) -> usize {
        usize::from(self.lapped.pastes[paste as usize].patch)
    }

    /// The cut of one paste.
    fn cut(&self, k: u32, plan: Option<&Plan>, cuts: &[Option<Box<Cut>>]) -> Found {
        let Some((plan, compared)) = plan.and_then(|plan| Some((plan, self.compare(k, plan, cuts)?))) else {
            return Found::default();
        };
        let path = shortest(plan, &compared);
        let [weight, before, _] = path.sums;
        if path.price[1] >= f64::from(WORTH) * path.price[0] {
            return Found { cut: None, sums: [weight, before, before] };
        }
        let step = |way: usize| {
            let ring = path.rings[way];
            (ring + 1 < plan.end[way]).then_some([distance(ring), plan.soft])
        };
        Found { cut: Some(Box::new(Cut::new(step))), sums: path.sums }
    }

    /// Compares a paste with what lies below. `None` if nothing does.
    fn compare(&self, k: u32, plan: &Plan, cuts: &[Option<Box<Cut>>]) -> Option<Comparison> {
        let paste = &self.lapped.pastes[k as usize];
        let first = if self.shown[k as usize].is_empty() { SHALLOW } else { 0 };
        let mut compared =
            Comparison { error: vec![[0.0; 2]; GRID * GRID], around: Vec::new(), least: [0.0; CUT_STEPS], first, hard: Vec::new() };
        let mut any = false;
        let deepest = distance(first) - 4.0 / GRID as f32;
        let on_face = |below: &mut Vec<f32>, (&face, uv): (&u32, &[Vec2; 3])| {
            let list = self.lists.of(face);
            let own = list.partition_point(|&(paste, _)| paste < k);
            let on_cell = |(at, bary)| {
                let (cell, place) = (cell_of(at), Cut::place(at));
                if plan.alpha[cell as usize] <= 0.0 || place.1 < deepest {
                    return None;
                }
                let [covered, least] = self.below(&list[..own], bary, cuts, below);
                if least < COVERED {
                    return Some((cell, place, None));
                }
                let weight = self.seen(list, own, bary);
                Some((cell, place, Some([weight * self.difference(list[own], bary, covered, below), weight])))
            };
            cells(uv).filter_map(on_cell).collect()
        };
        let faces = paste.faces.par_iter().zip(&paste.uv).with_min_len(LEAST_FACES);
        let found: Vec<Vec<_>> = faces.map_init(Vec::new, on_face).collect();
        for (cell, place, error) in found.into_iter().flatten() {
            match error {
                None => compared.keep_inside(place),
                Some(error) => (any, compared.error[cell as usize]) = (true, error),
            }
        }
        if any {
            compared.look_around();
            self.add_hard_edges(k, plan, cuts, &mut compared);
        }
        any.then_some(compared)
    }

    /// How much a point counts for the paste at a place of its face's list: what the pastes above, not cut yet, let through.
    fn seen(&self, list: &[(u32, u32)], own: usize, bary: Vec3) -> f32 {
        let above =
            |&(paste, slot): &(u32, u32)| 1.0 - paste_alpha(&self.lapped.patches, &self.lapped.pastes[paste as usize], slot, bary);
        list[own + 1..].iter().map(above).product::<f32>().max(HIDDEN)
    }

    /// Squared difference of what a paste shows at a point from what lies below it.
    fn difference(&self, entry: (u32, u32), bary: Vec3, covered: f32, below: &[f32]) -> f32 {
        let shown = self.shown(entry.0, entry.1, bary);
        shown.iter().zip(below).map(|(a, b)| (a - b / covered) * (a - b / covered)).sum()
    }

    /// Adds up what the pastes of a list show; returns their alpha together, there and at its least near there.
    fn below(&self, list: &[(u32, u32)], bary: Vec3, cuts: &[Option<Box<Cut>>], to: &mut Vec<f32>) -> [f32; 2] {
        to.clear();
        let mut clear = [1.0; 2];
        for &(number, slot) in list.iter().rev() {
            let paste = &self.lapped.pastes[number as usize];
            let cut = cuts[number as usize].as_deref();
            let mask = &self.masks[paste.patch as usize];
            let [a, b, c] = paste.uv[slot as usize];
            let uv = a * bary.x + b * bary.y + c * bary.z;
            let pixel = uv * Vec2::from(mask.size().map(|s| s as f32));
            let alpha = mask.alpha(pixel) * cut.map_or(1.0, |cut| cut.alpha(uv, 0.0));
            if alpha <= 0.0 {
                continue;
            }
            let share = clear[0] * alpha;
            let shown = self.shown(number, slot, bary);
            to.resize(shown.len(), 0.0);
            to.iter_mut().zip(shown).for_each(|(sum, v)| *sum += share * v);
            let least = f32::from(Stencil::new(mask, cut).eroded_alpha(pixel, NEAR)) / 254.0;
            clear = [clear[0] - share, clear[1] * (1.0 - least.min(1.0))];
            if clear[1] < 1.0 - COVERED {
                break;
            }
        }
        clear.map(|clear| 1.0 - clear)
    }

    /// What a paste shows at a point.
    fn shown(&self, number: u32, slot: u32, bary: Vec3) -> &[f32] {
        let paste = &self.lapped.pastes[number as usize];
        let patch = &self.lapped.patches[paste.patch as usize];
        let [a, b, c] = paste.uv[slot as usize];
        let uv = a * bary.x + b * bary.y + c * bary.z;
        let pixel = uv * Vec2::from(patch.mask.size().map(|s| s as f32));
        let level = &self.levels[patch.exemplar as usize];
        level.at(level.cell(exemplar_pixel(patch, paste, pixel)))
    }
}

impl Comparison {
    /// Finds `around`: sums of squares of cells with a difference, along rows and then along columns.
    fn look_around(&mut self) {
        let known = |&[error, weight]: &[f32; 2]| if weight > 0.0 { [error / weight, 1.0] } else { [0.0; 2] };
        let mut sums: Vec<[f32; 2]> = self.error.iter().map(known).collect();
        let mut before = [[0.0; 2]; GRID];
        for line in 0..2 * GRID {
            let (start, step) = if line < GRID { (line * GRID, 1) } else { (line - GRID, GRID) };
            before.iter_mut().enumerate().for_each(|(i, b)| *b = sums[start + i * step]);
            for i in 0..GRID {
                let near = &before[i.saturating_sub(AROUND)..(i + AROUND + 1).min(GRID)];
                sums[start + i * step] = near.iter().fold([0.0; 2], |sum, b| [sum[0] + b[0], sum[1] + b[1]]);
            }
        }
        let mean = |(own, [sum, count]): (&[f32; 2], [f32; 2])| if own[1] > 0.0 { own[1] * sum / count } else { 0.0 };
        self.around = self.error.iter().zip(sums).map(mean).collect();
    }

    /// What lies there is covered by nobody else.
    fn keep_inside(&mut self, (way, at): (usize, f32)) {
        let margin = MARGIN * 2.0 / GRID as f32;
        // A cell and its margin span so many ways.
        let aside = (CUT_STEPS as f32 / 8.0 * margin / at.max(margin)).ceil() as usize;
        for way in way + CUT_STEPS - aside..=way + CUT_STEPS + aside {
            let least = &mut self.least[way % CUT_STEPS];
            *least = least.max(at + margin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn around_a_cell_the_cells_that_were_compared_count_alike() {
        let mut random = Random::new(6, 0);
        let cell = |_| if random.unit() < 0.7 { [random.unit() as f32, random.range(0.1, 1.0) as f32] } else { [0.0; 2] };
        let error: Vec<[f32; 2]> = (0..GRID * GRID).map(cell).collect();
        let mut compared =
            Comparison { error: error.clone(), around: Vec::new(), least: [0.0; CUT_STEPS], first: 0, hard: Vec::new() };
        compared.look_around();
        for (i, own) in error.iter().enumerate() {
            let (x, y) = (i % GRID, i / GRID);
            let near = |t: usize| t.saturating_sub(AROUND)..(t + AROUND + 1).min(GRID);
            let all: Vec<f32> = near(y)
                .flat_map(|y| near(x).map(move |x| y * GRID + x))
                .filter(|&j| error[j][1] > 0.0)
                .map(|j| error[j][0] / error[j][1])
                .collect();
            let mean = if own[1] > 0.0 { own[1] * all.iter().sum::<f32>() / all.len() as f32 } else { 0.0 };
            assert!((compared.around[i] - mean).abs() < 1e-4 * (1.0 + mean), "cell {x}, {y}: {} for {mean}", compared.around[i]);
        }
    }
}
