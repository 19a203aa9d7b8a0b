//! The flattening of a growing disc: its faces in texture space over the patch's mask and hull, with the seed marked.

use crate::exemplar::TexturePatch;
use crate::paste::watch::Moment;
use egui::epaint::{Mesh, Vertex, WHITE_UV};
use egui::{Color32, ColorImage, Painter, Pos2, Rect, Shape, Stroke, TextureId, Ui, pos2, vec2};

/// Room around the mask, as a share of its size: discs reach a little beyond their hull.
const ROOM: f32 = 0.22;
/// Fewest points an edge of a face must be long on the mean for edges to be drawn one by one.
const LEAST_EDGE: f32 = 3.0;

const FACE: Color32 = Color32::from_rgba_premultiplied(30, 66, 92, 110);
const NEW: Color32 = Color32::from_rgba_premultiplied(190, 150, 40, 200);
const EDGE: Color32 = Color32::from_rgb(150, 205, 235);
const HULL: Color32 = Color32::from_rgb(255, 214, 84);

/// A patch's mask as a picture: alpha in grey.
#[must_use]
pub fn mask_picture(patch: &TexturePatch) -> ColorImage {
    let mask = patch.mask.finest();
    let [w, h] = mask.size();
    let grey = |alpha: &f32| Color32::from_gray((alpha * 150.0) as u8 + 24);
    ColorImage::new([w as usize, h as usize], mask.data().iter().map(grey).collect())
}

/// Shows a disc over its patch's mask in all the room there is.
pub fn show(ui: &mut Ui, patch: &TexturePatch, mask: TextureId, moment: &Moment) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::hover());
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 0.0, Color32::from_gray(14));
    let [w, h] = patch.mask.size().map(|n| n as f32);
    let scale = (rect.size() / (vec2(w, h) * (1.0 + 2.0 * ROOM))).min_elem();
    let size = vec2(w, h) * scale;
    let over = Rect::from_center_size(rect.center(), size);
    painter.image(mask, over, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);

    let to_screen = |uv: glam::Vec2| over.min + vec2(uv.x, uv.y) * size;
    faces(&painter, moment, to_screen);
    let pixel = |p: glam::Vec2| {
        let q = p - glam::Vec2::new(patch.origin[0] as f32, patch.origin[1] as f32);
        over.min + vec2(q.x, q.y) * scale
    };
    let hull: Vec<Pos2> = patch.hull.points().iter().map(|&p| pixel(p)).collect();
    painter.add(Shape::closed_line(hull, Stroke::new(1.5, HULL)));
    painter.circle(pixel(patch.centre), 3.5, Color32::WHITE, Stroke::new(1.0, Color32::BLACK));
    response
}

/// The faces as one mesh, the last that joined brighter, and their edges if these can be told apart.
fn faces(painter: &Painter, moment: &Moment, to_screen: impl Fn(glam::Vec2) -> Pos2) {
    let mut mesh = Mesh::default();
    let growing = moment.doing == crate::paste::watch::Doing::Growing;
    let last = moment.uv.len().saturating_sub(1);
    let mut length = 0.0;
    for (i, corners) in moment.uv.iter().enumerate() {
        let color = if growing && i == last { NEW } else { FACE };
        let first = mesh.vertices.len() as u32;
        let at = corners.map(&to_screen);
        length += at[0].distance(at[1]);
        mesh.vertices.extend(at.map(|pos| Vertex { pos, uv: WHITE_UV, color }));
        mesh.indices.extend([first, first + 1, first + 2]);
    }
    painter.add(Shape::mesh(mesh));
    if length >= LEAST_EDGE * moment.uv.len() as f32 {
        for corners in &moment.uv {
            painter.add(Shape::closed_line(corners.map(&to_screen).to_vec(), Stroke::new(0.7, EDGE)));
        }
    }
}

/// A legend line below the flattening.
#[must_use]
pub fn caption(moment: &Moment, place: [usize; 2]) -> String {
    let doing = match moment.doing {
        crate::paste::watch::Doing::Growing => "growing",
        crate::paste::watch::Doing::Fitting => "fitting to the field",
    };
    format!("{doing}: {} faces, fitted {} times, moment {} of {}", moment.faces.len(), moment.fits, place[0] + 1, place[1])
}
