//! Alpha masks: from the depth below an outline to a small grey image.
//!
//! 1. Alpha rises from 0 at the outline to 1 at the feather's depth, by the smooth step `3 t^2 - 2 t^3`.
//! 2. It is rounded to 8 bits, as files and renderers hold it, so that all of them agree to the last bit.
//! 3. The largest piece of what has alpha is kept (pixels that touch by a corner hang together, as bilinear filtering
//!    sees it) and cut out with a margin of transparent pixels.
//!
//! The mip levels with their transparent borders (LT 4) come from [`MipChain::mask`](super::MipChain::mask).

pub use super::coverage_mask::{CoverageMask, ERODED_RADII};

use super::Image;
use super::distance::squared_distance;
use glam::{IVec2, Vec2};

/// Alpha from which a point counts as opaque.
pub const OPAQUE: f32 = 254.0 / 255.0;
/// Transparent pixels around what has alpha.
const MARGIN: usize = 1;

/// Alpha at a depth below the outline, both in pixels: the smooth step from 0 at the outline to 1 at `feather`.
#[must_use]
pub fn feather_alpha(depth: f32, feather: f32) -> f32 {
    let t = (depth / feather.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A mask cut out of a larger image.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CutOut {
    pub(super) mask: Image,
    /// Top left corner in the larger image.
    pub(super) origin: IVec2,
    /// Smaller pieces that were left out, and their share of all alpha.
    pub(super) dropped: (usize, f32),
}

/// Rounds alpha (rows of `width`) to 8 bits, keeps the largest piece and cuts it out. `None` if nothing is left.
pub(super) fn cut_out(alpha: &[f32], width: usize) -> Option<CutOut> {
    let bytes: Vec<u8> = alpha.iter().map(|&a| (a * 255.0 + 0.5) as u8).collect();
    let pieces = Pieces::new(&bytes, width);
    let total: u64 = pieces.alpha.iter().sum();
    let keep = (0..pieces.alpha.len()).rev().max_by_key(|&i| pieces.alpha[i])?;
    let kept: Vec<&Run> = pieces.runs.iter().filter(|run| run.piece == keep).collect();
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for run in &kept {
        (low, high) = ([low[0].min(run.from), low[1].min(run.y)], [high[0].max(run.to), high[1].max(run.y + 1)]);
    }
    let [mask_width, mask_height] = [0, 1].map(|i| high[i] - low[i] + 2 * MARGIN);
    let mut data = vec![0.0; mask_width * mask_height];
    for run in kept {
        let source = &bytes[run.y * width + run.from..run.y * width + run.to];
        let first = (run.y - low[1] + MARGIN) * mask_width + run.from - low[0] + MARGIN;
        for (alpha, &byte) in data[first..].iter_mut().zip(source) {
            *alpha = f32::from(byte) / 255.0;
        }
    }
    let mask = Image::new(mask_width as u32, mask_height as u32, 1, data)?;
    let origin = IVec2::new(low[0] as i32, low[1] as i32) - MARGIN as i32;
    let share = 1.0 - pieces.alpha[keep] as f32 / total as f32;
    Some(CutOut { mask, origin, dropped: (pieces.alpha.len() - 1, share) })
}

/// Neighbouring pixels with alpha in row `y`, from column `from` to before column `to`.
struct Run {
    y: usize,
    from: usize,
    to: usize,
    piece: usize,
}

/// Connected pieces of what has alpha, as runs from the top row down.
struct Pieces {
    runs: Vec<Run>,
    /// Per piece: sum of alpha in 8 bits.
    alpha: Vec<u64>,
}

impl Pieces {
    /// Labels by runs and a union-find over them.
    fn new(bytes: &[u8], width: usize) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        let mut parent: Vec<usize> = Vec::new();
        let mut above = 0..0;
        for (y, row) in bytes.chunks_exact(width).enumerate() {
            let first = runs.len();
            let mut x = 0;
            while let Some(from) = row[x..].iter().position(|&b| b > 0).map(|skip| x + skip) {
                let to = row[from..].iter().position(|&b| b == 0).map_or(width, |length| from + length);
                let this = runs.len();
                parent.push(this);
                // Corner contact counts, so runs above may end or begin one pixel beside.
                while above.start < above.end && runs[above.start].to < from {
                    above.start += 1;
                }
                for other in above.clone().take_while(|&i| runs[i].from <= to) {
                    let (a, b) = (root(&mut parent, other), root(&mut parent, this));
                    parent[a.max(b)] = a.min(b);
                }
                runs.push(Run { y, from, to, piece: 0 });
                x = to;
            }
            above = first..runs.len();
        }
        let mut alpha = Vec::new();
        let mut piece_of = vec![0; runs.len()];
        for (i, run) in runs.iter_mut().enumerate() {
            let top = root(&mut parent, i);
            if top == i {
                piece_of[i] = alpha.len();
                alpha.push(0);
            }
            run.piece = piece_of[top];
            let row = &bytes[run.y * width + run.from..run.y * width + run.to];
            alpha[run.piece] += row.iter().map(|&b| u64::from(b)).sum::<u64>();
        }
        Self { runs, alpha }
    }
}

/// The first run of a piece; paths are halved on the way.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// The deepest point of what is `inside` (rows of `width`): the pixel centre farthest from all that is not, and its distance
/// from the nearest pixel centre that is not; what lies beyond the image counts as not inside. Of equally deep ones the
/// nearest to the centroid, of these the first. `None` if nothing is inside.
pub(super) fn deepest(inside: &[bool], width: usize) -> Option<(Vec2, f32)> {
    let height = inside.len().checked_div(width)?;
    let padded = width + 2;
    let mut outside = vec![true; padded * (height + 2)];
    for (y, row) in inside.chunks_exact(width).enumerate() {
        for (x, &inside) in row.iter().enumerate() {
            outside[(y + 1) * padded + x + 1] = !inside;
        }
    }
    let squared = squared_distance(&outside, padded);
    let most = squared.iter().copied().fold(0.0, f32::max);
    let centre = |i: usize| Vec2::new((i % padded) as f32 - 0.5, (i / padded) as f32 - 0.5);
    let count = outside.iter().filter(|&&o| !o).count();
    let sum = (0..outside.len()).filter(|&i| !outside[i]).map(|i| centre(i).as_dvec2()).sum::<glam::DVec2>();
    let centroid = (sum / count.max(1) as f64).as_vec2();
    (0..squared.len())
        .filter(|&i| most > 0.0 && squared[i] == most)
        .map(centre)
        .min_by(|a, b| a.distance_squared(centroid).total_cmp(&b.distance_squared(centroid)))
        .map(|p| (p, most.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::{cut_out, deepest, feather_alpha};
    use glam::{IVec2, Vec2};

    #[test]
    fn feather_runs_from_the_outline_to_its_depth() {
        assert_eq!(feather_alpha(0.0, 3.0), 0.0, "transparent at the outline");
        assert_eq!(feather_alpha(3.0, 3.0), 1.0, "opaque at the feather's depth");
        assert_eq!(feather_alpha(1.5, 3.0), 0.5, "half way down");
        assert_eq!(feather_alpha(1.0, 0.0), 1.0, "no feather, no ramp");
    }

    #[test]
    fn the_largest_piece_is_cut_out_with_a_margin() {
        #[rustfmt::skip]
        let alpha = [
            1.0, 0.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 0.5, 0.0, 0.0,
            0.0, 0.0, 0.0, 1.0, 1.0,
            0.3, 0.0, 0.0, 0.0, 0.0,
        ];
        let cut = cut_out(&alpha, 5).expect("has alpha");
        assert_eq!(cut.origin, IVec2::new(1, 0), "one pixel above and left of the piece");
        assert_eq!(cut.mask.size(), [5, 4], "its box and a pixel around");
        let bytes: Vec<u32> = cut.mask.data().iter().map(|a| (a * 255.0) as u32).collect();
        let expected = [[0, 0, 0, 0, 0], [0, 128, 0, 0, 0], [0, 0, 255, 255, 0], [0; 5]].concat();
        assert_eq!(bytes, expected, "corner contact hangs together, the others are gone");
        assert_eq!(cut.dropped.0, 2, "two pieces dropped");
        assert!((cut.dropped.1 - 332.0 / 970.0).abs() < 1e-2, "their share: {}", cut.dropped.1);
    }

    #[test]
    fn nothing_is_cut_out_of_nothing() {
        assert_eq!(cut_out(&[0.0, 0.001, f32::NAN, 0.0], 2), None, "no alpha in 8 bits");
    }

    #[test]
    fn deepest_point_of_a_bar_is_its_middle() {
        // 9 x 5 inside a margin: the ridge holds several equally deep pixels.
        let inside: Vec<bool> = (0..11 * 7).map(|i| (1..10).contains(&(i % 11)) && (1..6).contains(&(i / 11))).collect();
        assert_eq!(deepest(&inside, 11), Some((Vec2::new(5.5, 3.5), 3.0)), "the ridge's pixel nearest the centroid");
        assert_eq!(deepest(&[true; 9], 3), Some((Vec2::new(1.5, 1.5), 2.0)), "beyond the image is outside");
        assert_eq!(deepest(&[false; 9], 3), None, "nothing inside");
    }
}
