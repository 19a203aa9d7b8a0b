//! What goes on, and what the user is told.

use super::super::app::App;
use super::menu::shortened;
use egui::{Align, Align2, Area, Frame, Id, Label, Layout, Order, ProgressBar, RichText, Ui, vec2};

/// Notices that are shown at a time.
const NOTICES: usize = 4;
/// Room for what closes a notice, points.
const CLOSE: f32 = 34.0;

pub(super) fn show(app: &mut App, ui: &mut Ui) {
    ui.horizontal(|ui| {
        match app.work() {
            Some((name, stage, share)) => {
                ui.spinner();
                ui.label(if stage.is_empty() { name.to_owned() } else { format!("{name}: {}", shortened(&stage, 48)) });
                if let Some(share) = share {
                    ui.add(ProgressBar::new(share).desired_width(140.0).show_percentage());
                }
                if ui.small_button("Stop").on_hover_text("Stop this work (Esc)").clicked() {
                    app.act(super::super::Action::Stop, &ui.ctx().clone());
                }
            }
            None => {
                let text = match (&app.last_job, app.document.project().exemplars.is_empty(), app.shown.is_some()) {
                    (_, true, true) => "Choose an exemplar to paste".to_owned(),
                    (Some((name, seconds)), _, true) => format!("{name} in {}", duration(*seconds)),
                    _ => "Open a model, or pick a demo".to_owned(),
                };
                ui.label(text);
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.weak("F1 help");
            if app.document.unsaved() {
                ui.weak("unsaved");
            }
        });
    });
}

/// Seconds in words.
fn duration(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
}

/// What the user is told, over the view.
pub(super) fn notices(app: &mut App, ui: &Ui) {
    if app.notices.is_empty() {
        return;
    }
    let room = ui.max_rect();
    let width = (room.width() - 24.0).clamp(160.0, 520.0);
    let mut gone = None;
    let area = Area::new(Id::unique("notices")).order(Order::Foreground).pivot(Align2::LEFT_BOTTOM);
    area.fixed_pos(room.left_bottom() + vec2(12.0, -12.0)).show(ui.ctx(), |ui| {
        ui.set_max_width(width);
        let hidden = app.notices.len().saturating_sub(NOTICES);
        for (i, notice) in app.notices.iter().enumerate().skip(hidden) {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(width - 16.0);
                ui.horizontal_top(|ui| {
                    let visuals = ui.visuals();
                    let (word, colour) =
                        if notice.error { ("Error", visuals.error_fg_color) } else { ("Note", visuals.warn_fg_color) };
                    ui.label(RichText::new(word).strong().color(colour));
                    ui.vertical(|ui| {
                        ui.set_width((ui.available_width() - CLOSE).max(60.0));
                        ui.add(Label::new(&notice.text).wrap());
                    });
                    if ui.small_button("x").on_hover_text("Close").clicked() {
                        gone = Some(i);
                    }
                });
            });
        }
    });
    if let Some(i) = gone {
        app.notices.remove(i);
    }
}
