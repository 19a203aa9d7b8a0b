//! Questions that stand before a deed, and the help sheet.

use super::super::action::Action;
use super::super::app::{App, Loss, Question};
use super::super::deeds::Purpose;
use crate::job::Link;
use egui::{Align2, Context, Grid, Id, Modal, RichText, ScrollArea, TextEdit, Window, vec2};
use std::path::PathBuf;

/// What the pointer does.
const POINTER: [(&str, &str); 6] = [
    ("Drag", "turn around the model"),
    ("Shift+drag, middle or right drag", "move aside"),
    ("Wheel, pinch", "nearer and farther"),
    ("Arrow keys", "turn"),
    ("Drag the line of a split view", "compare two modes"),
    ("Drop files", "open them"),
];

pub(super) fn show(app: &mut App, context: &Context) {
    help(app, context);
    match app.question.clone() {
        Some(Question::Unsaved(loss)) => unsaved(app, context, loss),
        Some(Question::Name(purpose, text)) => name(app, context, purpose, text),
        Some(Question::Recover(path, project)) => {
            let answer = Modal::new(Id::unique("recover")).show(context, |ui| {
                ui.set_max_width(380.0);
                ui.heading("Unsaved work was found");
                let name = project.model.as_ref().map_or_else(|| "without a model".to_owned(), Link::name);
                ui.label(format!("The program ended without saving a project ({name}). Go on with it?"));
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    let restore = ui.button("Restore").clicked();
                    let discard = ui.button("Discard").on_hover_text("The work is lost").clicked();
                    (restore, discard)
                })
                .inner
            });
            let (restore, discard) = answer.inner;
            if restore {
                app.recover(*project);
            }
            if restore || discard {
                // The next autosave holds it, or nobody wants it.
                let _ = std::fs::remove_file(&path);
                app.question = None;
            }
        }
        None => {}
    }
}

/// The name of a file, typed.
fn name(app: &mut App, context: &Context, purpose: Purpose, mut text: String) {
    let (title, deed) = match purpose {
        Purpose::Open => ("Open which file?", "Open"),
        Purpose::Save => ("Save the project where?", "Save"),
        Purpose::Export(_) => ("Write to which file?", "Write"),
    };
    let answer = Modal::new(Id::unique("name")).show(context, |ui| {
        ui.set_width(420.0_f32.min(context.content_rect().width() - 40.0));
        let label = ui.heading(title);
        let edit = ui.add(TextEdit::singleline(&mut text).desired_width(f32::INFINITY).hint_text("folder/file"));
        let edit = edit.labelled_by(label.id);
        if !edit.has_focus() && !edit.lost_focus() {
            edit.request_focus();
        }
        let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        ui.add_space(8.0);
        ui.horizontal(|ui| [ui.button(deed).clicked() || entered, ui.button("Cancel").clicked()]).inner
    });
    let [done, cancel] = answer.inner;
    if done && !text.trim().is_empty() {
        app.question = None;
        app.take_files(purpose, &[PathBuf::from(text.trim())]);
    } else if cancel || answer.should_close() {
        app.question = None;
        app.after_save = None;
    } else {
        app.question = Some(Question::Name(purpose, text));
    }
}

fn unsaved(app: &mut App, context: &Context, loss: Loss) {
    let answer = Modal::new(Id::unique("unsaved")).show(context, |ui| {
        ui.set_max_width(380.0);
        ui.heading("Save changes first?");
        ui.label(format!("What was changed in {} is in no file yet.", app.document.title()));
        ui.add_space(8.0);
        ui.horizontal(|ui| [ui.button("Save").clicked(), ui.button("Discard").clicked(), ui.button("Cancel").clicked()]).inner
    });
    let [save, discard, cancel] = answer.inner;
    if save {
        app.question = None;
        app.after_save = Some(loss);
        app.save();
    } else if discard {
        app.lose_now(loss);
    } else if cancel || answer.should_close() {
        app.question = None;
    }
}

fn help(app: &mut App, context: &Context) {
    let mut open = app.open_panels.help;
    let room = context.content_rect();
    let window = Window::new("Help").open(&mut open).collapsible(false).resizable(false).pivot(Align2::CENTER_CENTER);
    let width = (room.width() - 60.0).min(560.0);
    window.default_pos(room.center()).default_width(width).show(context, |ui| {
        let height = room.height() - 120.0;
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            Grid::new("help").num_columns(2).striped(true).spacing(vec2(18.0, 4.0)).show(ui, |ui| {
                for (how, what) in POINTER {
                    ui.label(RichText::new(how).strong());
                    ui.label(what);
                    ui.end_row();
                }
                for action in Action::ALL {
                    let (_, shortcut, what) = action.facts();
                    if let Some(shortcut) = shortcut {
                        ui.label(RichText::new(context.format_shortcut(&shortcut)).strong());
                        ui.label(what);
                        ui.end_row();
                    }
                }
            });
        });
    });
    app.open_panels.help = open;
}
