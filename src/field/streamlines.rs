//! Streamlines: how a tangent field runs, as lines about evenly far apart.
//!
//! Based on: Jobard, Lefer, "Creating evenly-spaced streamlines of arbitrary density" (1997), on a surface instead of in the plane.
//!
//! 1. A line runs both ways from its seed, step by step straight over the faces ([`crate::mesh::walk`]), turned at every step
//!    into the direction of the face it has come to. It ends where it comes closer than half the spacing to another line or to
//!    itself, where the field turns against it, and at boundaries.
//! 2. Places beside a line, one spacing off, are the next seeds, as long as no line is nearer than nearly a spacing; when none is
//!    left, faces are gone through, about four for a square of the spacing.
//!
//! Points are looked up in cells of the spacing's size; two points on opposite sides of a thin wall do not see each other. The
//! work is proportional to the faces, and to the points of the lines.

use super::TangentField;
use crate::mesh::transport::projected;
use crate::mesh::walk::walk;
use crate::mesh::{Mesh, SurfacePoint};
use glam::{DVec3, IVec3, Vec3};
use std::collections::{HashMap, VecDeque};
use std::f64::consts::TAU;

/// Steps a spacing.
const STEPS: f64 = 4.0;

/// A line ends nearer than this share of the spacing to another one ...
const ENDS: f64 = 0.5;

/// ... and begins no nearer than this.
const BEGINS: f64 = 0.95;

/// A line as short as this many steps is left out: a point says nothing.
const SHORTEST: usize = 4;

/// A line ends where the field turns against it by more than this cosine tells.
const AGAINST: f64 = 0.0;

/// Spacings along the bounding box's diagonal, at the most: cells are counted in 32 bits.
const MOST_SPACINGS: f64 = 1e6;

/// How to draw streamlines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamlineOptions {
    /// Distance between lines, as a share of the bounding box's diagonal.
    pub spacing: f64,
    /// The longest a line may be, in spacings.
    pub longest: f64,
    /// Lines stay within so far of a point, world units; none: everywhere.
    pub around: Option<(DVec3, f64)>,
    /// At most so many lines: bounds the work for whatever is asked.
    pub most: usize,
}

impl Default for StreamlineOptions {
    fn default() -> Self {
        Self { spacing: 0.02, longest: 60.0, around: None, most: 20_000 }
    }
}

/// A line: its points in the order in which the field runs.
pub type Streamline = Vec<SurfacePoint>;

/// Lines that run along the directions of a field. The same for every run and number of threads.
#[must_use]
pub fn streamlines(mesh: &Mesh, field: &TangentField, options: &StreamlineOptions) -> Vec<Streamline> {
    let (low, high) = mesh.bounds();
    let diagonal = high.as_dvec3().distance(low.as_dvec3());
    let spacing = diagonal * options.spacing.max(1.0 / MOST_SPACINGS);
    if !(spacing.is_normal() && field.up.len() == mesh.face_count()) {
        return Vec::new();
    }
    let most = (options.longest * STEPS).clamp(1.0, 1e5) as usize;
    let (low, around) = (low.as_dvec3(), options.around);
    let mut tracer = Tracer { mesh, field, spacing, most, around, low, cells: HashMap::new(), lines: Vec::new() };
    let mut seeds = VecDeque::new();
    let mut due = 0.0;
    for face in 0..mesh.face_count() as u32 {
        due += mesh.area(face);
        if face > 0 && due < 0.25 * spacing * spacing {
            continue;
        }
        due = 0.0;
        seeds.push_back(SurfacePoint { face, bary: Vec3::splat(1.0 / 3.0) });
        while let Some(seed) = seeds.pop_front() {
            if tracer.lines.len() >= options.most {
                return tracer.lines;
            }
            if tracer.begin(seed) {
                tracer.beside_last(&mut seeds);
            }
        }
    }
    tracer.lines
}

/// A point of a line among those in one cell.
struct Met {
    line: u32,
    /// Steps from the line's seed, the way back negative.
    step: i32,
    point: DVec3,
    normal: DVec3,
}

struct Tracer<'a> {
    mesh: &'a Mesh,
    field: &'a TangentField,
    spacing: f64,
    most: usize,
    around: Option<(DVec3, f64)>,
    low: DVec3,
    cells: HashMap<IVec3, Vec<Met>>,
    lines: Vec<Streamline>,
}

impl Tracer<'_> {
    /// Draws a line through a seed, unless it is too near to others or too short.
    fn begin(&mut self, seed: SurfacePoint) -> bool {
        let line = self.lines.len() as u32;
        if self.beyond(seed) || self.near(seed, BEGINS * self.spacing, |_| true) {
            return false;
        }
        let mut met = vec![(0, seed)];
        self.mark(line, 0, seed);
        for sense in [1, -1] {
            let (mut at, mut heading) = (seed, None);
            for step in 1..=self.most as i32 {
                let Some((next, arrived)) = self.step(at, heading, f64::from(sense)) else { break };
                // Its own last steps are near by nature.
                let own = |m: &Met| m.line != line || (m.step - sense * step).abs() > 2 * STEPS as i32;
                if self.beyond(next) || self.near(next, ENDS * self.spacing, own) {
                    break;
                }
                self.mark(line, sense * step, next);
                met.push((sense * step, next));
                (at, heading) = (next, Some(arrived));
            }
        }
        if met.len() <= SHORTEST {
            for &(_, place) in &met {
                let key = self.key(self.mesh.position(place));
                if let Some(cell) = self.cells.get_mut(&key) {
                    cell.retain(|m| m.line != line);
                }
            }
            return false;
        }
        met.sort_by_key(|&(step, _)| step);
        self.lines.push(met.into_iter().map(|(_, place)| place).collect());
        true
    }

    /// True of places that no line goes to.
    fn beyond(&self, place: SurfacePoint) -> bool {
        self.around.is_some_and(|(middle, reach)| self.mesh.position(place).distance(middle) > reach)
    }

    /// One step along the field, or against it; and which way it went, on the face arrived at.
    fn step(&self, at: SurfacePoint, heading: Option<DVec3>, sense: f64) -> Option<(SurfacePoint, DVec3)> {
        let along = self.direction(at.face, heading, sense)?;
        let length = self.spacing / STEPS;
        let next = walk(self.mesh, at, along * length);
        let way = self.mesh.position(next) - self.mesh.position(at);
        let arrived = projected(way, self.mesh.normal(next.face)).try_normalize()?;
        // At a boundary the walk ends short.
        (way.length() > 0.5 * length).then_some((next, arrived))
    }

    /// Where the field leads from a face, for one who arrives with a heading: of several ways the one that goes on straightest.
    /// `None` where it leads back.
    fn direction(&self, face: u32, heading: Option<DVec3>, sense: f64) -> Option<DVec3> {
        let up = self.field.up[face as usize].as_dvec3().try_normalize()? * sense;
        let Some(heading) = heading else { return Some(up) };
        let normal = self.mesh.normal(face);
        let part = TAU / f64::from(self.field.ways.max(1));
        let turn = part * (normal.dot(up.cross(heading)).atan2(up.dot(heading)) / part).round();
        let along = up * turn.cos() + normal.cross(up) * turn.sin();
        (along.dot(heading) > AGAINST).then_some(along)
    }

    /// Seeds to both sides of the last line, a spacing off.
    fn beside_last(&self, seeds: &mut VecDeque<SurfacePoint>) {
        let Some(line) = self.lines.last() else { return };
        for pair in line.windows(2).step_by(STEPS as usize) {
            let way = self.mesh.position(pair[1]) - self.mesh.position(pair[0]);
            let normal = self.mesh.normal(pair[0].face);
            let Some(side) = projected(normal.cross(way), normal).try_normalize() else { continue };
            seeds.extend([1.0, -1.0].map(|sense| walk(self.mesh, pair[0], side * (sense * self.spacing))));
        }
    }

    fn key(&self, point: DVec3) -> IVec3 {
        ((point - self.low) / self.spacing).floor().as_ivec3()
    }

    fn mark(&mut self, line: u32, step: i32, place: SurfacePoint) {
        let (point, normal) = (self.mesh.position(place), self.mesh.normal(place.face));
        self.cells.entry(self.key(point)).or_default().push(Met { line, step, point, normal });
    }

    /// True if a point that counts lies within `reach` (at most a spacing), on the same side of the surface.
    fn near(&self, place: SurfacePoint, reach: f64, counts: impl Fn(&Met) -> bool) -> bool {
        let (point, normal) = (self.mesh.position(place), self.mesh.normal(place.face));
        let middle = self.key(point);
        (0..27).map(|k| middle + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)).any(|key| {
            let close = |m: &Met| m.point.distance(point) < reach && m.normal.dot(normal) > 0.0 && counts(m);
            self.cells.get(&key).is_some_and(|cell| cell.iter().any(close))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::up;
    use crate::mesh::shapes;

    fn lines_of(mesh: &Mesh, axis: DVec3, spacing: f64) -> (TangentField, Vec<Streamline>) {
        let (field, _) = up(mesh, axis, 0.3).expect("a field");
        let lines = streamlines(mesh, &field, &StreamlineOptions { spacing, ..StreamlineOptions::default() });
        (field, lines)
    }

    #[test]
    fn lines_run_along_the_field() {
        // Around the torus and around its tube at once: a field without singularities, that turns everywhere.
        let mesh = shapes::torus(80, 40, 1.0, 0.35);
        let helix = |f: u32| {
            let (normal, place) = (mesh.normal(f), mesh.centroid(f));
            let around = projected(DVec3::Z.cross(place), normal).normalize();
            (around * 0.8 + normal.cross(around) * 0.6).as_vec3()
        };
        let field = TangentField::along((0..mesh.face_count() as u32).map(helix).collect());
        let lines = streamlines(&mesh, &field, &StreamlineOptions { spacing: 0.03, ..StreamlineOptions::default() });
        assert!(lines.len() > 20, "{} lines", lines.len());
        let mut steps = 0;
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            let way = (mesh.position(pair[1]) - mesh.position(pair[0])).normalize();
            let along = [0, 1].map(|i| field.up[pair[i].face as usize].as_dvec3().normalize());
            let off = way.dot((along[0] + along[1]).normalize()).clamp(-1.0, 1.0).acos().to_degrees();
            assert!(off < 10.0, "{off} degrees off at {}", mesh.position(pair[0]));
            steps += 1;
        }
        assert!(steps > 500, "{steps} steps");
    }

    #[test]
    fn the_surface_is_covered_evenly() {
        let mesh = shapes::sphere(5);
        let spacing = 0.03;
        let (_, lines) = lines_of(&mesh, DVec3::Z, spacing);
        let world = spacing * mesh.bounds().0.distance(mesh.bounds().1) as f64;
        let points: Vec<(usize, DVec3)> = lines
            .iter()
            .enumerate()
            .flat_map(|(l, line)| line.iter().map(move |p| (l, *p)))
            .map(|(l, p)| (l, mesh.position(p)))
            .collect();
        let distance = |from: DVec3, skip: usize| {
            points.iter().filter(|(l, _)| *l != skip).map(|(_, p)| p.distance(from)).fold(f64::INFINITY, f64::min)
        };
        let empty = (0..mesh.face_count() as u32).step_by(7).map(|f| distance(mesh.centroid(f), usize::MAX)).fold(0.0, f64::max);
        assert!(empty < 1.6 * world, "nowhere is a gap of {} spacings", empty / world);
        let close = points.iter().step_by(3).map(|&(l, p)| distance(p, l)).fold(f64::INFINITY, f64::min);
        assert!(close > 0.45 * world, "nowhere do lines come within {} spacings", close / world);
    }

    #[test]
    fn a_field_of_four_ways_goes_on_straight() {
        let mesh = shapes::uneven_square(24);
        // Turned by a quarter from face to face at random: for four ways the same field.
        let up = |f: u32| [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y][(f as usize * 7 + 3) % 4] * 0.2;
        let field = TangentField { up: (0..mesh.face_count() as u32).map(up).collect(), right: None, ways: 4 };
        let lines = streamlines(&mesh, &field, &StreamlineOptions::default());
        let longest = lines.iter().map(|l| mesh.position(l[0]).distance(mesh.position(l[l.len() - 1]))).fold(0.0, f64::max);
        assert!(longest > 0.9, "some line crosses the square: {longest}");
        for line in &lines {
            let [a, b] = [0, line.len() - 1].map(|i| mesh.position(line[i]));
            let straight = (b - a).abs();
            assert!(straight.x.min(straight.y) < 1e-6, "from {a} to {b} along an axis");
        }
    }

    #[test]
    fn lines_stay_around_a_point_and_are_no_more_than_asked_for() {
        let mesh = shapes::sphere(4);
        let (field, _) = up(&mesh, DVec3::Z, 0.3).expect("a field");
        let around = Some((DVec3::X, 0.5));
        let lines = streamlines(&mesh, &field, &StreamlineOptions { around, ..StreamlineOptions::default() });
        let far = lines.iter().flatten().map(|&p| mesh.position(p).distance(DVec3::X)).fold(0.0, f64::max);
        assert!(!lines.is_empty() && far <= 0.5, "{} lines, as far as {far}", lines.len());
        let few = streamlines(&mesh, &field, &StreamlineOptions { around, most: 3, ..StreamlineOptions::default() });
        assert_eq!(few, lines[..3], "the first of them");
    }

    #[test]
    fn nothing_is_drawn_of_a_field_of_another_mesh_or_of_no_size() {
        let mesh = shapes::sphere(2);
        let short = TangentField::along(vec![Vec3::X; 3]);
        assert!(streamlines(&mesh, &short, &StreamlineOptions::default()).is_empty(), "another mesh");
        let nothing = TangentField::along(vec![Vec3::ZERO; mesh.face_count()]);
        assert!(streamlines(&mesh, &nothing, &StreamlineOptions::default()).is_empty(), "no direction");
    }
}
