//! One mesh and one exemplar through all methods: pictures and numbers.
//!
//! 1. [`Setting`] makes what all share, [`Reference`] what the exemplar is by itself.
//! 2. Each method is made and timed on its own ([`Maker`]); one that fails is told, and the others go on.
//! 3. Once all are there, each is measured on the surface, several at once, by points that depend on the mesh and the seed alone.
//! 4. Pictures are taken by the same cameras of all: the texture, where it comes from, and where it errs. The worst places that the
//!    measures found are looked at closely.

use super::CompareError;
use super::blind::{Blind, BlindKey, blind};
use super::make::{Costs, Made, Maker};
use super::measures::{
    Border, ErrorMap, Extreme, Mapped, Mapping, Measured, Placed, Reference, SeamVisibility, breaks, chart_borders, mapping,
    steps_across,
};
use super::method::Method;
use super::setting::{Setting, SettingOptions};
use super::shown::{ErrorColors, SourceColors, place_color};
use super::source::Sourced;
use crate::exemplar::{Channel, Exemplar, srgb};
use crate::field::Guide;
use crate::format::Model;
use crate::mesh::nearest::Nearest;
use crate::mesh::walk::Walker;
use crate::mesh::{Mesh, SurfacePoint};
use crate::progress::Progress;
use crate::render::camera::Projection;
use crate::render::picture::to_byte;
use crate::render::{Background, Camera, DrawOptions, Grid, Lighting, Picture, Stage, View, Visibility};
use crate::surface::SurfaceTexture;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};

/// A comparison to do.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareJob {
    /// The methods, in the order they are shown.
    pub methods: Vec<Method>,
    /// What all share.
    pub setting: SettingOptions,
    /// Where pictures are taken from.
    pub views: Vec<View>,
    /// Width and height of a picture, pixels.
    pub size: [u32; 2],
    /// Crops around borders for a blind look, and as many of the exemplar; 0 for none.
    pub blind: u32,
}

impl Default for CompareJob {
    fn default() -> Self {
        Self {
            methods: Method::USUAL.to_vec(),
            setting: SettingOptions::default(),
            views: [(30.0, 18.0), (205.0, 18.0)].map(|(yaw, pitch)| View::degrees(yaw, pitch)).to_vec(),
            size: [512, 512],
            blind: 0,
        }
    }
}

/// Samples along each side of a picture's pixel.
const SAMPLES: u32 = 2;
/// Width and height of a close-up, pixels.
const CLOSE: u32 = 224;
/// What a close-up shows, in widths of the exemplar.
const CLOSE_WIDTHS: f64 = 0.6;
/// What is behind the surface in one, linear light.
const BEHIND: Vec3 = Vec3::splat(0.7);
/// The eye of a close-up is this many of its heights away; what is nearer is not seen.
const AWAY: f64 = 1.5;
/// Places on chart borders are this many pixels apart.
const BORDER_STEP: f64 = 3.0;
/// Two borders are of one place if they are nearer than so many pixels.
const ONE_PLACE: f64 = 8.0;
/// The dark end of the error scale: this many times what 99 in a hundred patches of one half of the exemplar are off from the other
/// half, or that of an exemplar without halves.
const ERROR_SCALE: f64 = 1.5;
const ERROR_PLAIN: f64 = 0.2;

/// A picture and its name, without folder and ending.
#[derive(Debug, Clone)]
pub struct Named {
    /// The name.
    pub name: String,
    /// The picture.
    pub picture: Picture,
}

/// What was compared, and how.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SettingReport {
    /// Faces of the mesh that everything lies on.
    pub faces: usize,
    /// World length of one exemplar width.
    pub scale: f64,
    /// Area of the surface in areas of the exemplar.
    pub ratio: f64,
    /// World length of a pixel.
    pub pixel: f64,
    /// Size of the exemplar as it was used, pixels.
    pub exemplar_size: [u32; 2],
    /// Whether it goes on over its edges.
    pub tiles: bool,
    /// Directions at each place that look the same; 0 without a direction.
    pub ways: u32,
    /// Seed of all random choices.
    pub seed: u64,
    /// The error at the dark end of error pictures.
    pub error_scale: f64,
    /// The views, in words.
    pub views: Vec<String>,
    /// Width and height of the pictures.
    pub size: [u32; 2],
}

/// The pictures of one view, by name.
#[derive(Debug, Clone, Serialize)]
pub struct ViewPictures {
    /// The texture.
    pub texture: String,
    /// Where it comes from.
    pub source: String,
    /// Where it errs.
    pub error: String,
}

/// The worst place that a measure found.
#[derive(Debug, Clone, Serialize)]
pub struct Worst {
    /// The measure: `coherence`, `seams`, `chartSeams`, `stretch`, `direction` or `alpha`.
    pub measure: &'static str,
    /// Its value there.
    pub value: f64,
    /// The place in the world.
    pub position: [f64; 3],
    /// The close-up, by name.
    pub picture: String,
}

/// One method's numbers.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Figures {
    /// How much it looks like the exemplar.
    pub fidelity: Measured,
    /// What its source map tells.
    pub mapping: Mapping,
    /// How visible borders of what was copied together are.
    pub seams: SeamVisibility,
    /// How visible chart borders are, if there are charts.
    pub chart_seams: Option<SeamVisibility>,
    /// What it takes.
    pub costs: Costs,
}

/// One method's part of a report.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MethodReport {
    /// The method.
    pub method: Method,
    /// Its name for people.
    pub label: &'static str,
    /// What it does.
    pub says: &'static str,
    /// Why there is nothing, if it failed.
    pub failed: Option<String>,
    /// Its numbers.
    pub figures: Option<Figures>,
    /// Its pictures, view by view.
    pub pictures: Vec<ViewPictures>,
    /// Its worst places.
    pub worst: Vec<Worst>,
    /// The picture of a blind look, by name, and which of its crops are of the surface.
    pub blind: Option<(String, BlindKey)>,
}

/// All that was found.
#[derive(Debug)]
pub struct Comparison {
    /// What was compared.
    pub setting: SettingReport,
    /// One half of the exemplar against the other.
    pub floor: Measured,
    /// The methods.
    pub methods: Vec<MethodReport>,
    /// All pictures; `exemplar` and `places` are the exemplar and the colours of its places.
    pub pictures: Vec<Named>,
}

/// Compares.
///
/// # Errors
/// If the model is no mesh, the scale or field cannot be used, a view cannot be drawn, or `progress` cancels. Methods that fail are
/// told in the result.
pub fn compare(model: &Model, exemplar: &Exemplar, job: &CompareJob, progress: &dyn Progress) -> Result<Comparison, CompareError> {
    progress.stage("making the field", 0);
    let setting = Setting::new(model, exemplar, &job.setting)?;
    progress.stage("measuring the exemplar", 0);
    let reference = Reference::new(&setting.exemplar);
    let cell = Cell::new(&setting, &reference, job)?;
    let mut maker = Maker::new(&setting);
    let mut found = Vec::new();
    for &method in &job.methods {
        found.push((method, maker.make(method, progress)));
        if progress.cancelled() {
            return Err(CompareError::Cancelled);
        }
    }
    progress.stage("looking at the results", found.len() as u64);
    let looked_at = AtomicU64::new(0);
    let look = |(method, found): (Method, Result<Made, CompareError>)| {
        if progress.cancelled() {
            return Err(CompareError::Cancelled);
        }
        let mut pictures = Vec::new();
        let report = match found {
            Ok(made) => cell.report(&made, &mut pictures),
            Err(error) => empty(method, Some(error.to_string())),
        };
        progress.done(looked_at.fetch_add(1, Ordering::Relaxed) + 1);
        Ok((report, pictures))
    };
    let looked: Vec<(MethodReport, Vec<Named>)> = found.into_par_iter().map(look).collect::<Result<_, _>>()?;
    let (methods, taken): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
    let pictures = cell.of_exemplar().into_iter().chain(taken.into_iter().flatten()).collect();
    Ok(Comparison { setting: cell.setting_report(), floor: reference.floor, methods, pictures })
}

fn empty(method: Method, failed: Option<String>) -> MethodReport {
    let (label, says) = (method.label(), method.says());
    MethodReport { method, label, says, failed, figures: None, pictures: Vec::new(), worst: Vec::new(), blind: None }
}

/// What the methods of one cell are looked at with.
struct Cell<'a> {
    setting: &'a Setting,
    reference: &'a Reference,
    job: &'a CompareJob,
    /// What each view sees, by many samples a pixel and by one.
    seen: Vec<(Visibility, Visibility)>,
    tree: Nearest<'a>,
    walker: Walker<'a>,
    /// Lit as in a studio, and evenly for colours that mean something.
    lit: Stage<'a>,
    even: Stage<'a>,
    /// As evenly, for places seen from near, with nothing behind.
    near: Stage<'a>,
    error_scale: f64,
}

impl<'a> Cell<'a> {
    fn new(setting: &'a Setting, reference: &'a Reference, job: &'a CompareJob) -> Result<Self, CompareError> {
        let mesh = setting.mesh();
        let [width, height] = job.size;
        let [fine, coarse] = [SAMPLES, 1].map(|samples| Grid { width, height, samples });
        let look = |view: &View| {
            let camera = view.frame(mesh, fine.aspect());
            Ok((Visibility::new(mesh, &camera, fine)?, Visibility::new(mesh, &camera, coarse)?))
        };
        let seen = job.views.iter().map(look).collect::<Result<_, CompareError>>()?;
        let options = DrawOptions::default();
        let even = DrawOptions { lighting: Lighting::even(), occlusion: false, ..options };
        let floor = reference.floor.coherence.p99;
        let error_scale = if floor > 0.0 { ERROR_SCALE * floor } else { ERROR_PLAIN };
        let near = DrawOptions { background: Background::Plain(BEHIND), ..even };
        let [lit, even, near] = [options, even, near].map(|options| Stage::new(mesh, &options));
        let (tree, walker) = (Nearest::new(mesh), Walker::new(mesh));
        Ok(Self { setting, reference, job, seen, tree, walker, lit, even, near, error_scale })
    }

    fn setting_report(&self) -> SettingReport {
        let Setting { exemplar, plane, scale, ratio, guide, seed, .. } = self.setting;
        SettingReport {
            faces: self.setting.mesh().face_count(),
            scale: *scale,
            ratio: *ratio,
            pixel: plane.pixel,
            exemplar_size: exemplar.size(),
            tiles: plane.tiles,
            ways: match guide {
                Guide::Directed(field) => field.ways,
                Guide::Isotropic { .. } => 0,
            },
            seed: *seed,
            error_scale: self.error_scale,
            views: self.job.views.iter().map(View::describe).collect(),
            size: self.job.size,
        }
    }

    /// The exemplar and the colours of its places.
    fn of_exemplar(&self) -> Vec<Named> {
        let [w, h] = self.setting.exemplar.size();
        let image = self.setting.exemplar.channel(Channel::BaseColor).map(crate::exemplar::MipChain::finest);
        let picture = |color: &dyn Fn(u32, u32) -> Vec3| {
            let mut out = Picture::filled(w, h, [0, 0, 0, 255]);
            for (i, pixel) in out.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let color = color(i as u32 % w, i as u32 / w).map(srgb::encode);
                pixel[..3].copy_from_slice(&color.to_array().map(to_byte));
            }
            out
        };
        let own = |x: u32, y: u32| image.map_or(Vec3::ZERO, |i| i.pixel(i64::from(x), i64::from(y)));
        let place = |x: u32, y: u32| place_color(&self.setting.plane, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let named = |name: &str, picture| Named { name: name.to_owned(), picture };
        vec![named("exemplar", picture(&own)), named("places", picture(&place))]
    }

    fn report(&self, made: &Made, pictures: &mut Vec<Named>) -> MethodReport {
        let (plane, seed) = (self.setting.plane, self.setting.seed);
        let (mesh, home) = made.product.at_home(self.setting);
        let is_own = std::ptr::eq(mesh, self.setting.mesh());
        let home = Home { mesh, source: home.as_ref(), is_own };
        let others = (!is_own).then(|| Walker::new(mesh));
        let on = others.as_ref().unwrap_or(&self.walker);
        let right = |at: SurfacePoint| self.right(home, at);
        let up = |at: SurfacePoint| self.up(home, at);
        let ways = self.setting.field().map_or(1, |f| f.ways);
        let placed = Placed { on, texture: home.source, right: &right, pixel: plane.pixel };
        let mapped = Mapped { on, source: home.source, plane, up: &up, ways };
        let fidelity = self.reference.measure(&placed, seed);
        let (mapping, extremes) = mapping(&mapped, seed);
        let errors = self.reference.known().map(|known| ErrorMap::new(&placed, known, seed));
        let borders = breaks(&mapped, seed);
        let (seams, worst_seam) = self.seams(home, &borders);
        let charts = made.product.charts().map(|atlas| self.seams(home, &chart_borders(mesh, atlas, BORDER_STEP * plane.pixel)));
        let mut out = empty(made.method, None);
        out.figures = Some(Figures { fidelity, mapping, seams, chart_seams: charts.as_ref().map(|c| c.0), costs: made.costs });
        let key = made.method.key();
        if let Some(Blind { sheet, key: answers }) = blind(&placed, &borders, &self.setting.exemplar, self.job.blind as usize, seed)
        {
            let name = format!("{key}-blind");
            pictures.push(Named { name: name.clone(), picture: sheet });
            out.blind = Some((name, answers));
        }
        let source = made.product.source(self.setting);
        let source = source.as_ref();
        for (i, (seen, coarse)) in self.seen.iter().enumerate() {
            let name = |what: &str| format!("{key}-{what}-{}", i + 1);
            let names = ViewPictures { texture: name("texture"), source: name("source"), error: name("error") };
            let mut take = |name: &String, stage: &Stage<'_>, seen: &Visibility, texture: &dyn SurfaceTexture| {
                pictures.push(Named { name: name.clone(), picture: stage.draw(texture, seen) });
            };
            take(&names.texture, &self.lit, seen, source);
            take(&names.source, &self.even, coarse, &SourceColors::new(source, plane));
            if let Some(errors) = &errors {
                take(&names.error, &self.even, coarse, &ErrorColors::new(self.setting.mesh(), errors, self.error_scale));
            }
            out.pictures.push(names);
        }
        let apart = CLOSE_WIDTHS / 2.0 * self.setting.scale;
        let found: [(&'static str, Option<Extreme>); 6] = [
            ("coherence", errors.as_ref().and_then(|e| e.worst(mesh, apart))),
            ("seams", worst_seam),
            ("chartSeams", charts.and_then(|c| c.1)),
            ("stretch", extremes.stretch),
            ("direction", extremes.direction),
            ("alpha", extremes.alpha.filter(|_| mapping.bare > 0.0)),
        ];
        for (measure, extreme) in found {
            let Some(Extreme { at, value }) = extreme else { continue };
            let picture = format!("{key}-worst-{measure}");
            if let Some(close) = self.close_up(home, source, at) {
                pictures.push(Named { name: picture.clone(), picture: close });
                out.worst.push(Worst { measure, value, position: mesh.position(at).to_array(), picture });
            }
        }
        out
    }

    /// The point of the setting's mesh that is nearest to one of another.
    fn nearest(&self, home: Home, at: SurfacePoint) -> Option<SurfacePoint> {
        if home.is_own { Some(at) } else { self.tree.nearest(home.mesh.position(at)).map(|hit| hit.at) }
    }

    /// Texture up as the field has it.
    fn up(&self, home: Home, at: SurfacePoint) -> Option<DVec3> {
        let field = self.setting.field()?;
        Some(field.up[self.nearest(home, at)?.face as usize].as_dvec3())
    }

    /// Texture right at a point: where the method itself has it, else where the field has it.
    fn right(&self, home: Home, at: SurfacePoint) -> DVec3 {
        let own = home.source.origin(at).map(|o| o.right).filter(|r| *r != DVec3::ZERO);
        let asked = || self.up(home, at).map(|up| up.cross(home.mesh.normal(at.face)));
        own.or_else(asked).unwrap_or(DVec3::X)
    }

    /// How visible borders are, and the place where they are most: where the steps around are largest on the mean.
    fn seams(&self, Home { mesh, source, .. }: Home, borders: &[Border]) -> (SeamVisibility, Option<Extreme>) {
        let Some(own) = &self.reference.own else { return (SeamVisibility::default(), None) };
        let plane = self.setting.plane;
        let across = steps_across(mesh, source, borders, plane.pixel);
        let near = ONE_PLACE * plane.pixel;
        let positions: Vec<DVec3> = borders.iter().map(|b| mesh.position(b.at)).collect();
        let mean = |i: usize| {
            let around = (0..positions.len()).filter(|&j| positions[i].distance_squared(positions[j]) <= near * near);
            let (sum, count) = around.fold((0.0, 0), |(sum, count), j| (sum + across[j], count + 1));
            sum / f64::from(count)
        };
        // Of many borders a part is enough to find a bad one.
        let step = positions.len().div_ceil(LOOKED_AT).max(1);
        let mut worst: Option<Extreme> = None;
        for i in (0..positions.len()).step_by(step) {
            let value = mean(i);
            if worst.is_none_or(|w| value > w.value) {
                worst = Some(Extreme { at: borders[i].at, value });
            }
        }
        (own.visibility(&across), worst)
    }

    /// What is seen straight above a point.
    fn close_up(&self, home: Home, source: &dyn Sourced, at: SurfacePoint) -> Option<Picture> {
        let (mesh, there) = (self.setting.mesh(), self.nearest(home, at)?);
        let camera = above(mesh, there, self.right(home, at), CLOSE_WIDTHS * self.setting.scale);
        let seen = Visibility::new(mesh, &camera, Grid { width: CLOSE, height: CLOSE, samples: 1 }).ok()?;
        Some(self.near.draw(source, &seen))
    }
}

/// A texture on the mesh that it is measured on.
#[derive(Clone, Copy)]
struct Home<'a> {
    mesh: &'a Mesh,
    source: &'a dyn Sourced,
    /// Whether that mesh is the setting's.
    is_own: bool,
}

/// Borders whose surroundings are looked at for the worst place.
const LOOKED_AT: usize = 500;

/// A camera straight above a point, texture up upwards, that shows a square of this side, world units.
fn above(mesh: &Mesh, at: SurfacePoint, right: DVec3, side: f64) -> Camera {
    let normal = mesh.normal(at.face);
    let right = (right - normal * right.dot(normal)).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    let up = normal.cross(right);
    Camera {
        eye: mesh.position(at) + normal * (AWAY * side),
        right,
        up,
        forward: -normal,
        projection: Projection::Orthographic(0.5 * side),
        near: 1e-3 * side,
        world_up: up,
    }
}
