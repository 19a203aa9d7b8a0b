//! What is chosen for syntheses, and what became of them.

use super::{Figures, Method};
use crate::job::Synthesis;
use crate::viewer::action::Action;
use crate::viewer::app::App;
use crate::viewer::mode::Mode;
use crate::viewer::panels::{grouped, hint, shortened};
use egui::{ComboBox, DragValue, Grid, Slider, Ui};

/// Vertices that the slider spans.
const VERTICES: std::ops::RangeInclusive<u32> = 5_000..=400_000;

/// The longest name that is shown whole, letters.
const NAME: usize = 18;

pub(in crate::viewer) fn show(app: &mut App, ui: &mut Ui) {
    methods(app, ui);
    let mut chosen = app.document.project().synthesis;
    let before = chosen;
    Grid::new("synthesis").num_columns(2).spacing(egui::vec2(8.0, 5.0)).show(ui, |ui| {
        exemplar(app, ui, &mut chosen);
        let label = ui.label("vertices");
        let hint = "Each stands for a pixel of the exemplar. The texture is as large as it is pasted: with more vertices it has more pixels";
        let slider = Slider::new(&mut chosen.vertices, VERTICES).logarithmic(true).custom_formatter(|n, _| grouped(n as usize));
        ui.add(slider).labelled_by(label.id).on_hover_text(hint);
        ui.end_row();
        let label = ui.label("seed");
        ui.horizontal(|ui| {
            ui.add(DragValue::new(&mut chosen.seed).range(0..=999_999)).labelled_by(label.id);
            let next = ui.button("Another").on_hover_text("Another arrangement of the same texture");
            chosen.seed += u64::from(next.clicked());
        });
        ui.end_row();
    });
    if chosen != before {
        app.edit("synthesis", |p| p.synthesis = chosen);
    }
    let Some(shown) = app.shown.clone() else { return };
    let mut seen: Vec<Method> = app.viewport.seen_modes().filter_map(Mode::method).collect();
    seen.dedup();
    for &method in &seen {
        match app.synth.figures(method, &shown) {
            Some(figures) => ui.weak(said(method, figures)).on_hover_text(method.hint()),
            None => ui.weak(format!("{}: nothing yet", method.name())),
        };
    }
    let ready = seen.iter().any(|&method| app.synth.texture(method, &shown).is_some());
    let export = ui.add_enabled(ready, egui::Button::new(Action::ExportSynthesis.name()));
    if export.on_hover_text(hint(Action::ExportSynthesis)).clicked() {
        app.act(Action::ExportSynthesis, &ui.ctx().clone());
    }
}

/// The methods, to be shown in the panes that show one.
fn methods(app: &mut App, ui: &mut Ui) {
    ui.horizontal(|ui| {
        for method in Method::ALL {
            let on = app.viewport.seen_modes().any(|mode| mode.method() == Some(method));
            if ui.selectable_label(on, method.name()).on_hover_text(method.hint()).clicked() {
                app.viewport.show_method(method);
            }
        }
    });
}

fn exemplar(app: &App, ui: &mut Ui, chosen: &mut Synthesis) {
    let names: Vec<String> = app.document.project().exemplars.iter().map(|e| shortened(&e.link.name(), NAME)).collect();
    if names.len() < 2 {
        return;
    }
    let label = ui.label("exemplar");
    chosen.exemplar = chosen.exemplar.min(names.len() - 1);
    let combo = ComboBox::from_id_salt("synthesised exemplar").selected_text(&names[chosen.exemplar]).width(130.0);
    let response = combo.show_ui(ui, |ui| {
        for (i, name) in names.iter().enumerate() {
            ui.selectable_value(&mut chosen.exemplar, i, name);
        }
    });
    response.response.labelled_by(label.id).on_hover_text("Several are pasted side by side; one is synthesised");
    ui.end_row();
}

/// What became of one, in words.
fn said(method: Method, figures: &Figures) -> String {
    let [done, all] = figures.levels;
    let vertices = grouped(figures.vertices);
    if !figures.whole() {
        return format!("{}: level {done} of {all}, {vertices} vertices", method.name());
    }
    let [mesh, directions, matching] = figures.seconds;
    let before = match method {
        Method::WeiLevoy => format!("re-tiled in {mesh:.1} s"),
        Method::ChenDong if mesh > 0.0 => format!("marched in {mesh:.1} s"),
        Method::ChenDong => "circles kept".to_owned(),
    };
    let [width, height] = figures.exemplar;
    format!(
        "{}: {vertices} vertices, exemplar {width} x {height}; {before}, directions {directions:.1} s, matched in {matching:.1} s",
        method.name()
    )
}
