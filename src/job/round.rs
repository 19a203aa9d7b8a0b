//! Synthesis with round neighbourhoods from end to end: on the user's own vertices, or on a plane.
//!
//! 1. [`march`]: a mesh whose edges are longer than pixels is refined; then circles are marched about all its vertices. That
//!    depends on the mesh and the scale alone, and is kept, in memory or in a file, for all exemplars and directions.
//! 2. [`synthesize_marched`]: directions for the vertices, and matching.

use super::directions::{Direction, Way, directions};
use super::input::Steer;
use super::synth::{Density, ScaleError, VERTICES, levels_of, prepared};
use crate::exemplar::stack::Stack;
use crate::exemplar::{Exemplar, Wrap};
use crate::field::FieldError;
use crate::mesh::pyramid::Pyramid;
use crate::mesh::retile::{RetileError, RetileOptions, RetileStatistics, Retiled, retile};
use crate::mesh::subdivide::subdivide;
use crate::mesh::{Cleaned, Mesh, MeshError};
use crate::progress::Progress;
use crate::synth::round::{
    CacheError, Grid, Marching, MarchingStatistics, RoundError, RoundLevel, RoundOptions, synthesize_plane, synthesize_round,
};
use crate::synth::{Level, VertexTexture, image_of};
use serde::Serialize;
use std::borrow::Cow;
use std::time::Instant;

/// Edges longer than this many pixels are cut in two before marching: between their ends detail would be lost.
const LONGEST: f64 = 2.0;

/// A mesh that would need more than this many times the vertices that it has, or that are asked for, is re-tiled instead: long thin
/// faces become very many before they are short enough.
const MOST_CUT: usize = 2;

/// Levels unless more or fewer are asked for.
pub const LEVELS: usize = 2;

/// A job.
#[derive(Debug, Clone)]
pub struct RoundJob {
    /// How many pixels of the exemplar there are on the surface, as if each were a vertex.
    pub density: Density,
    /// Levels at most.
    pub levels: usize,
    /// The exemplar's longer side, pixels; `None` keeps it, but brings it to [`super::synth::SIDE`] if it is larger.
    pub side: Option<u32>,
    /// Whether the exemplar goes on over its edges; `None` finds out.
    pub tiles: Option<bool>,
    /// Which way.
    pub direction: Direction,
    /// The method.
    pub options: RoundOptions,
}

impl Default for RoundJob {
    fn default() -> Self {
        Self {
            density: Density::Vertices(VERTICES),
            levels: LEVELS,
            side: None,
            tiles: None,
            direction: Direction::Steered(Steer::Relaxed(1)),
            options: RoundOptions::default(),
        }
    }
}

/// Why a job fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RoundJobError {
    /// A scale that is none, or asks for too much.
    #[error(transparent)]
    Scale(#[from] ScaleError),
    /// The mesh cannot be refined so.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh cannot be re-tiled so.
    #[error(transparent)]
    Retile(#[from] RetileError),
    /// The directions cannot be made.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The synthesis itself.
    #[error(transparent)]
    Round(#[from] RoundError),
}

/// What was done to a mesh before marching.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Refined {
    /// Nothing: its own vertices.
    #[default]
    No,
    /// Long edges were cut; its own vertices are the first.
    Cut,
    /// It was re-tiled.
    Retiled,
}

/// A mesh with the circles about its vertices.
#[derive(Debug, Clone)]
pub struct Marched {
    /// The mesh that is synthesised on.
    pub mesh: Mesh,
    /// Its circles.
    pub marching: Marching,
    /// How it came from the one given.
    pub refined: Refined,
    /// Whether the circles were marched now, not read from those that were kept.
    pub fresh: bool,
    /// Seconds for refining, and for marching or reading.
    pub seconds: [f64; 2],
}

/// What a job did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RoundReport {
    /// Size of the exemplar as it was used, pixels.
    pub exemplar: [u32; 2],
    /// It goes on over its edges.
    pub tiles: bool,
    /// World length of one exemplar width; on a plane pixels.
    pub scale: f64,
    /// World length of a pixel.
    pub pixel: f64,
    /// What was done to the mesh first.
    pub refined: Refined,
    /// Marching, or what it was when it was kept; none on a plane.
    pub marching: Option<MarchingStatistics>,
    /// Whether it was done now.
    pub marched: bool,
    /// Bytes it takes.
    pub marching_bytes: usize,
    /// Singularities of the directions, if a smooth field was made.
    pub singularities: Option<usize>,
    /// Synthesis, the coarsest level first.
    pub levels: Vec<RoundLevel>,
    /// Seconds for refining, marching, directions, and synthesis.
    pub seconds: [f64; 4],
}

/// What comes out.
#[derive(Debug)]
pub struct Rounded {
    /// Values at the vertices.
    pub texture: VertexTexture,
    /// What was done.
    pub report: RoundReport,
}

impl RoundJob {
    /// The exemplar as the job uses it, and how many levels.
    #[must_use]
    pub fn exemplar(&self, exemplar: &Exemplar) -> (Exemplar, usize) {
        let exemplar = prepared(exemplar, self.side, self.tiles);
        let levels = levels_of(&exemplar, self.levels);
        (exemplar, levels)
    }
}

/// Refines a mesh and marches about its vertices; `kept` are the bytes of circles from before, used if they fit.
/// The second of the result says why those were not.
///
/// # Errors
/// If the mesh cannot be refined or marched about, or `progress` cancels.
pub fn march(
    mesh: &Mesh,
    exemplar: &Exemplar,
    job: &RoundJob,
    kept: Option<&[u8]>,
    progress: &dyn Progress,
) -> Result<(Marched, Option<CacheError>), RoundJobError> {
    let (exemplar, levels) = job.exemplar(exemplar);
    let start = Instant::now();
    let vertices = job.density.vertices(mesh, exemplar.size()[0])?;
    let pixel = (mesh.total_area() / vertices.max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
    let (mesh, refined) = refined(mesh, vertices, pixel, job.options.seed, progress)?;
    let refine_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let grid = Grid { pixel, circles: job.options.circles, levels };
    let (mut found, mut told) = (None, None);
    if let Some(bytes) = kept {
        match Marching::from_bytes(bytes, &mesh) {
            Ok(marching) if marching.fits(grid) => found = Some(marching),
            Ok(_) => told = Some(CacheError::Circles),
            Err(error) => told = Some(error),
        }
    }
    let fresh = found.is_none();
    let marching = match found {
        Some(marching) => marching,
        None => Marching::new(&mesh, grid, progress)?,
    };
    let seconds = [refine_seconds, start.elapsed().as_secs_f64()];
    Ok((Marched { mesh: mesh.into_owned(), marching, refined, fresh, seconds }, told))
}

/// The mesh with edges no longer than [`LONGEST`] pixels.
fn refined<'m>(
    mesh: &'m Mesh,
    vertices: usize,
    pixel: f64,
    seed: u64,
    progress: &dyn Progress,
) -> Result<(Cow<'m, Mesh>, Refined), RoundJobError> {
    let most = MOST_CUT * vertices.max(mesh.vertex_count());
    let mut now = Cow::Borrowed(mesh);
    loop {
        let long = |f: u32| {
            let [a, b, c] = now.corners(f);
            [a - b, b - c, c - a].iter().any(|e| e.length() > LONGEST * pixel)
        };
        let marked: Vec<bool> = (0..now.face_count() as u32).map(long).collect();
        if !marked.contains(&true) {
            let how = if matches!(now, Cow::Borrowed(_)) { Refined::No } else { Refined::Cut };
            return Ok((now, how));
        }
        if progress.cancelled() {
            return Err(RoundError::Cancelled.into());
        }
        let finer = subdivide(&now, &marked)?.mesh;
        if finer.vertex_count() > most {
            let options = RetileOptions { vertices, seed, ..RetileOptions::default() };
            return Ok((Cow::Owned(retile(mesh, &options, progress)?.mesh), Refined::Retiled));
        }
        now = Cow::Owned(finer);
    }
}

/// Synthesises on a mesh that was marched about. Nothing is marched, whatever the directions.
///
/// # Errors
/// If a direction is unusable, the circles are of other levels, or `progress` cancels.
pub fn synthesize_marched(
    cleaned: &Cleaned,
    marched: &Marched,
    exemplar: &Exemplar,
    job: &RoundJob,
    progress: &dyn Progress,
) -> Result<Rounded, RoundJobError> {
    let (exemplar, levels) = job.exemplar(exemplar);
    let start = Instant::now();
    let mesh = marched.mesh.clone();
    let whole = Retiled { mesh, at: Vec::new(), statistics: RetileStatistics::default() };
    let mut only = Pyramid { levels: vec![whole], parents: Vec::new() };
    let way = Way { direction: &job.direction, nearest: false, seed: job.options.seed };
    let (right, singularities) = directions(cleaned, &only, &way, progress)?;
    let right = right.first().map_or(&[][..], Vec::as_slice);
    let mesh = only.levels.swap_remove(0).mesh;
    let level = Level::new(mesh, right, marched.marching.pixel());
    let field_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let stacks = Stack::new(&exemplar, None).pyramid(levels);
    let made = synthesize_round(&level.mesh, &level.frames, &marched.marching, &stacks, &job.options, progress)?;
    let texture = VertexTexture::of_exemplar(&level, &exemplar, &made.places);
    let report = RoundReport {
        exemplar: exemplar.size(),
        tiles: exemplar.wrap == Wrap::Repeat,
        scale: level.spacing * f64::from(exemplar.size()[0]),
        pixel: level.spacing,
        refined: marched.refined,
        marching: Some(marched.marching.statistics()),
        marched: marched.fresh,
        marching_bytes: marched.marching.bytes(),
        singularities,
        levels: made.levels,
        seconds: [marched.seconds[0], marched.seconds[1], field_seconds, start.elapsed().as_secs_f64()],
    };
    Ok(Rounded { texture, report })
}

/// Synthesises an image of `size` pixels with all channels of the exemplar. The exemplar goes on over its edges only if the job says so:
/// what goes on from a neighbour would always fit, and one that tiles would be tiled, no more.
///
/// # Errors
/// If the size is none, or `progress` cancels.
pub fn synthesize_plane_image(
    size: [u32; 2],
    exemplar: &Exemplar,
    job: &RoundJob,
    progress: &dyn Progress,
) -> Result<(Exemplar, RoundReport), RoundJobError> {
    let inside = RoundJob { tiles: job.tiles.or(Some(false)), ..job.clone() };
    let (exemplar, levels) = inside.exemplar(exemplar);
    let start = Instant::now();
    let stacks = Stack::new(&exemplar, None).pyramid(levels);
    let made = synthesize_plane(size.map(|s| s as usize), &stacks, &job.options, progress)?;
    let image = image_of(size, &exemplar, &made.places);
    let report = RoundReport {
        exemplar: exemplar.size(),
        tiles: exemplar.wrap == Wrap::Repeat,
        scale: f64::from(exemplar.size()[0]),
        pixel: 1.0,
        levels: made.levels,
        seconds: [0.0, 0.0, 0.0, start.elapsed().as_secs_f64()],
        ..RoundReport::default()
    };
    Ok((image, report))
}
