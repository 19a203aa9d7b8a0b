//! Panels around the view: what is chosen on the left, figures on the right, the menu above, what goes on below.

mod dialogs;
mod figures;
mod gallery;
mod menu;
mod settings;
mod status;

pub(super) use menu::{hint, shortened};
pub(super) use settings::grouped;

use super::app::App;
use egui::{CentralPanel, Frame, Panel, Ui};

/// Width of the panels at the sides, points.
const LEFT: f32 = 264.0;
const RIGHT: f32 = 216.0;
const WATCH: f32 = 280.0;
/// Narrower windows than this show no figures; narrower than the second, no settings either.
const NARROW: [f32; 2] = [900.0, 560.0];

/// The whole interface.
pub(super) fn show(app: &mut App, ui: &mut Ui) {
    let width = ui.available_width();
    Panel::top("menu").show(ui, |ui| menu::show(app, ui));
    Panel::bottom("status").show(ui, |ui| status::show(app, ui));
    if width >= NARROW[1] {
        let left = Panel::left("settings").default_size(LEFT).size_range(220.0..=380.0).resizable(true);
        left.show(ui, |ui| settings::show(app, ui));
    }
    if app.open_panels.figures && width >= NARROW[0] {
        let right = Panel::right("figures").default_size(RIGHT).size_range(180.0..=320.0).resizable(true);
        right.show(ui, |ui| figures::show(app, ui));
    }
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
        let empty = app.document.project().model.is_none();
        if app.cut.is_some() {
            let half = 0.5 * ui.available_width();
            let editor = Panel::left("cut").default_size(half).size_range(0.25 * half..=1.6 * half).resizable(true);
            editor.show(ui, |ui| app.cutting(ui));
        }
        if app.watch.is_some() && width >= NARROW[1] {
            let beside = Panel::right("watch").default_size(WATCH).size_range(200.0..=480.0).resizable(true);
            beside.show(ui, |ui| app.watching(ui));
        }
        if empty {
            gallery::welcome(app, ui);
        } else {
            app.view(ui);
            if app.cut.is_none() {
                gallery::over_view(app, ui);
            }
        }
        status::notices(app, ui);
    });
    dialogs::show(app, ui.ctx());
}
