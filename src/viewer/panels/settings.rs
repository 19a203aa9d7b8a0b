//! What is chosen: model, exemplars, size, direction, texture patches. Every change is pasted again at once.

use super::super::action::Action;
use super::super::app::App;
use super::super::synth;
use super::menu::shortened;
use crate::exemplar::{Exemplar, srgb};
use crate::job::project::{Direction, ProjectExemplar, Shape, Size};
use crate::job::{Base, Link};
use egui::{Checkbox, ComboBox, DragValue, Image, RichText, ScrollArea, Sense, Slider, Ui, vec2};
use glam::Vec3;

/// The longest name that is shown whole, letters.
const NAME: usize = 26;
/// Surface area over exemplar area that the slider spans.
const RATIOS: std::ops::RangeInclusive<f64> = 2.0..=600.0;
/// The colour that detail lies over before another is chosen, a grey as in files.
const PLAIN: u8 = 137;
/// Side of an exemplar's small picture, points.
const PICTURE: f32 = 44.0;

pub(super) fn show(app: &mut App, ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space(4.0);
        model(app, ui);
        exemplars(app, ui);
        size(app, ui);
        direction(app, ui);
        if app.steer.on {
            heading(ui, "Comb");
            app.combing(ui);
        }
        if app.viewport.seen_modes().any(|mode| mode.method().is_some()) {
            heading(ui, "Synthesis");
            synth::panel::show(app, ui);
        }
        patches(app, ui);
    });
}

fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.label(RichText::new(text).strong());
}

fn model(app: &mut App, ui: &mut Ui) {
    heading(ui, "Model");
    let name = app.document.project().model.as_ref().map(Link::name);
    ui.horizontal(|ui| {
        if ui.button("Open...").on_hover_text("A mesh (OBJ, PLY, STL, glTF), a record or a project").clicked() {
            app.act(Action::Open, &ui.ctx().clone());
        }
        match &name {
            Some(name) => ui.label(shortened(name, NAME)).on_hover_text(name),
            None => ui.weak("none yet"),
        };
    });
    if let Some(shown) = &app.shown {
        let report = &shown.open.cleaned.report;
        let pieces = if report.components == 1 { "piece" } else { "pieces" };
        ui.weak(format!("{} faces, {} {pieces}", grouped(report.faces), report.components));
    }
}

fn exemplars(app: &mut App, ui: &mut Ui) {
    heading(ui, "Exemplar");
    let chosen = app.document.project().exemplars.clone();
    let several = chosen.len() > 1;
    for (i, exemplar) in chosen.iter().enumerate() {
        ui.horizontal(|ui| {
            match app.picture_of(ui.ctx(), &exemplar.link) {
                Some(id) => ui.add(Image::new((id, vec2(PICTURE, PICTURE)))),
                None => ui.allocate_response(vec2(PICTURE, PICTURE), Sense::hover()),
            };
            ui.vertical(|ui| {
                let name = exemplar.link.name();
                ui.horizontal(|ui| {
                    ui.label(shortened(&name, NAME - 8)).on_hover_text(&name);
                    if ui.small_button("cut").on_hover_text("Draw outlines of its texture patches").clicked() {
                        app.cut_exemplar(i, &ui.ctx().clone());
                    }
                    if ui.small_button("x").on_hover_text("Paste this exemplar no more").clicked() {
                        app.edit("exemplar", |p| drop(p.exemplars.remove(i)));
                    }
                });
                if several {
                    let mut weight = exemplar.weight;
                    ui.horizontal(|ui| {
                        let label = ui.label("share");
                        let drag = DragValue::new(&mut weight).range(0.05..=20.0).speed(0.05);
                        let changed = ui
                            .add(drag)
                            .labelled_by(label.id)
                            .on_hover_text("How often it is pasted, relative to the others")
                            .changed();
                        if changed {
                            app.edit("weight", |p| p.exemplars[i].weight = weight);
                        }
                    });
                }
            });
        });
    }
    if chosen.is_empty() {
        ui.weak("Drop an image here, or pick one:");
    }
    ui.horizontal(|ui| {
        ui.menu_button("Built-in", |ui| built_in(app, ui)).response.on_hover_text("Exemplars that come with the program");
        if ui.button("Open...").on_hover_text("An image; maps beside it (normal, height, ...) come along").clicked() {
            app.act(Action::Open, &ui.ctx().clone());
        }
    });
}

/// The built-in exemplars, to take or to add.
fn built_in(app: &mut App, ui: &mut Ui) {
    ui.weak("Click to use, Shift+click to add");
    egui::Grid::new("built-in exemplars").spacing(vec2(4.0, 4.0)).show(ui, |ui| {
        for (i, name) in crate::assets::exemplar_names().enumerate() {
            let link = Link::BuiltIn(name.to_owned());
            let Some(id) = app.picture_of(ui.ctx(), &link) else { continue };
            let button = egui::Button::image(Image::new((id, vec2(56.0, 56.0)))).frame(true);
            let response = ui.add(button).on_hover_text(name).accessible_name(name);
            if response.clicked() {
                take(app, link, ui.input(|i| i.modifiers.shift));
                ui.close();
            }
            if i % 4 == 3 {
                ui.end_row();
            }
        }
    });
}

/// Takes an exemplar, in place of those there are or beside them.
pub(super) fn take(app: &mut App, link: Link, beside: bool) {
    if beside {
        app.edit("exemplar", |p| p.exemplars.push(ProjectExemplar::new(link)));
    } else {
        app.set_exemplars(vec![link]);
    }
}

fn size(app: &mut App, ui: &mut Ui) {
    heading(ui, "Size");
    let now = app.document.project().size;
    ui.horizontal(|ui| {
        let mut world = matches!(now, Size::World(_));
        let before = world;
        ui.radio_value(&mut world, false, "relative").on_hover_text("By the surface: how many exemplars cover it");
        ui.radio_value(&mut world, true, "absolute").on_hover_text("By the world length of one exemplar width");
        if world != before {
            let scale = app.shown().and_then(|s| s.report()).map_or(1.0, |r| r.scale);
            let ratio = app.shown().and_then(|s| s.report()).map_or(crate::field::DEFAULT_RATIO, |r| r.ratio);
            app.edit("size", |p| p.size = if world { Size::World(scale) } else { Size::Ratio(ratio.clamp(2.0, 600.0)) });
            app.document.end_gesture();
        }
    });
    let slider = |ui: &mut Ui, value: &mut f64, range, hint: &str| {
        let label = ui.label("scale");
        ui.add(Slider::new(value, range).logarithmic(true).max_decimals(4)).labelled_by(label.id).on_hover_text(hint).changed()
    };
    ui.horizontal(|ui| match now {
        Size::Ratio(mut ratio) => {
            let hint = "Surface area over exemplar area: more makes the texture smaller";
            if slider(ui, &mut ratio, RATIOS, hint) {
                app.edit("scale", |p| p.size = Size::Ratio(ratio));
            }
        }
        Size::World(mut length) => {
            let most = app.shown().map_or(1.0, |s| {
                let (low, high) = s.mesh().bounds();
                f64::from((high - low).length())
            });
            let hint = "World length of one exemplar width: more makes the texture larger";
            if slider(ui, &mut length, 0.01 * most..=2.0 * most, hint) {
                app.edit("scale", |p| p.size = Size::World(length));
            }
        }
    });
}

fn direction(app: &mut App, ui: &mut Ui) {
    heading(ui, "Direction");
    let now = app.document.project().direction;
    const AXES: [(&str, [f64; 3]); 6] = [
        ("up +Y", [0.0, 1.0, 0.0]),
        ("up -Y", [0.0, -1.0, 0.0]),
        ("up +Z", [0.0, 0.0, 1.0]),
        ("up -Z", [0.0, 0.0, -1.0]),
        ("up +X", [1.0, 0.0, 0.0]),
        ("up -X", [-1.0, 0.0, 0.0]),
    ];
    let ways = [1, 2, 4, 6].map(|n| (format!("smoothest, {n}-way"), Direction::Relaxed(n)));
    let axes = AXES.map(|(name, axis)| (name.to_owned(), Direction::Up(axis)));
    let others = [
        ("along curvature".to_owned(), Direction::Curvature),
        ("as the exemplar asks".to_owned(), Direction::Auto),
        ("none".to_owned(), Direction::None),
    ];
    let choices: Vec<_> = axes.into_iter().chain(others).chain(ways).collect();
    let name = choices.iter().find(|(_, d)| *d == now).map_or_else(
        || match now {
            Direction::Up([x, y, z]) => format!("up {x:.2}, {y:.2}, {z:.2}"),
            Direction::Relaxed(n) => format!("smoothest, {n}-way"),
            _ => "other".to_owned(),
        },
        |(name, _)| name.clone(),
    );
    ui.horizontal(|ui| {
        let label = ui.label("field");
        let combo = ComboBox::from_id_salt("direction").selected_text(name).width(150.0).height(340.0).show_ui(ui, |ui| {
            for (name, direction) in choices {
                if ui.selectable_label(now == direction, name).clicked() {
                    app.edit("direction", |p| p.direction = direction);
                    app.document.end_gesture();
                }
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(
            "The tangent field: which way texture up lies on each face. None suits textures that look the same every way",
        );
    });
}

fn patches(app: &mut App, ui: &mut Ui) {
    heading(ui, "Texture patches");
    let project = app.document.project().clone();
    let shape = project.exemplars.first().and_then(|e| e.shapes.first()).cloned();
    let name = match &shape {
        None => "automatic",
        Some(Shape::Whole) => "whole",
        Some(Shape::Circle) => "circle",
        Some(Shape::Splotch) => "splotch",
        Some(Shape::Mask(_)) => "mask image",
        Some(Shape::Outline(_)) => "drawn outline",
    };
    egui::Grid::new("patches").num_columns(2).spacing(vec2(8.0, 5.0)).show(ui, |ui| {
        let label = ui.label("shape");
        let combo = ComboBox::from_id_salt("shape").selected_text(name).width(130.0).show_ui(ui, |ui| {
            let choices = [("automatic", None), ("splotch", Some(Shape::Splotch)), ("circle", Some(Shape::Circle)), ("whole", Some(Shape::Whole))];
            for (name, choice) in choices {
                if ui.selectable_label(shape == choice, name).clicked() {
                    let shapes: Vec<Shape> = choice.into_iter().collect();
                    app.edit("shape", |p| p.exemplars.iter_mut().for_each(|e| e.shapes.clone_from(&shapes)));
                    app.document.end_gesture();
                }
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(
            "The outline of the texture patches. Automatic: the exemplar's own transparency if it has any, else splotches (smooth random blobs)",
        );
        ui.end_row();

        let (mut own, before) = (project.feather.is_some(), project.feather);
        let least = smallest_side(app);
        let mut feather = before.unwrap_or_else(|| crate::job::patches::default_feather([least; 2]));
        let box_hint = "Width in pixels of the fall-off of alpha at a patch's edge; by the exemplar's size if not ticked";
        let toggled = ui.checkbox(&mut own, "feather").on_hover_text(box_hint).changed();
        let slider = Slider::new(&mut feather, 0.0..=least as f32 * 0.2).max_decimals(1);
        let response = ui.add_enabled(own, slider).on_hover_text(box_hint).accessible_name("feather in pixels");
        if toggled || response.changed() {
            app.edit("feather", |p| p.feather = own.then_some(feather));
        }
        ui.end_row();

        let mut own = project.distortion.is_some();
        let mut bound = project.distortion.unwrap_or(1.0);
        let box_hint = "Growth of a surface patch stops where the texture would be stretched more than this against the field";
        let toggled = ui.checkbox(&mut own, "distortion").on_hover_text(box_hint).changed();
        let slider = Slider::new(&mut bound, 0.2..=3.0).max_decimals(2);
        let response = ui.add_enabled(own, slider).on_hover_text(box_hint).accessible_name("distortion bound");
        if toggled || response.changed() {
            app.edit("distortion", |p| p.distortion = own.then_some(bound));
        }
        ui.end_row();

        let mut windows = project.windows;
        ui.label("");
        let hint = "Each paste shows the part of its exemplar that agrees best with what lies around it, and ends where that shows least; others are \
                    laid over hard edges. The paper's pastes all show the same";
        if ui.checkbox(&mut windows, "match borders").on_hover_text(hint).changed() {
            app.edit("windows", |p| p.windows = windows);
        }
        ui.end_row();

        ui.label("");
        let hint = "Smaller pastes are laid over hard edges that still show: fewer shards on thin limbs and in folds";
        let mut small = project.small;
        if ui.add_enabled(windows, Checkbox::new(&mut small, "smaller patches")).on_hover_text(hint).changed() {
            app.edit("smaller patches", |p| p.small = small);
        }
        ui.end_row();

        ui.label("");
        let hint = "Gives back the contrast that two textures lose where one fades into the other: for a wide feather, or soft exemplars";
        let mut contrast = project.contrast;
        if ui.add_enabled(windows, Checkbox::new(&mut contrast, "keep contrast")).on_hover_text(hint).changed() {
            app.edit("contrast", |p| p.contrast = contrast);
        }
        ui.end_row();

        ui.label("");
        let hint = "Takes slow changes of light out of the exemplars: for photographs that are lit from one side, or darker towards their corners";
        let mut equalize = project.equalize;
        if ui.checkbox(&mut equalize, "even out light").on_hover_text(hint).changed() {
            app.edit("light", |p| p.equalize = equalize);
        }
        ui.end_row();

        base(app, ui, project.base);

        let label = ui.label("seed");
        let mut seed = project.seed;
        ui.horizontal(|ui| {
            let drag = ui.add(DragValue::new(&mut seed).range(0..=999_999)).labelled_by(label.id);
            let next = ui.button("Next").on_hover_text("Another arrangement of the same texture");
            seed += u64::from(next.clicked());
            if drag.changed() || next.clicked() {
                app.edit("seed", |p| p.seed = seed);
            }
        });
        ui.end_row();
    });
}

/// What the exemplars' detail lies over, if only that is pasted: a row, and one more for a colour.
fn base(app: &mut App, ui: &mut Ui, now: Option<Base>) {
    let name = |base: Option<Base>| match base {
        None => "pasted as they are",
        Some(Base::Own) => "over their own colours",
        Some(Base::Vertex) => "over vertex colours",
        Some(Base::Color(_)) => "over one colour",
    };
    let painted = app.shown().is_some_and(|shown| shown.open.model.colors.is_some());
    let choices = [None, Some(Base::Own), painted.then_some(Base::Vertex), Some(Base::Color(decoded([PLAIN; 3])))];
    let hint = "Exemplars as they are bring their slow changes of colour to every paste. Over a base only their detail is pasted: over those \
                changes made smooth across the surface, the colours of the model's vertices, or one colour";
    let label = ui.label("exemplars");
    let combo = ComboBox::from_id_salt("base").selected_text(name(now)).width(150.0).show_ui(ui, |ui| {
        for base in choices.into_iter().enumerate().filter(|(k, base)| *k == 0 || base.is_some()).map(|(_, base)| base) {
            if ui.selectable_label(name(now) == name(base), name(base)).clicked() && name(now) != name(base) {
                app.edit("base", |p| p.base = base);
                app.document.end_gesture();
            }
        }
    });
    combo.response.labelled_by(label.id).on_hover_text(hint);
    ui.end_row();
    if let Some(Base::Color(color)) = now {
        ui.label("");
        let mut bytes = color.to_array().map(srgb::to_byte);
        if ui.color_edit_button_srgb(&mut bytes).on_hover_text("The colour that detail lies over").changed() {
            app.edit("base colour", |p| p.base = Some(Base::Color(decoded(bytes))));
        }
        ui.end_row();
    }
}

/// A colour as in files, linear.
fn decoded(bytes: [u8; 3]) -> Vec3 {
    bytes.map(|byte| srgb::decode(f32::from(byte) / 255.0)).into()
}

/// The smallest side of the exemplars that are read, pixels.
fn smallest_side(app: &App) -> u32 {
    let lapped = app.shown().and_then(|s| s.lapped());
    let sides = lapped.into_iter().flat_map(|l| &l.exemplars).flat_map(Exemplar::size);
    sides.min().unwrap_or(256)
}

/// A number in groups of three digits.
pub(in super::super) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}
