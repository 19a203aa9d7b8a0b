//! Indices of the field's singularities, written beside them.

use super::side::Turning;
use super::viewport::Viewport;
use egui::{Align2, Color32, FontId, Rect, Ui, vec2};
use glam::DVec3;

/// Distance of a label from its point, points.
const ASIDE: egui::Vec2 = vec2(9.0, -9.0);
/// Labels at most: more of them would hide the surface.
const MOST: usize = 200;

/// Writes the indices; `seen` says whether nothing hides a place.
pub(super) fn paint(ui: &Ui, viewport: &Viewport, turning: &Turning, seen: &dyn Fn(DVec3) -> bool) {
    let (painter, camera) = (ui.painter().with_clip_rect(viewport.rect()), viewport.orbit.camera());
    let mut taken: Vec<Rect> = Vec::new();
    for &(place, parts) in turning.points.iter().filter(|(place, _)| seen(*place)).take(MOST) {
        let Some(at) = viewport.place(&camera, place) else { continue };
        let text = painter.layout_no_wrap(index(parts, turning.ways), FontId::proportional(12.0), Color32::WHITE);
        let rect = Align2::LEFT_BOTTOM.anchor_size(at + ASIDE, text.size());
        let around = rect.expand2(vec2(4.0, 1.0));
        // One over another could not be read; nearer they part.
        if taken.iter().any(|other| other.intersects(around)) {
            continue;
        }
        painter.rect_filled(around, 4.0, Color32::from_black_alpha(190));
        painter.galley(rect.min, text, Color32::WHITE);
        taken.push(around);
    }
}

/// An index in words: so many `ways`-th parts of a full turn, as a fraction in lowest terms.
fn index(parts: i32, ways: u32) -> String {
    let (count, ways) = (parts.unsigned_abs(), ways.max(1));
    let common = (1..=ways).rev().find(|d| ways.is_multiple_of(*d) && count.is_multiple_of(*d)).unwrap_or(1);
    let (count, ways) = (count / common, ways / common);
    let sign = if parts < 0 { "\u{2212}" } else { "+" };
    if ways == 1 { format!("{sign}{count}") } else { format!("{sign}{count}/{ways}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_fractions_in_lowest_terms_with_their_sign() {
        let cases = [(1, 1, "+1"), (-1, 1, "\u{2212}1"), (1, 4, "+1/4"), (-2, 4, "\u{2212}1/2"), (4, 4, "+1"), (3, 6, "+1/2")];
        for (parts, ways, text) in cases {
            assert_eq!(index(parts, ways), text, "{parts} of {ways} parts");
        }
    }
}
