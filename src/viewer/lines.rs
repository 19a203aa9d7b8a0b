//! Lines on the surface: arrows and streamlines of the field, its singularities, the mesh's edges.
//!
//! They are strips of two triangles that lie a little above the surface, a mesh of their own with colours at its corners, so that
//! the graphics device hides what is behind the model as it does everywhere. Their width and distance go by how near the eye
//! is, in steps ([`Detail`]), and they are made anew when that changes.

use crate::field::{NWaySingularity, StreamlineOptions, TangentField, streamlines, turning_points};
use crate::mesh::walk::walk;
use crate::mesh::{Mesh, SurfacePoint};
use glam::{DVec3, Vec3, Vec4};
use std::collections::HashSet;

/// Lines seen from the top to the bottom of the view, where arrows stand as close as they do.
const ROWS: f64 = 30.0;
/// Width of lines as a share of the distance of arrows; edges of the mesh are thinner.
const WIDTH: f64 = 0.075;
const EDGE: f64 = 0.03;
/// How far lines lie above the surface, as a share of their width, and at least as a share of the mesh's size.
const LIFT: f64 = 0.35;
const LEAST_LIFT: f64 = 2e-4;
/// Distance of streamlines as a share of that of arrows, and how long they are at most, in these distances.
const BESIDE: f64 = 0.8;
const LONG: f64 = 30.0;
/// Steps along an arrow as a share of the distance of arrows, and how many it has at most.
const STEP: f64 = 0.2;
const STEPS: usize = 120;
/// An arrow ends where the field turns by more than this over a step, as a cosine.
const BREAK: f64 = 0.3;
/// Arrows at most, and edges at most: of larger meshes only those near the point looked at, or none.
const MOST_ARROWS: usize = 6000;
const MOST_EDGES: usize = 300_000;
/// Linear light: lines, poles (the field turns with the walk around), saddles (it turns against it), edges.
const INK: Vec3 = Vec3::new(0.01, 0.04, 0.11);
const POLE: Vec3 = Vec3::new(0.75, 0.02, 0.02);
const SADDLE: Vec3 = Vec3::new(0.95, 0.45, 0.0);
const WIRE: Vec3 = Vec3::new(0.02, 0.02, 0.03);

/// Which lines are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Lines {
    /// Arrows along the field.
    pub arrows: bool,
    /// Long lines along the field.
    pub streamlines: bool,
    /// The points around which the field turns.
    pub singularities: bool,
    /// The mesh's edges.
    pub edges: bool,
}

impl Lines {
    /// True if there are any.
    #[must_use]
    pub const fn any(self) -> bool {
        self.arrows || self.streamlines || self.singularities || self.edges
    }
}

/// How large things are seen: half octaves of the height of what is seen, world units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Detail(i32);

impl Detail {
    /// Of a view in which so much is seen from the top to the bottom.
    #[must_use]
    pub fn of(height: f64) -> Self {
        Self((2.0 * height.max(f64::MIN_POSITIVE).log2()).round().clamp(-2000.0, 2000.0) as i32)
    }

    /// World distance of arrows.
    fn spacing(self) -> f64 {
        (0.5 * f64::from(self.0)).exp2() / ROWS
    }
}

/// Strips of triangles with a colour each.
#[derive(Debug, Default)]
pub struct Strips {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Triangles.
    pub faces: Vec<[u32; 3]>,
    /// Colours of the triangles, linear light.
    pub colours: Vec<Vec3>,
}

impl Strips {
    /// As tints of [`crate::render::gpu::Renderer::load_tinted`].
    #[must_use]
    pub fn tints(&self) -> Vec<[Vec4; 3]> {
        self.colours.iter().map(|c| [c.extend(1.0); 3]).collect()
    }

    fn triangle(&mut self, corners: [DVec3; 3], colour: Vec3) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners.map(DVec3::as_vec3));
        self.faces.push([first, first + 1, first + 2]);
        self.colours.push(colour);
    }

    /// A strip from a to b of such widths there, facing along `normal`.
    fn strip(&mut self, [a, b]: [DVec3; 2], widths: [f64; 2], normal: DVec3, colour: Vec3) {
        let side = normal.cross(b - a).normalize_or_zero();
        let [l, m] = [side * (0.5 * widths[0]), side * (0.5 * widths[1])];
        self.triangle([a - l, b - m, b + m], colour);
        self.triangle([a - l, b + m, a + l], colour);
    }

    /// A small ball: an octahedron whose sides are cut once.
    fn ball(&mut self, middle: DVec3, radius: f64, colour: Vec3) {
        for k in 0..8 {
            let sign = |bit: u32| if k & bit == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [DVec3::X * sign(1), DVec3::Y * sign(2), DVec3::Z * sign(4)];
            let [xy, yz, zx] = [(x + y).normalize(), (y + z).normalize(), (z + x).normalize()];
            for face in [[x, xy, zx], [y, yz, xy], [z, zx, yz], [xy, yz, zx]] {
                let outward = (face[1] - face[0]).cross(face[2] - face[0]).dot(face[0]) > 0.0;
                let face = if outward { face } else { [face[0], face[2], face[1]] };
                self.triangle(face.map(|p| middle + p * radius), colour);
            }
        }
    }
}

/// Makes lines on a mesh; around `near`, where there would be too many.
#[must_use]
pub fn lines(mesh: &Mesh, field: Option<&TangentField>, which: Lines, detail: Detail, near: DVec3) -> Strips {
    let (low, high) = mesh.bounds();
    let size = (high - low).as_dvec3().length();
    let spacing = detail.spacing();
    let pen = Pen { mesh, spacing, lift: (LIFT * WIDTH * spacing).max(LEAST_LIFT * size) };
    let mut strips = Strips::default();
    if which.edges {
        pen.edges(&mut strips);
    }
    if let Some(field) = field {
        if which.streamlines {
            pen.streamlines(field, near, &mut strips);
        }
        if which.arrows {
            pen.arrows(field, near, &mut strips);
        }
        if which.singularities {
            for NWaySingularity { place, parts } in turning_points(mesh, field) {
                let colour = if parts > 0 { POLE } else { SADDLE };
                strips.ball(mesh.point(place), 0.22 * spacing, colour);
            }
        }
    }
    strips
}

struct Pen<'a> {
    mesh: &'a Mesh,
    spacing: f64,
    lift: f64,
}

/// A point on the way of a line, and the normal there.
#[derive(Debug, Clone, Copy)]
struct Station {
    position: DVec3,
    normal: DVec3,
}

impl Pen<'_> {
    fn station(&self, at: SurfacePoint) -> Station {
        Station { position: self.mesh.position(at), normal: self.mesh.normal(at.face) }
    }

    fn lifted(&self, station: &Station) -> DVec3 {
        station.position + station.normal * self.lift
    }

    /// The field's direction at a place that is nearest to the way come from.
    fn direction(&self, field: &TangentField, face: u32, before: Option<DVec3>) -> Option<DVec3> {
        let up = field.up.get(face as usize)?.as_dvec3().try_normalize()?;
        let (Some(before), true) = (before, field.ways > 1) else { return Some(up) };
        let right = up.cross(self.mesh.normal(face));
        let part = std::f64::consts::TAU / f64::from(field.ways);
        let turned = |k: u32| {
            let (sin, cos) = (f64::from(k) * part).sin_cos();
            up * cos + right * sin
        };
        (0..field.ways).map(turned).max_by(|a, b| a.dot(before).total_cmp(&b.dot(before)))
    }

    /// The stations from a place along the field, or against it, until a length is gone, the field breaks, or `on` says no.
    fn trace(&self, field: &TangentField, from: SurfacePoint, length: f64, sign: f64) -> Vec<Station> {
        let step = STEP * self.spacing;
        let mut way = Vec::new();
        let (mut at, mut left) = (from, length);
        let mut before: Option<DVec3> = None;
        while left > 0.0 && way.len() < STEPS {
            let Some(direction) = self.direction(field, at.face, before) else { break };
            if before.is_some_and(|b| b.dot(direction) < BREAK) {
                break;
            }
            before = Some(direction);
            at = walk(self.mesh, at, direction * (sign * step.min(left)));
            way.push(self.station(at));
            left -= step;
        }
        way
    }

    /// How far from the point looked at there is something to be seen, if things `distance` apart are not to be too many.
    fn reach(&self, distance: f64) -> f64 {
        let expected = self.mesh.total_area() / (distance * distance);
        if expected > MOST_ARROWS as f64 { distance * (MOST_ARROWS as f64 / 6.0).sqrt() } else { f64::INFINITY }
    }

    /// Places over the surface about `distance` apart, in the order of the faces; the ones around `near` if there are too many.
    fn places(&self, distance: f64, near: DVec3) -> Vec<SurfacePoint> {
        let mut taken: HashSet<[i64; 3]> = HashSet::new();
        let mut places = Vec::new();
        let cell = |p: DVec3| (p / distance).floor().to_array().map(|c| c as i64);
        let reach = self.reach(distance);
        for face in 0..self.mesh.face_count() as u32 {
            let middle = self.mesh.centroid(face);
            let [a, b, c] = self.mesh.corners(face);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if middle.distance(near) > reach + longest {
                continue;
            }
            // Rows of a large face; a small one has its middle.
            let rows = ((longest / (0.7 * distance)).ceil() as u32).clamp(1, 64);
            for i in 0..rows {
                for j in 0..rows - i {
                    let share = |k: u32| (f64::from(k) + 1.0 / 3.0) / f64::from(rows);
                    let bary = DVec3::new(1.0 - share(i) - share(j), share(i), share(j));
                    let at = SurfacePoint { face, bary: bary.as_vec3() };
                    let position = a * bary.x + b * bary.y + c * bary.z;
                    if position.distance(near) <= reach && taken.insert(cell(position)) {
                        places.push(at);
                        if places.len() >= MOST_ARROWS {
                            return places;
                        }
                    }
                }
            }
        }
        places
    }

    fn arrows(&self, field: &TangentField, near: DVec3, strips: &mut Strips) {
        let mut lengths: Vec<f32> = field.up.iter().map(|t| t.length()).filter(|l| *l > 0.0).collect();
        lengths.sort_unstable_by(f32::total_cmp);
        let median = lengths.get(lengths.len() / 2).copied().unwrap_or(1.0);
        for place in self.places(self.spacing, near) {
            let relative = f64::from((field.up[place.face as usize].length() / median).clamp(0.45, 1.6));
            let half = 0.42 * self.spacing * relative;
            let mut way = self.trace(field, place, half, -1.0);
            way.reverse();
            way.push(self.station(place));
            way.extend(self.trace(field, place, half, 1.0));
            let width = WIDTH * self.spacing;
            for pair in way.windows(2) {
                strips.strip([self.lifted(&pair[0]), self.lifted(&pair[1])], [width; 2], pair[0].normal, INK);
            }
            if let [.., before, tip] = way.as_slice() {
                let heading = (tip.position - before.position).normalize_or_zero();
                let side = tip.normal.cross(heading).normalize_or_zero();
                let point = self.lifted(tip) + heading * (1.2 * width);
                let base = self.lifted(tip) - heading * (2.4 * width);
                strips.triangle([base - side * (1.9 * width), point, base + side * (1.9 * width)], INK);
            }
        }
    }

    fn streamlines(&self, field: &TangentField, near: DVec3, strips: &mut Strips) {
        let distance = BESIDE * self.spacing;
        let (low, high) = self.mesh.bounds();
        let size = (high - low).as_dvec3().length().max(f64::MIN_POSITIVE);
        let options = StreamlineOptions {
            spacing: distance / size,
            longest: LONG,
            around: Some((near, self.reach(distance))),
            most: MOST_ARROWS,
        };
        let width = 0.6 * WIDTH * self.spacing;
        for line in streamlines(self.mesh, field, &options) {
            let way: Vec<Station> = line.into_iter().map(|at| self.station(at)).collect();
            for pair in way.windows(2) {
                strips.strip([self.lifted(&pair[0]), self.lifted(&pair[1])], [width; 2], pair[0].normal, INK);
            }
        }
    }

    fn edges(&self, strips: &mut Strips) {
        if self.mesh.edge_count() > MOST_EDGES {
            return;
        }
        let width = EDGE * self.spacing;
        for h in 0..3 * self.mesh.face_count() as u32 {
            let o = self.mesh.opposite[h as usize];
            // Each edge once; those of a boundary have one half only.
            if o < h {
                continue;
            }
            let mut normal = self.mesh.normal(h / 3);
            if let Some(&[_, _, _]) = self.mesh.faces.get((o / 3) as usize) {
                normal = (normal + self.mesh.normal(o / 3)).normalize_or(normal);
            }
            let [a, b] = [h, crate::mesh::next(h)].map(|h| self.mesh.point(self.mesh.origin(h)) + normal * self.lift);
            strips.strip([a, b], [width; 2], normal, WIRE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn lines_lie_just_above_the_surface_along_the_field() {
        let mesh = shapes::uneven_square(12);
        let field = TangentField::along(vec![Vec3::new(0.06, 0.08, 0.0); mesh.face_count()]);
        let which = Lines { arrows: true, streamlines: true, ..Lines::default() };
        let strips = lines(&mesh, Some(&field), which, Detail::of(1.0), DVec3::ZERO);
        assert!(strips.faces.len() > 500, "{} triangles", strips.faces.len());
        let heights = strips.positions.iter().map(|p| p.z);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(low, high), z| (low.min(z), high.max(z)));
        assert!(low > 0.0 && high < 0.01, "between {low} and {high}");
        // Strips come in pairs of triangles, of which the first one's first side runs along the line.
        let along = strips.faces.iter().filter(|face| {
            let [a, b] = [face[0], face[1]].map(|v| strips.positions[v as usize].as_dvec3());
            (b - a).normalize_or_zero().dot(DVec3::new(0.6, 0.8, 0.0)).abs() > 0.95
        });
        assert!(along.count() * 3 > strips.faces.len(), "most run along the field");
    }

    #[test]
    fn every_edge_is_drawn_once_and_too_many_not_at_all() {
        let mesh = shapes::torus(10, 6, 1.0, 0.3);
        let which = Lines { edges: true, ..Lines::default() };
        let strips = lines(&mesh, None, which, Detail::of(3.0), DVec3::ZERO);
        assert_eq!(strips.faces.len(), 2 * mesh.edge_count(), "two triangles an edge");
    }

    #[test]
    fn the_poles_of_a_sphere_are_marked() {
        let mesh = shapes::sphere(3);
        let up = (0..mesh.face_count() as u32).map(|f| (DVec3::Y - mesh.normal(f) * mesh.normal(f).y).as_vec3()).collect();
        let which = Lines { singularities: true, ..Lines::default() };
        let strips = lines(&mesh, Some(&TangentField::along(up)), which, Detail::of(2.0), DVec3::ZERO);
        assert_eq!(strips.faces.len(), 2 * 32, "two balls");
        assert!(strips.colours.iter().all(|c| *c == POLE), "both are poles");
    }
}
