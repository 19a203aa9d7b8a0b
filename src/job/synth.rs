//! Synthesis from end to end: a clean mesh and an exemplar in, a vertex texture out.
//!
//! 1. The exemplar is brought to the size asked for; its pyramid has as many levels as its smaller side allows.
//! 2. The mesh is re-tiled so that a vertex stands for a pixel of the exemplar, and coarser levels with a quarter each.
//! 3. Directions are found for the vertices of every level.
//! 4. `synth` matches level by level.

use super::directions::{Direction, Way, directions};
use super::input::Steer;
use crate::exemplar::stack::{self, Stack, resized, tiles};
use crate::exemplar::{Channel, Exemplar, Wrap};
use crate::field::FieldError;
use crate::mesh::nearest::Nearest;
use crate::mesh::pyramid::{Pyramid, pyramid};
use crate::mesh::retile::{MAX_VERTICES, RetileError, RetileOptions, RetileStatistics};
use crate::mesh::{Cleaned, Mesh};
use crate::progress::Progress;
use crate::surface::{SurfaceTexture, Texel};
use crate::synth::{Frame, LevelDone, Levels, Source, SynthError, SynthOptions, SynthStatistics, VertexTexture, synthesize};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;

/// Vertices unless more or fewer are asked for.
pub const VERTICES: usize = 24_576;

/// An exemplar's longer side, pixels, unless another size is asked for: a vertex stands for a pixel.
pub const SIDE: u32 = 128;

/// The smaller side of the exemplar's coarsest level, pixels, at least: with fewer there is nothing to choose from.
const COARSEST: u32 = 4;

/// Vertices of the coarsest level at least.
const FEWEST: usize = 48;

/// How many vertices to synthesise on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Density {
    /// So many.
    Vertices(usize),
    /// As many as make one width of the exemplar so long, world units.
    Scale(f64),
}

impl Density {
    /// The number of vertices on a mesh, each standing for a pixel of an exemplar `width` pixels wide.
    ///
    /// # Errors
    /// If a scale asks for too few or too many.
    pub fn vertices(self, mesh: &Mesh, width: u32) -> Result<usize, ScaleError> {
        match self {
            Self::Vertices(n) => Ok(n),
            Self::Scale(scale) => {
                let vertices = mesh.total_area() / (scale / f64::from(width)).powi(2);
                if !(scale > 0.0 && (4.0..=MAX_VERTICES as f64).contains(&vertices)) {
                    return Err(ScaleError { scale, vertices });
                }
                Ok(vertices.round() as usize)
            }
        }
    }
}

/// A scale that is none, or asks for too much.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a scale of {scale} asks for {vertices:.3e} vertices: give one that asks for 4 to {MAX_VERTICES}")]
pub struct ScaleError {
    /// The scale.
    pub scale: f64,
    /// Vertices it asks for.
    pub vertices: f64,
}

/// A job.
#[derive(Debug, Clone)]
pub struct SynthJob {
    /// How many vertices.
    pub density: Density,
    /// Levels at most.
    pub levels: usize,
    /// The exemplar's longer side, pixels; `None` keeps it, but brings it to [`SIDE`] if it is larger.
    pub side: Option<u32>,
    /// Whether the exemplar goes on over its edges; `None` finds out.
    pub tiles: Option<bool>,
    /// Which way.
    pub direction: Direction,
    /// Re-tiling keeps edges over which the surface bends by more than this, radians.
    pub crease: Option<f64>,
    /// Also relax the paper's own error of directions.
    pub nearest: bool,
    /// The method.
    pub options: SynthOptions,
}

impl Default for SynthJob {
    fn default() -> Self {
        Self {
            density: Density::Vertices(VERTICES),
            levels: 4,
            side: None,
            tiles: None,
            direction: Direction::Steered(Steer::Relaxed(1)),
            crease: None,
            nearest: false,
            options: SynthOptions::default(),
        }
    }
}

impl SynthJob {
    fn way(&self) -> Way<'_> {
        Way { direction: &self.direction, nearest: self.nearest, seed: self.options.seed }
    }
}

/// Why a job fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SynthJobError {
    /// A scale that is none, or asks for too much.
    #[error(transparent)]
    Scale(#[from] ScaleError),
    /// The mesh cannot be re-tiled so.
    #[error(transparent)]
    Retile(#[from] RetileError),
    /// The directions cannot be made.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The synthesis itself.
    #[error(transparent)]
    Synth(#[from] SynthError),
}

/// What a job did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SynthReport {
    /// Size of the exemplar as it was used, pixels.
    pub exemplar: [u32; 2],
    /// It goes on over its edges.
    pub tiles: bool,
    /// World length of one exemplar width.
    pub scale: f64,
    /// Distance of two samples, world units.
    pub spacing: f64,
    /// Re-tiling, the finest level first.
    pub retile: Vec<RetileStatistics>,
    /// Singularities of the directions on the finest level, if a smooth field was made.
    pub singularities: Option<usize>,
    /// Synthesis, the coarsest level first.
    pub synth: SynthStatistics,
    /// Seconds for re-tiling all levels, for directions, and for synthesis.
    pub seconds: [f64; 3],
}

/// What comes out.
#[derive(Debug)]
pub struct Synthesized {
    /// Values at the vertices of the re-tiled mesh.
    pub texture: VertexTexture,
    /// The levels that were synthesised on.
    pub levels: Levels,
    /// What was done.
    pub report: SynthReport,
}

/// The exemplar as a job uses it: of one that changes, its first frame.
#[must_use]
pub fn prepared(exemplar: &Exemplar, side: Option<u32>, wraps: Option<bool>) -> Exemplar {
    let [w, h] = exemplar.size();
    let longer = w.max(h);
    let to = side.unwrap_or_else(|| longer.min(SIDE)).max(1);
    let scaled = |n: u32| ((f64::from(n) * f64::from(to) / f64::from(longer)).round() as u32).max(1);
    let mut out = resized(exemplar, [scaled(w), scaled(h)]).into_owned();
    out.remove_frames();
    let wraps = wraps.unwrap_or_else(|| exemplar.wrap == Wrap::Repeat || tiles(&out));
    out.wrap = if wraps { Wrap::Repeat } else { Wrap::Clamp };
    out
}

/// Levels that an exemplar of a size is good for, at most `most`; where it tiles, its sides must halve evenly.
#[must_use]
pub fn levels_of(exemplar: &Exemplar, most: usize) -> usize {
    let size = exemplar.size();
    let smaller = size[0].min(size[1]);
    let good = |k: &usize| {
        let halves = 1_u32 << k.min(&31);
        smaller / halves >= COARSEST && (exemplar.wrap == Wrap::Clamp || size.iter().all(|s| s.is_multiple_of(halves)))
    };
    (1..most.max(1)).take_while(good).count() + 1
}

/// Does a job on a clean mesh. `seen` is told of every level that is done, with the levels and the exemplar as used.
///
/// # Errors
/// If the mesh cannot be re-tiled, a direction is unusable, or `progress` cancels.
pub fn synthesize_on(
    cleaned: &Cleaned,
    exemplar: &Exemplar,
    job: &SynthJob,
    progress: &dyn Progress,
    seen: &mut dyn FnMut(&Levels, &Exemplar, LevelDone),
) -> Result<Synthesized, SynthJobError> {
    let exemplar = prepared(exemplar, job.side, job.tiles);
    let count = levels_of(&exemplar, job.levels);
    let start = Instant::now();
    let pyramid = retiled(&cleaned.mesh, exemplar.size()[0], job, count, progress)?;
    let retile_seconds = start.elapsed().as_secs_f64();
    let retile = pyramid.levels.iter().map(|l| l.statistics).collect();
    let start = Instant::now();
    let (right, singularities) = directions(cleaned, &pyramid, &job.way(), progress)?;
    let levels = Levels::of_pyramid(pyramid, right);
    let field_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let source = Source::image(&Stack::new(&exemplar, None), levels.len());
    let made = synthesize(&levels, &source, &job.options, progress, &mut |done| seen(&levels, &exemplar, done))?;
    let texture = VertexTexture::of_exemplar(levels.finest(), &exemplar, &made.places);
    let seconds = [retile_seconds, field_seconds, start.elapsed().as_secs_f64()];
    let spacing = texture.spacing;
    let report = SynthReport {
        exemplar: exemplar.size(),
        tiles: exemplar.wrap == Wrap::Repeat,
        scale: spacing * f64::from(exemplar.size()[0]),
        spacing,
        retile,
        singularities,
        synth: made.statistics,
        seconds,
    };
    Ok(Synthesized { texture, levels, report })
}

/// Synthesises from a textured mesh instead of an image (WL 5): `from` is re-tiled into `job.side` squared vertices ([`SIDE`]
/// squared without one), which take what `texture` shows there, and its neighbourhoods take the place of the image's.
///
/// # Errors
/// As [`synthesize_on`].
pub fn transfer(
    cleaned: &Cleaned,
    from: &Cleaned,
    texture: &dyn SurfaceTexture,
    job: &SynthJob,
    progress: &dyn Progress,
) -> Result<Synthesized, SynthJobError> {
    let start = Instant::now();
    let exemplar_vertices = (job.side.unwrap_or(SIDE) as usize).pow(2);
    let there = SynthJob { density: Density::Vertices(exemplar_vertices), ..job.clone() };
    let exemplar_pyramid = retiled(&from.mesh, 1, &there, job.levels, progress)?;
    let pyramid = retiled(&cleaned.mesh, 1, job, exemplar_pyramid.levels.len(), progress)?;
    let retile_seconds = start.elapsed().as_secs_f64();
    let retile = pyramid.levels.iter().map(|l| l.statistics).collect();
    let start = Instant::now();
    let (right, singularities) = directions(cleaned, &pyramid, &job.way(), progress)?;
    let levels = Levels::of_pyramid(pyramid, right);
    // The exemplar's directions are those of its own smoothest field, unless there is something to follow on it too.
    let (right, _) = directions(from, &exemplar_pyramid, &follow(job).way(), progress)?;
    let exemplar_levels = Levels::of_pyramid(exemplar_pyramid, right);
    let field_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let exemplar = painted(from, texture, &exemplar_levels);
    let mut matched = Vec::new();
    let vertices = exemplar.mesh.vertex_count();
    for v in 0..vertices {
        for (channel, values) in exemplar.all() {
            let n = channel.components();
            let value = std::array::from_fn(|k| values[v * n + k.min(n - 1)]);
            stack::matched(*channel, value, &mut matched);
        }
    }
    let source = Source::mesh(exemplar_levels, matched.len() / vertices.max(1), &matched);
    let made = synthesize(&levels, &source, &job.options, progress, &mut |_| ())?;
    let texture = VertexTexture::of_texture(levels.finest(), &exemplar, &made.places);
    let seconds = [retile_seconds, field_seconds, start.elapsed().as_secs_f64()];
    let spacing = texture.spacing;
    let side = (vertices as f64).sqrt();
    let report = SynthReport {
        exemplar: [side.round() as u32; 2],
        tiles: false,
        scale: spacing * side,
        spacing,
        retile,
        singularities,
        synth: made.statistics,
        seconds,
    };
    Ok(Synthesized { texture, levels, report })
}

/// The directions of an exemplar mesh: what is tied to the other mesh means nothing on this one.
fn follow(job: &SynthJob) -> SynthJob {
    let direction = match &job.direction {
        Direction::Steered(Steer::Constraints(..) | Steer::Field(_)) => Direction::Steered(Steer::Relaxed(1)),
        other => other.clone(),
    };
    SynthJob { direction, ..job.clone() }
}

/// What a texture shows at the vertices of the finest level.
fn painted(from: &Cleaned, texture: &dyn SurfaceTexture, levels: &Levels) -> VertexTexture {
    let (tree, level) = (Nearest::new(&from.mesh), levels.finest());
    let texels: Vec<Texel> = (0..level.mesh.vertex_count() as u32)
        .into_par_iter()
        .map(|v| match tree.nearest(level.mesh.point(v)) {
            Some(hit) => texture.texel(hit.at, level.spacing as f32),
            None => Texel::empty(Vec3::Z),
        })
        .collect();
    let of = |channel: Channel| -> (Channel, Vec<f32>) {
        let value = |(t, frame): (&Texel, &Frame)| -> Vec3 {
            match channel {
                Channel::BaseColor => t.base_color,
                Channel::Normal => {
                    let n = t.normal.as_dvec3();
                    DVec3::new(n.dot(frame.right), n.dot(frame.up), n.dot(frame.normal)).as_vec3()
                }
                Channel::Height => Vec3::splat(t.height),
                Channel::Roughness => Vec3::splat(t.roughness),
                Channel::Metallic => Vec3::splat(t.metallic),
                Channel::Occlusion => Vec3::splat(t.occlusion),
                Channel::Emissive => t.emissive,
                Channel::Opacity => Vec3::splat(t.opacity),
            }
        };
        let all = texels.iter().zip(&level.frames).map(value);
        (channel, all.flat_map(|v| v.to_array().into_iter().take(channel.components())).collect())
    };
    VertexTexture::new(level, texture.channels().iter().map(of).collect())
}

/// The re-tiled levels; as many of the `count` as the surface has room for. An exemplar is `width` pixels wide.
fn retiled(mesh: &Mesh, width: u32, job: &SynthJob, count: usize, progress: &dyn Progress) -> Result<Pyramid, SynthJobError> {
    let vertices = job.density.vertices(mesh, width)?;
    let options = RetileOptions { vertices, crease: job.crease, seed: job.options.seed, ..RetileOptions::default() };
    let mut count = count.min((1..).take_while(|k| vertices >> (2 * k).min(60) >= FEWEST).count() + 1);
    loop {
        match pyramid(mesh, &options, count, progress) {
            // Coarse levels need room for every part and every hole of the surface.
            Err(RetileError::TooFew { .. }) if count > 1 => count -= 1,
            made => return Ok(made?),
        }
    }
}
