//! The camera's map between the world and the samples of a picture: where points lie on the grid, and where a sample's ray
//! meets a face.
//!
//! What is measured at a sample comes from the analytic intersection of its ray with the face's plane: perspective-correct
//! by construction, and free of the rasterizer's snapping.

use super::RenderError;
use super::camera::{Camera, Projection};
use crate::mesh::{Mesh, SurfacePoint};
use glam::{DVec2, DVec3};

/// The most samples along one side of a picture: coordinates then fit 27 bits.
const MAX_SIDE: u32 = 1 << 15;
/// The most samples in one picture: one gigabyte of face numbers.
const MAX_SAMPLES: u64 = 1 << 28;

/// The size of a picture and the samples within its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples along each side of a pixel: `samples * samples` in each.
    pub samples: u32,
}

impl Grid {
    /// Samples across and down.
    #[must_use]
    pub const fn size(self) -> [usize; 2] {
        [self.width as usize * self.samples as usize, self.height as usize * self.samples as usize]
    }

    /// Width over height.
    #[must_use]
    pub fn aspect(self) -> f64 {
        f64::from(self.width.max(1)) / f64::from(self.height.max(1))
    }

    /// # Errors
    /// If a side is zero or too long, or there are too many samples.
    pub fn check(self) -> Result<(), RenderError> {
        let Self { width, height, samples } = self;
        let [across, down] = [width, height].map(|n| u64::from(n) * u64::from(samples));
        let fits = across.min(down) > 0 && across.max(down) <= u64::from(MAX_SIDE) && across * down <= MAX_SAMPLES;
        fits.then_some(()).ok_or(RenderError::Size { width, height, samples, max_side: MAX_SIDE, max_samples: MAX_SAMPLES })
    }
}

/// What a ray through a sample meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The point on the surface.
    pub at: SurfacePoint,
    /// Where that is in the world.
    pub position: DVec3,
    /// Its distance from the eye along the camera's forward axis, world units.
    pub depth: f64,
    /// World width of the sample on the surface: the side of a square with the area that the sample covers there.
    pub footprint: f64,
    /// Whether the face's outer side is seen.
    pub front: bool,
    /// Unit vector from the point towards the eye.
    pub to_eye: DVec3,
}

/// The camera's map between the world and the grid of samples.
pub(super) struct Lens<'a> {
    pub(super) camera: &'a Camera,
    pub(super) size: [usize; 2],
    /// Samples per unit on the picture plane (at distance 1 for a perspective).
    scale: f64,
    middle: DVec2,
    perspective: bool,
}

/// Nearness as an affine function of the sample position: 1/depth in a perspective, -depth in a parallel projection. Held
/// between the values at the face's vertices, since the plane of a face seen edge-on is steep.
pub(super) struct Plane {
    at_origin: f64,
    slope: DVec2,
    low: f64,
    high: f64,
}

impl Plane {
    #[inline]
    pub(super) fn nearness(&self, x: f64, y: f64) -> f64 {
        (self.at_origin + self.slope.x * x + self.slope.y * y).max(self.low).min(self.high)
    }
}

impl<'a> Lens<'a> {
    pub(super) fn new(camera: &'a Camera, grid: Grid) -> Self {
        let size = grid.size();
        let half = 0.5 * size[1] as f64;
        let (scale, perspective) = match camera.projection {
            Projection::Perspective(tangent) => (half / tangent, true),
            Projection::Orthographic(height) => (half / height, false),
        };
        Self { camera, size, scale, middle: DVec2::new(0.5 * size[0] as f64, half), perspective }
    }

    /// Where a point in view coordinates lies on the grid of samples. Meaningless behind the eye.
    #[inline]
    pub(super) fn project(&self, view: DVec3) -> DVec2 {
        let scale = if self.perspective { self.scale / view.z } else { self.scale };
        self.middle + DVec2::new(view.x, -view.y) * scale
    }

    fn nearness(&self, depth: f64) -> f64 {
        if self.perspective { 1.0 / depth } else { -depth }
    }

    /// Start and direction of the ray through a place on the grid; the direction's part along forward is 1.
    #[inline]
    pub(super) fn ray(&self, at: [f64; 2]) -> (DVec3, DVec3) {
        let offset = (DVec2::from(at) - self.middle) / self.scale;
        let aside = self.camera.right * offset.x - self.camera.up * offset.y;
        if self.perspective {
            (self.camera.eye, self.camera.forward + aside)
        } else {
            (self.camera.eye + aside, self.camera.forward)
        }
    }

    pub(super) fn plane(&self, mesh: &Mesh, face: u32) -> Plane {
        let [a, b, c] = mesh.corners(face);
        let normal = (b - a).cross(c - a);
        let height = normal.dot(a - self.camera.eye);
        let along = DVec3::new(normal.dot(self.camera.right), -normal.dot(self.camera.up), normal.dot(self.camera.forward));
        // Perspective: 1/t = n.(f + r x + u y) / n.(a - eye). Parallel: -t = (n.(r x + u y) - n.(a - eye)) / n.f.
        let (constant, divisor) = if self.perspective { (along.z, height) } else { (-height, along.z) };
        let slope = along.truncate() / (divisor * self.scale);
        let near = [a, b, c].map(|p| self.nearness(self.camera.to_view(p).z.max(self.camera.near)));
        Plane {
            at_origin: constant / divisor - slope.dot(self.middle),
            slope,
            low: near[0].min(near[1]).min(near[2]),
            high: near[0].max(near[1]).max(near[2]),
        }
    }

    /// Where the ray through a place on the grid meets a face (or, just beside it, the face's nearest edge).
    pub(super) fn hit(&self, mesh: &Mesh, face: u32, at: [f64; 2]) -> Hit {
        let (start, direction) = self.ray(at);
        let [a, b, c] = mesh.corners(face);
        let area = (b - a).cross(c - a);
        let length = area.length();
        let normal = area / length;
        let slant = normal.dot(direction);
        let met = start - a + direction * (normal.dot(a - start) / slant);
        let weights = DVec3::new(
            (c - b).cross(met - (b - a)).dot(area),
            (a - c).cross(met - (c - a)).dot(area),
            (b - a).cross(met).dot(area),
        );
        let weights = weights / area.length_squared();
        let bary = if weights.is_finite() { weights.max(DVec3::ZERO) } else { DVec3::ONE };
        let bary = bary / bary.element_sum();
        let position = a * bary.x + b * bary.y + c * bary.z;
        let depth = (position - self.camera.eye).dot(self.camera.forward);
        // The area of the sample on the face's plane is z^2 / |n.d| times that on the picture plane.
        let width = if self.perspective { depth / self.scale } else { 1.0 / self.scale };
        Hit {
            at: SurfacePoint { face, bary: bary.as_vec3() },
            position,
            depth,
            footprint: width / slant.abs().max(MIN_SLANT).sqrt(),
            front: slant < 0.0,
            to_eye: -direction.normalize(),
        }
    }
}

/// The smallest cosine between ray and normal that widens the footprint: beyond, filtering would blur all detail away.
const MIN_SLANT: f64 = 0.05;
