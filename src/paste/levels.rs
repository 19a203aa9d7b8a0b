//! One level of an exemplar as numbers that can be compared, for whoever asks how well two places of it agree.

use crate::exemplar::stack::matched;
use crate::exemplar::{Channel, ChannelSet, Exemplar};
use glam::Vec2;
use rayon::prelude::*;

/// One level of an exemplar as numbers to match, repeated once to the right and down, so that windows need no remainder.
pub(super) struct Level {
    size: [usize; 2],
    /// Pixels of it along one of the exemplar's.
    pub(super) scale: Vec2,
    pub(super) components: usize,
    pub(super) data: Vec<f32>,
}

impl Level {
    pub(super) fn new(exemplar: &Exemplar, channels: ChannelSet, level: usize) -> Self {
        let images: Vec<_> = channels.iter().filter_map(|c| Some((c, exemplar.channel(c)?.levels().get(level)?))).collect();
        let full = exemplar.size();
        let [w, h] = images.first().map_or([1, 1], |(_, image)| image.size()).map(|s| s as usize);
        let row = |y: i64| {
            let mut numbers = Vec::new();
            for x in 0..w as i64 {
                images.iter().for_each(|(c, image)| matched(*c, image.pixel(x, y).to_array(), &mut numbers));
            }
            numbers
        };
        let rows: Vec<Vec<f32>> = (0..h as i64).into_par_iter().map(row).collect();
        let components = rows.first().map_or(0, Vec::len) / w.max(1);
        let mut data = Vec::with_capacity(4 * w * h * components);
        rows.iter().chain(&rows).flat_map(|row| [row, row]).for_each(|row| data.extend_from_slice(row));
        Self { size: [w, h], scale: Vec2::new(w as f32 / full[0] as f32, h as f32 / full[1] as f32), components, data }
    }

    /// The finest one that is no longer than `side`, of some channels.
    pub(super) fn of_side(exemplar: &Exemplar, channels: ChannelSet, side: u32) -> Self {
        let long = |level: usize| (exemplar.size().into_iter().max().unwrap_or(1) >> level).max(1);
        let count = exemplar.channel(Channel::BaseColor).map_or(1, |c| c.levels().len());
        Self::new(exemplar, channels, (0..count).find(|&l| long(l) <= side).unwrap_or(count - 1))
    }

    /// The pixel of this level under a pixel of the exemplar, wrapped.
    pub(super) fn cell(&self, pixel: Vec2) -> [usize; 2] {
        let p = (pixel * self.scale).floor();
        [(p.x as i64).rem_euclid(self.size[0] as i64) as usize, (p.y as i64).rem_euclid(self.size[1] as i64) as usize]
    }

    /// Where a pixel's numbers begin. Those of a pixel shifted by another begin at the sum.
    pub(super) fn first(&self, [x, y]: [usize; 2]) -> usize {
        (y * 2 * self.size[0] + x) * self.components
    }

    /// The mean of all pixels.
    pub(super) fn mean(&self) -> Vec<f32> {
        let row = self.size[0] * self.components;
        let mut sums = vec![0.0_f64; self.components];
        for pixels in self.data.chunks_exact(2 * row).take(self.size[1]).map(|rows| &rows[..row]) {
            pixels.chunks_exact(self.components).for_each(|p| sums.iter_mut().zip(p).for_each(|(s, &x)| *s += f64::from(x)));
        }
        sums.iter().map(|s| (s / (self.size[0] * self.size[1]) as f64) as f32).collect()
    }

    pub(super) fn at(&self, pixel: [usize; 2]) -> &[f32] {
        &self.data[self.first(pixel)..][..self.components]
    }
}
