//! How much detail there is, and how much of it comes again.

use super::pieces::Pieces;
use rayon::prelude::*;

/// Pieces this far apart, pixels, may look alike for no good reason.
const FAR: i64 = 40;
/// Pixels of overlap along each side, at least, for a shift to count.
const OVERLAP: i64 = 48;
/// Steps of the shifts, and of the pixels compared at each.
const STEP: usize = 2;

/// Mean lightness of a pixel's encoded components, which is near enough.
fn grey(pixel: &[f32; 3]) -> f64 {
    f64::from(pixel[0] + pixel[1] + pixel[2]) / 3.0
}

/// The mean square of the Laplacian.
#[must_use]
pub fn laplacian_energy(pieces: &Pieces) -> f64 {
    let side = pieces.side;
    let (mut sum, mut count) = (0.0, 0.0);
    for piece in &pieces.data {
        for y in 1..side.saturating_sub(1) {
            for x in 1..side - 1 {
                let at = |x: usize, y: usize| grey(&piece[y * side + x]);
                let l = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1) - 4.0 * at(x, y);
                sum += l * l;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The largest correlation of a piece with itself, shifted by more than 40 pixels; the mean over the pieces.
#[must_use]
pub fn repetition(pieces: &Pieces) -> f64 {
    let side = pieces.side as i64;
    let reach = side - OVERLAP;
    if pieces.data.is_empty() || reach <= FAR {
        return 0.0;
    }
    let one = |piece: &Vec<[f32; 3]>| {
        let grey: Vec<f64> = piece.iter().map(grey).collect();
        let mut best = 0.0_f64;
        for dy in (0..=reach).step_by(STEP) {
            for dx in (-reach..=reach).step_by(STEP) {
                if dx * dx + dy * dy >= FAR * FAR {
                    best = best.max(correlation(&grey, side, dx, dy));
                }
            }
        }
        best
    };
    let all: Vec<f64> = pieces.data.par_iter().map(one).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

/// The correlation coefficient of a square with itself, shifted; every other pixel of every other row counts.
fn correlation(grey: &[f64], side: i64, dx: i64, dy: i64) -> f64 {
    let (mut n, mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for y in (0..side - dy).step_by(STEP) {
        for x in ((-dx).max(0)..side.min(side - dx)).step_by(STEP) {
            let (p, q) = (grey[(y * side + x) as usize], grey[((y + dy) * side + x + dx) as usize]);
            (n, a, b, aa, bb, ab) = (n + 1.0, a + p, b + q, aa + p * p, bb + q * q, ab + p * q);
        }
    }
    let (va, vb) = (aa - a * a / n, bb - b * b / n);
    if va > 1e-9 * n && vb > 1e-9 * n { (ab - a * b / n) / (va * vb).sqrt() } else { 0.0 }
}
