//! The tangent field as arrows that follow it over the picture: texture up is where they point, longer ones mean larger
//! texture. Rings mark the points around which the field turns.

use super::super::camera::Camera;
use super::super::lens::{Hit, Lens};
use super::super::picture::Picture;
use super::super::raster::Visibility;
use super::super::stroke::Strokes;
use super::{Show, colour_only, coloured};
use crate::exemplar::ChannelSet;
use crate::field::{Singularity, TangentField, singularities};
use crate::mesh::{Mesh, NONE, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{DVec2, Vec2, Vec3};

/// Pixels between arrows, as a share of the picture's height, and the least of it.
const SPACING: f32 = 1.0 / 26.0;
const LEAST_SPACING: f32 = 11.0;
/// Length of an arrow where the field has its median length, as a share of the spacing.
const LENGTH: f32 = 0.95;
/// Lengths of the field below and above these multiples of the median look alike.
const SHORTEST: f32 = 0.45;
const LONGEST: f32 = 1.7;
/// Colours, sRGB: arrows, poles (the field turns with the walk around), saddles (it turns against it).
const ARROW: Vec3 = Vec3::new(0.05, 0.16, 0.33);
const POLE: Vec3 = Vec3::new(0.84, 0.10, 0.10);
const SADDLE: Vec3 = Vec3::new(0.95, 0.55, 0.0);
/// Linear light of the surface below.
const SURFACE: Vec3 = Vec3::new(0.66, 0.65, 0.62);

pub(super) struct Arrows<'a> {
    mesh: &'a Mesh,
    field: &'a TangentField,
    median: f32,
    singular: Vec<Singularity>,
    size: f64,
}

impl<'a> Arrows<'a> {
    pub(super) fn new(mesh: &'a Mesh, field: &'a TangentField) -> Self {
        let mut lengths: Vec<f32> = field.up.iter().map(|t| t.length()).filter(|l| *l > 0.0).collect();
        lengths.sort_unstable_by(f32::total_cmp);
        let median = lengths.get(lengths.len() / 2).copied().unwrap_or(1.0);
        let (low, high) = mesh.bounds();
        let size = (high - low).as_dvec3().length();
        Self { mesh, field, median, singular: singularities(mesh, &field.up), size }
    }

    /// Where the field leads in the picture at a place in it: direction with the foreshortening as its length, and the hit.
    fn flow(&self, seen: &Visibility, lens: &Lens, at: Vec2) -> Option<(Vec2, Hit)> {
        let n = seen.grid().samples as f32;
        let sample = (at * n).floor();
        if !sample.is_finite() || sample.min_element() < 0.0 {
            return None;
        }
        let hit = seen.hit(self.mesh, sample.x as usize, sample.y as usize)?;
        let up = self.field.up.get(hit.at.face as usize)?.as_dvec3().try_normalize()?;
        let camera: &Camera = seen.camera();
        // A step small enough to be straight.
        let step = 1e-3 * self.size;
        let moved = |p| lens.project(camera.to_view(p));
        let across = moved(hit.position + camera.right * step).distance(moved(hit.position));
        let along: DVec2 = (moved(hit.position + up * step) - moved(hit.position)) / across;
        Some((along.as_vec2(), hit))
    }

    /// The curve through a place from `half` pixels before it to as many after it, along the field.
    fn trace(&self, seen: &Visibility, lens: &Lens, at: Vec2, half: f32) -> Vec<Vec2> {
        let mut curve = self.walk(seen, lens, at, half, -1.0);
        curve.reverse();
        curve.push(at);
        curve.extend(self.walk(seen, lens, at, half, 1.0));
        curve
    }

    /// The points after `at` on the way along the field (`sign` 1) or against it (-1).
    fn walk(&self, seen: &Visibility, lens: &Lens, at: Vec2, length: f32, sign: f32) -> Vec<Vec2> {
        /// Pixels of one step.
        const STEP: f32 = 1.5;
        let mut curve = Vec::new();
        let (mut here, mut left) = (at, length);
        let mut last: Option<(Vec2, Hit)> = None;
        while left > 0.0 {
            let Some((along, hit)) = self.flow(seen, lens, here) else { break };
            // Over a silhouette or a jump of the field an arrow ends.
            let broken = last.is_some_and(|(before, old)| {
                before.dot(along) < 0.3 * before.length() * along.length() || (old.depth - hit.depth).abs() > 0.03 * self.size
            });
            if broken || along.length() < 0.05 {
                break;
            }
            let step = STEP.min(left);
            here += along * (sign * step);
            left -= step;
            last = Some((along, hit));
            curve.push(here);
        }
        curve
    }

    fn arrow(&self, seen: &Visibility, lens: &Lens, at: Vec2, spacing: f32, strokes: &mut Strokes) {
        let Some((_, hit)) = self.flow(seen, lens, at) else { return };
        let relative = (self.field.up[hit.at.face as usize].length() / self.median).clamp(SHORTEST, LONGEST);
        let curve = self.trace(seen, lens, at, 0.5 * LENGTH * spacing * relative);
        let [.., before, tip] = curve.as_slice() else { return };
        let length: f32 = curve.windows(2).map(|w| w[0].distance(w[1])).sum();
        let width = 0.075 * spacing;
        let pieces = (curve.len() - 1) as f32;
        for (i, pair) in curve.windows(2).enumerate() {
            let grown = |i: usize| width * (0.55 + 0.45 * i as f32 / pieces);
            strokes.taper(pair[0], pair[1], grown(i), grown(i + 1));
        }
        let heading = (*tip - *before).normalize_or_zero();
        let barb = (0.42 * length).min(0.26 * spacing);
        for side in [1.0, -1.0] {
            let back = Vec2::from_angle(side * 0.5).rotate(-heading) * barb;
            strokes.taper(*tip, *tip + back, width, 0.7 * width);
        }
    }

    /// Where a vertex is seen in the picture, if it is.
    fn seen_at(&self, seen: &Visibility, lens: &Lens, vertex: u32) -> Option<Vec2> {
        let view = seen.camera().to_view(self.mesh.point(vertex));
        let sample = lens.project(view);
        if view.z < seen.camera().near || !sample.is_finite() || sample.min_element() < 0.0 {
            return None;
        }
        let (x, y) = (sample.x as usize, sample.y as usize);
        let near = (y.saturating_sub(1)..=y + 1).flat_map(|v| (x.saturating_sub(1)..=x + 1).map(move |u| (u, v)));
        let visible = near.filter(|&(u, v)| seen.face(u, v) != NONE).any(|(u, v)| {
            seen.hit(self.mesh, u, v).is_some_and(|hit| (hit.depth - view.z).abs() < 2.0 * hit.footprint + 2e-3 * self.size)
        });
        visible.then(|| (sample / f64::from(seen.grid().samples)).as_vec2())
    }
}

impl SurfaceTexture for Arrows<'_> {
    fn channels(&self) -> ChannelSet {
        colour_only()
    }

    fn texel(&self, _: SurfacePoint, _: f32) -> Texel {
        coloured(SURFACE)
    }
}

impl Show for Arrows<'_> {
    fn texture(&self) -> &dyn SurfaceTexture {
        self
    }

    fn overlay(&self, seen: &Visibility, picture: &mut Picture) {
        let lens = Lens::new(seen.camera(), seen.grid());
        let spacing = (SPACING * picture.height as f32).max(LEAST_SPACING);
        let rows = (picture.height as f32 / (0.87 * spacing)) as u32 + 1;
        let columns = (picture.width as f32 / spacing) as u32 + 1;
        for row in 0..rows {
            for column in 0..columns {
                // Every other row is shifted: six neighbours at equal distance.
                let x = (column as f32 + if row % 2 == 0 { 0.25 } else { 0.75 }) * spacing;
                let at = Vec2::new(x, (row as f32 + 0.5) * 0.87 * spacing);
                let mut strokes = Strokes::default();
                self.arrow(seen, &lens, at, spacing, &mut strokes);
                strokes.draw(picture, ARROW, 0.9);
            }
        }
        for singular in &self.singular {
            if let Some(at) = self.seen_at(seen, &lens, singular.vertex) {
                let mut ring = Strokes::default();
                ring.ring(at, 0.24 * spacing, 0.11 * spacing);
                ring.widened(0.08 * spacing).draw(picture, Vec3::ONE, 0.8);
                ring.draw(picture, if singular.index > 0 { POLE } else { SADDLE }, 1.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::camera::View;
    use super::super::super::lens::Grid;
    use super::*;
    use crate::mesh::shapes;
    use glam::DVec3;

    #[test]
    fn arrows_point_where_the_texture_is_up() {
        let mesh = shapes::uneven_square(6);
        for up in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(-0.6, 0.8, 0.0)] {
            let field = TangentField::along(vec![up * 0.1; mesh.face_count()]);
            let arrows = Arrows::new(&mesh, &field);
            let grid = Grid { width: 100, height: 100, samples: 2 };
            let camera = View::degrees(0.0, 0.0).frame(&mesh, 1.0);
            let seen = Visibility::new(&mesh, &camera, grid).unwrap();
            let curve = arrows.trace(&seen, &Lens::new(&camera, grid), Vec2::splat(50.0), 10.0);
            let way = curve[curve.len() - 1] - curve[0];
            let expected = Vec2::new(up.x, -up.y) * 20.0;
            assert!((way - expected).length() < 0.5, "up {up}: the arrow leads along {way}");
        }
    }

    #[test]
    fn the_poles_of_a_global_up_are_marked() {
        let mesh = shapes::sphere(3);
        let up = (0..mesh.face_count() as u32).map(|f| (DVec3::Y - mesh.normal(f) * mesh.normal(f).y).as_vec3()).collect();
        let field = TangentField::along(up);
        let arrows = Arrows::new(&mesh, &field);
        let grid = Grid { width: 200, height: 200, samples: 1 };
        for (pitch, marked) in [(90.0, true), (-90.0, true), (0.0, false)] {
            let camera = View::degrees(0.0, pitch).frame(&mesh, 1.0);
            let seen = Visibility::new(&mesh, &camera, grid).unwrap();
            let mut picture = Picture::filled(200, 200, [255; 4]);
            arrows.overlay(&seen, &mut picture);
            let red = |x, y| picture.pixel(x, y)[0] > 180 && picture.pixel(x, y)[1] < 90;
            let near = (90..110).any(|y| (90..110).any(|x| red(x, y)));
            assert_eq!(near, marked, "a red ring in the middle seen from pitch {pitch}");
        }
    }
}
