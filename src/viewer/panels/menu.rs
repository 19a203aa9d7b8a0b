//! The menu, and what the panes show.

use super::super::action::Action;
use super::super::app::App;
use super::super::mode::{Backdrop, Light, Mode};
use egui::{Button, ComboBox, MenuBar, Ui};
use std::path::PathBuf;

/// Points across that the menus and all that stands beside them take in one row, and what the choice of each pane's mode adds.
const ONE_ROW: f32 = 520.0;
const PANE: f32 = 160.0;

pub(super) fn show(app: &mut App, ui: &mut Ui) {
    let mut asked = None;
    let mut open: Option<PathBuf> = None;
    let [undo, redo] = app.document.steps();
    let panes = 1 + usize::from(app.viewport.split.is_some());
    let wide = ui.available_width() >= ONE_ROW + PANE * panes as f32;
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            use Action::{ExportBaked, ExportPicture, ExportRecord, ExportSynthesis, New, Open, Quit, Reload, Save, SaveAs};
            [New, Open].into_iter().for_each(|a| item(ui, a, true, &mut asked));
            ui.add_enabled_ui(!app.settings.recent.is_empty(), |ui| {
                ui.menu_button("Open recent", |ui| {
                    for path in &app.settings.recent {
                        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
                        if ui
                            .add(Button::new(shortened(&name, 40)).wrap_mode(egui::TextWrapMode::Extend))
                            .on_hover_text(path.display().to_string())
                            .clicked()
                        {
                            open = Some(path.clone());
                            ui.close();
                        }
                    }
                });
            });
            item(ui, Reload, true, &mut asked);
            ui.separator();
            [Save, SaveAs].into_iter().for_each(|a| item(ui, a, true, &mut asked));
            ui.separator();
            [ExportPicture, ExportRecord, ExportBaked].into_iter().for_each(|a| item(ui, a, app.shown.is_some(), &mut asked));
            item(ui, ExportSynthesis, app.synthesized().is_some(), &mut asked);
            ui.separator();
            item(ui, Quit, true, &mut asked);
        });
        ui.menu_button("Edit", |ui| {
            step(ui, Action::Undo, undo, &mut asked);
            step(ui, Action::Redo, redo, &mut asked);
            ui.separator();
            item(ui, Action::Stop, app.work().is_some(), &mut asked);
        });
        ui.menu_button("View", |ui| {
            use Action::{
                Arrows, Comb, Compare, Cut, Edges, Figures, Frame, Gallery, NextMode, Play, Singularities, Split, Streamlines,
                Theme, Turntable, Watch,
            };
            [Frame, Turntable].into_iter().for_each(|a| item(ui, a, true, &mut asked));
            item(ui, Play, app.changes(), &mut asked);
            [Split, NextMode, Compare].into_iter().for_each(|a| item(ui, a, true, &mut asked));
            ui.separator();
            [Comb, Cut, Watch].into_iter().for_each(|a| item(ui, a, app.shown.is_some(), &mut asked));
            ui.separator();
            ui.menu_button("Light", |ui| {
                for light in Light::ALL {
                    ui.radio_value(&mut app.viewport.light, light, light.name());
                }
            });
            ui.menu_button("Background", |ui| {
                for backdrop in Backdrop::ALL {
                    ui.radio_value(&mut app.viewport.backdrop, backdrop, backdrop.name());
                }
            });
            ui.separator();
            [Arrows, Streamlines, Singularities, Edges].into_iter().for_each(|a| item(ui, a, true, &mut asked));
            ui.separator();
            [Gallery, Figures, Theme].into_iter().for_each(|a| item(ui, a, true, &mut asked));
        });
        ui.menu_button("Help", |ui| item(ui, Action::Help, true, &mut asked));
        if wide {
            ui.separator();
            shown(app, ui, &mut asked);
        }
    });
    if !wide {
        ui.horizontal_wrapped(|ui| shown(app, ui, &mut asked));
    }
    if let Some(action) = asked {
        app.act(action, &ui.ctx().clone());
    }
    if let Some(path) = open {
        app.open_all(&[path]);
    }
}

/// What the panes show, and the tools.
fn shown(app: &mut App, ui: &mut Ui, asked: &mut Option<Action>) {
    let split = app.viewport.split.is_some();
    for pane in 0..1 + usize::from(split) {
        mode(ui, pane, split, &mut app.viewport.modes[pane]);
    }
    ui.separator();
    let tools = [(Action::Comb, app.steer.on), (Action::Cut, app.cut.is_some()), (Action::Watch, app.watch.is_some())];
    for (action, on) in tools {
        if ui.selectable_label(on, action.name()).on_hover_text(hint(action)).clicked() {
            *asked = Some(action);
        }
    }
    ui.separator();
    if ui.selectable_label(split, "Split").on_hover_text(hint(Action::Split)).clicked() {
        *asked = Some(Action::Split);
    }
    let compared = app.viewport.seen_modes().any(|mode| mode.method().is_some());
    if ui.selectable_label(compared, "Compare").on_hover_text(hint(Action::Compare)).clicked() {
        *asked = Some(Action::Compare);
    }
}

/// The choice of a pane's mode.
fn mode(ui: &mut Ui, pane: usize, split: bool, chosen: &mut Mode) {
    let label = match (split, pane) {
        (false, _) => "Show",
        (true, 0) => "Left",
        (true, _) => "Right",
    };
    let text = ui.label(label);
    let choice = ComboBox::from_id_salt(("mode", pane)).selected_text(chosen.name()).width(104.0).show_ui(ui, |ui| {
        for mode in Mode::ALL {
            ui.selectable_value(chosen, mode, mode.name()).on_hover_text(mode.hint());
        }
    });
    choice.response.labelled_by(text.id).on_hover_text(chosen.hint());
}

/// What a deed does and its keys.
pub(in super::super) fn hint(action: Action) -> String {
    let (_, shortcut, what) = action.facts();
    shortcut.map_or_else(|| what.to_owned(), |s| format!("{what} ({})", s.format(&egui::ModifierNames::NAMES, false)))
}

fn item(ui: &mut Ui, action: Action, enabled: bool, asked: &mut Option<Action>) {
    entry(ui, action, action.name().to_owned(), enabled, asked);
}

/// Undo or redo, with the name of what it concerns.
fn step(ui: &mut Ui, action: Action, of: Option<&str>, asked: &mut Option<Action>) {
    let text = of.map_or_else(|| action.name().to_owned(), |name| format!("{} {name}", action.name()));
    entry(ui, action, text, of.is_some(), asked);
}

fn entry(ui: &mut Ui, action: Action, text: String, enabled: bool, asked: &mut Option<Action>) {
    let (_, shortcut, what) = action.facts();
    let mut button = Button::new(text).wrap_mode(egui::TextWrapMode::Extend);
    if let Some(shortcut) = shortcut {
        button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
    }
    if ui.add_enabled(enabled, button).on_hover_text(what).clicked() {
        *asked = Some(action);
        ui.close();
    }
}

/// A text of at most so many letters: of a longer one its beginning and its end.
pub(in super::super) fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let (head, tail) = (most.div_ceil(2).saturating_sub(1), most / 2);
    let begin: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!("{begin}\u{2026}{end}")
}
