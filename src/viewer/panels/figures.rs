//! Figures of what is shown: pastes, draws per face, the field, memory, and the time of frames.

use super::super::action::Action;
use super::super::app::App;
use super::super::trace::{KEPT, STALL};
use super::menu::hint;
use super::settings::grouped;
use crate::exemplar::srgb;
use crate::job::estimate::in_words;
use crate::render::picture::to_byte;
use egui::{Color32, Grid, Pos2, Rect, RichText, ScrollArea, Sense, Shape, Stroke, Ui, pos2, vec2};

pub(super) fn show(app: &mut App, ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space(4.0);
        overlays(app, ui);
        ui.add_space(6.0);
        ui.label(RichText::new("Figures").strong());
        let Some(shown) = app.shown() else {
            ui.weak("Nothing is shown yet");
            return;
        };
        let mut rows: Vec<(&str, String, &str)> =
            vec![("faces", grouped(shown.mesh().face_count()), "Faces that are pasted on; large ones were cut")];
        if let Some(lapped) = shown.lapped() {
            rows.push(("texture patches", lapped.patches.len().to_string(), "Masks cut from the exemplars"));
            rows.push(("pastes", grouped(lapped.pastes.len()), "Texture patches laid on surface patches"));
        }
        if let Some(report) = shown.report() {
            let p = &report.paste;
            rows.extend([
                ("scale", format!("{:.4}", report.scale), "World length of one exemplar width"),
                (
                    "draws per face",
                    format!("{:.2}", p.draws_per_face),
                    "Mean number of pastes on a face after culling; the paper has 1.5 to 3.2",
                ),
                ("before culling", format!("{:.2}", p.draws_before_cull), "The same with faces that later pastes hide"),
                ("least alpha", format!("{:.3}", p.least_alpha), "Of all points audited; below 1 the surface would show"),
                (
                    "hard edges",
                    format!("{:.3}", p.visible_hard_edges_per_exemplar),
                    "Visible length of edges where growth had to stop, in exemplar widths per exemplar area",
                ),
                (
                    "filled faces",
                    grouped(report.filled_faces),
                    "Faces where the axis says nothing, which took their neighbours' direction",
                ),
            ]);
        }
        if let Some(field) = shown.field() {
            let ways = if field.ways > 1 { format!("{}-way", field.ways) } else { "one direction".to_owned() };
            rows.push(("field", ways, "Directions that look alike at each place"));
        }
        if let Some(turning) = app.side.turning(shown.number()) {
            let (count, sum, ways) = (turning.points.len(), turning.sum(), turning.ways);
            let sum = if ways > 1 { format!("{count} (sum {sum}/{ways})") } else { format!("{count} (sum {sum})") };
            rows.push((
                "singularities",
                sum,
                "Points around which the field turns; on a closed surface their indices sum to its Euler number",
            ));
        }
        let [mesh, lists, images] = shown.subject.bytes();
        rows.push(("memory: mesh", in_words(mesh as f64), "On the graphics device: vertex positions"));
        rows.push(("memory: pastes", in_words(lists as f64), "On the graphics device: paste lists of all faces"));
        rows.push(("memory: images", in_words(images as f64), "On the graphics device: exemplars and masks with their mip levels"));
        Grid::new("figures").num_columns(2).spacing(vec2(10.0, 3.0)).show(ui, |ui| {
            for (name, value, hint) in rows {
                ui.label(name).on_hover_text(hint);
                ui.label(RichText::new(value).monospace()).on_hover_text(hint);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label("interface time per frame");
        graph(ui, &app.trace().frames);
        let last = app.trace().frames.last().copied().unwrap_or(0.0);
        ui.weak(format!("{:.1} ms now, {:.1} ms at most", 1e3 * last, 1e3 * app.trace().longest().as_secs_f64()));
    });
}

/// Lines on the surface, and what the colours of the modes mean.
fn overlays(app: &mut App, ui: &mut Ui) {
    ui.label(RichText::new("Lines").strong());
    let lines = &mut app.lines;
    let boxes = [
        (&mut lines.arrows, Action::Arrows),
        (&mut lines.streamlines, Action::Streamlines),
        (&mut lines.singularities, Action::Singularities),
        (&mut lines.edges, Action::Edges),
    ];
    for (on, action) in boxes {
        ui.checkbox(on, action.name()).on_hover_text(hint(action));
    }
    for mode in app.viewport.seen_modes() {
        let Some(legend) = app.side.legend(mode) else { continue };
        ui.add_space(6.0);
        ui.label(RichText::new(legend.title).strong());
        for (colour, label) in &legend.entries {
            if label.is_empty() {
                continue;
            }
            ui.horizontal(|ui| {
                let (swatch, _) = ui.allocate_exact_size(vec2(22.0, 12.0), Sense::hover());
                let [r, g, b] = colour.to_array().map(|c| to_byte(srgb::encode(c)));
                ui.painter().rect_filled(swatch, 2.0, Color32::from_rgb(r, g, b));
                ui.label(label);
            });
        }
    }
}

/// Times of the last frames as a line, with the time that is not to be passed.
fn graph(ui: &mut Ui, times: &[f32]) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width().min(280.0), 52.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let bound = STALL.as_secs_f32();
    let most = times.iter().copied().fold(1.5 * bound, f32::max);
    let height = |seconds: f32| rect.bottom() - seconds / most * rect.height();
    painter.hline(rect.x_range(), height(bound), Stroke::new(1.0, ui.visuals().weak_text_color()));
    let points: Vec<Pos2> = times.iter().enumerate().map(|(i, t)| pos2(along(rect, i), height(*t))).collect();
    let colour: Color32 = ui.visuals().hyperlink_color;
    painter.add(Shape::line(points, Stroke::new(1.5, colour)));
}

fn along(rect: Rect, i: usize) -> f32 {
    rect.left() + i as f32 / (KEPT - 1) as f32 * rect.width()
}
