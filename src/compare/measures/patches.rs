//! Nearest patches, both ways (Simakov et al. 2008).

use super::pieces::{Pieces, Room};
use crate::exemplar::Exemplar;
use crate::numeric::pca::Pca;
use crate::numeric::rows::{Exhaustive, Rows};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// Side of a patch, pixels.
pub(super) const PATCH: usize = 11;
/// Principal components of the exemplar's patches.
const KEPT: usize = 32;
/// One in so many patches is enough to find the components.
const FEW: usize = 4;
/// Patches of an exemplar that are known, on an even grid, and the least distance between them, pixels. With as many as pixels, but drawn at
/// random, a verbatim copy of bricks was nearly as far from its exemplar (worst hundredth 0.063) as a synthesis (0.073): between
/// pixels a patch differs from its neighbours by as much as a border does. On the grid the copy has 0.033.
const MOST: usize = 1 << 16;
const CLOSEST: f64 = 0.5;
/// So many are cut at a time.
const AT_A_TIME: usize = 1 << 12;
/// Patches cut from each piece, along each of its sides.
const ALONG: usize = 3;

/// The spread of some distances.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Their mean.
    pub mean: f64,
    /// 95 in a hundred are below this,
    pub p95: f64,
    /// and 99 below this.
    pub p99: f64,
}

/// The exemplar's patches, ready to be asked for the nearest.
#[derive(Debug)]
pub struct Known {
    pca: Arc<Pca>,
    search: Exhaustive,
}

impl Known {
    /// Finds principal components and lays the patches out. `None` without pieces.
    #[must_use]
    pub fn new(exemplar: &Pieces) -> Option<Self> {
        if exemplar.data.is_empty() {
            return None;
        }
        let all = patches(exemplar);
        let few: Vec<u32> = (0..all.len() as u32).step_by(FEW).collect();
        let pca = Arc::new(Pca::new(&all.select(&few), KEPT));
        let search = Exhaustive::new(pca.project_all(&all));
        Some(Self { pca, search })
    }

    /// All patches of an exemplar, from the part of its width between two shares. `None` if that is smaller than a patch.
    #[must_use]
    pub fn of_image(exemplar: &Exemplar, part: [f64; 2]) -> Option<Self> {
        let room = Room::new(exemplar, PATCH, part)?;
        let middles = room.grid(MOST, CLOSEST);
        let cut = |middles: &[[f64; 2]]| {
            let pieces: Vec<Vec<[f32; 3]>> = middles.par_iter().map(|&middle| room.piece(PATCH, middle)).collect();
            Pieces { side: PATCH, data: pieces }.middles(PATCH)
        };
        let few: Vec<[f64; 2]> = middles.iter().step_by(middles.len().div_ceil(AT_A_TIME)).copied().collect();
        let pca = Arc::new(Pca::new(&cut(&few), KEPT));
        let mut all = Rows::new(pca.kept());
        middles.chunks(AT_A_TIME).for_each(|middles| pca.project_all(&cut(middles)).iter().for_each(|row| all.push(row)));
        Some(Self { pca, search: Exhaustive::new(all) })
    }

    /// The distance of each patch asked, rows of [`Pieces::middles`], to the nearest; colour steps, root mean square over a patch.
    #[must_use]
    pub fn distances(&self, asked: &Rows) -> Vec<f64> {
        distances(&self.search, &self.pca.project_all(asked), asked.dims())
    }
}

/// Distances from each patch of the result to the nearest of the exemplar, and the other way round, in colour steps (root mean
/// square over a patch). `known` holds the exemplar's patches.
#[must_use]
pub(super) fn coherence_to(result: &Pieces, exemplar: &Pieces, known: &Known) -> (Spread, Spread) {
    if result.data.is_empty() {
        return (NOTHING, NOTHING);
    }
    // The middle of each result piece is asked; whatever lies anywhere in the exemplar's pieces may answer.
    let there = spread(known.distances(&result.middles(PATCH)));
    let asked = exemplar.middles(PATCH);
    let found = Exhaustive::new(known.pca.project_all(&patches(result)));
    let back = spread(distances(&found, &known.pca.project_all(&asked), asked.dims()));
    (there, back)
}

/// The same for an exemplar that is asked once.
#[must_use]
pub fn coherence(result: &Pieces, exemplar: &Pieces) -> (Spread, Spread) {
    Known::new(exemplar).map_or((NOTHING, NOTHING), |known| coherence_to(result, exemplar, &known))
}

const NOTHING: Spread = Spread { mean: f64::NAN, p95: f64::NAN, p99: f64::NAN };

/// Patches all over the pieces.
fn patches(pieces: &Pieces) -> Rows {
    let mut out = Rows::new(3 * PATCH * PATCH);
    let room = pieces.side.saturating_sub(PATCH);
    for piece in &pieces.data {
        for k in 0..ALONG * ALONG {
            let [x, y] = [k % ALONG, k / ALONG].map(|i| i * room / (ALONG - 1));
            let rows = (y..y + PATCH).flat_map(|r| &piece[r * pieces.side + x..][..PATCH]);
            out.push(&rows.copied().collect::<Vec<_>>().concat());
        }
    }
    out
}

fn distances(search: &Exhaustive, asked: &Rows, dims: usize) -> Vec<f64> {
    let indices: Vec<u32> = (0..asked.len() as u32).collect();
    indices
        .par_chunks(64)
        .flat_map_iter(|chunk| search.nearest(&asked.select(chunk)))
        .map(|near| (near.squared / dims as f64).sqrt())
        .collect()
}

fn spread(mut found: Vec<f64>) -> Spread {
    found.sort_by(f64::total_cmp);
    let at = |share: f64| found[((found.len() - 1) as f64 * share).round() as usize];
    Spread { mean: found.iter().sum::<f64>() / found.len() as f64, p95: at(0.95), p99: at(0.99) }
}
