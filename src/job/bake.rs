//! From a surface texture to a model that any tool shows with it: unwrap, bake, and back onto the user's faces.
//!
//! 1. Unwrap the clean mesh, or take the model's own coordinates.
//! 2. Bake the texture into the atlas.
//! 3. Give each of the user's vertices the place of its first corner, and copies of it to corners with another place or
//!    normal. Faces keep their number, their order and their winding.

use super::Bound;
use crate::atlas::{
    Atlas, AtlasError, BakeOptions, BakeStatistics, Frames, Page, Stretch, UnwrapOptions, bake, keep, stretch, unwrap,
};
use crate::exemplar::{Channel, Image};
use crate::format::corners::join_corners;
use crate::format::{Look, Model, Record};
use crate::mesh::clean::UserFace;
use crate::mesh::{CleanOptions, Cleaned, Mesh, MeshError, NONE, SurfacePoint, clean};
use crate::paste::{Compositing, LappedTexture};
use crate::progress::Progress;
use crate::render::ChartColors;
use crate::render::normals::{corner_normals, crease_angle};
use crate::surface::SurfaceTexture;
use glam::{Vec2, Vec3, Vec4};
use serde::Serialize;
use std::collections::HashMap;
use std::time::Instant;

/// Where texels are to lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// In charts that are made.
    #[default]
    Charts,
    /// Where the model's own texture coordinates say.
    Own,
}

/// A bake to do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BakeJob {
    /// Where texels are to lie.
    pub coordinates: Coordinates,
    /// How to unwrap; its size and mips also hold for the model's own coordinates.
    pub unwrap: UnwrapOptions,
    /// How to bake.
    pub bake: BakeOptions,
    /// Edges that turn by more than this, in radians, stay sharp in the normals of a model that has none; `None` chooses by
    /// the mesh.
    pub crease: Option<f64>,
    /// What composites a record's pastes.
    pub compositing: Compositing,
}

/// Figures of a bake.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct BakeReport {
    /// Texels along each side of a page.
    pub size: u32,
    /// Pages.
    pub pages: u32,
    /// Charts.
    pub charts: usize,
    /// Texels around each chart that belong to it.
    pub margin: u32,
    /// Share of the pages under charts.
    pub efficiency: f64,
    /// Texels a world unit.
    pub density: f64,
    /// Stretch of the charts.
    pub stretch: Stretch,
    /// Texels, samples and chart borders.
    #[serde(flatten)]
    pub bake: BakeStatistics,
    /// Vertices of the model that is written.
    pub vertices: usize,
    /// Seconds (wall) of unwrapping and packing, and of baking.
    pub unwrap_seconds: f64,
    /// Seconds of baking, gutters and borders.
    pub bake_seconds: f64,
}

impl BakeJob {
    /// Everything by default, on pages of so many texels.
    #[must_use]
    pub fn sized(size: u32) -> Self {
        Self { unwrap: UnwrapOptions { size, ..UnwrapOptions::default() }, ..Self::default() }
    }
}

impl BakeReport {
    /// What the charts and the bake say of themselves.
    pub(super) fn new(mesh: &Mesh, atlas: &Atlas, stretch: Stretch, bake: BakeStatistics) -> Self {
        Self {
            size: atlas.size,
            pages: atlas.pages,
            charts: atlas.chart_count(),
            margin: atlas.margin,
            efficiency: atlas.efficiency(),
            density: atlas.density(mesh),
            stretch,
            bake,
            ..Self::default()
        }
    }
}

/// A model with its bake.
#[derive(Debug, Clone, PartialEq)]
pub struct BakedModel {
    /// The user's faces; vertices are repeated at chart borders, and have normals.
    pub model: Model,
    /// The bake.
    pub look: Look,
    /// The charts, on the clean mesh.
    pub atlas: Atlas,
    /// Figures.
    pub report: BakeReport,
}

/// Bakes a texture that lies on the clean mesh of a model; `user_faces` leads from the model's faces to the mesh's.
///
/// # Errors
/// If the charts do not fit, the model's own coordinates cannot be baked into, or `progress` cancels.
pub fn bake_model(
    model: &Model,
    mesh: &Mesh,
    user_faces: &[UserFace],
    texture: &dyn SurfaceTexture,
    job: &BakeJob,
    progress: &dyn Progress,
) -> Result<BakedModel, AtlasError> {
    let begin = Instant::now();
    let options = &job.unwrap;
    let atlas = match job.coordinates {
        Coordinates::Charts => unwrap(mesh, options, progress)?,
        Coordinates::Own => keep(mesh, &own_coordinates(model, mesh, user_faces)?, options.size, options.mips)?,
    };
    let unwrap_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let normals = shading_normals(model, mesh, user_faces, job.crease);
    let frames = if texture.channels().has(Channel::Normal) {
        Frames::with_tangents(mesh, &atlas, normals)
    } else {
        Frames::smooth(normals)
    };
    let baked = bake(mesh, &atlas, &frames, texture, &job.bake, progress)?;
    let (model, mut look) = outgoing(model, user_faces, &atlas, &frames);
    take_pages(&mut look, baked.pages);
    let report = BakeReport {
        vertices: model.positions.len(),
        unwrap_seconds,
        bake_seconds: begin.elapsed().as_secs_f64(),
        ..BakeReport::new(mesh, &atlas, stretch(mesh, &atlas), baked.statistics)
    };
    Ok(BakedModel { model, look, atlas, report })
}

/// Puts what was baked into a look.
pub(super) fn take_pages(look: &mut Look, pages: Vec<Page>) {
    let with_mips = pages.iter().any(|page| !page.mips.is_empty());
    let (pages, mips): (Vec<_>, Vec<_>) = pages.into_iter().map(|page| (page.images, page.mips)).unzip();
    look.pages = pages;
    look.mips = if with_mips { mips } else { Vec::new() };
}

/// Bakes what a record's pastes show; the record then holds both. `bound` is the record on its clean mesh.
///
/// # Errors
/// As [`bake_model`].
pub fn bake_record(
    record: Record,
    bound: &Bound,
    job: &BakeJob,
    progress: &dyn Progress,
) -> Result<(Record, Atlas, BakeReport), AtlasError> {
    let texture = job.compositing.of(&bound.mesh, &bound.lapped).map_err(AtlasError::Baker)?;
    let made = bake_model(&record.model, &bound.mesh, &bound.user_faces, texture.as_ref(), job, progress)?;
    let BakedModel { model, look, atlas, report } = made;
    Ok((Record { model, look: Some(look), ..record }, atlas, report))
}

/// For each mesh face the first of the model's faces it stands for.
fn first_user(mesh: &Mesh, user_faces: &[UserFace]) -> Vec<u32> {
    let mut first = vec![NONE; mesh.face_count()];
    for (user, to) in user_faces.iter().enumerate().rev() {
        if to.face != NONE {
            first[to.face as usize] = user as u32;
        }
    }
    first
}

/// Something the model has at its vertices, at the corners of the mesh's faces.
pub(super) fn at_corners<T: Copy + Default>(
    model: &Model,
    mesh: &Mesh,
    user_faces: &[UserFace],
    of: impl Fn(&UserFace, u32) -> T,
) -> Vec<[T; 3]> {
    let one = |&user: &u32| {
        let mut mine = [T::default(); 3];
        if let Some(to) = user_faces.get(user as usize) {
            (0..3).for_each(|k| mine[to.corners[k] as usize] = of(to, model.faces[user as usize][k]));
        }
        mine
    };
    first_user(mesh, user_faces).iter().map(one).collect()
}

fn own_coordinates(model: &Model, mesh: &Mesh, user_faces: &[UserFace]) -> Result<Vec<[Vec2; 3]>, AtlasError> {
    let uvs = model.uvs.as_ref().ok_or_else(|| AtlasError::Keep("the model has none".into()))?;
    Ok(at_corners(model, mesh, user_faces, |_, v| uvs[v as usize]))
}

/// True if the user's face runs against the mesh's.
const fn turned(to: &UserFace) -> bool {
    !matches!(to.corners, [0, 1, 2] | [1, 2, 0] | [2, 0, 1])
}

/// The normals that renderers will see, at the corners of the mesh's faces: the model's own, or smooth ones.
fn shading_normals(model: &Model, mesh: &Mesh, user_faces: &[UserFace], crease: Option<f64>) -> Vec<[Vec3; 3]> {
    match &model.normals {
        Some(own) => at_corners(model, mesh, user_faces, |to, v| if turned(to) { -own[v as usize] } else { own[v as usize] }),
        None => corner_normals(mesh, crease.unwrap_or_else(|| crease_angle(mesh))),
    }
}

/// Numbers for normals: equal ones share one.
#[derive(Default)]
struct NormalNumbers {
    known: HashMap<[u32; 3], u32>,
    all: Vec<Vec3>,
}

impl NormalNumbers {
    fn of(&mut self, normal: Vec3) -> u32 {
        *self.known.entry(normal.to_array().map(f32::to_bits)).or_insert_with(|| {
            self.all.push(normal);
            self.all.len() as u32 - 1
        })
    }
}

/// The user's model with its vertices split, and the coordinates and tangents of the look.
fn outgoing(model: &Model, user_faces: &[UserFace], atlas: &Atlas, frames: &Frames) -> (Model, Look) {
    let mut out = model.clone();
    let user_corners = model.faces.as_flattened().to_vec();
    // A face that was dropped has no area: one place will do for it, that of one of its vertices elsewhere. With a place for
    // each it could reach from chart to chart.
    let mut numbers = NormalNumbers::default();
    let mut place: Vec<[u32; 2]> = vec![[NONE; 2]; user_corners.len()];
    let mut anywhere = vec![[NONE; 2]; model.positions.len()];
    for (user, to) in user_faces.iter().enumerate().filter(|(_, to)| to.face != NONE) {
        for k in 0..3 {
            let (face, corner) = (to.face as usize, to.corners[k] as usize);
            let normal = frames.normals[face][corner];
            let here = [atlas.corners[face][corner], numbers.of(if turned(to) { -normal } else { normal })];
            place[3 * user + k] = here;
            let vertex = user_corners[3 * user + k] as usize;
            if anywhere[vertex] == [NONE; 2] {
                anywhere[vertex] = here;
            }
        }
    }
    for (at, corners) in place.as_chunks_mut::<3>().0.iter_mut().zip(&model.faces) {
        if at[0] == [NONE; 2] {
            *at = [corners.map(|v| anywhere[v as usize]).into_iter().find(|p| *p != [NONE; 2]).unwrap_or([NONE; 2]); 3];
        }
    }
    // Tangents at atlas vertices, in the user's winding.
    let mut tangents: HashMap<[u32; 2], Vec4> = HashMap::new();
    if !frames.tangents.is_empty() {
        for (user, to) in user_faces.iter().enumerate().filter(|(_, to)| to.face != NONE) {
            for k in 0..3 {
                let t = frames.tangents[to.face as usize][to.corners[k] as usize];
                tangents.entry(place[3 * user + k]).or_insert(if turned(to) { -t } else { t });
            }
        }
    }
    for (k, corner) in out.faces.as_flattened_mut().iter_mut().enumerate() {
        *corner = k as u32;
    }
    let kept = join_corners(&mut out.faces, model.positions.len(), |k| (user_corners[k as usize], place[k as usize]));
    let copy = |v: u32| v as usize;
    out.positions = kept.iter().map(|&(v, _)| model.positions[copy(v)]).collect();
    out.uvs = model.uvs.as_ref().map(|t| kept.iter().map(|&(v, _)| t[copy(v)]).collect());
    out.colors = model.colors.as_ref().map(|c| kept.iter().map(|&(v, _)| c[copy(v)]).collect());
    out.motion = model.motion.as_ref().map(|m| m.at_vertices(&kept.iter().map(|&(v, _)| v).collect::<Vec<_>>()));
    let place_of = |at: &Option<[u32; 2]>| at.filter(|p| *p != [NONE; 2]);
    out.normals = Some(
        kept.iter()
            .map(|(v, at)| match (place_of(at), &model.normals) {
                (_, Some(own)) => own[copy(*v)],
                (Some([_, n]), None) => numbers.all[n as usize].normalize_or(Vec3::Z),
                (None, None) => Vec3::Z,
            })
            .collect(),
    );
    let look = Look {
        uv: kept.iter().map(|(_, at)| place_of(at).map_or(Vec2::ZERO, |[a, _]| atlas.uv[a as usize])).collect(),
        tangents: (!frames.tangents.is_empty()).then(|| {
            let of = |at: &Option<[u32; 2]>| place_of(at).and_then(|p| tangents.get(&p).copied());
            kept.iter().map(|(_, at)| of(at).unwrap_or(Vec4::new(1.0, 0.0, 0.0, 1.0))).collect()
        }),
        pages: Vec::new(),
        mips: Vec::new(),
        face_page: if atlas.pages > 1 {
            user_faces.iter().map(|to| if to.face == NONE { 0 } else { atlas.page_of(to.face) }).collect()
        } else {
            Vec::new()
        },
    };
    (out, look)
}

/// A model with a normal at each vertex: its own, or those of its clean mesh. Vertices are not split, so creases are smoothed.
///
/// # Errors
/// If the model is no mesh at all.
pub fn with_normals(model: &Model) -> Result<Model, MeshError> {
    let mut out = model.clone();
    if out.normals.is_none() {
        let Cleaned { mesh, user_faces, .. } = clean(&model.positions, &model.faces, &CleanOptions::default())?;
        let smooth = mesh.vertex_normals();
        let mut normals = vec![Vec3::Z; model.positions.len()];
        for (corners, to) in model.faces.iter().zip(&user_faces).filter(|(_, to)| to.face != NONE) {
            for k in 0..3 {
                let normal = smooth[mesh.faces[to.face as usize][to.corners[k] as usize] as usize];
                normals[corners[k] as usize] = if turned(to) { -normal } else { normal }.normalize_or(Vec3::Z);
            }
        }
        out.normals = Some(normals);
    }
    Ok(out)
}

/// Pixels of the exemplars a world unit, the mean over all pastes: what a bake needs to lose nothing.
#[must_use]
pub fn exemplar_density(mesh: &Mesh, lapped: &LappedTexture) -> f64 {
    let (mut pixels, mut world) = (0.0, 0.0);
    for paste in &lapped.pastes {
        let size = lapped.patches[paste.patch as usize].mask.size();
        let scale = f64::from(size[0]) * f64::from(size[1]);
        for (&face, [a, b, c]) in paste.faces.iter().zip(&paste.uv) {
            pixels += f64::from((*b - *a).perp_dot(*c - *a).abs()) * scale;
            world += mesh.area_vector(face).length();
        }
    }
    if world > 0.0 { (pixels / world).sqrt() } else { 0.0 }
}

/// Share of a page that charts fill, as a rule, but for the gutters of small pages.
const FILLED: f64 = 0.6;

/// Texels of a page's side that go to gutters, as a rule: on a page of 256 they cost half of its texels.
const GUTTERS: f64 = 64.0;

/// The sizes that are chosen from when nobody says: a bake that shows all the exemplar has, within reason.
const SIZES: [u32; 4] = [256, 512, 1024, 2048];

/// A larger page than those is tried if the charts with their gutters find no room.
const LARGEST: u32 = 8192;

/// Texels a world unit on a page of so many texels a side, before the charts are made.
fn expected_density(mesh: &Mesh, size: u32) -> f64 {
    let area = mesh.total_area();
    let size = f64::from(size);
    if area > 0.0 { (size - GUTTERS).max(0.25 * size) * (FILLED / area).sqrt() } else { 0.0 }
}

/// Texels along each side of an atlas that keeps the exemplars' density, 2048 at most.
#[must_use]
pub fn default_size(mesh: &Mesh, lapped: &LappedTexture) -> u32 {
    let wanted = exemplar_density(mesh, lapped);
    SIZES.into_iter().find(|&s| expected_density(mesh, s) >= wanted).unwrap_or(SIZES[SIZES.len() - 1])
}

/// Samples along each side of a texel: one where a texel holds no more than a pixel or so of the exemplars, as many as it takes
/// where it holds more.
#[must_use]
pub fn default_samples(mesh: &Mesh, lapped: &LappedTexture, size: u32) -> u32 {
    let pixels = exemplar_density(mesh, lapped) / expected_density(mesh, size);
    [1, 2, 4].into_iter().find(|&n| pixels <= 1.5 * f64::from(n)).unwrap_or(8)
}

/// Bakes a record at a size that suits it, on a larger page where that has no room for the charts and their gutters.
///
/// # Errors
/// As [`bake_model`].
pub fn bake_record_sized(
    record: &Record,
    bound: &Bound,
    job: &BakeJob,
    progress: &dyn Progress,
) -> Result<(Record, Atlas, BakeReport), AtlasError> {
    let mut size = default_size(&bound.mesh, &bound.lapped);
    loop {
        let mut job = job.clone();
        job.unwrap.size = size;
        match bake_record(record.clone(), bound, &job, progress) {
            Err(AtlasError::NoRoom { .. }) if size < LARGEST => size *= 2,
            done => return done,
        }
    }
}

/// Texels along a side of a picture of charts.
const VIEW: u32 = 1024;

/// What lies under no chart, linear light.
const PAPER: Vec3 = Vec3::splat(0.9);

/// The charts of an atlas as a texture, each in its colour, borders drawn.
#[must_use]
pub fn chart_colors<'a>(mesh: &'a Mesh, atlas: &'a Atlas) -> ChartColors<'a> {
    ChartColors::new(mesh, &atlas.chart, atlas.seams(mesh).flat_map(|(h, o)| [h, o]))
}

/// A picture of the first page of an atlas: charts in the colours of [`chart_colors`].
///
/// # Errors
/// If `progress` cancels.
pub fn page_view(mesh: &Mesh, atlas: &Atlas, progress: &dyn Progress) -> Result<Image, AtlasError> {
    let small = Atlas { size: VIEW, ..atlas.clone() };
    let frames = Frames::smooth(vec![[Vec3::Z; 3]; mesh.face_count()]);
    let options = BakeOptions { seams: false, ..BakeOptions::default() };
    let baked = bake(mesh, &small, &frames, &chart_colors(mesh, atlas), &options, progress)?;
    let page = baked.pages.first();
    let texel = |x: u32, y: u32| {
        let there = page.filter(|p| p.covered[(y * VIEW + x) as usize]).and_then(|p| p.image(Channel::BaseColor));
        there.map_or(PAPER, |image| image.pixel(i64::from(x), i64::from(y)))
    };
    Ok(Image::from_fn(VIEW, VIEW, texel))
}

/// A baked model as a texture on its clean mesh.
#[derive(Debug, Clone)]
pub struct LookOnMesh {
    /// Coordinates at the corners of the mesh's faces.
    pub uv: Vec<[Vec2; 3]>,
    /// Page of each face.
    pub page: Vec<u32>,
    /// Frames at the corners.
    pub frames: Frames,
}

impl LookOnMesh {
    /// Carries a look over to the clean mesh of its model.
    #[must_use]
    pub fn new(model: &Model, look: &Look, mesh: &Mesh, user_faces: &[UserFace]) -> Self {
        let uv = at_corners(model, mesh, user_faces, |_, v| look.uv[v as usize]);
        let normals = shading_normals(model, mesh, user_faces, None);
        let tangents = match &look.tangents {
            Some(t) => at_corners(model, mesh, user_faces, |to, v| if turned(to) { -t[v as usize] } else { t[v as usize] }),
            None => Vec::new(),
        };
        let page = first_user(mesh, user_faces).iter().map(|&u| look.face_page.get(u as usize).copied().unwrap_or(0)).collect();
        Self { uv, page, frames: Frames { normals, tangents } }
    }
}

/// The point that a face of the model shows at given weights of its corners, on the mesh.
#[must_use]
pub fn on_mesh(to: &UserFace, bary: Vec3) -> SurfacePoint {
    let mut mine = [0.0; 3];
    (0..3).for_each(|k| mine[to.corners[k] as usize] = bary[k]);
    SurfacePoint { face: to.face, bary: Vec3::from_array(mine) }
}
