//! Pieces of a texture: squares of pixels cut from a surface or from an image, in the same way.

use crate::exemplar::{Channel, Exemplar, Image, Wrap, srgb};
use crate::mesh::walk::Walker;
use crate::mesh::{Mesh, SurfacePoint};
use crate::random::Random;
use crate::surface::SurfaceTexture;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Squares of pixels, three numbers each, encoded as sRGB.
#[derive(Debug, Clone, PartialEq)]
pub struct Pieces {
    /// Pixels along each side.
    pub side: usize,
    /// For each piece its rows from the top.
    pub data: Vec<Vec<[f32; 3]>>,
}

/// A texture on a surface with what its pieces need.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    /// The surface.
    pub on: &'a Walker<'a>,
    /// What it shows.
    pub texture: &'a dyn SurfaceTexture,
    /// Texture right at a point; need not be unit or tangent.
    pub right: &'a (dyn Fn(SurfacePoint) -> DVec3 + Sync),
    /// World length of a pixel.
    pub pixel: f64,
}

/// Places along the sides of a piece at which it is looked whether it unrolls, less one; and how much longer or shorter than in the plane the
/// ways between them may be.
const UNROLLED: u32 = 12;
const PULLED: f64 = 1.3;

/// Offsets of a piece's pixels from its middle, pixels right and down.
fn offsets(side: usize) -> impl Iterator<Item = [f64; 2]> {
    let middle = (side as f64 - 1.0) / 2.0;
    (0..side * side).map(move |i| [(i % side) as f64 - middle, (i / side) as f64 - middle])
}

/// Points spread over a surface by area.
#[derive(Debug, Clone)]
pub struct ByArea {
    /// Areas of the faces up to each one.
    sums: Vec<f64>,
}

impl ByArea {
    /// Sums up the areas.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let sum = |sum: &mut f64, f: u32| {
            *sum += mesh.area(f);
            Some(*sum)
        };
        Self { sums: (0..mesh.face_count() as u32).scan(0.0, sum).collect() }
    }

    /// The next point; a mesh without faces has none.
    pub fn draw(&self, random: &mut Random) -> Option<SurfacePoint> {
        let area = random.range(0.0, *self.sums.last()?);
        let face = (self.sums.partition_point(|&s| s <= area) as u32).min(self.sums.len() as u32 - 1);
        // Uniform on a triangle: the half of the square beyond the diagonal is folded back.
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        Some(SurfacePoint { face, bary: Vec3::new((1.0 - u - v) as f32, u as f32, v as f32) })
    }

    /// So many points, each by its own stream of a seed.
    #[must_use]
    pub fn points(&self, count: usize, seed: u64) -> Vec<SurfacePoint> {
        (0..count).filter_map(|k| self.draw(&mut Random::new(seed, k as u64))).collect()
    }
}

/// The directions of a piece at a point, right and down, unit.
pub(super) fn directions(at: &Placed, point: SurfacePoint) -> [DVec3; 2] {
    let normal = at.on.mesh().normal(point.face);
    let right = (at.right)(point);
    let right = (right - normal * right.dot(normal)).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    [right, right.cross(normal)]
}

/// Pieces around points spread over a surface by area; each pixel lies straight ahead from its point.
#[must_use]
pub fn of_surface(at: &Placed, side: usize, count: usize, seed: u64) -> Pieces {
    around(at, side, &ByArea::new(at.on.mesh()).points(count, seed))
}

/// Pieces around given points.
#[must_use]
pub fn around(at: &Placed, side: usize, points: &[SurfacePoint]) -> Pieces {
    let one = |&point: &SurfacePoint| -> Vec<[f32; 3]> {
        let [right, down] = directions(at, point);
        let pixel = |[x, y]: [f64; 2]| {
            let there = at.on.walk(point, (right * x + down * y) * at.pixel);
            at.texture.texel(there, 0.0).base_color.to_array().map(srgb::encode_near)
        };
        offsets(side).map(pixel).collect()
    };
    Pieces { side, data: points.par_iter().map(one).collect() }
}

/// True if a piece around a point lies on the surface nearly as it does in the plane: nowhere torn, folded or pulled.
#[must_use]
pub fn unrolls(at: &Placed, side: usize, point: SurfacePoint) -> bool {
    let [right, down] = directions(at, point);
    let step = side as f64 / f64::from(UNROLLED);
    let place = |i: u32| {
        let [x, y] = [i % (UNROLLED + 1), i / (UNROLLED + 1)].map(|k| (f64::from(k) * step) - side as f64 / 2.0);
        at.on.mesh().position(at.on.walk(point, (right * x + down * y) * at.pixel))
    };
    let places: Vec<DVec3> = (0..(UNROLLED + 1) * (UNROLLED + 1)).map(place).collect();
    let beside = |a: usize, b: usize| {
        let length = places[a].distance(places[b]) / (step * at.pixel);
        (1.0 / PULLED..=PULLED).contains(&length)
    };
    let row = UNROLLED as usize + 1;
    (0..places.len()).all(|i| (i % row == row - 1 || beside(i, i + 1)) && (i / row == row - 1 || beside(i, i + row)))
}

/// Pieces of an exemplar, between its pixels as those of a surface are; from the part of its width between two shares. No
/// pieces if that part is too small, unless the exemplar tiles.
#[must_use]
pub fn of_image(exemplar: &Exemplar, side: usize, count: usize, seed: u64, part: [f64; 2]) -> Pieces {
    let Some(view) = Room::new(exemplar, side, part) else { return Pieces { side, data: Vec::new() } };
    let one = |k: usize| {
        let mut random = Random::new(seed, k as u64);
        view.piece(side, [0, 1].map(|axis| random.range(view.low[axis], view.high[axis])))
    };
    Pieces { side, data: (0..count).into_par_iter().map(one).collect() }
}

/// An exemplar's image, and where middles of pieces may lie on it.
pub(super) struct Room<'a> {
    image: &'a Image,
    tiles: bool,
    low: [f64; 2],
    high: [f64; 2],
}

impl<'a> Room<'a> {
    /// For pieces of a side, in the part of its width between two shares. `None` if that is too small, unless the exemplar tiles.
    pub(super) fn new(exemplar: &'a Exemplar, side: usize, part: [f64; 2]) -> Option<Self> {
        let image = exemplar.channel(Channel::BaseColor)?.finest();
        let [w, h] = image.size().map(f64::from);
        let tiles = exemplar.wrap == Wrap::Repeat;
        let reach = if tiles { 0.0 } else { side as f64 / 2.0 };
        let (low, high) = ([part[0] * w + reach, reach], [part[1] * w - reach, h - reach]);
        (low[0] <= high[0] && low[1] <= high[1]).then_some(Self { image, tiles, low, high })
    }

    /// Middles on an even grid, as many as `most`, but no closer than so many pixels.
    pub(super) fn grid(&self, most: usize, closest: f64) -> Vec<[f64; 2]> {
        let size = [0, 1].map(|axis| self.high[axis] - self.low[axis]);
        let step = (size[0] * size[1] / most as f64).sqrt().max(closest);
        // What tiles goes on where it began.
        let along = |axis: usize| (size[axis] / step) as usize + usize::from(!self.tiles);
        let [columns, rows] = [along(0), along(1)].map(|count| count.max(1));
        (0..columns * rows)
            .map(|i| [self.low[0] + step * (i % columns) as f64, self.low[1] + step * (i / columns) as f64])
            .collect()
    }

    /// The piece around a middle.
    pub(super) fn piece(&self, side: usize, [x, y]: [f64; 2]) -> Vec<[f32; 3]> {
        offsets(side).map(|[dx, dy]| self.at(x + dx, y + dy).to_array().map(srgb::encode_near)).collect()
    }

    fn at(&self, x: f64, y: f64) -> Vec3 {
        let [w, h] = self.image.size().map(i64::from);
        let (x, y) = (x - 0.5, y - 0.5);
        let ([x0, y0], u, v) = ([x.floor(), y.floor()], (x - x.floor()) as f32, (y - y.floor()) as f32);
        let pixel = |dx: i64, dy: i64| {
            let (x, y) = (x0 as i64 + dx, y0 as i64 + dy);
            if self.tiles { self.image.pixel(x.rem_euclid(w), y.rem_euclid(h)) } else { self.image.pixel(x, y) }
        };
        pixel(0, 0).lerp(pixel(1, 0), u).lerp(pixel(0, 1).lerp(pixel(1, 1), u), v)
    }
}

impl Pieces {
    /// The same at half the size: 2x2 pixels averaged.
    #[must_use]
    pub fn halved(&self) -> Self {
        let (side, from) = (self.side / 2, self.side);
        let one = |piece: &Vec<[f32; 3]>| -> Vec<[f32; 3]> {
            let mean = |i: usize| {
                let (x, y) = (2 * (i % side), 2 * (i / side));
                let four = [piece[y * from + x], piece[y * from + x + 1], piece[(y + 1) * from + x], piece[(y + 1) * from + x + 1]];
                std::array::from_fn(|k| four.iter().map(|p| p[k]).sum::<f32>() / 4.0)
            };
            (0..side * side).map(mean).collect()
        };
        Self { side, data: self.data.iter().map(one).collect() }
    }

    /// The square of `side` pixels in the middle of each piece, as rows of numbers.
    #[must_use]
    pub fn middles(&self, side: usize) -> crate::numeric::rows::Rows {
        let side = side.min(self.side);
        let from = (self.side - side) / 2;
        let mut out = crate::numeric::rows::Rows::new(3 * side * side);
        for piece in &self.data {
            let rows = (from..from + side).flat_map(|y| &piece[y * self.side + from..][..side]);
            out.push(&rows.copied().collect::<Vec<_>>().concat());
        }
        out
    }
}
