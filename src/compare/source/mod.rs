//! Where in the exemplar what is shown comes from: the source map of a texture.
//!
//! All that is compared here copies its exemplar, pixel by pixel or piece by piece, and so has a place of it at every point of the
//! surface. That place tells what colours cannot: whether neighbours were copied together, whether the same place comes again, how
//! large and which way the exemplar lies.
//!
//! A blend of several places (soft edges of pastes, projections that fade into each other, values between vertices) counts as the one
//! that weighs most.

mod baked;
mod pasted;
mod vertex;

pub use baked::BakedSource;
pub use pasted::PastedSource;
pub use vertex::{SeenSource, VertexSource};

use crate::mesh::Mesh;
use crate::surface::SurfaceTexture;
use glam::{DVec2, DVec3};

/// The place of the exemplar that a surface point shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Pixels of the exemplar, right and down from its top left corner; may lie outside one that tiles.
    pub pixel: DVec2,
    /// Texture right at the point, unit, in the plane of its face.
    pub right: DVec3,
    /// World steps of one pixel right and down; `None` where neighbours were not copied together.
    pub steps: Option<[DVec3; 2]>,
}

/// A texture that knows where what it shows comes from.
pub trait Sourced: SurfaceTexture {
    /// The place of the exemplar at a point; `None` where nothing is shown.
    fn origin(&self, at: crate::mesh::SurfacePoint) -> Option<Origin>;

    /// The texture was turned by multiples of a full turn over this on purpose, since the exemplar looks the same so.
    fn ways(&self) -> u32 {
        1
    }
}

/// The exemplar that places are of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Pixels.
    pub size: DVec2,
    /// Whether it goes on over its edges.
    pub tiles: bool,
    /// World length of a pixel, as asked for.
    pub pixel: f64,
}

impl Plane {
    /// The way between two places of the exemplar; over its edges if it tiles.
    #[must_use]
    pub fn between(&self, from: DVec2, to: DVec2) -> DVec2 {
        let way = to - from;
        if self.tiles { way - (way / self.size).round() * self.size } else { way }
    }

    /// The place within the exemplar, whether or not it tiles.
    #[must_use]
    pub fn wrapped(&self, place: DVec2) -> DVec2 {
        place.rem_euclid(self.size)
    }

    /// The way in pixels that a step on the surface makes in a copy that goes on.
    #[must_use]
    pub fn expected(&self, mesh: &Mesh, face: u32, origin: &Origin, step: DVec3) -> DVec2 {
        match origin.steps {
            Some(steps) => solved(steps, step),
            None => DVec2::new(step.dot(origin.right), step.dot(origin.right.cross(mesh.normal(face)))) / self.pixel,
        }
    }

    /// How far, in pixels, `to` lies from where a copy that goes on from `from` would be after a step on the surface.
    #[must_use]
    pub fn gap(&self, mesh: &Mesh, face: u32, from: &Origin, to: &Origin, step: DVec3) -> f64 {
        let there = from.pixel + self.expected(mesh, face, from, step);
        self.between(there, to.pixel).length()
    }
}

/// A vector in the plane of two others, by their shares.
fn solved([a, b]: [DVec3; 2], v: DVec3) -> DVec2 {
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let determinant = aa * bb - ab * ab;
    if determinant > f64::MIN_POSITIVE {
        let (av, bv) = (a.dot(v), b.dot(v));
        DVec2::new(bb * av - ab * bv, aa * bv - ab * av) / determinant
    } else {
        DVec2::ZERO
    }
}

/// World steps of one pixel right and down on a face whose corners show three places; `None` if those lie on a line.
#[must_use]
pub(super) fn steps([p, q, r]: [DVec3; 3], [a, b, c]: [DVec2; 3]) -> Option<[DVec3; 2]> {
    let (d, e) = (b - a, c - a);
    let double = d.perp_dot(e);
    let steps = [((q - p) * e.y - (r - p) * d.y) / double, ((r - p) * d.x - (q - p) * e.x) / double];
    steps.iter().all(|s| s.is_finite()).then_some(steps)
}
