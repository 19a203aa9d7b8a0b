//! Combing in the window: the pointer on the view picks places of the surface, strokes and handles become edits of the project.

use super::handles::{self, Grip, Handle, lined};
use super::{Combing, Edit, Ground, Tool};
use crate::field::Mirror;
use crate::job::Project;
use crate::job::project::Direction;
use crate::mesh::nearest::{Nearest, Tree};
use crate::mesh::{Mesh, SurfacePoint};
use crate::render::Camera;
use crate::viewer::build::Shown;
use crate::viewer::library::OpenModel;
use crate::viewer::viewport::Viewport;
use crate::viewer::worker::Lane;
use egui::{Color32, CursorIcon, Event, Key, Modifiers, PointerButton, Pos2, Ui};
use glam::DVec3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Weight of the projected axis once something is combed: constraints rule out to two and a half of their extents, the axis
/// beyond. Without it a single stroke would turn the texture of the whole model.
pub const BASE_WEIGHT: f64 = 0.05;

/// The comb's radius grows and shrinks by this factor a key press.
const RADIUS_STEP: f64 = 1.25;

/// Places nearer to the eye than this share of the distance to a handle, or to another place, hide it.
const HIDDEN: f64 = 0.995;

/// A button that goes up within so many points of where it went down was a click.
const CLICK: f32 = 3.0;

const BRUSH: Color32 = Color32::from_rgb(255, 214, 84);
const TWIN: Color32 = Color32::from_rgb(150, 200, 230);
const SIDES: u32 = 40;

/// What became of the pointer.
#[derive(Debug, Default)]
pub struct Pointed {
    /// The comb has hold of it: the camera stays where it is.
    pub held: bool,
    /// What has changed.
    pub edit: Option<Edit>,
}

/// Something that the pointer did.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// Its main button went down, with these keys held.
    Press(Pos2, Modifiers),
    Move(Pos2),
    Release,
}

/// What the pointer did, in its order.
fn steps(events: &[Event]) -> Vec<Step> {
    let step = |event: &Event| match *event {
        Event::PointerMoved(at) => Some(Step::Move(at)),
        Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, modifiers } => Some(Step::Press(pos, modifiers)),
        Event::PointerButton { button: PointerButton::Primary, pressed: false, .. } => Some(Step::Release),
        _ => None,
    };
    events.iter().filter_map(step).collect()
}

/// Combing, and the surface that is combed.
#[derive(Debug)]
pub struct SteerRoom {
    /// True while the pointer combs.
    pub on: bool,
    /// The constraints.
    pub combing: Combing,
    ground: Option<(Arc<OpenModel>, Tree)>,
    trees: Lane<(Arc<OpenModel>, Tree)>,
    asked: Option<Arc<OpenModel>>,
    hovered: Option<(usize, Grip)>,
    /// Where the button went down, until the pointer has left that place.
    pressed: Option<Pos2>,
    /// Where the pointer is on the surface.
    at: Option<SurfacePoint>,
}

impl SteerRoom {
    /// Nothing to comb yet; `wake` is called when there is.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            on: false,
            combing: Combing::default(),
            ground: None,
            trees: Lane::new("lapped combing", wake),
            asked: None,
            hovered: None,
            pressed: None,
            at: None,
        }
    }

    /// True once the model that is shown can be combed.
    #[must_use]
    pub fn ready(&self, shown: &Shown) -> bool {
        self.ground.as_ref().is_some_and(|(open, _)| Arc::ptr_eq(open, &shown.open))
    }

    /// Keeps up with what is shown and with changes of the project made elsewhere. An error says why the project's constraints
    /// cannot be shown.
    ///
    /// # Errors
    /// What is wrong with them, in words.
    pub fn follow(&mut self, shown: &Shown, project: &Project) -> Result<(), String> {
        for (open, tree) in self.trees.take() {
            self.ground = Some((open, tree));
        }
        if !self.ready(shown) {
            if self.asked.as_ref().is_none_or(|asked| !Arc::ptr_eq(asked, &shown.open)) {
                self.combing = Combing { settings: self.combing.settings, ..Combing::default() };
                self.asked = Some(Arc::clone(&shown.open));
                let open = Arc::clone(&shown.open);
                self.trees.submit(move |_, deliver| {
                    let tree = Tree::new(&open.cleaned.mesh);
                    deliver((open, tree));
                });
            }
            return Ok(());
        }
        if self.combing.busy() || *self.combing.constraints() == project.constraints {
            return Ok(());
        }
        let constraints = project.constraints.clone();
        self.with(shown, |combing, ground| combing.set(ground, constraints).map_err(|e| e.to_string())).unwrap_or(Ok(()))
    }

    /// Does something on the ground, if that is ready.
    pub fn with<T>(&mut self, shown: &Shown, deed: impl FnOnce(&mut Combing, &Ground<'_>) -> T) -> Option<T> {
        let (open, tree) = self.ground.as_ref().filter(|(open, _)| Arc::ptr_eq(open, &shown.open))?;
        let tree = Nearest::over(&open.cleaned.mesh, tree);
        let ground = Ground {
            mesh: &open.cleaned.mesh,
            tree: &tree,
            user_faces: Some(&open.cleaned.user_faces),
            axis: axis(&shown.project),
            scale: shown.report().map_or(1.0, |report| report.scale),
        };
        Some(deed(&mut self.combing, &ground))
    }

    /// The place of the clean mesh under a place of the window.
    #[must_use]
    pub fn pick(&self, shown: &Shown, viewport: &Viewport, at: Pos2) -> Option<SurfacePoint> {
        let (open, tree) = self.ground.as_ref().filter(|(open, _)| Arc::ptr_eq(open, &shown.open))?;
        let (from, along) = viewport.ray(&viewport.orbit.camera(), at);
        Nearest::over(&open.cleaned.mesh, tree).ray(from, along, f64::INFINITY).map(|hit| hit.at)
    }

    /// True if no part of the model hides a place on it; false while that cannot be told yet.
    #[must_use]
    pub fn in_sight(&self, shown: &Shown, camera: &Camera, place: DVec3) -> bool {
        let Some((open, tree)) = self.ground.as_ref().filter(|(open, _)| Arc::ptr_eq(open, &shown.open)) else { return false };
        Nearest::over(&open.cleaned.mesh, tree).ray(camera.eye, place - camera.eye, HIDDEN).is_none()
    }

    /// Takes the pointer and the keys, before the camera gets them.
    pub fn point(&mut self, ui: &Ui, viewport: &Viewport, shown: &Shown) -> Pointed {
        if !self.on || !self.ready(shown) {
            (self.at, self.hovered) = (None, None);
            return Pointed::default();
        }
        let (steps, pointer, down) = ui.input(|i| (steps(&i.events), i.pointer.latest_pos(), i.pointer.primary_down()));
        let (mut held, mut edit) = (self.combing.busy(), None);
        // Of what happened since the last frame everything counts: a quick stroke may begin and end between two frames.
        for step in steps {
            edit = self.step(ui, viewport, shown, step).or(edit);
            held |= self.combing.busy();
        }
        if self.combing.busy() && !down {
            edit = self.with(shown, Combing::end).flatten().or(edit);
        }
        let busy = self.combing.busy();
        let over = pointer.filter(|&p| busy || on_view(ui, viewport, p));
        self.at = over.and_then(|p| self.pick(shown, viewport, p));
        if !busy {
            self.hovered = over.and_then(|p| self.grip(shown, viewport, &viewport.orbit.camera(), p));
        }
        if over.is_some() {
            edit = self.keys(ui, shown).or(edit);
            ui.ctx().set_cursor_icon(match self.hovered {
                Some((_, Grip::Move)) => CursorIcon::Move,
                Some((_, Grip::Turn | Grip::Widen)) => CursorIcon::Grab,
                None if self.at.is_some() => CursorIcon::Crosshair,
                None => CursorIcon::Default,
            });
        }
        Pointed { held, edit }
    }

    /// One thing that the pointer did.
    fn step(&mut self, ui: &Ui, viewport: &Viewport, shown: &Shown, step: Step) -> Option<Edit> {
        match step {
            Step::Press(at, modifiers) if !self.combing.busy() && on_view(ui, viewport, at) => {
                self.pressed = Some(at);
                self.hovered = self.grip(shown, viewport, &viewport.orbit.camera(), at);
                let (place, hovered) = (self.pick(shown, viewport, at), self.hovered);
                let tool = match modifiers {
                    m if m.shift => Tool::Scale,
                    m if m.alt => Tool::Erase,
                    _ => self.combing.settings.tool,
                };
                self.with(shown, |combing, ground| match (hovered, place) {
                    (Some((index, grip)), _) => combing.begin_handle(ground, index, grip),
                    (None, Some(place)) => combing.begin_stroke(place, tool),
                    (None, None) => combing.select(None),
                });
                None
            }
            Step::Move(at) if self.combing.busy() => {
                self.pressed = self.pressed.filter(|from| from.distance(at) < CLICK);
                let place = self.pick(shown, viewport, at).filter(|_| self.pressed.is_none())?;
                let moved = self.with(shown, |combing, ground| combing.drag(ground, place)) == Some(true);
                moved.then(|| self.live(&shown.project))
            }
            Step::Release if self.combing.busy() => self.with(shown, Combing::end).flatten(),
            _ => None,
        }
    }

    /// Gives a gesture up, or else the selection. False if there is neither.
    pub fn escape(&mut self, shown: &Shown) -> bool {
        let (busy, some) = (self.combing.busy(), self.on && self.combing.selected().is_some());
        if busy {
            self.with(shown, Combing::cancel);
        } else {
            self.combing.select(None);
        }
        busy || some
    }

    /// The state in the middle of dragging a handle, so that the picture follows.
    fn live(&self, project: &Project) -> Edit {
        let what = self.hovered.map_or("Move handle", |(_, grip)| grip.what());
        Edit { what, before: project.constraints.clone(), after: self.combing.constraints().clone() }
    }

    fn keys(&mut self, ui: &Ui, shown: &Shown) -> Option<Edit> {
        if ui.ctx().text_edit_focused() {
            return None;
        }
        let pressed = |key| ui.input(|i| i.key_pressed(key));
        let radius = &mut self.combing.settings.radius;
        if pressed(Key::OpenBracket) {
            *radius = (*radius / RADIUS_STEP).max(0.01);
        }
        if pressed(Key::CloseBracket) {
            *radius = (*radius * RADIUS_STEP).min(0.5);
        }
        let delete = pressed(Key::Delete) || pressed(Key::Backspace);
        delete.then(|| self.with(shown, Combing::delete).flatten()).flatten()
    }

    fn grip(&self, shown: &Shown, viewport: &Viewport, camera: &Camera, pointer: Pos2) -> Option<(usize, Grip)> {
        let handles = self.combing.handles(&shown.open.cleaned.mesh);
        let seen = |handle: &Handle| self.sees(shown, camera, handle);
        handles::grip_at(&handles, self.combing.selected(), pointer, &|p| viewport.place(camera, p), &seen)
    }

    /// True if no part of the mesh hides a handle.
    fn sees(&self, shown: &Shown, camera: &Camera, handle: &Handle) -> bool {
        handle.normal.dot(handle.place - camera.eye) < 0.0 && self.in_sight(shown, camera, handle.place)
    }

    /// Paints handles, the stroke and the comb over the view.
    pub fn paint(&self, ui: &Ui, viewport: &Viewport, shown: &Shown) {
        if !self.on || !self.ready(shown) {
            return;
        }
        let camera = viewport.orbit.camera();
        let mesh = &shown.open.cleaned.mesh;
        let painter = ui.painter().with_clip_rect(viewport.rect());
        let project = |p: DVec3| viewport.place(&camera, p);
        let handles = self.combing.handles(mesh);
        let hovered = self.hovered.map(|(i, _)| i);
        handles::paint(&painter, &handles, self.combing.selected(), hovered, &project, &|h| self.sees(shown, &camera, h));
        let way: Vec<DVec3> = self.combing.way().iter().map(|&p| mesh.position(p)).collect();
        let mirror = self.combing.settings.symmetry.map(|axis| Mirror::middle(mesh, axis));
        let lines = [(BRUSH, None), (TWIN, mirror)];
        for (color, mirror) in lines.into_iter().filter(|(color, mirror)| *color == BRUSH || mirror.is_some()) {
            let image = |p: DVec3| mirror.map_or(p, |m: Mirror| m.point(p));
            lined(&painter, way.iter().filter_map(|&p| project(image(p))).collect(), color, 2.0);
            if let Some(at) = self.at.filter(|_| self.hovered.is_none()) {
                let ring = brush(mesh, at, self.combing.settings.radius);
                lined(&painter, ring.into_iter().filter_map(|p| project(image(p))).collect(), color, 1.0);
            }
        }
    }
}

/// True if the pointer is on the view and on nothing that lies over it.
pub(in crate::viewer) fn on_view(ui: &Ui, viewport: &Viewport, at: Pos2) -> bool {
    let divider = viewport.split.map(|share| viewport.rect().left() + share * viewport.rect().width());
    let free = divider.is_none_or(|x| (at.x - x).abs() > 6.0);
    let top = ui.ctx().layer_id_at(at).is_none_or(|layer| layer == ui.layer_id());
    free && top && viewport.rect().contains(at)
}

/// The ring of the comb around a place.
fn brush(mesh: &Mesh, at: SurfacePoint, radius: f64) -> Vec<DVec3> {
    let (low, high) = mesh.bounds();
    let radius = radius * high.as_dvec3().distance(low.as_dvec3());
    let (x, y) = mesh.normal(at.face).any_orthonormal_pair();
    let place = mesh.position(at);
    let on = |i: u32| {
        let (sine, cosine) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
        place + (x * cosine + y * sine) * radius
    };
    (0..=SIDES).map(on).collect()
}

/// What angles are measured against.
fn axis(project: &Project) -> DVec3 {
    match project.direction {
        Direction::Up(axis) => DVec3::from(axis),
        _ => DVec3::Y,
    }
}

/// Puts an edit into a project. Constraints steer along an axis: a project whose direction comes from elsewhere gets one.
pub fn put(project: &mut Project, edit: &Edit) {
    let first = project.constraints.constraints.is_empty();
    project.constraints.clone_from(&edit.after);
    if first && project.constraints.base_weight == 0.0 {
        project.constraints.base_weight = BASE_WEIGHT;
    }
    let directed = edit.after.constraints.iter().any(|c| c.direction.is_some() || c.angle.is_some());
    match project.direction {
        Direction::Up(_) => {}
        Direction::None if !directed => {}
        _ => project.direction = Direction::Up([0.0, 1.0, 0.0]),
    }
}
