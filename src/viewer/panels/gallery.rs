//! Built-in models and exemplars, to pick: on an empty window, and over the view.

use super::super::action::Action;
use super::super::app::App;
use super::super::gallery::SIDE;
use super::menu::hint;
use crate::job::project::Direction;
use crate::job::{Link, Project, ProjectExemplar};
use egui::{Align, Image, Layout, RichText, ScrollArea, Ui, Window, vec2};

/// A model with an exemplar on it, and whether that looks the same every way.
const DEMOS: [(&str, &str, bool); 8] = [
    ("dragonling", "scales", false),
    ("dragonling", "fur", false),
    ("knot", "weave", false),
    ("knot", "pebbles", true),
    ("vase", "bricks", false),
    ("gear", "rust", true),
    ("terrain", "leaves", true),
    ("dragonling_25k", "moss", true),
];

/// What an empty window shows.
pub(super) fn welcome(app: &mut App, ui: &mut Ui) {
    let rect = ui.max_rect();
    ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.with_layout(Layout::top_down(Align::Center), |ui| {
            ui.add_space((0.08 * rect.height()).max(8.0));
            ui.label(RichText::new("Put a texture on a model").heading());
            ui.label("Drop a mesh and an image here, open files, or begin with one of these:");
            ui.add_space(6.0);
            if ui.button("Open...").on_hover_text(hint(Action::Open)).clicked() {
                app.act(Action::Open, &ui.ctx().clone());
            }
            ui.add_space(10.0);
            let picture = SIDE as f32;
            let columns = ((rect.width() - 40.0) / (2.0 * picture + 34.0)).floor().clamp(1.0, 3.0) as usize;
            let mut chosen = None;
            for row in DEMOS.chunks(columns) {
                let width = row.len() as f32 * (2.0 * picture + 34.0);
                ui.allocate_ui_with_layout(vec2(width, picture + 32.0), Layout::left_to_right(Align::Center), |ui| {
                    for &(model, exemplar, isotropic) in row {
                        if demo(app, ui, model, exemplar) {
                            chosen = Some((model, exemplar, isotropic));
                        }
                    }
                });
            }
            if let Some((model, exemplar, isotropic)) = chosen {
                begin(app, model, exemplar, isotropic);
            }
        });
    });
}

/// Begins with a built-in model and exemplar.
fn begin(app: &mut App, model: &str, exemplar: &str, isotropic: bool) {
    let [model, exemplar] = [model, exemplar].map(|name| Link::BuiltIn(name.to_owned()));
    app.edit("demo", |p| {
        p.exemplars = vec![ProjectExemplar::new(exemplar)];
        p.direction = if isotropic { Direction::None } else { Project::default().direction };
        (p.model, p.view) = (Some(model), None);
    });
    app.document.end_gesture();
}

/// A demo as a button of two pictures.
fn demo(app: &mut App, ui: &mut Ui, model: &str, exemplar: &str) -> bool {
    let name = format!("{model} with {exemplar}");
    let pictures = [model, exemplar].map(|n| app.picture_of(ui.ctx(), &Link::BuiltIn(n.to_owned())));
    let side = SIDE as f32;
    let (rect, response) = ui.allocate_exact_size(vec2(2.0 * side + 18.0, side + 26.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    let visuals = ui.style().interact(&response);
    ui.painter().rect(rect, 6.0, visuals.weak_bg_fill, visuals.bg_stroke, egui::StrokeKind::Inside);
    for (i, picture) in pictures.into_iter().enumerate() {
        let place = egui::Rect::from_min_size(rect.min + vec2(6.0 + i as f32 * (side + 6.0), 5.0), vec2(side, side));
        match picture {
            Some(id) => Image::new((id, vec2(side, side))).corner_radius(4.0).paint_at(ui, place),
            None => drop(ui.painter().rect_filled(place, 4.0, ui.visuals().faint_bg_color)),
        }
    }
    let at = rect.center_bottom() - vec2(0.0, 4.0);
    let font = egui::TextStyle::Body.resolve(ui.style());
    ui.painter().text(at, egui::Align2::CENTER_BOTTOM, name, font, visuals.text_color());
    response.clicked()
}

/// Models to change to while one is shown, in a window of their own.
pub(super) fn over_view(app: &mut App, ui: &Ui) {
    let room = app.viewport.rect();
    if !app.open_panels.gallery {
        return;
    }
    let mut open = true;
    let mut chosen = None;
    let window = Window::new("Models").open(&mut open).resizable(false).collapsible(true).default_open(false);
    window.default_pos(room.left_top() + vec2(10.0, 10.0)).constrain_to(room).show(ui.ctx(), |ui| {
        let names: Vec<&str> = crate::assets::mesh_names().collect();
        egui::Grid::new("models").spacing(vec2(6.0, 6.0)).show(ui, |ui| {
            for (i, name) in names.into_iter().enumerate() {
                let link = Link::BuiltIn(name.to_owned());
                ui.vertical(|ui| {
                    let response = match app.picture_of(ui.ctx(), &link) {
                        Some(id) => ui.add(egui::Button::image(Image::new((id, vec2(72.0, 72.0))))),
                        None => ui.button(name),
                    };
                    let response = response.accessible_name(name);
                    ui.weak(name);
                    if response.clicked() {
                        chosen = Some(link);
                    }
                });
                if i % 3 == 2 {
                    ui.end_row();
                }
            }
        });
    });
    app.open_panels.gallery = open;
    if let Some(link) = chosen {
        app.set_model(link);
    }
}
