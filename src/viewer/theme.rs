//! How the interface looks, by day and by night.

use egui::{Color32, Context, CornerRadius, Stroke, Theme, vec2};

/// What can be acted on and what is chosen, in the dark and in the light theme.
const ACCENT: [Color32; 2] = [Color32::from_rgb(94, 168, 232), Color32::from_rgb(14, 98, 172)];
/// Errors, the same.
const ALARM: [Color32; 2] = [Color32::from_rgb(255, 138, 122), Color32::from_rgb(176, 30, 20)];
/// Hints and warnings, the same.
const WARNING: [Color32; 2] = [Color32::from_rgb(240, 196, 92), Color32::from_rgb(132, 84, 0)];

/// Sets both themes up and takes one.
pub fn apply(context: &Context, dark: bool) {
    for (i, theme) in [Theme::Dark, Theme::Light].into_iter().enumerate() {
        context.style_mut_of(theme, |style| {
            let visuals = &mut style.visuals;
            visuals.selection.bg_fill = ACCENT[i].gamma_multiply(if i == 0 { 0.45 } else { 0.30 });
            visuals.selection.stroke = Stroke::new(1.0, if i == 0 { Color32::WHITE } else { Color32::from_rgb(8, 50, 92) });
            visuals.hyperlink_color = ACCENT[i];
            visuals.error_fg_color = ALARM[i];
            visuals.warn_fg_color = WARNING[i];
            // The usual greys of text fall below a contrast of 4.5 on panels.
            let text = if i == 0 { Color32::from_gray(208) } else { Color32::from_gray(36) };
            visuals.widgets.noninteractive.fg_stroke.color = text;
            visuals.widgets.inactive.fg_stroke.color = text;
            visuals.weak_text_color = Some(if i == 0 { Color32::from_gray(158) } else { Color32::from_gray(92) });
            for widget in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
                widget.corner_radius = CornerRadius::same(4);
            }
            visuals.slider_trailing_fill = true;
            style.spacing.item_spacing = vec2(8.0, 5.0);
            style.spacing.button_padding = vec2(8.0, 3.0);
            style.spacing.slider_width = 110.0;
        });
    }
    context.set_theme(if dark { Theme::Dark } else { Theme::Light });
}
