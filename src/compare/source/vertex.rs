//! The source map of a synthesised texture: at each point the place of the nearest vertex, and between vertices whose places go on
//! from each other the place between them.

use super::{Origin, Plane, Sourced, steps};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use crate::synth::{OnMesh, Place, VertexTexture};
use glam::{DVec2, DVec3};

/// Corners whose places lie farther than this from where a copy that goes on would be, as a share of their distance, were not copied
/// together. Texture frames of neighbours are turned against each other by some degrees on any curved surface.
const TURNED: f64 = 0.3;
/// And pixels by which they may always differ.
const LOOSE: f64 = 0.2;

/// A synthesised texture on its own mesh, and where it comes from.
#[derive(Debug, Clone, Copy)]
pub struct VertexSource<'a> {
    texture: &'a VertexTexture,
    plane: Plane,
}

impl<'a> VertexSource<'a> {
    /// Of a texture; `plane` is the exemplar it was made from.
    #[must_use]
    pub const fn new(texture: &'a VertexTexture, plane: Plane) -> Self {
        Self { texture, plane }
    }

    fn place(&self, vertex: u32) -> Option<DVec2> {
        match self.texture.places.get(vertex as usize)? {
            Place::Pixel(at) => Some(DVec2::new(f64::from(at[0]), f64::from(at[1]))),
            Place::Vertex(_) => None,
        }
    }
}

impl SurfaceTexture for VertexSource<'_> {
    fn channels(&self) -> ChannelSet {
        self.texture.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.texture.texel(at, footprint)
    }
}

impl Sourced for VertexSource<'_> {
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        let mesh = &self.texture.mesh;
        let corners = mesh.faces[at.face as usize];
        let main = (0..3).max_by(|&a, &b| at.bary[a].total_cmp(&at.bary[b]))?;
        let first = self.place(corners[main])?;
        let frame = self.texture.frames[corners[main] as usize];
        let [right, down] = [frame.right, -frame.up];
        let point = mesh.point(corners[main]);
        let ahead = |p: DVec3| DVec2::new((p - point).dot(right), (p - point).dot(down)) / self.plane.pixel;
        // The places of the other corners, as they lie about the first one's.
        let mut places = [first; 3];
        let mut together = true;
        for k in (0..3).filter(|&k| k != main) {
            let expected = ahead(mesh.point(corners[k]));
            let way = self.plane.between(first, self.place(corners[k])?);
            together &= (way - expected).length() <= TURNED * expected.length() + LOOSE;
            places[k] = first + way;
        }
        let normal = mesh.normal(at.face);
        let right = (right - normal * right.dot(normal)).normalize_or(right);
        let bary = at.bary.as_dvec3();
        let found = if together { steps(mesh.corners(at.face), places) } else { None };
        Some(match found {
            Some(steps) => {
                let pixel = places[0] * bary.x + places[1] * bary.y + places[2] * bary.z;
                Origin { pixel, right, steps: Some(steps) }
            }
            None => Origin { pixel: first + ahead(mesh.position(at)), right, steps: None },
        })
    }
}

/// The same seen from the mesh that the texture was made for: each point looks at the nearest one.
#[derive(Debug)]
pub struct SeenSource<'a> {
    on: OnMesh<'a>,
    source: VertexSource<'a>,
}

impl<'a> SeenSource<'a> {
    /// Binds a texture to a mesh.
    #[must_use]
    pub fn new(mesh: &'a Mesh, texture: &'a VertexTexture, plane: Plane) -> Self {
        Self { on: OnMesh::new(mesh, texture), source: VertexSource::new(texture, plane) }
    }
}

impl SurfaceTexture for SeenSource<'_> {
    fn channels(&self) -> ChannelSet {
        self.on.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.on.texel(at, footprint)
    }
}

impl Sourced for SeenSource<'_> {
    /// Directions are those on the texture's own mesh.
    fn origin(&self, at: SurfacePoint) -> Option<Origin> {
        self.source.origin(self.on.there(at)?)
    }
}
