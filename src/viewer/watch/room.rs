//! Watching in the window: subjects of the first pastes alone, the growth of the paste that was clicked, its disc on the model and
//! its flattening beside it.

use super::{Watch, describe, flat, panel, topmost};
use crate::mesh::SurfacePoint;
use crate::paste::{FaceLists, Growth, LappedTexture, Paste, watch::Moment};
use crate::render::gpu::{GpuError, Renderer, Subject};
use crate::render::{Camera, DrawOptions, Stage};
use crate::viewer::build::Shown;
use crate::viewer::steer::room::SteerRoom;
use crate::viewer::viewport::Viewport;
use crate::viewer::worker::Lane;
use egui::epaint::{Mesh, Vertex, WHITE_UV};
use egui::{Color32, Context, Shape, Stroke, TextureHandle, TextureOptions, Ui};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Faces of a disc that are painted over the model at most; of a larger disc every n-th.
const MOST_FACES: usize = 4000;

const FACE: Color32 = Color32::from_rgba_premultiplied(20, 70, 110, 90);
const NEW: Color32 = Color32::from_rgba_premultiplied(200, 160, 30, 220);
const EDGE: Color32 = Color32::from_rgba_premultiplied(120, 190, 225, 225);

/// A subject of the first pastes alone.
type Made = (usize, Result<Subject, GpuError>);

/// Watching one result.
pub struct WatchRoom {
    watch: Watch,
    shown: Arc<Shown>,
    lists: FaceLists,
    subjects: Lane<Made>,
    subject: Option<(usize, Subject)>,
    asked: usize,
    growths: Lane<(usize, Option<Growth>)>,
    mask: Option<(u16, TextureHandle)>,
    sight: Sight,
}

/// Which faces a camera sees, as far as it was asked for: rays through the model are too dear to be sent again every frame.
#[derive(Debug, Default)]
struct Sight {
    camera: Option<Camera>,
    faces: BTreeMap<u32, bool>,
}

impl Sight {
    fn sees(&mut self, camera: &Camera, face: u32, ask: impl FnOnce() -> bool) -> bool {
        if self.camera.as_ref() != Some(camera) {
            *self = Self { camera: Some(*camera), faces: BTreeMap::new() };
        }
        *self.faces.entry(face).or_insert_with(ask)
    }
}

impl std::fmt::Debug for WatchRoom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WatchRoom").field("watch", &self.watch).finish_non_exhaustive()
    }
}

impl WatchRoom {
    /// All pastes are seen. `None` if there are none, or nobody knows where they began: those of an opened record.
    pub fn new(shown: Arc<Shown>, wake: impl Fn() + Clone + Send + Sync + 'static) -> Option<Self> {
        let laid = shown.laid.as_ref()?;
        let count = laid.lapped.pastes.len();
        let lists = FaceLists::new(shown.mesh().face_count(), &laid.lapped.pastes);
        Some(Self {
            watch: Watch::new(count),
            lists,
            subjects: Lane::new("lapped watching", wake.clone()),
            subject: None,
            asked: count,
            growths: Lane::new("lapped growing", wake),
            mask: None,
            sight: Sight::default(),
            shown,
        })
    }

    /// The player.
    #[must_use]
    pub const fn watch(&self) -> &Watch {
        &self.watch
    }

    /// The player, to be set.
    pub const fn watch_mut(&mut self) -> &mut Watch {
        &mut self.watch
    }

    /// True if it is of this result.
    #[must_use]
    pub fn is_of(&self, shown: &Arc<Shown>) -> bool {
        Arc::ptr_eq(&self.shown, shown)
    }

    /// True if nothing is being made.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.subjects.is_idle() && self.growths.is_idle()
    }

    /// The subject of the pastes that are to be seen, and another number with every other; none if all are.
    #[must_use]
    pub fn subject(&self) -> Option<(&Subject, u64)> {
        let all = self.watch.shown() == self.watch.count();
        self.subject.as_ref().filter(|_| !all).map(|(count, subject)| (subject, *count as u64))
    }

    /// Lets time pass and asks for what is to be seen.
    pub fn follow(&mut self, ui: &Ui, renderer: &Arc<Renderer>) {
        let seconds = f64::from(ui.input(|i| i.stable_dt));
        if self.watch.pass(seconds) {
            ui.ctx().request_repaint();
        }
        for (count, made) in self.subjects.take() {
            self.subject = made.ok().map(|subject| (count, subject)).or(self.subject.take());
        }
        for (paste, growth) in self.growths.take() {
            match growth {
                Some(growth) => self.watch.grow(paste, growth),
                None => self.watch.choose(None),
            }
        }
        let count = self.watch.shown();
        if count != self.asked && self.subjects.meter().is_none() {
            self.asked = count;
            let (shown, renderer) = (Arc::clone(&self.shown), Arc::clone(renderer));
            self.subjects.submit(move |_, deliver| deliver((count, of_first(&shown, count, &renderer))));
        }
        if let Some(paste) = self.watch.chosen().filter(|_| self.watch.wants_growth() && self.growths.meter().is_none()) {
            let shown = Arc::clone(&self.shown);
            self.growths.submit(move |_, deliver| deliver((paste, growth(&shown, paste))));
        }
    }

    /// Chooses the topmost paste at a place of the clean mesh.
    pub fn click(&mut self, at: Option<SurfacePoint>) {
        let laid = self.shown.laid.as_ref();
        let paste = at.and_then(|at| {
            let at = laid.and_then(|l| l.fine.as_ref()).map_or(at, |fine| fine.locate(at));
            topmost(self.lists.of(at.face), self.watch.shown())
        });
        self.watch.choose(paste);
    }

    /// Shows the panel.
    pub fn show(&mut self, ui: &mut Ui) {
        let Some(laid) = self.shown.laid.as_ref() else { return };
        ui.add_space(4.0);
        ui.strong("Watch")
            .on_hover_text("Pastes laid one by one, and how a paste's surface patch grew and was laid flat (3.3, 3.4)");
        let chosen = self.watch.chosen();
        let about = chosen.map(|paste| describe(paste, self.watch.count(), laid.seedings.get(paste)));
        panel::pastes(ui, &mut self.watch, about.as_deref());
        let patch = self.watch.growth().map(|growth| growth.patch);
        let Some((number, patch)) = patch.and_then(|p| Some((p, laid.lapped.patches.get(usize::from(p))?))) else { return };
        ui.separator();
        let mask = mask(ui.ctx(), &mut self.mask, number, patch);
        panel::growth(ui, &mut self.watch, patch, mask);
    }

    /// Paints the growing disc over the model, but for what nearer parts hide.
    pub fn paint(&mut self, ui: &Ui, viewport: &Viewport, steer: &SteerRoom) {
        let Some(moment) = self.watch.moment() else { return };
        let painter = ui.painter().with_clip_rect(viewport.rect());
        let (camera, shown, sight) = (viewport.orbit.camera(), &self.shown, &mut self.sight);
        let mesh = shown.mesh();
        let mut seen = |face| sight.sees(&camera, face, || steer.in_sight(shown, &camera, mesh.centroid(face)));
        disc(&painter, viewport, &camera, mesh, &moment, &mut seen);
    }
}

/// A picture of a patch's mask, made when another patch is looked at.
fn mask(
    context: &Context,
    kept: &mut Option<(u16, TextureHandle)>,
    number: u16,
    patch: &crate::exemplar::TexturePatch,
) -> egui::TextureId {
    if let Some((of, texture)) = kept
        && *of == number
    {
        return texture.id();
    }
    let texture = context.load_texture("mask", flat::mask_picture(patch), TextureOptions::LINEAR);
    kept.insert((number, texture)).1.id()
}

/// The first pastes alone, on the device; the patches are there already.
fn of_first(shown: &Shown, count: usize, renderer: &Renderer) -> Result<Subject, GpuError> {
    let pastes: Vec<Paste> = shown.lapped().map_or_else(Vec::new, |l| l.pastes.iter().take(count).cloned().collect());
    let layers = shown.lapped().map_or_else(Vec::new, |l| l.layers.clone());
    let first = LappedTexture { pastes, layers, ..LappedTexture::default() };
    let stage = Stage::new(shown.mesh(), &DrawOptions::default());
    renderer.load_with(&stage, &first, None, Arc::clone(shown.subject.patches()))
}

fn growth(shown: &Shown, paste: usize) -> Option<Growth> {
    let laid = shown.laid.as_ref()?;
    let options = shown.project.job(laid.lapped.exemplars.first()).paste;
    Growth::of(shown.mesh(), &laid.guide, &laid.lapped, &options, laid.seedings.get(paste)?)
}

/// The disc's faces that look at the eye and are `seen`, the last that joined brighter.
fn disc(
    painter: &egui::Painter,
    viewport: &Viewport,
    camera: &Camera,
    surface: &crate::mesh::Mesh,
    moment: &Moment,
    seen: &mut dyn FnMut(u32) -> bool,
) {
    let growing = moment.doing == crate::paste::watch::Doing::Growing;
    let last = moment.faces.len().saturating_sub(1);
    let every = moment.faces.len().div_ceil(MOST_FACES).max(1);
    let mut mesh = Mesh::default();
    for (i, &face) in moment.faces.iter().enumerate().filter(|(i, _)| i % every == 0 || *i == last) {
        let corners = surface.corners(face);
        if surface.normal(face).dot(surface.centroid(face) - camera.eye) >= 0.0 || !seen(face) {
            continue;
        }
        let [Some(a), Some(b), Some(c)] = corners.map(|p| viewport.place(camera, p)) else { continue };
        let color = if growing && i == last { NEW } else { FACE };
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend([a, b, c].map(|pos| Vertex { pos, uv: WHITE_UV, color }));
        mesh.indices.extend([first, first + 1, first + 2]);
    }
    let corners: Vec<_> = mesh.vertices.chunks_exact(3).map(|v| [v[0].pos, v[1].pos, v[2].pos]).collect();
    painter.add(Shape::mesh(mesh));
    for [a, b, c] in corners {
        painter.add(Shape::closed_line(vec![a, b, c], Stroke::new(0.6, EDGE)));
    }
}
