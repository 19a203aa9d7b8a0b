//! The editor of outlines: the exemplar with zoom and pan, outlines and anchors over it, the live wire under the pointer.

use super::{Cutter, Drawn, Line, Under};
use crate::viewer::steer::handles::lined;
use egui::{Color32, CursorIcon, Key, Painter, PointerButton, Pos2, Rect, Sense, Stroke, TextureId, Ui, Vec2, pos2, vec2};

/// How near an anchor the pointer must come, points.
const REACH: f32 = 8.0;
/// Half the side of an anchor, points.
const ANCHOR: f32 = 3.5;
/// A point of scrolling changes the zoom by this factor's logarithm.
const SCROLL: f32 = 0.004;
/// The largest zoom, points a pixel, and the smallest against the one that shows all.
const ZOOMS: [f32; 2] = [40.0, 0.25];
/// Free room around an exemplar that is shown whole, points.
const MARGIN: f32 = 12.0;

const WIRE: Color32 = Color32::from_rgb(255, 214, 84);
const DONE: Color32 = Color32::from_rgb(240, 240, 240);
const CHOSEN: Color32 = Color32::from_rgb(120, 220, 255);

/// Which part of the exemplar is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Zoom {
    /// Points a pixel; 0: as many as show all.
    scale: f32,
    /// The pixel in the middle.
    middle: Vec2,
    /// Where the editor is in the window.
    room: Option<Rect>,
}

impl Zoom {
    /// Shows all of it again.
    pub fn fit(&mut self) {
        *self = Self::default();
    }

    /// Where a pixel of the exemplar is in the window, once that was shown.
    #[must_use]
    pub fn place(&self, pixel: glam::Vec2) -> Option<Pos2> {
        self.room.map(|room| room.center() + (vec2(pixel.x, pixel.y) - self.middle) * self.scale)
    }
}

/// What is shown.
#[derive(Debug, Clone, Copy)]
pub struct Canvas {
    /// The exemplar, once it is there.
    pub picture: Option<TextureId>,
    /// The veil of [`super::preview::veil`], if there is one.
    pub veil: Option<TextureId>,
    /// Its size in pixels.
    pub size: [u32; 2],
}

/// Shows the editor in all the room there is.
pub fn show(ui: &mut Ui, cutter: &mut Cutter, zoom: &mut Zoom, canvas: &Canvas) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let size = vec2(canvas.size[0] as f32, canvas.size[1] as f32);
    look(ui, zoom, &response, size);
    zoom.room = Some(rect);
    let scale = zoom.scale;
    let origin = rect.center() - zoom.middle * scale;
    let to_screen = |p: glam::Vec2| origin + vec2(p.x, p.y) * scale;
    let to_pixel = |p: Pos2| {
        let q = (p - origin) / scale;
        glam::Vec2::new(q.x, q.y)
    };
    let reach = REACH / scale;
    let under = keys_and_pointer(ui, cutter, &response, to_pixel, reach);

    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let whole = Rect::from_min_size(origin, size * scale);
    let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    for picture in [canvas.picture, canvas.veil].into_iter().flatten() {
        painter.image(picture, whole, all, Color32::WHITE);
    }
    for (i, drawn) in cutter.outlines().iter().enumerate() {
        let chosen = cutter.selected() == Some(i);
        let color = if chosen || under == Some(Under::Inside(i)) { CHOSEN } else { DONE };
        let line: Vec<Pos2> = drawn.line().map(to_screen).collect();
        lined(&painter, line, color, 1.5);
        let here = drawn.anchors.iter().enumerate();
        for (a, anchor) in here {
            let hot = under == Some(Under::Anchor { outline: i, anchor: a });
            square(&painter, to_screen(*anchor), if hot { WIRE } else { color });
        }
    }
    if let Some((drawn, live)) = cutter.drawing() {
        draw_open(&painter, drawn, live, under == Some(Under::Close), to_screen);
    }
    response
}

fn draw_open(painter: &Painter, drawn: &Drawn, live: &[glam::Vec2], closing: bool, to_screen: impl Fn(glam::Vec2) -> Pos2) {
    lined(painter, drawn.line().map(&to_screen).collect(), WIRE, 2.0);
    if !closing {
        lined(painter, live.iter().copied().map(&to_screen).collect(), WIRE, 1.0);
    }
    drawn.anchors.iter().for_each(|p| square(painter, to_screen(*p), WIRE));
    if closing && let Some(first) = drawn.anchors.first() {
        painter.circle_stroke(to_screen(*first), 2.2 * ANCHOR, Stroke::new(2.0, CHOSEN));
    }
}

fn square(painter: &Painter, at: Pos2, color: Color32) {
    let rect = Rect::from_center_size(at, Vec2::splat(2.0 * ANCHOR));
    painter.rect(rect, 1.0, color, Stroke::new(1.0, Color32::BLACK), egui::StrokeKind::Outside);
}

/// Zooms and pans.
fn look(ui: &Ui, zoom: &mut Zoom, response: &egui::Response, size: Vec2) {
    let room = (response.rect.size() - Vec2::splat(2.0 * MARGIN)).max(Vec2::splat(1.0));
    let fit = (room / size.max(Vec2::splat(1.0))).min_elem();
    if zoom.scale == 0.0 {
        (zoom.scale, zoom.middle) = (fit, 0.5 * size);
    }
    if response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Secondary) {
        zoom.middle -= response.drag_delta() / zoom.scale;
        ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
    }
    let Some(pointer) = response.hover_pos() else { return };
    let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
    if scroll != 0.0 || pinch != 1.0 {
        let before = zoom.scale;
        zoom.scale = (before * (scroll * SCROLL).exp() * pinch).clamp(ZOOMS[1] * fit, ZOOMS[0].max(fit));
        // The pixel under the pointer stays there.
        zoom.middle += (pointer - response.rect.center()) * (1.0 / before - 1.0 / zoom.scale);
    }
}

fn keys_and_pointer(
    ui: &Ui,
    cutter: &mut Cutter,
    response: &egui::Response,
    to_pixel: impl Fn(Pos2) -> glam::Vec2,
    reach: f32,
) -> Option<Under> {
    let typing = ui.ctx().text_edit_focused();
    let (down, pressed, released, straight) =
        ui.input(|i| (i.pointer.primary_down(), i.pointer.primary_pressed(), i.pointer.primary_released(), i.modifiers.shift));
    let kept = cutter.line;
    if straight {
        cutter.line = Line::Straight;
    }
    let mut under = None;
    if let Some(pointer) = response.interact_pointer_pos().or(response.hover_pos()) {
        let at = to_pixel(pointer);
        under = Some(cutter.under(at, reach));
        if let Some(under) = under.filter(|_| pressed && response.contains_pointer()) {
            cutter.press(at, under);
        }
        if cutter.moved(at, down) {
            ui.ctx().request_repaint();
        }
        ui.ctx().set_cursor_icon(match under {
            Some(Under::Anchor { .. }) => CursorIcon::Grab,
            Some(Under::Close) => CursorIcon::PointingHand,
            _ => CursorIcon::Crosshair,
        });
    }
    if released {
        cutter.release();
    }
    cutter.line = kept;
    if !typing && response.contains_pointer() {
        let pressed = |key| ui.input(|i| i.key_pressed(key));
        if pressed(Key::Enter) {
            cutter.close();
        }
        if pressed(Key::Backspace) || pressed(Key::Delete) {
            if cutter.drawing().is_some() { cutter.back() } else { cutter.delete() }
        }
    }
    under
}
