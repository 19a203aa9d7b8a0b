//! The three-dimensional view: one pane or two beside each other, all seen by one camera.

use super::graphics::{Graphics, Look, Pane};
use super::mode::{Backdrop, Light, Mode};
use super::orbit::Orbit;
use super::synth::Method;
use crate::mesh::Mesh;
use crate::render::gpu::{GpuError, Path, Screen, Subject};
use crate::render::{Camera, DrawOptions, Projection};
use egui::{Color32, CursorIcon, Key, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};
use glam::DVec3;
use std::time::Duration;

/// Factor by which a point of scrolling brings nearer.
const SCROLL: f64 = 0.004;
/// Half the width of what takes hold of the divider, points.
const GRIP: f32 = 5.0;
/// A room whose width over height changes by this share has another shape.
const RESHAPED: f64 = 0.01;
/// The divider stays so far from the borders, as a share of the width.
const LEAST_SHARE: f32 = 0.05;

/// What a pane is given to show in a mode.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    /// The subject; none if it is not ready.
    pub subject: Option<&'a Subject>,
    /// Lines on the surface, and a number that is another with every other.
    pub lines: Option<(&'a Subject, u64)>,
    /// A picture that stands for the frame, of this very view.
    pub still: Option<egui::TextureId>,
    /// Counts up with every other subject.
    pub number: u64,
    /// Another number with every other frame of exemplars that go by time.
    pub moment: u64,
}

/// Everything that a frame depends on.
#[derive(Debug, Clone, PartialEq)]
struct Key3 {
    size: [u32; 2],
    orbit: Orbit,
    mode: Mode,
    light: Light,
    options: DrawOptions,
    number: u64,
    moment: u64,
    lines: u64,
}

/// The view.
#[derive(Debug)]
pub struct Viewport {
    /// The camera.
    pub orbit: Orbit,
    /// What the panes show.
    pub modes: [Mode; 2],
    /// Where the divider between two panes is, as a share of the width.
    pub split: Option<f32>,
    /// Goes around by itself.
    pub turntable: bool,
    /// Whether exemplars that go by time change.
    pub playing: bool,
    /// Seconds that they have been changing for.
    pub clock: f64,
    /// The light.
    pub light: Light,
    /// What is behind.
    pub backdrop: Backdrop,
    panes: [Pane; 2],
    /// What both draw by.
    screen: Option<Screen>,
    drawn: [Option<Key3>; 2],
    rect: Rect,
    scale: f32,
    /// When the camera moved last, seconds of the interface's clock.
    moved: f64,
    /// The camera that showed all of the model, and for which shape of room.
    framed: Option<(Orbit, f64)>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            orbit: Orbit::default(),
            modes: [Mode::Single, Mode::Pastes],
            split: None,
            turntable: false,
            playing: false,
            clock: 0.0,
            light: Light::default(),
            backdrop: Backdrop::default(),
            panes: Default::default(),
            screen: None,
            drawn: [None, None],
            rect: Rect::from_min_size(Pos2::ZERO, Vec2::new(4.0, 3.0)),
            scale: 1.0,
            moved: 0.0,
            framed: None,
        }
    }
}

/// What became of the view in a frame.
#[derive(Debug)]
pub struct Seen {
    /// The pointer on the view.
    pub response: egui::Response,
    /// Why a pane could not be drawn.
    pub error: Option<GpuError>,
    /// Panes that were drawn anew.
    pub frames: u32,
    /// How long the device took for them, of the time of this frame.
    pub device: Duration,
}

impl Viewport {
    /// How much of the world is seen from the top to the bottom, at the point looked at.
    #[must_use]
    pub fn height(&self) -> f64 {
        let Projection::Perspective(tangent) = self.orbit.camera().projection else { return 1.0 };
        2.0 * tangent * self.orbit.distance
    }

    /// Where it is in the window, points.
    #[must_use]
    pub const fn rect(&self) -> Rect {
        self.rect
    }

    /// Makes ready what takes longer than a frame. What cannot be made is told when it is drawn with.
    pub fn prepare(&mut self, graphics: &Graphics) {
        self.screen = graphics.screen().ok();
    }

    /// Where it will be in the window, and pixels a point.
    pub const fn set_room(&mut self, rect: Rect, scale: f32) {
        (self.rect, self.scale) = (rect, scale);
    }

    /// Width over height.
    #[must_use]
    pub fn aspect(&self) -> f64 {
        f64::from(self.rect.width().max(1.0) / self.rect.height().max(1.0))
    }

    /// Its size in pixels.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        [self.rect.width(), self.rect.height()].map(|s| (s * self.scale).round().max(0.0) as u32)
    }

    /// Seconds since the camera moved last.
    #[must_use]
    pub fn at_rest(&self, now: f64) -> f64 {
        now - self.moved
    }

    /// The modes that are seen.
    pub fn seen_modes(&self) -> impl Iterator<Item = Mode> + '_ {
        self.modes.iter().copied().take(1 + usize::from(self.split.is_some()))
    }

    /// Shows the texture as it is pasted with a synthesis beside it, or no synthesis any more.
    pub fn compare(&mut self) {
        if self.seen_modes().any(|mode| mode.method().is_some()) {
            (self.split, self.modes[0]) = (None, Mode::Single);
        } else {
            (self.split, self.modes) = (Some(0.5), [Mode::Single, Mode::WeiLevoy]);
        }
    }

    /// Shows a method in the pane that shows another one.
    pub fn show_method(&mut self, method: Method) {
        let seen: Vec<Mode> = self.seen_modes().collect();
        let other = seen.iter().rposition(|mode| mode.method().is_some_and(|m| m != method));
        if let Some(pane) = other.filter(|_| seen.iter().all(|mode| mode.method() != Some(method))) {
            self.modes[pane] = method.mode();
        }
    }

    /// Light and background of frames.
    #[must_use]
    pub fn options(&self, dark: bool) -> DrawOptions {
        let (lighting, background) = (self.light.lighting(), self.backdrop.background(dark));
        DrawOptions { lighting, background, occlusion: false, ..DrawOptions::default() }
    }

    /// Shows all of a mesh.
    pub fn frame(&mut self, mesh: &Mesh) {
        let aspect = self.aspect();
        self.orbit.frame(mesh, aspect);
        self.framed = Some((self.orbit, aspect));
    }

    /// Shows all of a mesh again if it did, nobody has moved the camera since, and the room has another shape now.
    pub fn keep_framed(&mut self, mesh: &Mesh) {
        if self.framed.is_some_and(|(orbit, aspect)| orbit == self.orbit && (self.aspect() / aspect - 1.0).abs() > RESHAPED) {
            self.frame(mesh);
        }
    }

    /// Where a point of the world is in the window, if it is in front of the eye.
    #[must_use]
    pub fn place(&self, camera: &Camera, point: DVec3) -> Option<Pos2> {
        let view = camera.to_view(point);
        let Projection::Perspective(tangent) = camera.projection else { return None };
        (view.z > camera.near).then(|| {
            let unit = 0.5 * f64::from(self.rect.height()) / (tangent * view.z);
            self.rect.center() + vec2((view.x * unit) as f32, (-view.y * unit) as f32)
        })
    }

    /// The ray through a place in the window: where it starts and where it leads.
    #[must_use]
    pub fn ray(&self, camera: &Camera, at: Pos2) -> (DVec3, DVec3) {
        let from_middle = (at - self.rect.center()) / (0.5 * self.rect.height().max(1.0));
        camera.ray([f64::from(from_middle.x), f64::from(-from_middle.y)])
    }

    /// Takes all the room there is. `held`: something else has hold of the pointer's main button. `bounds` are the corners
    /// of what is shown.
    pub fn show<'a>(
        &mut self,
        ui: &mut Ui,
        graphics: &Graphics,
        bounds: Option<[DVec3; 2]>,
        held: bool,
        given: impl Fn(Mode) -> Given<'a>,
    ) -> Seen {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        self.set_room(rect, ui.pixels_per_point());
        let before = self.orbit;
        self.steer(ui, &response, held);
        let divider = self.split.map(|share| self.drag_divider(ui, share));
        if self.orbit != before {
            self.moved = ui.input(|i| i.time);
            ui.ctx().request_repaint();
        }
        let options = self.options(ui.visuals().dark_mode);
        let camera = self.orbit.camera();
        let depth = bounds.map_or([camera.near, 1e3 * camera.near], |bounds| depths(&camera, bounds));
        let size = self.pixels();
        // Until there is a picture, and for modes that have none.
        ui.painter().rect_filled(rect, 0.0, Color32::from_gray(self.backdrop.grey(ui.visuals().dark_mode)));
        let (mut error, mut frames, mut device) = (None, 0, Duration::ZERO);
        for (i, mode) in self.seen_modes().collect::<Vec<_>>().into_iter().enumerate() {
            let given = given(mode);
            let lines = given.lines.map_or(0, |(_, number)| number);
            let key = Key3 {
                size,
                orbit: self.orbit,
                mode,
                light: self.light,
                options,
                number: given.number,
                moment: given.moment,
                lines,
            };
            if let Some(subject) = given.subject.filter(|_| self.drawn[i].as_ref() != Some(&key)) {
                let path = if mode == Mode::Layered { Path::Layered } else { Path::Single };
                if self.drawn[i].as_ref().is_none_or(|old| old.number != key.number || old.mode != mode) {
                    self.panes[i].forget();
                }
                let both: Vec<&Subject> = std::iter::once(subject).chain(given.lines.map(|(lines, _)| lines)).collect();
                let look = Look { subjects: &both, path, camera: &camera, options: &options, depth };
                match self.draw(i, graphics, size, &look) {
                    Ok(took) => device += took,
                    Err(failed) => error = Some(failed),
                }
                self.drawn[i] = Some(key);
                frames += 1;
            }
            if let Some(picture) = given.still.or_else(|| given.subject.and_then(|_| self.panes[i].picture())) {
                let part = part(rect, divider, i);
                let uv = Rect::from_min_max(relative(rect, part.min), relative(rect, part.max));
                ui.painter().image(picture, part, uv, Color32::WHITE);
            }
        }
        if let Some(x) = divider {
            let colour = ui.visuals().strong_text_color();
            ui.painter().vline(x, rect.y_range(), Stroke::new(1.5, colour));
            ui.painter().circle(pos2(x, rect.center().y), 4.5, ui.visuals().panel_fill, Stroke::new(1.5, colour));
        }
        Seen { response, error, frames, device }
    }

    fn draw(&mut self, pane: usize, graphics: &Graphics, size: [u32; 2], look: &Look<'_>) -> Result<Duration, GpuError> {
        let screen = match &mut self.screen {
            Some(screen) => screen,
            none => none.insert(graphics.screen()?),
        };
        self.panes[pane].draw(graphics, screen, size, look)
    }

    /// Turns, moves and brings nearer by the pointer.
    fn steer(&mut self, ui: &Ui, response: &egui::Response, held: bool) {
        let drag = response.drag_delta();
        let (x, y) = (f64::from(drag.x), f64::from(drag.y));
        let shift = ui.input(|i| i.modifiers.shift);
        let height = f64::from(self.rect.height());
        if response.dragged_by(egui::PointerButton::Primary) && !held {
            if shift {
                self.orbit.pan(x, y, height);
            } else {
                self.orbit.turn(x, y);
            }
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        }
        if response.dragged_by(egui::PointerButton::Middle) || response.dragged_by(egui::PointerButton::Secondary) {
            self.orbit.pan(x, y, height);
        }
        if response.hovered() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
            if scroll != 0.0 || pinch != 1.0 {
                self.orbit.zoom((f64::from(scroll) * SCROLL).exp() * f64::from(pinch));
            }
        }
        if response.has_focus() || response.hovered() {
            let step = |key| f64::from(u8::from(ui.input(|i| i.key_down(key) && i.modifiers.is_none()))) * 4.0;
            let (right, up) = (step(Key::ArrowRight) - step(Key::ArrowLeft), step(Key::ArrowUp) - step(Key::ArrowDown));
            if right != 0.0 || up != 0.0 {
                self.orbit.turn(-right, -up);
                ui.ctx().request_repaint();
            }
        }
        if self.turntable {
            self.orbit.turntable(f64::from(ui.input(|i| i.stable_dt)));
            ui.ctx().request_repaint();
        }
    }

    /// The divider, dragged; where it is now, points.
    fn drag_divider(&mut self, ui: &Ui, share: f32) -> f32 {
        let x = self.rect.left() + share * self.rect.width();
        let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, self.rect.y_range());
        let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::drag());
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) else { return x };
        let share = ((pointer.x - self.rect.left()) / self.rect.width().max(1.0)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
        self.split = Some(share);
        self.rect.left() + share * self.rect.width()
    }
}

/// The part of the view that a pane fills.
fn part(rect: Rect, divider: Option<f32>, pane: usize) -> Rect {
    match (divider, pane) {
        (None, _) => rect,
        (Some(x), 0) => rect.with_max_x(x),
        (Some(x), _) => rect.with_min_x(x),
    }
}

/// A place as shares of a rectangle.
fn relative(rect: Rect, at: Pos2) -> Pos2 {
    let share = (at - rect.min) / rect.size().max(Vec2::splat(1.0));
    share.to_pos2()
}

/// Distances along the camera's axis between which a box lies, with some room.
fn depths(camera: &Camera, [low, high]: [DVec3; 2]) -> [f64; 2] {
    let corner = |k: u32| DVec3::new(pick(k & 1, low.x, high.x), pick(k & 2, low.y, high.y), pick(k & 4, low.z, high.z));
    let along = (0..8).map(|k| camera.to_view(corner(k)).z);
    let (near, far) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), d| (near.min(d), far.max(d)));
    let room = 0.01 * (high - low).length();
    let near = (near - room).max(camera.near);
    [near, (far + room).max(2.0 * near)]
}

const fn pick(bit: u32, low: f64, high: f64) -> f64 {
    if bit == 0 { low } else { high }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_where_its_ray_leads() {
        let mut viewport = Viewport { rect: Rect::from_min_size(pos2(40.0, 30.0), vec2(640.0, 400.0)), ..Viewport::default() };
        viewport.orbit.turn(120.0, 40.0);
        let camera = viewport.orbit.camera();
        for at in [pos2(100.0, 50.0), pos2(360.0, 230.0), pos2(650.0, 420.0)] {
            let (start, direction) = viewport.ray(&camera, at);
            let back = viewport.place(&camera, start + direction * 3.0).expect("in front");
            assert!(back.distance(at) < 1e-3, "{at} came back as {back}");
        }
    }
}
