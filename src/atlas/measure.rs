//! What a set of charts is worth: stretch, and whether any texel is owned twice.

use super::Atlas;
use super::raster::Triangle;
use crate::mesh::{Mesh, NONE};
use serde::Serialize;

/// Texture stretch after Sander et al., "Texture Mapping Progressive Meshes", SIGGRAPH 2001: how finely the atlas samples the
/// surface, against the same number of texels spread evenly. 1 is perfect.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Stretch {
    /// Root mean square over the surface and over directions.
    pub l2: f64,
    /// The largest anywhere, in any direction.
    pub linf: f64,
    /// Faces without area in the atlas, left out of both.
    pub collapsed_faces: usize,
    /// Their share of the surface.
    pub collapsed_share: f64,
}

/// Measures the stretch of an atlas.
#[must_use]
pub fn stretch(mesh: &Mesh, atlas: &Atlas) -> Stretch {
    let (mut squares, mut world, mut texels) = (0.0, 0.0, 0.0);
    let (mut linf, mut lost): (f64, f64) = (0.0, 0.0);
    let mut collapsed_faces = 0;
    for f in 0..mesh.face_count() as u32 {
        let area = mesh.area(f);
        let [a, b, c] = atlas.face_texels(f);
        let double = (b - a).perp_dot(c - a);
        if double.abs() < f64::MIN_POSITIVE {
            collapsed_faces += 1;
            lost += area;
            continue;
        }
        let [p, q, r] = mesh.corners(f);
        // World steps of one texel right and down.
        let along_u = (p * (b.y - c.y) + q * (c.y - a.y) + r * (a.y - b.y)) / double;
        let along_v = (p * (c.x - b.x) + q * (a.x - c.x) + r * (b.x - a.x)) / double;
        let (uu, uv, vv) = (along_u.length_squared(), along_u.dot(along_v), along_v.length_squared());
        squares += 0.5 * (uu + vv) * area;
        linf = linf.max((0.5 * (uu + vv + ((uu - vv).powi(2) + 4.0 * uv * uv).sqrt())).sqrt());
        world += area;
        texels += 0.5 * double.abs();
    }
    if world <= 0.0 {
        return Stretch { collapsed_faces, collapsed_share: 1.0, ..Stretch::default() };
    }
    let even = (texels / world).sqrt();
    Stretch { l2: (squares / world).sqrt() * even, linf: linf * even, collapsed_faces, collapsed_share: lost / (lost + world) }
}

/// What lies on top of what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Overlap {
    /// Texels that two charts touch.
    pub shared_texels: usize,
    /// Texels whose centre lies in two faces.
    pub doubled_texels: usize,
    /// Faces that lie upside down.
    pub flipped_faces: usize,
}

/// Rasterizes an atlas at `size` texels a side, looking for texels that are owned twice.
#[must_use]
pub fn overlap(mesh: &Mesh, atlas: &Atlas, size: u32) -> Overlap {
    let n = i64::from(size);
    let mut found = Overlap::default();
    for page in 0..atlas.pages {
        let mut owner = vec![NONE; (n * n) as usize];
        let mut shared = vec![false; owner.len()];
        let mut inside = vec![false; owner.len()];
        for f in (0..mesh.face_count() as u32).filter(|&f| atlas.page_of(f) == page) {
            let corners = atlas.face_uv(f).map(|p| p.as_dvec2() * f64::from(size));
            let Some(triangle) = Triangle::new(corners) else { continue };
            found.flipped_faces += usize::from(!triangle.upright());
            let chart = atlas.chart[f as usize];
            let place = |x: i64, y: i64| ((0..n).contains(&x) && (0..n).contains(&y)).then(|| (y * n + x) as usize);
            triangle.touched(0..n, |x, y| {
                if let Some(i) = place(x, y) {
                    shared[i] |= owner[i] != NONE && owner[i] != chart;
                    owner[i] = chart;
                }
            });
            triangle.samples(0..n, 1, |x, y, _| {
                if let Some(i) = place(x, y) {
                    found.doubled_texels += usize::from(std::mem::replace(&mut inside[i], true));
                }
            });
        }
        found.shared_texels += shared.iter().filter(|&&s| s).count();
    }
    found
}
