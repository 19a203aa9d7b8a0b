//! Exact rasterization of triangles in the plane: which samples lie inside, which texels are touched at all.
//!
//! Based on: J. Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988.
//!
//! Corners are snapped to 1/[`SUBTEXEL`] of a texel, the same place for all faces that share it, so edge functions are
//! whole numbers: with the top-left rule every sample of a chart belongs to one face, and none is missed on an edge
//! between two.

use super::Atlas;
use crate::mesh::Mesh;
use glam::{DVec2, Vec3};
use std::ops::Range;

/// Steps a texel is divided into. The largest page has 2^14 texels, so products stay below 2^50.
pub const SUBTEXEL: i64 = 1024;

/// A triangle on the snapping grid, counter-clockwise where y points down (that is, with positive area).
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    corners: [[i64; 2]; 3],
    /// The face's own corner at each of `corners`.
    order: [usize; 3],
    /// Twice the area.
    area: i64,
}

impl Triangle {
    /// Snaps corners given in texels. `None` if nothing is left of the area.
    #[must_use]
    pub fn new(corners: [DVec2; 3]) -> Option<Self> {
        let snap = |p: DVec2| [p.x, p.y].map(|c| (c * SUBTEXEL as f64).round() as i64);
        let [a, b, c] = corners.map(snap);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        match area {
            0 => None,
            1.. => Some(Self { corners: [a, b, c], order: [0, 1, 2], area }),
            _ => Some(Self { corners: [a, c, b], order: [0, 2, 1], area: -area }),
        }
    }

    /// True if the corners came in the order that is counter-clockwise where y points up, as charts have it.
    #[must_use]
    pub const fn upright(&self) -> bool {
        self.order[1] == 2
    }

    fn range(&self, axis: usize) -> (i64, i64) {
        let [a, b, c] = self.corners.map(|p| p[axis]);
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Rows of texels that the triangle touches.
    #[must_use]
    pub fn rows(&self) -> Range<i64> {
        let (low, high) = self.range(1);
        low.div_euclid(SUBTEXEL)..high.div_euclid(SUBTEXEL) + 1
    }

    fn columns(&self) -> Range<i64> {
        let (low, high) = self.range(0);
        low.div_euclid(SUBTEXEL)..high.div_euclid(SUBTEXEL) + 1
    }

    /// Edge function of the edge across from corner `k`, at a point: zero on it, twice the area at the corner.
    fn edge(&self, k: usize, p: [i64; 2]) -> i64 {
        let (a, b) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    }

    /// 0 where samples on the edge belong to the triangle, -1 where they belong to its neighbour.
    fn bias(&self, k: usize) -> i64 {
        let (a, b) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        if dy < 0 || (dy == 0 && dx > 0) { 0 } else { -1 }
    }

    /// Calls `found(x, y, barycentric)` for every sample inside, of `samples` by `samples` in each texel of the rows: x and y
    /// count texels.
    pub fn samples(&self, rows: Range<i64>, samples: u32, mut found: impl FnMut(i64, i64, Vec3)) {
        let n = i64::from(samples);
        let step = SUBTEXEL / n;
        let (left, right) = self.range(0);
        let (top, bottom) = self.range(1);
        let first = |low: i64| (low - step / 2).div_euclid(step);
        let (x0, x1) = (first(left), first(right) + 1);
        let (y0, y1) = (first(top).max(rows.start * n), (first(bottom) + 1).min(rows.end * n - 1));
        let bias = [0, 1, 2].map(|k| self.bias(k));
        let dx = [0, 1, 2].map(|k| (self.corners[(k + 1) % 3][1] - self.corners[(k + 2) % 3][1]) * step);
        let scale = 1.0 / self.area as f64;
        for sy in y0..=y1 {
            let mut e = [0, 1, 2].map(|k| self.edge(k, [x0 * step + step / 2, sy * step + step / 2]));
            let mut inside = false;
            for sx in x0..=x1 {
                if (0..3).all(|k| e[k] + bias[k] >= 0) {
                    inside = true;
                    let mut bary = [0.0_f32; 3];
                    (0..3).for_each(|k| bary[self.order[k]] = (e[k] as f64 * scale) as f32);
                    found(sx.div_euclid(n), sy.div_euclid(n), Vec3::from_array(bary));
                } else if inside {
                    break;
                }
                (0..3).for_each(|k| e[k] += dx[k]);
            }
        }
    }

    /// Calls `found(x, y)` for every texel of the rows whose square the triangle touches.
    pub fn touched(&self, rows: Range<i64>, mut found: impl FnMut(i64, i64)) {
        let mine = self.rows();
        let half = SUBTEXEL / 2;
        // An edge function plus this is the greatest it is anywhere on the square around a centre.
        let reach = [0, 1, 2].map(|k| {
            let (a, b) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
            ((b[0] - a[0]).abs() + (b[1] - a[1]).abs()) * half
        });
        let columns = self.columns();
        for y in mine.start.max(rows.start)..mine.end.min(rows.end) {
            for x in columns.clone() {
                let centre = [x * SUBTEXEL + half, y * SUBTEXEL + half];
                if (0..3).all(|k| self.edge(k, centre) + reach[k] >= 0) {
                    found(x, y);
                }
            }
        }
    }

    /// The point of the triangle nearest to a texel's centre: its distance squared, texels, and its barycentric coordinates.
    #[must_use]
    pub fn nearest(&self, x: i64, y: i64) -> (f64, Vec3) {
        let at = |p: [i64; 2]| DVec2::new(p[0] as f64, p[1] as f64) / SUBTEXEL as f64;
        let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let corners = self.corners.map(at);
        let inner = [0, 1, 2].map(|k| self.edge(k, [x * SUBTEXEL + SUBTEXEL / 2, y * SUBTEXEL + SUBTEXEL / 2]));
        let (mut best, mut bary) = (f64::INFINITY, [0.0; 3]);
        if inner.iter().all(|&e| e >= 0) {
            best = 0.0;
            bary = inner.map(|e| e as f64 / self.area as f64);
        } else {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let along = (b - a).length_squared();
                let t = if along > 0.0 { ((p - a).dot(b - a) / along).clamp(0.0, 1.0) } else { 0.0 };
                let distance = (a.lerp(b, t) - p).length_squared();
                if distance < best {
                    best = distance;
                    bary = [0.0; 3];
                    bary[k] = 1.0 - t;
                    bary[(k + 1) % 3] = t;
                }
            }
        }
        let mut own = [0.0_f32; 3];
        (0..3).for_each(|k| own[self.order[k]] = bary[k] as f32);
        (best, Vec3::from_array(own))
    }
}

/// Rows of texels that are worked on together.
pub const BAND: usize = 32;

/// The faces that touch each band of a page's rows, in the order of faces.
#[derive(Debug)]
pub struct Bands {
    start: Vec<u32>,
    face: Vec<u32>,
}

impl Bands {
    /// Sorts the faces of one page.
    #[must_use]
    pub fn new(mesh: &Mesh, atlas: &Atlas, page: u32) -> Self {
        let bands = (atlas.size as usize).div_ceil(BAND);
        let reach = |f: u32| {
            let rows = Triangle::new(atlas.face_texels(f)).filter(|_| atlas.page_of(f) == page)?.rows();
            let band = |row: i64| (row.max(0) as usize / BAND).min(bands - 1);
            Some(band(rows.start)..band(rows.end - 1) + 1)
        };
        let faces = 0..mesh.face_count() as u32;
        let mut start = vec![0_u32; bands + 1];
        for f in faces.clone() {
            reach(f).into_iter().flatten().for_each(|b| start[b + 1] += 1);
        }
        for b in 0..bands {
            start[b + 1] += start[b];
        }
        let mut fill = start.clone();
        let mut face = vec![0; start[bands] as usize];
        for f in faces {
            for b in reach(f).into_iter().flatten() {
                face[fill[b] as usize] = f;
                fill[b] += 1;
            }
        }
        Self { start, face }
    }

    /// Number of bands.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.start.len() - 1
    }

    /// The faces of a band.
    #[must_use]
    pub fn faces(&self, band: usize) -> &[u32] {
        &self.face[self.start[band] as usize..self.start[band + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::Triangle;
    use crate::random::Random;
    use glam::DVec2;

    #[test]
    fn a_fan_of_triangles_owns_every_sample_once_and_touches_what_it_should() {
        let mut random = Random::new(3, 0);
        for samples in [1, 2, 4] {
            // Corners on whole and half texels too, where samples lie on edges.
            let mut point = || DVec2::new((random.unit() * 64.0).round() / 2.0, (random.unit() * 64.0).round() / 2.0);
            for _ in 0..50 {
                let (inner, corners) = (point(), [DVec2::ZERO, DVec2::new(32.0, 0.0), DVec2::splat(32.0), DVec2::new(0.0, 32.0)]);
                let mut owned = vec![0_u32; 32 * 32];
                let mut touched = vec![false; 32 * 32];
                for k in 0..4 {
                    let Some(t) = Triangle::new([corners[k], corners[(k + 1) % 4], inner]) else { continue };
                    t.samples(0..32, samples, |x, y, bary| {
                        owned[(y * 32 + x) as usize] += 1;
                        assert!((bary.element_sum() - 1.0).abs() < 1e-5 && bary.min_element() >= 0.0, "inside: {bary}");
                    });
                    t.touched(0..32, |x, y| {
                        if (0..32).contains(&x) && (0..32).contains(&y) {
                            touched[(y * 32 + x) as usize] = true;
                        }
                    });
                }
                assert!(owned.iter().all(|&n| n == samples * samples), "every sample of the square is owned once");
                assert!(touched.iter().all(|&t| t), "and every texel touched");
            }
        }
    }

    #[test]
    fn slivers_between_samples_still_touch_their_texels() {
        let t = Triangle::new([DVec2::new(2.1, 2.1), DVec2::new(9.2, 2.2), DVec2::new(2.1, 2.2)]).expect("it has area");
        let (mut inside, mut touched) = (0, 0);
        t.samples(0..20, 1, |_, _, _| inside += 1);
        t.touched(0..20, |_, y| touched += usize::from(y == 2));
        assert_eq!((inside, touched), (0, 8), "no centre, but the squares of columns 2 to 9");
        assert!(t.nearest(5, 2).0 < 0.25, "the nearest point lies within the texel");
    }
}
