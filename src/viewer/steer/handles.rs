//! Constraints as handles: a disc at the place, an arrow along the direction with a knob at its tip, and a ring as wide as the
//! extent.

use crate::field::Anchor;
use crate::mesh::Mesh;
use egui::{Color32, Painter, Pos2, Shape, Stroke};
use glam::DVec3;
use std::f64::consts::TAU;

/// How near the pointer must come to a handle's part, points.
const GRAB: f32 = 9.0;

/// Radius of the disc at the place, points.
const DISC: f32 = 5.0;

/// Sides of the ring as it is drawn.
const RING_SIDES: u32 = 48;

/// The arrow's length as a share of the extent: its knob and the ring are then far enough apart to be told apart.
const ARROW: f64 = 0.7;

/// A part of a handle that can be pulled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grip {
    /// The place.
    Move,
    /// The direction.
    Turn,
    /// The extent.
    Widen,
}

impl Grip {
    /// What pulling it does, in words for a menu.
    #[must_use]
    pub const fn what(self) -> &'static str {
        match self {
            Self::Move => "Move handle",
            Self::Turn => "Turn handle",
            Self::Widen => "Widen handle",
        }
    }
}

/// A constraint as it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// Its place, world units.
    pub place: DVec3,
    /// The surface's normal there.
    pub normal: DVec3,
    /// Unit direction of texture up, if it says one.
    pub direction: Option<DVec3>,
    /// Relative scale, if it says one.
    pub scale: Option<f64>,
    /// How far it reaches, world units.
    pub extent: f64,
    /// Its weight.
    pub weight: f64,
}

/// Where a point of the world lies on the screen, points; `None` behind the eye.
pub type Project<'a> = dyn Fn(DVec3) -> Option<Pos2> + 'a;

impl Handle {
    /// The handle of an anchor.
    #[must_use]
    pub fn new(mesh: &Mesh, anchor: &Anchor) -> Self {
        Self {
            place: mesh.position(anchor.at),
            normal: mesh.normal(anchor.at.face),
            direction: anchor.direction,
            scale: anchor.ln_scale.map(f64::exp),
            extent: anchor.extent,
            weight: anchor.weight,
        }
    }

    /// The knob at the arrow's tip.
    #[must_use]
    pub fn tip(&self) -> Option<DVec3> {
        self.direction.map(|d| self.place + d * (ARROW * self.extent))
    }

    /// A point of the ring.
    #[must_use]
    pub fn ring(&self, angle: f64) -> DVec3 {
        let along = self.direction.unwrap_or_else(|| self.normal.any_orthonormal_vector());
        let side = self.normal.cross(along);
        self.place + (along * angle.cos() + side * angle.sin()) * self.extent
    }

    fn ring_on(&self, project: &Project<'_>) -> Vec<Pos2> {
        (0..=RING_SIDES).filter_map(|i| project(self.ring(TAU * f64::from(i) / f64::from(RING_SIDES)))).collect()
    }
}

/// The part of a handle that lies under the pointer: of a selected handle any part, of others the disc at the place. `seen` says
/// whether a place is hidden behind the mesh.
#[must_use]
pub fn grip_at(
    handles: &[Handle],
    selected: Option<usize>,
    pointer: Pos2,
    project: &Project<'_>,
    seen: &dyn Fn(&Handle) -> bool,
) -> Option<(usize, Grip)> {
    let near = |p: DVec3| project(p).map_or(f32::INFINITY, |q| q.distance(pointer));
    if let Some((index, handle)) = selected.and_then(|i| Some((i, handles.get(i)?))) {
        if handle.tip().is_some_and(|tip| near(tip) < GRAB) {
            return Some((index, Grip::Turn));
        }
        if near(handle.place) < GRAB {
            return Some((index, Grip::Move));
        }
        let on_ring = handle.ring_on(project).windows(2).any(|w| to_segment(pointer, w[0], w[1]) < 0.7 * GRAB);
        if on_ring {
            return Some((index, Grip::Widen));
        }
    }
    let close = |(i, handle): (usize, &Handle)| {
        let d = near(handle.place);
        (d < GRAB && seen(handle)).then_some((i, d))
    };
    handles.iter().enumerate().filter_map(close).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| (i, Grip::Move))
}

fn to_segment(p: Pos2, a: Pos2, b: Pos2) -> f32 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_sq().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (a + ab * t).distance(p)
}

/// Colours that stand out from any texture: each line lies on a wider dark one.
const LIGHT: Color32 = Color32::from_rgb(255, 214, 84);
const PLAIN: Color32 = Color32::from_rgb(240, 240, 240);
const DARK: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 170);

/// Paints the handles that are seen; the selected one with its ring, the hovered one brighter.
pub fn paint(
    painter: &Painter,
    handles: &[Handle],
    selected: Option<usize>,
    hovered: Option<usize>,
    project: &Project<'_>,
    seen: &dyn Fn(&Handle) -> bool,
) {
    for (i, handle) in handles.iter().enumerate() {
        let chosen = selected == Some(i);
        if !chosen && !seen(handle) {
            continue;
        }
        let Some(place) = project(handle.place) else { continue };
        let color = if chosen || hovered == Some(i) { LIGHT } else { PLAIN };
        if chosen {
            let ring = handle.ring_on(project);
            lined(painter, ring, color, 1.5);
        }
        if let Some(tip) = handle.tip().and_then(project) {
            // Weight shows as the arrow's width.
            let width = (1.6 * handle.weight.sqrt() as f32).clamp(1.0, 4.0);
            lined(painter, vec![place, tip], color, width);
            let back = (place - tip).normalized() * 8.0;
            let side = back.rot90() * 0.5;
            let head = vec![tip, tip + back + side, tip + back - side];
            painter.add(Shape::convex_polygon(head, color, Stroke::new(1.0, DARK)));
            if chosen {
                painter.circle(tip, DISC - 1.0, color, Stroke::new(1.5, DARK));
            }
        }
        painter.circle(place, DISC, color, Stroke::new(1.5, DARK));
        if let Some(scale) = handle.scale {
            let text = format!("x{scale:.2}");
            let at = place + egui::vec2(DISC + 4.0, -DISC - 2.0);
            for (shift, color) in [(1.0, Color32::BLACK), (0.0, color)] {
                let font = egui::FontId::proportional(12.0);
                painter.text(at + egui::Vec2::splat(shift), egui::Align2::LEFT_CENTER, &text, font, color);
            }
        }
    }
}

/// A line that shows on light and dark ground.
pub(in crate::viewer) fn lined(painter: &Painter, points: Vec<Pos2>, color: Color32, width: f32) {
    painter.add(Shape::line(points.clone(), Stroke::new(width + 2.0, DARK)));
    painter.add(Shape::line(points, Stroke::new(width, color)));
}
