//! Border lines of an exemplar: how strongly each pixel lies in grout, in a gap, on the border of a scale.
//!
//! Based on: Lindeberg, "Edge Detection and Ridge Detection with Automatic Scale Selection", IJCV 30 (1998): second derivatives
//! across a line, normalised by the scale; and, for what chance would draw, Galerne, Gousseau, Morel, "Random Phase Textures"
//! (2011), section 3 (asymptotic discrete spot noise).
//!
//! 1. All channels but the normals, whose borders are steps rather than lines, are blurred at several scales.
//! 2. A pixel is as much in a dark line as its strongest second derivative rises, in a bright line as it falls, times the square
//!    of the scale: a line answers most at the scale of its own width. The largest answer of all scales counts, over all channels.
//! 3. A share of the strongest answers is full strength, so that faint lines of a pale exemplar count as much as black ones.
//! 4. The twin of an exemplar is noise with the same spectrum: copies of the exemplar, shifted at random and of random sign, are
//!    added up, and their values replaced by the exemplar's in the same order (Theiler et al., "Testing for nonlinearity in time
//!    series", 1992), so that both are as dark as often. It has as much contrast at every size and in every direction, but no line
//!    of it closes but by chance.

use crate::exemplar::Wrap;
use crate::exemplar::stack::Stack;
use crate::random::Random;
use rayon::prelude::*;

/// Scales of the derivatives, shares of the image's longer side: half the width of the lines that answer most, an octave in two steps.
const SCALES: [f32; 4] = [0.0088, 0.0125, 0.0177, 0.025];
/// A blur is cut off at so many of its own widths.
const REACH: f32 = 3.0;
/// The share of all pixels that is weaker than a line at full strength.
const STRONGEST: f32 = 0.93;
/// A pixel is on a line from this strength on.
const ON_LINE: f32 = 0.5;
/// Copies that a twin is made of: with many more the eye sees no difference.
const COPIES: usize = 60;
/// Contrast, in steps of encoded colour, below which an exemplar shows nothing: half a step of 8 bits.
const FLAT: f32 = 0.002;

/// What lines are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Darker, or deeper, than both sides.
    Dark,
    /// Brighter, or higher.
    Bright,
}

impl Tone {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Dark, Self::Bright];
}

/// How strongly each pixel lies on a line, 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines {
    /// Width and height.
    pub size: [usize; 2],
    /// What lies beyond the edge.
    pub wrap: Wrap,
    /// Rows of pixels from the top.
    pub strength: Vec<f32>,
}

impl Lines {
    /// The dark and the bright lines of a stack; `None` if it is of one colour.
    pub(super) fn of(stack: &Stack) -> Option<[Self; 2]> {
        if stack.components == 0 || contrast(stack) < FLAT {
            return None;
        }
        let count = stack.size[0] * stack.size[1];
        let mut strongest = [vec![0.0_f32; count], vec![0.0_f32; count]];
        let side = stack.size[0].max(stack.size[1]) as f32;
        for scale in SCALES.map(|s| s * side) {
            let found = answers(&stack.blurred(scale, REACH), scale * scale);
            for (best, now) in strongest.iter_mut().zip(found) {
                best.iter_mut().zip(now).for_each(|(b, n)| *b = b.max(n));
            }
        }
        Some(strongest.map(|strength| Self { size: stack.size, wrap: stack.wrap, strength: normalised(strength) }))
    }

    /// A strength in means of all pixels.
    pub(super) fn above(&self, strength: f32) -> f32 {
        let mean = self.strength.iter().map(|&s| f64::from(s)).sum::<f64>() / self.strength.len().max(1) as f64;
        strength / (mean as f32).max(f32::MIN_POSITIVE)
    }

    /// Mean way from one line to the next along rows and columns, as a share of the width.
    pub(super) fn apart(&self) -> f32 {
        let [w, h] = self.size;
        let on = |i: usize| self.strength[i] >= ON_LINE;
        let begins = |i: usize, before: usize| on(i) && !on(before);
        let across = (0..w * h).filter(|&i| i % w > 0 && begins(i, i - 1)).count();
        let down = (w..w * h).filter(|&i| begins(i, i - w)).count();
        let way = |n: usize| (w * h) as f32 / (n.max(1) as f32);
        (way(across) * way(down)).sqrt().min(w as f32) / w as f32
    }

    /// The strength at a pixel; what lies beyond the edge is as the wrap says.
    #[must_use]
    pub fn at(&self, x: i64, y: i64) -> f32 {
        let [w, h] = self.size.map(|s| s as i64);
        let (x, y) = match self.wrap {
            Wrap::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
            Wrap::Repeat => (x.rem_euclid(w), y.rem_euclid(h)),
        };
        self.strength[(y * w + x) as usize]
    }
}

/// The dark and the bright answer of each pixel at one scale.
fn answers(smooth: &Stack, unit: f32) -> [Vec<f32>; 2] {
    let w = smooth.size[0];
    let one = |i: usize| {
        let (x, y) = ((i % w) as i64, (i / w) as i64);
        let at = |dx: i64, dy: i64| smooth.pixel(x + dx, y + dy);
        let (middle, [left, right, up, down]) = (at(0, 0), [at(-1, 0), at(1, 0), at(0, -1), at(0, 1)]);
        let corners = [at(-1, -1), at(1, 1), at(1, -1), at(-1, 1)];
        let (mut dark, mut bright) = (0.0, 0.0);
        for c in 0..smooth.components {
            let (xx, yy) = (left[c] + right[c] - 2.0 * middle[c], up[c] + down[c] - 2.0 * middle[c]);
            let xy = 0.25 * (corners[0][c] + corners[1][c] - corners[2][c] - corners[3][c]);
            let (mean, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
            dark += (mean + spread).max(0.0).powi(2);
            bright += (spread - mean).max(0.0).powi(2);
        }
        (unit * dark.sqrt(), unit * bright.sqrt())
    };
    let (dark, bright) = (0..w * smooth.size[1]).into_par_iter().map(one).unzip();
    [dark, bright]
}

/// On a scale where a share of the strongest is 1.
fn normalised(mut strength: Vec<f32>) -> Vec<f32> {
    let mut sorted = strength.clone();
    let rank = ((sorted.len() - 1) as f32 * STRONGEST) as usize;
    let full = sorted.select_nth_unstable_by(rank, f32::total_cmp).1.max(f32::MIN_POSITIVE);
    strength.iter_mut().for_each(|s| *s = (*s / full).min(1.0));
    strength
}

/// Standard deviation of all components together.
fn contrast(stack: &Stack) -> f32 {
    let mean = stack.mean();
    let sum: f64 = stack
        .data
        .chunks_exact(stack.components)
        .map(|p| p.iter().zip(&mean).map(|(v, m)| f64::from(v - m).powi(2)).sum::<f64>())
        .sum();
    (sum / (stack.size[0] * stack.size[1]) as f64).sqrt() as f32
}

/// Noise with the spectrum and the values of a stack. What does not tile is mirrored at its edges first, which would else be lines.
pub(super) fn twin(stack: &Stack, random: &mut Random) -> Stack {
    let ([w, h], n, mean) = (stack.size, stack.components, stack.mean());
    let fold = |i: usize, n: usize| if i < n { i } else { 2 * n - 1 - i };
    let period = match stack.wrap {
        Wrap::Repeat => [w, h],
        Wrap::Clamp => [2 * w, 2 * h],
    };
    let copies: Vec<([usize; 2], f32)> = (0..COPIES)
        .map(|_| {
            let shift = period.map(|p| random.below(p as u64) as usize);
            (shift, if random.below(2) == 0 { 1.0 } else { -1.0 } / (COPIES as f32).sqrt())
        })
        .collect();
    let mut data = vec![0.0; stack.data.len()];
    data.par_chunks_exact_mut(w * n).enumerate().for_each(|(y, row)| {
        for &([right, down], sign) in &copies {
            let from = fold((y + down) % period[1], h) * w;
            for (x, out) in row.chunks_exact_mut(n).enumerate() {
                let pixel = (from + fold((x + right) % period[0], w)) * n;
                out.iter_mut().zip(&stack.data[pixel..pixel + n]).zip(&mean).for_each(|((o, v), m)| *o += sign * (v - m));
            }
        }
    });
    for c in 0..n {
        revalued(&mut data, &stack.data, c, n);
    }
    Stack { data, ..stack.clone() }
}

/// Gives a component of the pixels the values that it has in others, in the order of its own.
fn revalued(data: &mut [f32], values: &[f32], component: usize, components: usize) {
    let of = |from: &[f32]| from.iter().skip(component).step_by(components).copied().collect::<Vec<f32>>();
    let (own, mut wanted) = (of(data), of(values));
    let mut order: Vec<u32> = (0..own.len() as u32).collect();
    order.par_sort_by(|&a, &b| own[a as usize].total_cmp(&own[b as usize]));
    wanted.par_sort_by(f32::total_cmp);
    for (at, value) in order.into_iter().zip(wanted) {
        data[at as usize * components + component] = value;
    }
}
