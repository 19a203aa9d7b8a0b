//! The comb's panel: what a stroke does, how wide it reaches, symmetry, and the selected handle's own figures.

use super::{CombSettings, Combing, Edit, Ground, MOST_WEIGHT, Tool};
use egui::{Slider, Ui};

/// Shows the panel. What was changed by it, if anything.
pub fn show(ui: &mut Ui, combing: &mut Combing, ground: Option<&Ground<'_>>) -> Option<Edit> {
    comb(ui, &mut combing.settings);
    ui.separator();
    let ground = ground?;
    let edit = selected(ui, combing, ground);
    let count = combing.constraints().constraints.len();
    if count == 0 {
        ui.weak("Nothing combed yet: drag over the surface");
        return edit;
    }
    let cleared = ui.horizontal(|ui| {
        ui.label(if count == 1 { "1 constraint".to_owned() } else { format!("{count} constraints") });
        ui.button("Clear").on_hover_text("Takes all constraints away").clicked()
    });
    cleared.inner.then(|| combing.clear(ground)).flatten().or(edit)
}

fn comb(ui: &mut Ui, settings: &mut CombSettings) {
    ui.horizontal(|ui| {
        for (tool, name, help) in [
            (Tool::Direction, "Direction", "A stroke sets texture up along it (the tangent field T of the paper)"),
            (Tool::Scale, "Scale", "A stroke sets the length of T: how large the texture is. Hold Shift for this at any time"),
            (Tool::Erase, "Erase", "A stroke takes constraints away. Hold Alt for this at any time"),
        ] {
            ui.selectable_value(&mut settings.tool, tool, name).on_hover_text(help);
        }
    });
    ui.add(Slider::new(&mut settings.radius, 0.01..=0.5).logarithmic(true).text("Radius"))
        .on_hover_text("How far a stroke reaches over the surface, as a share of the mesh's diagonal: the extent of its Gaussians");
    ui.add(Slider::new(&mut settings.weight, 1.0 / MOST_WEIGHT..=MOST_WEIGHT).logarithmic(true).text("Weight"))
        .on_hover_text("How strongly a stroke holds against others near it");
    let scale = Slider::new(&mut settings.scale, 0.25..=4.0).logarithmic(true).text("Scale");
    ui.add_enabled(true, scale).on_hover_text("Relative scale that a scale stroke sets: 2 makes the texture twice as large");
    ui.horizontal(|ui| {
        ui.label("Symmetry").on_hover_text("Strokes and handles are mirrored at a plane through the middle of the mesh");
        for (axis, name) in [(None, "off"), (Some(0), "x"), (Some(1), "y"), (Some(2), "z")] {
            ui.selectable_value(&mut settings.symmetry, axis, name);
        }
    });
}

fn selected(ui: &mut Ui, combing: &mut Combing, ground: &Ground<'_>) -> Option<Edit> {
    let index = combing.selected()?;
    let handle = *combing.handles(ground.mesh).get(index)?;
    let mut edit = None;
    ui.label(format!("Handle {} of {}", index + 1, combing.constraints().constraints.len()));
    let mut weight = handle.weight;
    let slider = Slider::new(&mut weight, 1.0 / MOST_WEIGHT..=MOST_WEIGHT).logarithmic(true).text("Its weight");
    if ui.add(slider).changed() {
        edit = combing.weigh(ground, weight);
    }
    let mut extent = handle.extent;
    let widest = 0.5 * ground.diagonal();
    if ui.add(Slider::new(&mut extent, 1e-2 * widest..=widest).logarithmic(true).text("Its extent")).changed() {
        edit = combing.widen(ground, extent).or(edit);
    }
    let mut scale = handle.scale.unwrap_or(1.0);
    if ui.add(Slider::new(&mut scale, 0.25..=4.0).logarithmic(true).text("Its scale")).changed() {
        edit = combing.rescale(ground, Some(scale)).or(edit);
    }
    if ui.button("Delete handle").on_hover_text("Delete, or Backspace").clicked() {
        edit = combing.delete(ground).or(edit);
    }
    edit
}
