//! Texture atlases: the surface cut into charts, the charts packed, any [`crate::surface::SurfaceTexture`] baked into them.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 4, "Rendering with a texture atlas", without the hand work.
//!
//! 1. [`unwrap()`] cuts the mesh into charts, lays them flat and packs them: an [`Atlas`].
//! 2. [`bake()`] asks the texture at every texel, fills the gutters, and makes both sides of each chart's border agree.
//! 3. [`AtlasTexture`] is what came out as a surface texture again.
//!
//! The atlas is in the space of glTF: (0, 0) is the top left corner of the image, texel centres lie at halves.

pub mod bake;
pub mod charts;
pub mod dilate;
pub mod frames;
pub mod grow;
pub mod keep;
pub mod measure;
pub mod mips;
pub mod parts;
pub mod raster;
pub mod seams;
pub mod texture;

pub use bake::{BakeOptions, BakeStatistics, Baked, Page, bake};
pub use charts::{ChartMethod, UnwrapOptions, unwrap};
pub use frames::Frames;
pub use keep::keep;
pub use measure::{Stretch, stretch};
pub use mips::mip_levels;
pub use texture::AtlasTexture;

use crate::mesh::{Mesh, NONE};
use glam::{DVec2, Vec2};

/// Why there is no atlas.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AtlasError {
    /// A side of no texels, or of more than can be made.
    #[error("an atlas of {0} x {0} texels cannot be made: give a size of 16 to {MAX_SIZE}")]
    Size(u32),
    /// Gutters so wide that nothing is left for the charts.
    #[error(
        "{charts} charts with gutters of {margin} texels find no room on {pages} page(s) of {size} x {size} texels: give a larger \
         --size, more --pages or fewer --mips"
    )]
    NoRoom {
        /// Charts to place.
        charts: usize,
        /// Texels around each.
        margin: u32,
        /// Pages allowed.
        pages: u32,
        /// Texels along a side.
        size: u32,
    },
    /// The mesh cannot be unwrapped.
    #[error("the mesh cannot be unwrapped: {0}: run `lapped inspect` on it, or bake into its own coordinates with --uv keep")]
    Unwrap(String),
    /// The mesh's own coordinates cannot hold a bake.
    #[error("the mesh's own texture coordinates cannot be baked into: {0}: leave --uv keep away, and charts are made")]
    Keep(String),
    /// The surface cannot be displaced.
    #[error("the surface cannot be displaced: {0}")]
    Displace(String),
    /// What was to answer for the texture failed.
    #[error("the texture cannot be baked: {0}: bake on the processor (--baker cpu)")]
    Baker(String),
    /// Asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// The widest page, in texels: four float channels of it are 4 GiB.
pub const MAX_SIZE: u32 = 16_384;

/// A mesh's charts and where they lie on their pages.
#[derive(Debug, Clone, PartialEq)]
pub struct Atlas {
    /// For each face its chart. A chart is a set of faces that share atlas vertices.
    pub chart: Vec<u32>,
    /// For each face its corners as indices into `vertices` and `uv`.
    pub corners: Vec<[u32; 3]>,
    /// Vertex of the mesh at each atlas vertex; a mesh vertex on a chart border is there once for each chart (or more often,
    /// where a chart meets itself).
    pub vertices: Vec<u32>,
    /// Place of each atlas vertex on its page, 0 to 1, (0, 0) at the top left.
    pub uv: Vec<Vec2>,
    /// For each chart its page.
    pub page: Vec<u32>,
    /// Number of pages.
    pub pages: u32,
    /// Texels along each side of a page.
    pub size: u32,
    /// Texels around each chart that belong to it.
    pub margin: u32,
}

impl Atlas {
    /// Number of charts.
    #[must_use]
    pub const fn chart_count(&self) -> usize {
        self.page.len()
    }

    /// Places of a face's corners, 0 to 1.
    #[inline]
    #[must_use]
    pub fn face_uv(&self, face: u32) -> [Vec2; 3] {
        self.corners[face as usize].map(|v| self.uv[v as usize])
    }

    /// Places of a face's corners in texels.
    #[inline]
    #[must_use]
    pub fn face_texels(&self, face: u32) -> [DVec2; 3] {
        self.face_uv(face).map(|uv| uv.as_dvec2() * f64::from(self.size))
    }

    /// The page a face lies on.
    #[inline]
    #[must_use]
    pub fn page_of(&self, face: u32) -> u32 {
        self.page[self.chart[face as usize] as usize]
    }

    /// Area of all charts over the area of all pages.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        let area: f64 = (0..self.corners.len() as u32).map(|f| self.texel_area(f)).sum();
        area / (f64::from(self.size).powi(2) * f64::from(self.pages))
    }

    /// Texels a world unit, the mean over the surface.
    #[must_use]
    pub fn density(&self, mesh: &Mesh) -> f64 {
        let texels: f64 = (0..self.corners.len() as u32).map(|f| self.texel_area(f)).sum();
        let world = mesh.total_area();
        if world > 0.0 { (texels / world).sqrt() } else { 0.0 }
    }

    fn texel_area(&self, face: u32) -> f64 {
        let [a, b, c] = self.face_texels(face);
        0.5 * (b - a).perp_dot(c - a).abs()
    }

    /// The half-edges of the mesh whose other side lies elsewhere in the atlas, one of each pair: (half-edge, opposite).
    pub fn seams<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = (u32, u32)> + 'a {
        (0..mesh.opposite.len() as u32).filter_map(move |h| {
            let o = mesh.opposite[h as usize];
            (o != NONE && h < o && self.parts(h, o)).then_some((h, o))
        })
    }

    fn parts(&self, h: u32, o: u32) -> bool {
        let at = |h: u32| self.corners[(h / 3) as usize][(h % 3) as usize];
        at(h) != at(crate::mesh::next(o)) || at(crate::mesh::next(h)) != at(o)
    }
}
