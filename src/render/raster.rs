//! Which face lies under each sample of a picture: an exact z-buffer rasterizer.
//!
//! Based on: J. Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988 (edge functions on a fixed-point
//! grid, with the top-left rule), and the analytic ray-plane intersection for everything that is measured at a sample.
//!
//! 1. Vertices are projected in double precision relative to the eye and snapped to 1/4096 of a sample.
//! 2. Each band of sample rows walks its faces in index order. Edge functions are exact integers, so faces that share an
//!    edge leave neither gap nor overlap between them.
//! 3. Of all faces over a sample the nearest wins; at equal depth the one with the smaller index. Depth is that of the
//!    face's plane in double precision, so the winner depends on nothing but the mesh and the camera.
//! 4. Only face numbers are kept. Barycentric coordinates, depth and footprint follow from the ray when asked for:
//!    perspective-correct by construction, and free of the snapping.
//!
//! Faces that cross the near plane, or reach absurdly far beside the picture, are clipped first. Bands are independent:
//! the result is the same for any number of threads. Both sides of a face are seen.

use super::RenderError;
use super::camera::Camera;
use super::clip::{OUTSIDE, Projected, SUBSAMPLE_BITS, clip, project};
use super::lens::{Grid, Hit, Lens};
use crate::mesh::{Mesh, NONE, SurfacePoint};
use glam::DVec2;
use rayon::prelude::*;

/// Sample rows in a band: enough that few faces are set up twice, few enough that bands are many.
const BAND: usize = 32;
/// Faces sorted into bands by one task.
const CHUNK: usize = 1 << 15;

/// The nearest face under each sample of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Visibility {
    camera: Camera,
    grid: Grid,
    faces: Vec<u32>,
}

impl Visibility {
    /// What a camera sees of a mesh.
    ///
    /// # Errors
    /// If the grid has no samples or too many.
    pub fn new(mesh: &Mesh, camera: &Camera, grid: Grid) -> Result<Self, RenderError> {
        grid.check()?;
        Ok(Self { camera: *camera, grid, faces: rasterize(mesh, &Lens::new(camera, grid), None) })
    }

    /// What lies behind everything this one holds: at each sample the next face along the ray.
    #[must_use]
    pub fn behind(&self, mesh: &Mesh) -> Self {
        let faces = rasterize(mesh, &Lens::new(&self.camera, self.grid), Some(&self.faces));
        Self { faces, ..*self }
    }

    /// True if no face is seen at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faces.iter().all(|&f| f == NONE)
    }

    /// The camera it was made with.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The grid it was made on.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Face numbers, [`NONE`] where there is nothing; rows of samples from the top.
    #[must_use]
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// The face under a sample, [`NONE`] where there is nothing or outside the picture.
    #[inline]
    #[must_use]
    pub fn face(&self, x: usize, y: usize) -> u32 {
        let [across, down] = self.grid.size();
        if x < across && y < down { self.faces[y * across + x] } else { NONE }
    }

    /// What is seen at a sample.
    #[must_use]
    pub fn hit(&self, mesh: &Mesh, x: usize, y: usize) -> Option<Hit> {
        let face = self.face(x, y);
        let lens = Lens::new(&self.camera, self.grid);
        (face != NONE).then(|| lens.hit(mesh, face, [x as f64 + 0.5, y as f64 + 0.5]))
    }

    /// The visible surface point under a place in the picture, in pixels from its top left corner.
    #[must_use]
    pub fn pick(&self, mesh: &Mesh, at: DVec2) -> Option<SurfacePoint> {
        let sample = (at * f64::from(self.grid.samples)).floor();
        if !sample.is_finite() || sample.min_element() < 0.0 {
            return None;
        }
        self.hit(mesh, sample.x as usize, sample.y as usize).map(|hit| hit.at)
    }
}

fn rasterize(mesh: &Mesh, lens: &Lens<'_>, in_front: Option<&[u32]>) -> Vec<u32> {
    let vertices: Vec<Projected> = mesh.positions.par_iter().map(|p| project(lens, p.as_dvec3())).collect();
    let bins = sort_into_bands(mesh, lens, &vertices);
    let across = lens.size[0];
    let mut out = vec![NONE; across * lens.size[1]];
    out.par_chunks_mut(across * BAND).enumerate().for_each(|(number, faces)| {
        let start = number * across * BAND;
        let mut band = Band {
            top: number * BAND,
            across,
            nearness: vec![f64::NEG_INFINITY; faces.len()],
            in_front: in_front.map(|f| &f[start..start + faces.len()]),
            limits: Vec::new(),
            faces,
        };
        band.set_limits(mesh, lens);
        for chunk in &bins {
            for &face in &chunk[number] {
                band.draw(mesh, lens, &vertices, face);
            }
        }
    });
    out
}

/// For each chunk of faces and each band the faces that may touch it, ascending.
fn sort_into_bands(mesh: &Mesh, lens: &Lens<'_>, vertices: &[Projected]) -> Vec<Vec<Vec<u32>>> {
    let bands = lens.size[1].div_ceil(BAND);
    let last = bands as i32 - 1;
    let row = |y: i32| (y >> SUBSAMPLE_BITS).div_euclid(BAND as i32);
    mesh.faces
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, faces)| {
            let mut bins = vec![Vec::new(); bands];
            for (i, corners) in faces.iter().enumerate() {
                let v = corners.map(|c| vertices[c as usize]);
                let clipped = v.iter().any(|v| v.x == OUTSIDE);
                let (low, high) = if clipped {
                    (0, last)
                } else {
                    let [a, b, c] = v;
                    // No sample centre between left and right, or between top and bottom: never seen.
                    let x = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
                    let y = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
                    if first_centre(x.0) > last_centre(x.1) || first_centre(y.0) > last_centre(y.1) {
                        continue;
                    }
                    (row(y.0).max(0), row(y.1).min(last))
                };
                for band in low..=high {
                    bins[band as usize].push((chunk * CHUNK + i) as u32);
                }
            }
            bins
        })
        .collect()
}

/// Fixed-point position of a sample's centre.
#[inline]
const fn centre(sample: i64) -> i64 {
    (sample << SUBSAMPLE_BITS) + (1 << (SUBSAMPLE_BITS - 1))
}

/// The first sample whose centre is at or after a fixed-point coordinate.
#[inline]
const fn first_centre(at: i32) -> i64 {
    (at as i64 + (1 << (SUBSAMPLE_BITS - 1)) - 1) >> SUBSAMPLE_BITS
}

/// The last sample whose centre is at or before a fixed-point coordinate.
#[inline]
const fn last_centre(at: i32) -> i64 {
    (at as i64 - (1 << (SUBSAMPLE_BITS - 1))) >> SUBSAMPLE_BITS
}

/// Some rows of samples while they are being filled.
struct Band<'a> {
    top: usize,
    across: usize,
    faces: &'a mut [u32],
    nearness: Vec<f64>,
    /// What lies in front of all that may be seen here, and how near that is.
    in_front: Option<&'a [u32]>,
    limits: Vec<f64>,
}

impl Band<'_> {
    fn set_limits(&mut self, mesh: &Mesh, lens: &Lens<'_>) {
        let Some(in_front) = self.in_front else { return };
        let nearness = |(i, &face): (usize, &u32)| {
            if face == NONE {
                return f64::NEG_INFINITY;
            }
            let (x, y) = (i % self.across, self.top + i / self.across);
            lens.plane(mesh, face).nearness(x as f64 + 0.5, y as f64 + 0.5)
        };
        self.limits = in_front.iter().enumerate().map(nearness).collect();
    }

    fn draw(&mut self, mesh: &Mesh, lens: &Lens<'_>, vertices: &[Projected], face: u32) {
        let corners = mesh.faces[face as usize].map(|c| vertices[c as usize]);
        if corners.iter().any(|v| v.x == OUTSIDE) {
            let outline = clip(lens, mesh.corners(face).map(|p| lens.camera.to_view(p)));
            for k in 2..outline.len() {
                self.fill(mesh, lens, face, [outline[0], outline[k - 1], outline[k]]);
            }
        } else {
            self.fill(mesh, lens, face, corners.map(|v| [v.x, v.y]));
        }
    }

    /// Fills a triangle given on the fixed-point grid.
    fn fill(&mut self, mesh: &Mesh, lens: &Lens<'_>, face: u32, corners: [[i32; 2]; 3]) {
        let [ax, bx, cx] = corners.map(|p| i64::from(p[0]));
        let [ay, by, cy] = corners.map(|p| i64::from(p[1]));
        let area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        let edges = match area {
            0 => return,
            1.. => [Edge::new(ax, ay, bx, by), Edge::new(bx, by, cx, cy), Edge::new(cx, cy, ax, ay)],
            _ => [Edge::new(ax, ay, cx, cy), Edge::new(cx, cy, bx, by), Edge::new(bx, by, ax, ay)],
        };
        let [xs, ys] = [0, 1].map(|k| corners.map(|p| p[k]));
        let span = |v: [i32; 3]| (first_centre(v[0].min(v[1]).min(v[2])), last_centre(v[0].max(v[1]).max(v[2])));
        let (left, right) = span(xs);
        let (top, bottom) = span(ys);
        let rows = self.faces.len() / self.across;
        let (left, right) = (left.max(0), right.min(self.across as i64 - 1));
        let (top, bottom) = (top.max(self.top as i64), bottom.min((self.top + rows) as i64 - 1));
        if left > right || top > bottom {
            return;
        }
        let mut plane = None;
        for y in top..=bottom {
            let (mut from, mut to) = (left, right);
            for edge in &edges {
                edge.narrow(y, &mut from, &mut to);
            }
            if from > to {
                continue;
            }
            let plane = plane.get_or_insert_with(|| lens.plane(mesh, face));
            let row = (y as usize - self.top) * self.across;
            for x in from..=to {
                self.offer(row + x as usize, plane.nearness(x as f64 + 0.5, y as f64 + 0.5), face);
            }
        }
    }

    #[inline]
    fn offer(&mut self, i: usize, nearness: f64, face: u32) {
        if let Some(in_front) = self.in_front {
            // Strictly after what lies in front, in the order of nearness, then index.
            let after = nearness < self.limits[i] || (nearness == self.limits[i] && face > in_front[i]);
            if in_front[i] == NONE || !after {
                return;
            }
        }
        // Faces come in ascending order: at equal nearness the first one stays.
        if nearness > self.nearness[i] {
            self.nearness[i] = nearness;
            self.faces[i] = face;
        }
    }
}

/// An edge function `a x + b y + c` on the fixed-point grid, positive inside; on the edge itself inside only if the edge
/// is a left or a top one.
struct Edge {
    a: i64,
    b: i64,
    c: i64,
}

impl Edge {
    #[inline]
    fn new(x0: i64, y0: i64, x1: i64, y1: i64) -> Self {
        let (a, b) = (y0 - y1, x1 - x0);
        let top_left = a > 0 || (a == 0 && b > 0);
        Self { a, b, c: -(a * x0 + b * y0) - i64::from(!top_left) }
    }

    /// Narrows the samples of a row to those inside.
    #[inline]
    fn narrow(&self, y: i64, from: &mut i64, to: &mut i64) {
        let at_first = self.a * centre(0) + self.b * centre(y) + self.c;
        let step = self.a << SUBSAMPLE_BITS;
        match step {
            1.. => *from = (*from).max(-at_first.div_euclid(step)),
            0 if at_first < 0 => *to = *from - 1,
            0 => {}
            _ => *to = (*to).min(at_first.div_euclid(-step)),
        }
    }
}
