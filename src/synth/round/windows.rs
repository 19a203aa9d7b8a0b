//! The exemplar resampled on the circles, once for every pixel of a level (Chen, Dong 2008, sec. 5.3).
//!
//! A window holds its numbers component by component and within each sample by sample, so that sums over samples run over
//! neighbouring numbers. A place between pixels has the window between theirs.

use super::template::Template;
use crate::exemplar::Wrap;
use crate::exemplar::stack::Stack;
use rayon::prelude::*;

/// Circles that reach over the edge of an exemplar that does not tile are kept away from it; but at least the middle half of each side
/// is kept, or small levels would have nothing left to choose from.
const KEPT: usize = 4;

/// The windows of one level.
pub(super) struct Windows {
    pub(super) stack: Stack,
    /// Samples a window.
    pub(super) per: usize,
    data: Vec<f32>,
    /// Pixels from each edge that places keep away, right and down.
    margin: [f32; 2],
}

impl Windows {
    pub(super) fn new(stack: Stack, template: &Template) -> Self {
        let (per, components) = (template.samples().len(), stack.components);
        let mut data = vec![0.0; stack.size[0] * stack.size[1] * per * components];
        let one = |sample: &mut Vec<f32>, (i, out): (usize, &mut [f32])| {
            let at = [(i % stack.size[0]) as f32 + 0.5, (i / stack.size[0]) as f32 + 0.5];
            for (k, s) in template.samples().iter().enumerate() {
                sample.fill(0.0);
                stack.sample([at[0] + s.offset.x, at[1] - s.offset.y], sample);
                sample.iter().enumerate().for_each(|(c, &value)| out[c * per + k] = value);
            }
        };
        let room = (per * components).max(1);
        data.par_chunks_exact_mut(room).enumerate().with_min_len(64).for_each_init(|| vec![0.0; components], one);
        let margin = stack.size.map(|n| match stack.wrap {
            Wrap::Repeat => 0.0,
            Wrap::Clamp => template.circles().min((n - 1) / KEPT) as f32,
        });
        Self { stack, per, data, margin }
    }

    /// Numbers a window.
    pub(super) const fn room(&self) -> usize {
        self.per * self.stack.components
    }

    /// A place brought onto the exemplar; `None` if it lies beyond or too near the edge of one that does not tile.
    #[inline]
    pub(super) fn place(&self, at: [f32; 2]) -> Option<[f32; 2]> {
        let mut out = at;
        for k in 0..2 {
            let n = self.stack.size[k] as f32;
            match self.stack.wrap {
                Wrap::Repeat => {
                    let turned = out[k].rem_euclid(n);
                    // Just below zero the remainder rounds up to the whole.
                    out[k] = if turned < n { turned } else { 0.0 };
                }
                Wrap::Clamp if !(self.margin[k]..=n - self.margin[k]).contains(&out[k]) => return None,
                Wrap::Clamp => {}
            }
        }
        Some(out)
    }

    /// The place nearest to one that may lie beyond the edge.
    pub(super) fn nearest(&self, at: [f32; 2]) -> [f32; 2] {
        let inside = |k: usize| {
            let n = self.stack.size[k] as f32;
            if self.stack.wrap == Wrap::Repeat { at[k] } else { at[k].clamp(self.margin[k], n - self.margin[k]) }
        };
        let at = [inside(0), inside(1)];
        self.place(at).unwrap_or(at)
    }

    /// Whole pixels at which places may lie.
    pub(super) fn pixels(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        let [w, h] = self.stack.size;
        (0..w * h).map(move |i| [(i % w) as f32 + 0.5, (i / w) as f32 + 0.5]).filter(|&at| self.place(at).is_some())
    }

    /// The window at a place.
    #[inline]
    pub(super) fn at(&self, place: [f32; 2], out: &mut [f32]) {
        let [w, h] = self.stack.size.map(|n| n as i64);
        let low = place.map(|a| (a - 0.5).floor());
        let ([u, v], [x, y]) = ([place[0] - 0.5 - low[0], place[1] - 0.5 - low[1]], low.map(|l| l as i64));
        let whole = |i: i64, n: i64| match self.stack.wrap {
            _ if (0..n).contains(&i) => i,
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Repeat => i.rem_euclid(n),
        };
        let ([x0, x1], [y0, y1]) = ([x, x + 1].map(|i| whole(i, w)), [y, y + 1].map(|i| whole(i, h)));
        let room = self.room();
        let window = |x: i64, y: i64| &self.data[(y * w + x) as usize * room..][..room];
        if u == 0.0 && v == 0.0 {
            out.copy_from_slice(window(x0, y0));
            return;
        }
        let (a, b, c, d) = (window(x0, y0), window(x1, y0), window(x0, y1), window(x1, y1));
        let [p, q, r, s] = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        for (i, out) in out[..room].iter_mut().enumerate() {
            *out = p * a[i] + q * b[i] + r * c[i] + s * d[i];
        }
    }
}
