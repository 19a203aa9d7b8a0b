//! A model whose relief is real: the mesh cut fine and moved by the texture's height, with the atlas of the mesh it came from.
//!
//! 1. Unwrap and bake as ever; the normal map is left out, since the geometry now has what it stood for.
//! 2. Cut faces until none is larger than asked ([`cut_larger`]); the atlas follows, since cutting moves nothing.
//! 3. Move each vertex along its smooth normal by its height. A vertex on a chart border is one vertex while it moves, so
//!    nothing tears.

use super::bake::{BakeJob, BakeReport, BakedModel, Coordinates};
use crate::atlas::{Atlas, AtlasError, Frames, bake, stretch, unwrap};
use crate::exemplar::{Channel, ChannelSet};
use crate::format::{Look, Model};
use crate::mesh::subdivide::{Subdivision, cut_larger};
use crate::mesh::{Mesh, SurfacePoint};
use crate::progress::Progress;
use crate::render::normals::{corner_normals, crease_angle};
use crate::surface::{SurfaceTexture, Texel};
use glam::{Vec2, Vec3};
use std::time::Instant;

/// How to displace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Displace {
    /// How far apart heights 0 and 1 are, world units; half of it goes outward, half inward.
    pub height: f64,
    /// Faces to cut the mesh into, about.
    pub faces: usize,
}

impl Displace {
    /// Faces by default: 400,000, what tools still turn smoothly.
    pub const FACES: usize = 400_000;
}

/// Cutting in four leaves faces between the largest allowed and a quarter of it, half of it on the mean.
const MEAN_SHARE: f64 = 0.5;

/// Places that rounding alone keeps apart, as a share of the page.
const SAME_PLACE: f32 = 1e-6;

/// A texture without its normals.
struct WithoutNormals<'a>(&'a dyn SurfaceTexture);

impl SurfaceTexture for WithoutNormals<'_> {
    fn channels(&self) -> ChannelSet {
        self.0.channels().iter().filter(|&c| c != Channel::Normal).fold(ChannelSet::default(), ChannelSet::with)
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.0.texel(at, footprint)
    }
}

/// Bakes a texture and displaces the mesh by its height.
///
/// # Errors
/// If the texture has no height, the charts do not fit, the mesh would get too large, or `progress` cancels.
pub fn displace_mesh(
    mesh: &Mesh,
    texture: &dyn SurfaceTexture,
    job: &BakeJob,
    displace: &Displace,
    progress: &dyn Progress,
) -> Result<BakedModel, AtlasError> {
    if !texture.channels().has(Channel::Height) {
        return Err(AtlasError::Displace("the texture has no height map, and heights are what moves the surface".into()));
    }
    if job.coordinates == Coordinates::Own {
        return Err(AtlasError::Displace("--uv keep and --displace do not go together: the faces are cut".into()));
    }
    let begin = Instant::now();
    let atlas = unwrap(mesh, &job.unwrap, progress)?;
    let unwrap_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let flat = WithoutNormals(texture);
    let crease = job.crease.unwrap_or_else(|| crease_angle(mesh));
    let baked = bake(mesh, &atlas, &Frames::smooth(corner_normals(mesh, crease)), &flat, &job.bake, progress)?;

    progress.stage("displacing", 0);
    let largest = mesh.total_area() / (displace.faces.max(1) as f64 * MEAN_SHARE);
    let fine = cut_larger(mesh, largest).map_err(|e| AtlasError::Displace(e.to_string()))?;
    let fine = fine.unwrap_or_else(|| Subdivision::none(mesh));
    let moved = moved(&fine, texture, displace.height);
    let normals = corner_normals(&moved, crease);
    let (model, mut look) = split(&moved, &fine, &atlas, &normals);
    look.pages = baked.pages.into_iter().map(|page| page.images).collect();
    let report = BakeReport {
        vertices: model.positions.len(),
        unwrap_seconds,
        bake_seconds: begin.elapsed().as_secs_f64(),
        ..BakeReport::new(mesh, &atlas, stretch(mesh, &atlas), baked.statistics)
    };
    Ok(BakedModel { model, look, atlas, report })
}

/// The fine mesh with every vertex moved along its normal.
fn moved(fine: &Subdivision, texture: &dyn SurfaceTexture, height: f64) -> Mesh {
    let mesh = &fine.mesh;
    let normals = mesh.vertex_normals();
    let mut known = vec![false; mesh.vertex_count()];
    let mut positions = mesh.positions.clone();
    for (f, corners) in mesh.faces.iter().enumerate() {
        // A texel of the width of the face: finer relief than the faces can carry would alias.
        let footprint = (2.0 * mesh.area(f as u32)).sqrt() as f32;
        for (k, &v) in corners.iter().enumerate() {
            if !std::mem::replace(&mut known[v as usize], true) {
                let texel = texture.texel(SurfacePoint { face: fine.parent[f], bary: fine.corners[f][k] }, footprint);
                let by = f64::from((texel.height - 0.5) * texel.alpha.clamp(0.0, 1.0)) * height;
                let from = mesh.point(v);
                positions[v as usize] = (from + normals[v as usize].as_dvec3() * by).as_vec3();
            }
        }
    }
    Mesh { positions, ..mesh.clone() }
}

/// The model of a mesh whose vertices are split where the atlas or the normals are.
fn split(mesh: &Mesh, fine: &Subdivision, atlas: &Atlas, normals: &[[Vec3; 3]]) -> (Model, Look) {
    let (mut model, mut look) = (Model::default(), Look::default());
    let mut out_normals = Vec::new();
    // For each vertex the copies made of it so far, as a chain.
    let none = u32::MAX;
    let mut first = vec![none; mesh.vertex_count()];
    let mut following: Vec<u32> = Vec::new();
    for (f, corners) in mesh.faces.iter().enumerate() {
        let place = atlas.face_uv(fine.parent[f]);
        model.faces.push([0, 1, 2].map(|k| {
            let bary = fine.corners[f][k];
            let uv: Vec2 = place[0] * bary.x + place[1] * bary.y + place[2] * bary.z;
            let (vertex, normal) = (corners[k] as usize, normals[f][k]);
            let mut at = first[vertex];
            while at != none {
                let i = at as usize;
                let same: Vec2 = look.uv[i];
                if (same - uv).abs().max_element() < SAME_PLACE && out_normals[i] == normal {
                    return at;
                }
                at = following[i];
            }
            let made = look.uv.len() as u32;
            model.positions.push(mesh.positions[vertex]);
            out_normals.push(normal);
            look.uv.push(uv);
            following.push(std::mem::replace(&mut first[vertex], made));
            made
        }));
        if atlas.pages > 1 {
            look.face_page.push(atlas.page_of(fine.parent[f]));
        }
    }
    model.normals = Some(out_normals);
    (model, look)
}
