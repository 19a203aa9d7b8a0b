//! What is synthesised on: a mesh whose vertices have circles, or the pixels of a plane. Synthesis knows nothing else of either.

use super::Grid;
use super::marching::{Marching, Packed, Reader};
use super::template::Template;
use crate::mesh::{Mesh, NONE, next, prev};
use crate::synth::Frame;
use glam::{DVec3, Vec2};
use rayon::prelude::*;

/// Vertices whose samples one task reads.
const CHUNK: usize = 1024;

/// Vertices whose frames are turned against each other by more than this (its cosine) do not continue each other.
const ALIGNED: f64 = 0.85;

/// A sample: three vertices and their shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tap {
    pub(super) vertices: [u32; 3],
    pub(super) shares: [f32; 3],
}

impl Tap {
    /// The vertex with the largest share.
    #[inline]
    pub(super) fn main(&self) -> u32 {
        let [a, b, c] = self.shares;
        self.vertices[if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) }]
    }
}

/// One level of what is synthesised on.
pub(super) trait Ground: Sync {
    /// Vertices.
    fn len(&self) -> usize;

    /// A sample of a vertex's neighbourhood, if there is one.
    fn tap(&self, vertex: u32, sample: usize) -> Option<Tap>;

    /// Where one vertex lies in another's texture frame, in pixels right and up; `None` if their frames do not agree.
    fn way(&self, from: u32, to: u32) -> Option<Vec2>;

    /// The vertices that share an edge with one.
    fn beside(&self, vertex: u32, visit: &mut dyn FnMut(u32));

    /// The vertex of the next coarser level that a vertex takes its place from, and where it lies from there, in pixels of this
    /// level right and up.
    fn parent(&self, vertex: u32) -> (u32, Vec2);
}

/// A level of a mesh: all its vertices, with circles as wide as the level's pixels.
pub(super) struct Surface<'a> {
    mesh: &'a Mesh,
    frames: &'a [Frame],
    first: &'a [u32],
    /// World length of a pixel.
    pixel: f64,
    per: usize,
    samples: Vec<Packed>,
}

impl<'a> Surface<'a> {
    /// Reads the samples of a level in the frames' directions. `first` are the mesh's half-edges by vertex.
    pub(super) fn new(
        mesh: &'a Mesh,
        frames: &'a [Frame],
        first: &'a [u32],
        normals: &[glam::Vec3],
        marching: &Marching,
        level: usize,
        template: &Template,
    ) -> Self {
        let per = template.samples().len();
        let mut samples = vec![Packed::default(); mesh.vertex_count() * per];
        let read = |reader: &mut Reader, (chunk, out): (usize, &mut [Packed])| {
            for (k, out) in out.chunks_exact_mut(per).enumerate() {
                let v = chunk * CHUNK + k;
                marching.samples(reader, v as u32, level, frames[v].right, template, out);
            }
        };
        samples.par_chunks_mut(CHUNK * per).enumerate().for_each_init(|| Reader::new(mesh, normals), read);
        Self { mesh, frames, first, pixel: marching.pixel() * f64::from(1_u32 << level), per, samples }
    }

    /// Samples that nothing is found at.
    pub(super) fn missing(&self) -> u64 {
        self.samples.iter().filter(|s| s.face == NONE).count() as u64
    }
}

impl Ground for Surface<'_> {
    fn len(&self) -> usize {
        self.frames.len()
    }

    #[inline]
    fn tap(&self, vertex: u32, sample: usize) -> Option<Tap> {
        let packed = self.samples[vertex as usize * self.per + sample];
        (packed.face != NONE).then(|| Tap { vertices: self.mesh.faces[packed.face as usize], shares: packed.shares() })
    }

    #[inline]
    fn way(&self, from: u32, to: u32) -> Option<Vec2> {
        let (there, here) = (&self.frames[from as usize], &self.frames[to as usize]);
        // The frames' angle against each other, but for how the normals differ: exact where they do not.
        let turn = there.right.dot(here.right) + there.up.dot(here.up);
        let bent = 1.0 + there.normal.dot(here.normal);
        if turn < ALIGNED * bent {
            return None;
        }
        let way: DVec3 = (self.mesh.point(to) - self.mesh.point(from)) / self.pixel;
        let flat = Vec2::new(way.dot(there.right) as f32, way.dot(there.up) as f32);
        Some(flat.normalize_or_zero() * way.length() as f32)
    }

    fn beside(&self, vertex: u32, visit: &mut dyn FnMut(u32)) {
        let mut last = NONE;
        for h in self.mesh.ring(self.first[vertex as usize]) {
            visit(self.mesh.origin(next(h)));
            last = h;
        }
        if last != NONE && self.mesh.opposite[prev(last) as usize] == NONE {
            visit(self.mesh.origin(prev(last)));
        }
    }

    fn parent(&self, vertex: u32) -> (u32, Vec2) {
        (vertex, Vec2::ZERO)
    }
}

/// A level of a plane: pixels in rows from the top, samples between the three pixels around them, as if every square of four were
/// cut from its top left to its bottom right.
pub(super) struct Plane {
    size: [usize; 2],
    /// For each sample three pixels, right and down, and their shares.
    taps: Vec<([[i32; 2]; 3], [f32; 3])>,
}

/// A sample this near to a pixel's row or column lies on it.
const SNAP: f32 = 1e-4;

impl Plane {
    pub(super) fn new(size: [usize; 2], template: &Template) -> Self {
        let tap = |s: &super::template::Sample| {
            let at = Vec2::new(s.offset.x, -s.offset.y);
            let snapped = at.map(|a| if (a - a.round()).abs() < SNAP { a.round() } else { a });
            let low = snapped.floor();
            let (part, [x, y]) = (snapped - low, [low.x as i32, low.y as i32]);
            let (u, v) = (part.x, part.y);
            // Above the diagonal, and below it.
            if u >= v {
                ([[x, y], [x + 1, y], [x + 1, y + 1]], [1.0 - u, u - v, v])
            } else {
                ([[x, y], [x + 1, y + 1], [x, y + 1]], [1.0 - v, u, v - u])
            }
        };
        Self { size, taps: template.samples().iter().map(tap).collect() }
    }

    fn at(&self, vertex: u32) -> [i32; 2] {
        [(vertex as usize % self.size[0]) as i32, (vertex as usize / self.size[0]) as i32]
    }

    fn vertex(&self, [x, y]: [i32; 2]) -> Option<u32> {
        let inside = (0..self.size[0] as i32).contains(&x) && (0..self.size[1] as i32).contains(&y);
        inside.then(|| (y as usize * self.size[0] + x as usize) as u32)
    }
}

impl Ground for Plane {
    fn len(&self) -> usize {
        self.size[0] * self.size[1]
    }

    #[inline]
    fn tap(&self, vertex: u32, sample: usize) -> Option<Tap> {
        let [x, y] = self.at(vertex);
        let (pixels, shares) = &self.taps[sample];
        let mut vertices = [vertex; 3];
        for k in 0..3 {
            if shares[k] > 0.0 {
                vertices[k] = self.vertex([x + pixels[k][0], y + pixels[k][1]])?;
            }
        }
        Some(Tap { vertices, shares: *shares })
    }

    #[inline]
    fn way(&self, from: u32, to: u32) -> Option<Vec2> {
        let ([x, y], [u, v]) = (self.at(from), self.at(to));
        Some(Vec2::new((u - x) as f32, (y - v) as f32))
    }

    fn beside(&self, vertex: u32, visit: &mut dyn FnMut(u32)) {
        let [x, y] = self.at(vertex);
        [[x + 1, y], [x, y - 1], [x - 1, y], [x, y + 1]].into_iter().filter_map(|p| self.vertex(p)).for_each(visit);
    }

    fn parent(&self, vertex: u32) -> (u32, Vec2) {
        let [x, y] = self.at(vertex);
        let width = self.size[0].div_ceil(2);
        let side = |a: i32| if a % 2 == 0 { -0.5 } else { 0.5 };
        ((y as usize / 2 * width + x as usize / 2) as u32, Vec2::new(side(x), -side(y)))
    }
}

/// The sizes of a plane's levels, the finest first.
pub(super) fn plane_sizes(size: [usize; 2], grid: Grid) -> Vec<[usize; 2]> {
    (0..grid.levels).map(|l| size.map(|s| s.div_ceil(1 << l))).collect()
}
