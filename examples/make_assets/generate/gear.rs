//! A spur gear with a recessed web, lightening holes and a bored hub: flat faces and right angles throughout, genus 6.
//!
//! The solid is a stack of flat rings and upright walls. Each outline is sampled once; rings are triangulated between
//! their outlines (Delaunay with refinement, outlines kept), walls are strips between copies of an outline at two heights,
//! so everything fits vertex by vertex. The gear's axis is z; it stands on y = 0.

use super::Triangles;
use super::portable::{cos, sin};
use super::solids::rest;
use glam::{DVec2, DVec3};
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Edge length.
const EDGE: f64 = 0.07;
const TEETH: usize = 14;
/// Radii: tip and foot of the teeth, inside of the rim, hub, bore.
const TIP: f64 = 1.0;
const FOOT: f64 = 0.8;
const RIM: f64 = 0.64;
const HUB: f64 = 0.31;
const BORE: f64 = 0.17;
/// Lightening holes: how many, where, how large.
const HOLES: usize = 5;
const HOLE_RING: f64 = 0.475;
const HOLE: f64 = 0.105;
/// Half thicknesses: rim, web, hub.
const RIM_HALF: f64 = 0.2;
const WEB_HALF: f64 = 0.09;
const HUB_HALF: f64 = 0.28;
/// Width of the 45 degree chamfers on tooth tips and hub.
const CHAMFER: f64 = 0.035;

type Loop = Vec<DVec2>;

/// The gear, about 8,000 faces.
pub(crate) fn gear() -> Triangles {
    let teeth = outline(0.0);
    let teeth_top = outline(CHAMFER);
    let rim = circle(DVec2::ZERO, RIM, 0.0);
    let hub = circle(DVec2::ZERO, HUB, 0.0);
    let hub_top: Loop = hub.iter().map(|&p| p * ((HUB - CHAMFER) / HUB)).collect();
    let bore = keyed_bore();
    let holes: Vec<Loop> = (0..HOLES)
        .map(|i| {
            let a = TAU * (i as f64 + 0.25) / HOLES as f64;
            circle(DVec2::new(cos(a), sin(a)) * HOLE_RING, HOLE, a)
        })
        .collect();
    let mut solid = Solid::default();
    solid.ring(&teeth_top, &[&rim], RIM_HALF);
    let hole_loops: Vec<&Loop> = std::iter::once(&hub).chain(&holes).collect();
    solid.ring(&rim, &hole_loops, WEB_HALF);
    solid.ring(&hub_top, &[&bore], HUB_HALF);
    // Each wall with the solid on its left, seen from above: outlines as they run, holes backwards.
    solid.wall(&teeth, -(RIM_HALF - CHAMFER), RIM_HALF - CHAMFER, true);
    solid.bevel(&teeth, &teeth_top, RIM_HALF - CHAMFER, RIM_HALF);
    solid.wall(&bore, -HUB_HALF, HUB_HALF, false);
    for hole in &holes {
        solid.wall(hole, -WEB_HALF, WEB_HALF, false);
    }
    solid.both_walls(&rim, WEB_HALF, RIM_HALF, false);
    solid.both_walls(&hub, WEB_HALF, HUB_HALF - CHAMFER, true);
    solid.bevel(&hub, &hub_top, HUB_HALF - CHAMFER, HUB_HALF);
    rest(solid.mesh)
}

/// Adds points from the last one of a loop to `end`, evenly, at most [`EDGE`] apart.
fn line_to(points: &mut Loop, end: DVec2) {
    let Some(&start) = points.last() else { return points.push(end) };
    let steps = (start.distance(end) / EDGE).round().max(1.0) as usize;
    points.extend((1..=steps).map(|i| start.lerp(end, i as f64 / steps as f64)));
}

fn circle(centre: DVec2, radius: f64, phase: f64) -> Loop {
    // Small circles need more segments than their edge length asks for.
    let count = (TAU * radius / EDGE).round().max(20.0) as usize;
    (0..count)
        .map(|i| {
            let a = phase + TAU * i as f64 / count as f64;
            centre + DVec2::new(cos(a), sin(a)) * radius
        })
        .collect()
}

/// The toothed outline, counter-clockwise; `inset` draws in the tips and flanks for the chamfer. The number of points does
/// not depend on it.
fn outline(inset: f64) -> Loop {
    let mut points = Loop::new();
    let pitch = TAU / TEETH as f64;
    let at = |r: f64, a: f64| DVec2::new(cos(a), sin(a)) * r;
    for tooth in 0..TEETH {
        let a = pitch * tooth as f64;
        // Half widths of a tooth as angles: at the foot, and at the tip.
        let (foot, tip) = (0.31 * pitch - 0.5 * inset / FOOT, 0.17 * pitch - 0.4 * inset / TIP);
        let (low, high) = (FOOT - 0.3 * inset, TIP - inset);
        let corners = [at(low, a - foot), at(high, a - tip), at(high, a + tip), at(low, a + foot)];
        // The steps of the outline itself, so that both copies agree in number.
        let plain = [at(FOOT, a - 0.31 * pitch), at(TIP, a - 0.17 * pitch), at(TIP, a + 0.17 * pitch), at(FOOT, a + 0.31 * pitch)];
        let close = (at(low, a + pitch - foot), at(FOOT, a + 0.69 * pitch));
        for k in 0..4 {
            let (end, plain_end) = if k < 3 { (corners[k + 1], plain[k + 1]) } else { close };
            let steps = (plain[k].distance(plain_end) / EDGE).round().max(1.0) as usize;
            points.extend((0..steps).map(|i| corners[k].lerp(end, i as f64 / steps as f64)));
        }
    }
    points
}

/// The bore with a keyway at its top.
fn keyed_bore() -> Loop {
    let (half, depth) = (0.05, 0.07);
    let start = (BORE * BORE - half * half).sqrt();
    let count = 22;
    // From the keyway's left corner around to its right corner.
    let gap = half / BORE;
    let mut points: Loop = (0..=count)
        .map(|i| {
            let a = 0.25 * TAU + gap * 1.015 + (TAU - 2.03 * gap) * f64::from(i) / f64::from(count);
            DVec2::new(cos(a), sin(a)) * BORE
        })
        .collect();
    points[0] = DVec2::new(-half, start);
    points[count as usize] = DVec2::new(half, start);
    line_to(&mut points, DVec2::new(half, start + depth));
    line_to(&mut points, DVec2::new(-half, start + depth));
    line_to(&mut points, DVec2::new(-half, start));
    points.pop();
    points
}

#[derive(Default)]
struct Solid {
    mesh: Triangles,
    /// Vertices by the bits of their position.
    known: BTreeMap<[u64; 3], u32>,
}

impl Solid {
    fn vertex(&mut self, p: DVec2, z: f64) -> u32 {
        let p = DVec3::new(p.x, p.y, z);
        *self.known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.mesh.positions.push(p);
            self.mesh.positions.len() as u32 - 1
        })
    }

    /// A flat ring at +z and its twin at -z.
    fn ring(&mut self, outer: &Loop, inner: &[&Loop], z: f64) {
        for [a, b, c] in triangulate(outer, inner) {
            let top = [a, b, c].map(|p| self.vertex(p, z));
            let bottom = [a, c, b].map(|p| self.vertex(p, -z));
            self.mesh.faces.extend([top, bottom]);
        }
    }

    /// A wall along a loop from z = `low` to `high`; `outward` if the solid is inside the loop.
    fn wall(&mut self, line: &Loop, low: f64, high: f64, outward: bool) {
        let rows = ((high - low) / EDGE).round().max(1.0) as usize;
        for row in 0..rows {
            let z = |r: usize| if r == rows { high } else { low + (high - low) * r as f64 / rows as f64 };
            self.strip(line, z(row), line, z(row + 1), outward, row);
        }
    }

    fn both_walls(&mut self, line: &Loop, low: f64, high: f64, outward: bool) {
        self.wall(line, low, high, outward);
        self.wall(line, -high, -low, outward);
    }

    /// The slanted strip between two loops of as many points, above and below.
    fn bevel(&mut self, lower: &Loop, upper: &Loop, low: f64, high: f64) {
        self.strip(lower, low, upper, high, true, 0);
        self.strip(upper, -high, lower, -low, true, 0);
    }

    fn strip(&mut self, lower: &Loop, low: f64, upper: &Loop, high: f64, outward: bool, row: usize) {
        for i in 0..lower.len() {
            let j = (i + 1) % lower.len();
            let (a, b) = (self.vertex(lower[i], low), self.vertex(lower[j], low));
            let (c, d) = (self.vertex(upper[i], high), self.vertex(upper[j], high));
            // Diagonals alternate, so that no direction is preferred.
            let pair = if (i + row).is_multiple_of(2) { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] };
            self.mesh.faces.extend(pair.map(|[p, q, r]| if outward { [p, q, r] } else { [p, r, q] }));
        }
    }
}

/// Triangles between an outline and the holes in it, counter-clockwise, with no new points on the loops.
fn triangulate(outer: &Loop, inner: &[&Loop]) -> Vec<[DVec2; 3]> {
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    for line in std::iter::once(&outer).chain(inner) {
        let mut handles = Vec::new();
        for p in *line {
            if let Ok(handle) = cdt.insert(Point2::new(p.x, p.y)) {
                handles.push(handle);
            }
        }
        for i in 0..handles.len() {
            cdt.add_constraint(handles[i], handles[(i + 1) % handles.len()]);
        }
    }
    let parameters = RefinementParameters::<f64>::new()
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(28.0))
        .with_max_allowed_area(0.6 * EDGE * EDGE)
        .with_max_additional_vertices(4000)
        .exclude_outer_faces(true);
    let refined = cdt.refine(parameters);
    let outside: BTreeSet<_> = refined.excluded_faces.into_iter().collect();
    cdt.inner_faces().filter(|f| !outside.contains(&f.fix())).map(|f| f.positions().map(|p| DVec2::new(p.x, p.y))).collect()
}
