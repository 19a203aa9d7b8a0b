//! Marching around a vertex: the curves in which cylinders about its normal cut the surface.
//!
//! Based on: Chen, Dong, "Adaptive surface texture synthesis using round-shaped neighbourhoods", Computer Graphics Forum 27(8),
//! 2008, sec. 4.3.
//!
//! 1. Seen along the normal, a face is a triangle in the plane and the cylinder a circle. Corners are inside or outside, and an edge
//!    is crossed once if its ends differ, and twice or not at all if both are outside. Decided per vertex and per edge, the same from
//!    both sides, so that a circle through vertices, which regular grids give at every turn, is no special case.
//! 2. In each face the circle enters and leaves; going on from face to face it comes back or meets a boundary. On faces that are seen
//!    from behind, under an overhang, it goes the other way around. Where several crossings could follow, the next by angle does.
//! 3. Of the curves that the cylinder cuts the one around the vertex is kept: it starts at an edge that leads out from the
//!    vertex, and if it closes without going around once, it is none.
//!
//! The length of a piece is that of the helix between its ends, which is exact on planes across the normal.

use crate::mesh::{Mesh, NONE, next, prev};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A curve of more faces than this is none: it runs along a fold, or faces are so small that it will not fit what is kept.
const MOST_FACES: usize = 1 << 14;

/// Room for the faces of an ordinary curve.
const USUAL_FACES: usize = 64;

/// The surface may rise or fall this many radii at most before a curve is given up: it has left the vertex's surroundings.
const STEEPEST: f64 = 3.0;

/// Directions in which a curve's first edge is looked for.
const DIRECTIONS: usize = 6;

/// A closed curve has gone around once if its angles sum to a full turn but for this.
const AROUND: f64 = 1e-3;

/// A place where a curve comes into a face, and in the last place of an open one where it leaves the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// The half-edge it comes in by; of the last crossing of an open curve that by which it leaves the last face.
    pub(super) half_edge: u32,
    /// Angle about the normal, radians, from the axis' own direction.
    pub(super) angle: f64,
    /// World length from the curve's start.
    pub(super) way: f64,
}

/// A curve, or a part of one between boundaries.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Curve {
    pub(super) crossings: Vec<Crossing>,
    /// World length.
    pub(super) length: f64,
    pub(super) closed: bool,
}

/// A vertex, its normal, and two directions across it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    at: DVec3,
    pub(super) across: [DVec3; 2],
    normal: DVec3,
}

/// A point seen along an axis: its place in the plane and its height.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    pub(super) flat: DVec2,
    height: f64,
}

impl Axis {
    pub(super) fn new(at: DVec3, normal: DVec3) -> Self {
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let right = normal.any_orthonormal_vector();
        Self { at, across: [right, normal.cross(right)], normal }
    }

    #[inline]
    pub(super) fn seen(&self, point: DVec3) -> Seen {
        let way = point - self.at;
        Seen { flat: DVec2::new(way.dot(self.across[0]), way.dot(self.across[1])), height: way.dot(self.normal) }
    }

    /// The angle of a direction.
    pub(super) fn angle(&self, direction: DVec3) -> f64 {
        direction.dot(self.across[1]).atan2(direction.dot(self.across[0]))
    }
}

/// The difference of two angles of a few turns at most, in [-pi, pi).
#[inline]
pub(super) fn difference(from: f64, to: f64) -> f64 {
    let mut turn = to - from;
    while turn >= PI {
        turn -= TAU;
    }
    while turn < -PI {
        turn += TAU;
    }
    turn
}

/// A crossing of the circle with a half-edge.
#[derive(Debug, Clone, Copy)]
struct Cut {
    half_edge: u32,
    at: Seen,
    /// Its angle, once it is known.
    angle: f64,
}

impl Cut {
    fn with_angle(self) -> Self {
        Self { angle: angle(self.at), ..self }
    }
}

/// Marches about vertices of one mesh.
pub(super) struct Marcher<'a> {
    mesh: &'a Mesh,
    first: &'a [u32],
    axis: Axis,
    radius: f64,
    /// The face looked at last, and how its corners are seen.
    face: u32,
    corners: [Seen; 3],
    met: Vec<u32>,
}

impl<'a> Marcher<'a> {
    /// `first` are the mesh's [`Mesh::vertex_half_edges`].
    pub(super) fn new(mesh: &'a Mesh, first: &'a [u32]) -> Self {
        let axis = Axis::new(DVec3::ZERO, DVec3::Z);
        Self { mesh, first, axis, radius: 0.0, face: NONE, corners: [Seen::default(); 3], met: Vec::new() }
    }

    /// The curves about a vertex at a radius: one that is closed and goes around, or parts of one that end at boundaries.
    pub(super) fn curves(&mut self, vertex: u32, axis: Axis, radius: f64, out: &mut Vec<Curve>) {
        out.clear();
        (self.axis, self.radius, self.face) = (axis, radius, NONE);
        self.met.clear();
        for k in 0..DIRECTIONS {
            // Half a step off, so that no direction runs along the lines of a regular grid.
            let start = self.outward(vertex, DVec2::from_angle(TAU * (k as f64 + 0.25) / DIRECTIONS as f64));
            let Some(start) = start.filter(|h| !self.met.contains(h)) else { continue };
            let Some(curve) = self.curve(start) else { continue };
            if curve.closed {
                let (c, turns) = (&curve.crossings, |w: &[Crossing]| difference(w[0].angle, w[1].angle));
                let last = difference(c[c.len() - 1].angle, c[0].angle);
                if (c.windows(2).map(turns).sum::<f64>() + last - TAU).abs() < AROUND {
                    out.clear();
                    out.push(curve);
                    return;
                }
            } else {
                self.met.extend(curve.crossings.iter().map(|c| c.half_edge));
                out.push(curve);
            }
        }
    }

    #[inline]
    fn see(&mut self, face: u32) -> [Seen; 3] {
        if self.face != face {
            let vertices = self.mesh.faces[face as usize];
            let before = if self.face == NONE { [NONE; 3] } else { self.mesh.faces[self.face as usize] };
            let known = self.corners;
            for (k, v) in vertices.into_iter().enumerate() {
                self.corners[k] = match before.iter().position(|&b| b == v) {
                    Some(j) => known[j],
                    None => self.axis.seen(self.mesh.point(v)),
                };
            }
            self.face = face;
        }
        self.corners
    }

    /// A half-edge that crosses the circle outward, reached from the vertex along edges that lead farthest in a direction.
    fn outward(&self, vertex: u32, direction: DVec2) -> Option<u32> {
        let mut at = vertex;
        let mut far = 0.0;
        loop {
            let mut best = (far, None);
            for h in self.mesh.ring(self.first[at as usize]) {
                let flat = self.axis.seen(self.mesh.point(self.mesh.origin(next(h)))).flat;
                if flat.length_squared() >= self.radius * self.radius {
                    if flat.dot(direction) > 0.0 {
                        return Some(h);
                    }
                } else if flat.dot(direction) > best.0 {
                    best = (flat.dot(direction), Some(h));
                }
            }
            (at, far) = (self.mesh.origin(next(best.1?)), best.0);
        }
    }

    /// The curve through a half-edge that it enters a face by.
    fn curve(&mut self, start: u32) -> Option<Curve> {
        let mut curve = Curve { crossings: Vec::with_capacity(USUAL_FACES), ..Curve::default() };
        let first = self.cut(start, true)?.with_angle();
        let mut at = first;
        let mut way = 0.0;
        let limit = STEEPEST * self.radius;
        loop {
            if curve.crossings.len() > MOST_FACES || at.at.height.abs() > limit {
                return None;
            }
            curve.crossings.push(Crossing { half_edge: at.half_edge, angle: at.angle, way });
            let out = self.following(at, false)?;
            way += self.length(at, out);
            let over = self.mesh.opposite[out.half_edge as usize];
            if over == NONE {
                curve.crossings.push(Crossing { half_edge: out.half_edge, angle: out.angle, way });
                break;
            }
            if over == start {
                (curve.length, curve.closed) = (way, true);
                return Some(curve);
            }
            at = Cut { half_edge: over, ..out };
        }
        // Backward from the start, up to the other boundary.
        let mut before = Vec::new();
        let mut behind = 0.0;
        let mut at = first;
        while self.mesh.opposite[at.half_edge as usize] != NONE {
            if before.len() > MOST_FACES || at.at.height.abs() > limit {
                return None;
            }
            at.half_edge = self.mesh.opposite[at.half_edge as usize];
            let into = self.following(at, true)?;
            behind += self.length(into, at);
            before.push(Crossing { half_edge: into.half_edge, angle: into.angle, way: -behind });
            at = into;
        }
        before.reverse();
        before.append(&mut curve.crossings);
        before.iter_mut().for_each(|c| c.way += behind);
        (curve.length, curve.crossings) = (way + behind, before);
        Some(curve)
    }

    fn length(&self, from: Cut, to: Cut) -> f64 {
        let (along, up) = (self.radius * difference(from.angle, to.angle), to.at.height - from.at.height);
        (along * along + up * up).sqrt()
    }

    /// Where the circle leaves a face that it enters at `at`; with `backward`, where it entered the one that it leaves there.
    fn following(&mut self, at: Cut, backward: bool) -> Option<Cut> {
        let face = at.half_edge / 3;
        let seen = self.see(face);
        let corner = |h: u32| seen[(h % 3) as usize];
        let (after, before) = (next(at.half_edge), prev(at.half_edge));
        let (p, q, c) = (corner(at.half_edge), corner(after), corner(before));
        // Nearly always the circle comes in over one edge and goes out over one of the others, by where the corner between is.
        let squared = self.radius * self.radius;
        let inside = |s: Seen| s.flat.length_squared() < squared;
        if inside(p) != inside(q) {
            let (toward, away) = if backward { (before, after) } else { (after, before) };
            let (other, beyond) = if backward { (p, c) } else { (q, c) };
            if inside(c) {
                return self.cut(toward, backward).map(Cut::with_angle);
            }
            let along = beyond.flat - other.flat;
            if other.flat.dot(along) >= 0.0 || beyond.flat.dot(along) <= 0.0 {
                return self.cut(away, backward).map(Cut::with_angle);
            }
        }
        let from_behind = (q.flat - p.flat).perp_dot(c.flat - p.flat) < 0.0;
        let sense = if from_behind == backward { 1.0 } else { -1.0 };
        let mut found: Option<Cut> = None;
        for k in 0..3 {
            let Some(cut) = self.cut(3 * face + k, backward).map(Cut::with_angle) else { continue };
            found = match found {
                None => Some(cut),
                // The next one along the circle.
                Some(other) => {
                    let far = |c: Cut| (sense * (c.angle - at.angle)).rem_euclid(TAU);
                    Some(if far(cut) < far(other) { cut } else { other })
                }
            };
        }
        found
    }

    /// Where the circle enters a half-edge's face over it, or leaves it.
    fn cut(&mut self, half_edge: u32, enters: bool) -> Option<Cut> {
        let seen = self.see(half_edge / 3);
        let (a, b) = (seen[(half_edge % 3) as usize], seen[(next(half_edge) % 3) as usize]);
        let squared = self.radius * self.radius;
        let inside = |s: Seen| s.flat.length_squared() < squared;
        // With the inside on its left, the circle enters over edges that lead out of it, and leaves over those that lead in.
        let t = match (inside(a), inside(b)) {
            (true, true) => return None,
            (true, false) if !enters => return None,
            (false, true) if enters => return None,
            (true, false) => Self::root(a, b, squared, true)?,
            (false, true) => Self::root(a, b, squared, false)?,
            (false, false) => {
                // The same from both of its faces, whatever is rounded.
                let turned = self.mesh.origin(half_edge) > self.mesh.origin(next(half_edge));
                let (p, q) = if turned { (b, a) } else { (a, b) };
                let t = Self::root(p, q, squared, enters != turned).filter(|_| {
                    let along = q.flat - p.flat;
                    p.flat.dot(along) < 0.0 && q.flat.dot(along) > 0.0
                })?;
                if turned { 1.0 - t } else { t }
            }
        };
        let t = t.clamp(0.0, 1.0);
        let at = Seen { flat: a.flat.lerp(b.flat, t), height: a.height + (b.height - a.height) * t };
        Some(Cut { half_edge, at, angle: 0.0 })
    }

    /// Where along a to b the circle is met on the way in, or on the way out.
    fn root(a: Seen, b: Seen, squared: f64, out: bool) -> Option<f64> {
        let along = b.flat - a.flat;
        let (qa, qb, qc) = (along.length_squared(), a.flat.dot(along), a.flat.length_squared() - squared);
        let inner = qb * qb - qa * qc;
        // Ends on both sides have a root, whatever rounding says; of ends outside the ones that have none are told by it.
        if qa <= 0.0 || (inner < 0.0 && qc > 0.0 && b.flat.length_squared() >= squared) {
            return None;
        }
        let inner = inner.max(0.0).sqrt();
        Some((if out { inner - qb } else { -inner - qb }) / qa)
    }
}

#[inline]
fn angle(at: Seen) -> f64 {
    at.flat.y.atan2(at.flat.x)
}

/// The half-edge by which a curve leaves the face that it enters by `half_edge`, from what is kept: 0 the same, 1 the next, 2 the one
/// before.
#[inline]
pub(super) const fn turned(half_edge: u32, turn: u32) -> u32 {
    match turn {
        1 => next(half_edge),
        2 => prev(half_edge),
        _ => half_edge,
    }
}
