//! The closed path around a place that stays on lines as far as it can.
//!
//! Based on: the shortest closed paths of intelligent scissors (Mortensen, Barrett 1995) and of minimum error cuts (Efros, Freeman
//! 2001), here around a place and free to run outwards as well as around.
//!
//! 1. Pixels in a ring around the place are steps of a graph, each joined to its eight neighbours. A step costs its length times how
//!    little of a line there is, over the square of how far out it lies: so a wide path is as cheap as a narrow one, and cheaper if
//!    lines are as good.
//! 2. The ring is cut open on the ray to the right: a way that crosses the ray comes to a further sheet of the same pixels. The
//!    cheapest way (Dijkstra) over two sheets shows where a good path crosses the ray; the cheapest way from there over one sheet back
//!    to it is the closed path.

use super::lines::Lines;
use glam::{IVec2, Vec2};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The ring, in shares of the room around a place: paths of the mean between both enclose about what a splotch does.
const INNER: f32 = 0.66;
const OUTER: f32 = 1.0;
/// Exponent of the superellipse that rings are, as splotches: 2 is an ellipse, infinity the box.
const ROUNDNESS: f32 = 4.0;
/// What a step on the strongest line costs, beside 1 for one off any line: keeps a path from wandering within wide lines.
const LEAST: f32 = 0.06;
/// Cost of a straight step off any line, half way out.
const FULL: f32 = 400.0;

const STEPS: [[i32; 2]; 8] = [[1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, 1], [-1, -1], [1, -1]];
const FAR: u32 = u32::MAX;

/// A closed path.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Pixel by pixel, middles; they may lie over the edges of an image that repeats.
    pub points: Vec<Vec2>,
    /// The mean strength of the lines along it.
    pub share: f32,
}

/// The closed path around a place, within `half` of it in each direction; `None` if there is no room for one.
pub fn closed(lines: &Lines, centre: Vec2, half: Vec2) -> Option<Loop> {
    let ring = Ring::new(lines, centre, half);
    let starts: Vec<u32> = (0..ring.count()).filter(|&i| ring.on_ray(i)).map(|i| i as u32).collect();
    let twice = ring.way(&starts, 2, None)?;
    // Where it comes to the second sheet.
    let passed = *twice.iter().find(|&&node| node as usize >= ring.count())? % ring.count() as u32;
    let once = ring.way(&[passed], 1, Some(passed))?;
    let points: Vec<IVec2> = once.iter().skip(1).map(|&node| ring.pixel(node as usize % ring.count())).collect();
    let strength: Vec<f32> = points.iter().map(|p| lines.at(p.x.into(), p.y.into())).collect();
    let share = strength.iter().sum::<f32>() / strength.len() as f32;
    Some(Loop { share, points: points.iter().map(|p| p.as_vec2() + 0.5).collect() })
}

/// Pixels around a place.
struct Ring {
    low: IVec2,
    size: IVec2,
    centre: Vec2,
    /// What a pixel costs; infinite outside the ring.
    cost: Vec<f32>,
}

impl Ring {
    fn new(lines: &Lines, centre: Vec2, half: Vec2) -> Self {
        let low = (centre - half).ceil().as_ivec2();
        let size = ((centre + half).floor().as_ivec2() - low).max(IVec2::ZERO);
        let cost = |i: i32| {
            let p = low + IVec2::new(i % size.x, i / size.x);
            let off = ((p.as_vec2() + 0.5 - centre) / half).abs();
            let out = (off.x.powf(ROUNDNESS) + off.y.powf(ROUNDNESS)).powf(1.0 / ROUNDNESS);
            let inside = (INNER..=OUTER).contains(&out);
            if inside { (LEAST + 1.0 - lines.at(p.x.into(), p.y.into())) / (out * out) } else { f32::INFINITY }
        };
        Self { low, size, centre, cost: (0..size.x * size.y).map(cost).collect() }
    }

    fn count(&self) -> usize {
        self.cost.len()
    }

    fn pixel(&self, i: usize) -> IVec2 {
        self.low + IVec2::new(i as i32 % self.size.x, i as i32 / self.size.x)
    }

    /// True of pixels beyond the horizontal line through the place.
    fn beyond(&self, i: usize) -> bool {
        self.pixel(i).y as f32 + 0.5 >= self.centre.y
    }

    fn right(&self, i: usize) -> bool {
        self.pixel(i).x as f32 + 0.5 > self.centre.x
    }

    /// True of the first pixels beyond the ray to the right.
    fn on_ray(&self, i: usize) -> bool {
        let before = i.checked_sub(self.size.x as usize).is_none_or(|j| !self.beyond(j));
        self.cost[i].is_finite() && self.right(i) && self.beyond(i) && before
    }

    /// The cheapest way from one of some pixels, over so many sheets to one of them, or to a pixel given. Nodes are pixels, sheet
    /// after sheet.
    fn way(&self, starts: &[u32], sheets: usize, end: Option<u32>) -> Option<Vec<u32>> {
        let count = self.count();
        let mut cost = vec![FAR; count * (sheets + 1)];
        let mut from = vec![FAR; count * (sheets + 1)];
        let mut front = BinaryHeap::new();
        for &start in starts {
            cost[start as usize] = 0;
            front.push(Reverse((0, start)));
        }
        while let Some(Reverse((so_far, node))) = front.pop() {
            if so_far > cost[node as usize] {
                continue;
            }
            let (sheet, i) = (node as usize / count, node as usize % count);
            if sheet == sheets && end.map_or_else(|| self.on_ray(i), |end| end as usize == i) {
                let mut way = vec![node];
                while let Some(&before) = way.last().map(|&n| &from[n as usize]).filter(|&&b| b != FAR) {
                    way.push(before);
                }
                way.reverse();
                return Some(way);
            }
            let place = IVec2::new(i as i32 % self.size.x, i as i32 / self.size.x);
            for step in STEPS.map(IVec2::from_array) {
                let q = place + step;
                if q.cmplt(IVec2::ZERO).any() || q.cmpge(self.size).any() {
                    continue;
                }
                let j = (q.y * self.size.x + q.x) as usize;
                let price = 0.5 * FULL * (self.cost[i] + self.cost[j]) * step.as_vec2().length();
                let sheet = match (self.right(i), self.beyond(i), self.beyond(j)) {
                    (true, false, true) => Some(sheet + 1).filter(|&s| s <= sheets),
                    (true, true, false) => sheet.checked_sub(1),
                    _ => Some(sheet),
                };
                let Some(next) = sheet.filter(|_| price.is_finite()).map(|s| s * count + j) else { continue };
                let through = so_far.saturating_add(price as u32);
                if through < cost[next] {
                    (cost[next], from[next]) = (through, node);
                    front.push(Reverse((through, next as u32)));
                }
            }
        }
        None
    }
}
