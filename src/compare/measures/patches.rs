//! Nearest patches, both ways (Simakov et al. 2008).

use super::pieces::Pieces;
use crate::numeric::pca::Pca;
use crate::numeric::rows::{Exhaustive, Rows};
use rayon::prelude::*;
use serde::Serialize;

/// Side of a patch, pixels.
const PATCH: usize = 11;
/// Principal components of the exemplar's patches.
const KEPT: usize = 32;
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

/// Distances from each patch of the result to the nearest of the exemplar, and the other way round, in colour steps (root mean
/// square over a patch).
#[must_use]
pub fn coherence(result: &Pieces, exemplar: &Pieces) -> (Spread, Spread) {
    if result.data.is_empty() || exemplar.data.is_empty() {
        return (NOTHING, NOTHING);
    }
    // The middle of each result piece is asked; whatever lies anywhere in the exemplar's pieces may answer.
    let asked = result.middles(PATCH);
    let all = patches(exemplar);
    let pca = Pca::new(&all, KEPT);
    let there = spread(&pca.project_all(&all), &pca.project_all(&asked), asked.dims());
    let asked = exemplar.middles(PATCH);
    let back = spread(&pca.project_all(&patches(result)), &pca.project_all(&asked), asked.dims());
    (there, back)
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

fn spread(of: &Rows, asked: &Rows, dims: usize) -> Spread {
    let search = Exhaustive::new(of.clone());
    let indices: Vec<u32> = (0..asked.len() as u32).collect();
    let mut found: Vec<f64> = indices
        .par_chunks(64)
        .flat_map_iter(|chunk| search.nearest(&asked.select(chunk)))
        .map(|near| (near.squared / dims as f64).sqrt())
        .collect();
    found.sort_by(f64::total_cmp);
    let at = |share: f64| found[((found.len() - 1) as f64 * share).round() as usize];
    Spread { mean: found.iter().sum::<f64>() / found.len() as f64, p95: at(0.95), p99: at(0.99) }
}
