//! The sliders of watching.

use super::{Play, SPEEDS, Watch, flat};
use crate::exemplar::TexturePatch;
use egui::{Slider, TextureId, Ui};

/// Shows how many pastes are seen and how fast they are laid. `about` says which paste is chosen.
pub fn pastes(ui: &mut Ui, watch: &mut Watch, about: Option<&str>) {
    ui.horizontal(|ui| {
        let running = watch.play == Play::Pastes;
        let name = if running { "Pause" } else { "Lay one by one" };
        if ui.button(name).on_hover_text("Lays the pastes one after the other, the lowest first").clicked() {
            if running { watch.play = Play::Still } else { watch.lay() }
        }
        for (text, by, help) in [("-", -1_i64, "One paste less"), ("+", 1, "One paste more")] {
            if ui.small_button(text).on_hover_text(help).clicked() {
                watch.play = Play::Still;
                let next = (watch.shown() as i64 + by).max(0) as usize;
                watch.show(next);
            }
        }
    });
    let (mut shown, count) = (watch.shown(), watch.count());
    let slider = Slider::new(&mut shown, 0..=count).text("pastes");
    if ui.add(slider).on_hover_text("How many of the pastes are seen").changed() {
        watch.play = Play::Still;
        watch.show(shown);
    }
    ui.add(Slider::new(&mut watch.speed, SPEEDS).logarithmic(true).text("per second")).on_hover_text("Speed of watching");
    match about {
        Some(about) => ui.label(about),
        None => ui.weak("Click a place on the model to watch the paste there grow"),
    };
}

/// Shows the growth of the chosen paste: its flattening, and a slider through its moments.
pub fn growth(ui: &mut Ui, watch: &mut Watch, patch: &TexturePatch, mask: TextureId) {
    let Some(moment) = watch.moment() else { return };
    let [mut at, all] = watch.place();
    ui.horizontal(|ui| {
        let running = watch.play == Play::Growth;
        if ui.button(if running { "Pause" } else { "Grow" }).on_hover_text("Lets the disc grow face by face").clicked() {
            if running {
                watch.play = Play::Still;
            } else {
                if at + 1 >= all {
                    watch.go_to(0);
                }
                watch.play = Play::Growth;
            }
        }
        let slider = Slider::new(&mut at, 0..=all.saturating_sub(1)).show_value(false);
        if ui.add(slider).on_hover_text("Moments of the growth").changed() {
            watch.play = Play::Still;
            watch.go_to(at);
        }
    });
    ui.small(flat::caption(&moment, watch.place()));
    flat::show(ui, patch, mask, &moment);
}
