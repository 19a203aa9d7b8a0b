//! A model whose relief is real: the mesh cut fine and moved by the texture's height, with the atlas of the mesh it came from.
//!
//! 1. Unwrap the mesh, and cut its faces until none is larger than asked ([`cut_larger`]); the atlas follows, since cutting moves
//!    nothing.
//! 2. Bake as ever. Of the normal map only what the geometry cannot have is left: how the normals at a texel differ from their mean
//!    over a face of the fine mesh. Where faces are no larger than texels, that is nothing, and no normal map is written.
//! 3. Move each vertex along its smooth normal by its height. A vertex on a chart border is one vertex while it moves, so
//!    nothing tears.

use super::bake::{BakeJob, BakeReport, BakedModel, Coordinates, take_pages};
use crate::atlas::{Atlas, AtlasError, Frames, bake, stretch, unwrap};
use crate::exemplar::{Channel, ChannelSet};
use crate::format::{Look, Model};
use crate::mesh::subdivide::{Subdivision, cut_larger};
use crate::mesh::{Mesh, SurfacePoint};
use crate::progress::Progress;
use crate::render::normals::{corner_normals, crease_angle};
use crate::surface::{SurfaceTexture, Texel};
use glam::{Quat, Vec2};
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

/// A texture whose normals have only what is finer than a width; none at all without one.
struct Finer<'a> {
    texture: &'a dyn SurfaceTexture,
    mesh: &'a Mesh,
    width: Option<f32>,
}

impl Finer<'_> {
    /// What is left of a normal, given its mean around.
    fn rest(&self, face: u32, texel: &mut Texel, mean: &Texel) {
        let flat = self.mesh.normal(face).as_vec3().try_normalize();
        if let (Some(flat), Some(mean), Some(own)) = (flat, mean.normal.try_normalize(), texel.normal.try_normalize()) {
            texel.normal = (Quat::from_rotation_arc(mean, flat) * own).normalize_or(flat);
        }
    }
}

impl SurfaceTexture for Finer<'_> {
    fn channels(&self) -> ChannelSet {
        let kept = |c: &Channel| *c != Channel::Normal || self.width.is_some();
        self.texture.channels().iter().filter(kept).fold(ChannelSet::default(), ChannelSet::with)
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let mut texel = self.texture.texel(at, footprint);
        if let Some(width) = self.width {
            self.rest(at.face, &mut texel, &self.texture.texel(at, width));
        }
        texel
    }

    fn texels(&self, points: &[(SurfacePoint, f32)], shown: &mut [Texel]) -> Result<(), String> {
        self.texture.texels(points, shown)?;
        if let Some(width) = self.width {
            let wide: Vec<(SurfacePoint, f32)> = points.iter().map(|&(at, _)| (at, width)).collect();
            let mut means = shown.to_vec();
            self.texture.texels(&wide, &mut means)?;
            for ((&(at, _), texel), mean) in points.iter().zip(shown).zip(&means) {
                self.rest(at.face, texel, mean);
            }
        }
        Ok(())
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
    let crease = job.crease.unwrap_or_else(|| crease_angle(mesh));
    let largest = mesh.total_area() / (displace.faces.max(1) as f64 * MEAN_SHARE);
    let fine = cut_larger(mesh, largest).map_err(|e| AtlasError::Displace(e.to_string()))?;
    let fine = fine.unwrap_or_else(|| Subdivision::none(mesh));
    // Two faces make up a square of this side.
    let width = (2.0 * mesh.total_area() / fine.mesh.face_count().max(1) as f64).sqrt();
    let finer = texture.channels().has(Channel::Normal) && width * atlas.density(mesh) > 1.0;
    let kept = Finer { texture, mesh, width: finer.then_some(width as f32) };
    let normals = corner_normals(mesh, crease);
    let frames = if finer { Frames::with_tangents(mesh, &atlas, normals) } else { Frames::smooth(normals) };
    let baked = bake(mesh, &atlas, &frames, &kept, &job.bake, progress)?;

    progress.stage("displacing", 0);
    let moved = moved(&fine, texture, displace.height);
    let normals = corner_normals(&moved, crease);
    let frames = if finer { Frames::with_tangents(&moved, &on_pieces(&fine, &atlas), normals) } else { Frames::smooth(normals) };
    let (model, mut look) = split(&moved, &fine, &atlas, &frames);
    take_pages(&mut look, baked.pages);
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

/// The place in the atlas of a corner of a fine face.
fn place(fine: &Subdivision, atlas: &Atlas, face: usize, corner: usize) -> Vec2 {
    let [a, b, c] = atlas.face_uv(fine.parent[face]);
    let bary = fine.corners[face][corner];
    a * bary.x + b * bary.y + c * bary.z
}

/// The atlas with the faces as they are cut, every corner for itself.
fn on_pieces(fine: &Subdivision, atlas: &Atlas) -> Atlas {
    let faces = 0..fine.parent.len();
    Atlas {
        chart: fine.parent.iter().map(|&f| atlas.chart[f as usize]).collect(),
        corners: faces.clone().map(|f| [0, 1, 2].map(|k| 3 * f as u32 + k)).collect(),
        vertices: fine.mesh.faces.as_flattened().to_vec(),
        uv: faces.flat_map(|f| [0, 1, 2].map(|k| place(fine, atlas, f, k))).collect(),
        ..atlas.clone()
    }
}

/// The model of a mesh whose vertices are split where the atlas or the normals are.
fn split(mesh: &Mesh, fine: &Subdivision, atlas: &Atlas, frames: &Frames) -> (Model, Look) {
    let (mut model, mut look) = (Model::default(), Look::default());
    let mut out_normals = Vec::new();
    let mut tangents = Vec::new();
    // For each vertex the copies made of it so far, as a chain.
    let none = u32::MAX;
    let mut first = vec![none; mesh.vertex_count()];
    let mut following: Vec<u32> = Vec::new();
    for (f, corners) in mesh.faces.iter().enumerate() {
        model.faces.push([0, 1, 2].map(|k| {
            let uv = place(fine, atlas, f, k);
            let (vertex, normal) = (corners[k] as usize, frames.normals[f][k]);
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
            tangents.extend(frames.tangents.get(f).map(|t| t[k]));
            look.uv.push(uv);
            following.push(std::mem::replace(&mut first[vertex], made));
            made
        }));
        if atlas.pages > 1 {
            look.face_page.push(atlas.page_of(fine.parent[f]));
        }
    }
    model.normals = Some(out_normals);
    look.tangents = (!tangents.is_empty()).then_some(tangents);
    (model, look)
}
