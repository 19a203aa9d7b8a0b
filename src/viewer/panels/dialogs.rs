//! Questions that stand before a deed, and the help sheet.

use super::super::action::Action;
use super::super::app::{App, Loss, Question};
use egui::{Align2, Context, Grid, Id, Modal, RichText, ScrollArea, Window, vec2};

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
        Some(Question::Recover(path, project)) => {
            let answer = Modal::new(Id::unique("recover")).show(context, |ui| {
                ui.set_max_width(380.0);
                ui.heading("Unsaved work was found");
                let name = project.model.as_ref().map_or_else(|| "without a model".to_owned(), |m| m.name());
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
        ScrollArea::vertical().max_height(room.height() - 120.0).show(ui, |ui| {
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
