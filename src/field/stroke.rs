//! Combing: what a stroke over the surface asks for.
//!
//! A stroke is the way that a pointer took, point by point on the surface. It becomes constraints along it ([`stroke`]), and what
//! was asked for before where it passes gives way ([`overrule`]).
//!
//! 1. The way is measured by its length. A constraint stands at its beginning and its end, and between them wherever a radius of
//!    the comb has passed, or the way has turned by more than [`TURN`].
//! 2. The direction at a place is that of the chord over half a radius to both sides, laid into the face: hands tremble.
//! 3. Each constraint reaches as far as the comb's radius.

use super::constraints::{Anchor, Constraint, Constraints};
use crate::mesh::transport::projected;
use crate::mesh::{Mesh, SurfacePoint};
use glam::DVec3;

/// A bend by more than this, radians, gets a constraint of its own: the field between two constraints turns evenly.
pub const TURN: f64 = 0.3;

/// Constraints stand no closer than this share of the radius, however the way turns: what is closer is trembling.
const CLOSEST: f64 = 0.25;

/// The way is looked at in steps of this share of the radius.
const STEP: f64 = 0.125;

/// A way shorter than this share of the radius says no direction: it is a click.
const SHORTEST: f64 = 0.25;

/// At most so many steps are looked at; a longer way is looked at in longer steps.
const MOST_STEPS: usize = 4096;

/// What a stroke wishes for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// Texture up along the stroke.
    Direction,
    /// A scale relative to the base scale.
    Scale(f64),
}

/// A comb.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comb {
    /// How far the constraints reach: their extent, world units.
    pub radius: f64,
    /// Their weight.
    pub weight: f64,
    /// What they wish for.
    pub wish: Wish,
}

/// A constraint that a stroke has left, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Dab {
    /// The place.
    pub at: SurfacePoint,
    /// The constraint.
    pub constraint: Constraint,
}

/// The constraints of a stroke along a way. A way too short to have a direction gives none, unless it wishes for a scale.
#[must_use]
pub fn stroke(mesh: &Mesh, way: &[SurfacePoint], comb: &Comb) -> Vec<Dab> {
    let usable = |x: f64| x.is_normal() && x > 0.0;
    let Some(way) = Way::new(mesh, way).filter(|_| usable(comb.radius) && usable(comb.weight)) else { return Vec::new() };
    if way.length() < SHORTEST * comb.radius {
        return match comb.wish {
            Wish::Direction => Vec::new(),
            Wish::Scale(_) => vec![comb.dab(mesh, way.at(0.0), DVec3::ZERO)],
        };
    }
    let steps = (way.length() / (STEP * comb.radius)).ceil().min(MOST_STEPS as f64) as usize;
    let mut dabs: Vec<Dab> = Vec::new();
    // Where the last constraint stands, and which way the stroke ran there.
    let mut last: Option<(f64, DVec3)> = None;
    for step in 0..=steps {
        let s = way.length() * step as f64 / steps as f64;
        let at = way.at(s);
        let normal = mesh.normal(at.face);
        let Some(along) = projected(way.chord(s, 0.5 * comb.radius), normal).try_normalize() else { continue };
        if let Some((before, was)) = last {
            let passed = s - before;
            let turned = projected(was, normal).try_normalize().is_some_and(|w| w.dot(along) < TURN.cos());
            let due = passed >= comb.radius || turned || step == steps;
            if passed < CLOSEST * comb.radius || !due {
                continue;
            }
        }
        dabs.push(comb.dab(mesh, at, along));
        last = Some((s, along));
    }
    dabs
}

/// Takes away what was asked for where new constraints stand, of the same kind and on the same side of the surface: within
/// half of the comb's radius. `anchors` are the constraints tied to the mesh, in their order. Constraints that are left with
/// nothing to say go.
pub fn overrule(constraints: &mut Constraints, anchors: &[Anchor], mesh: &Mesh, dabs: &[Dab], comb: &Comb) {
    let reach = 0.5 * comb.radius;
    let places: Vec<(DVec3, DVec3)> = dabs.iter().map(|d| (mesh.position(d.at), mesh.normal(d.at.face))).collect();
    for (constraint, anchor) in constraints.constraints.iter_mut().zip(anchors) {
        let (here, normal) = (mesh.position(anchor.at), mesh.normal(anchor.at.face));
        if places.iter().any(|&(place, n)| place.distance(here) < reach && n.dot(normal) > 0.0) {
            match comb.wish {
                // A full basis is measured against the direction.
                Wish::Direction => (constraint.direction, constraint.angle, constraint.right) = (None, None, None),
                Wish::Scale(_) => constraint.scale = None,
            }
        }
    }
    constraints.constraints.retain(|c| !c.is_empty());
}

impl Comb {
    fn dab(&self, mesh: &Mesh, at: SurfacePoint, along: DVec3) -> Dab {
        let place = Constraint {
            position: Some(mesh.position(at).to_array()),
            extent: Some(self.radius),
            weight: (self.weight != 1.0).then_some(self.weight),
            ..Constraint::default()
        };
        let constraint = match self.wish {
            Wish::Direction => Constraint { direction: Some(along.to_array()), ..place },
            Wish::Scale(scale) => Constraint { scale: Some(scale), ..place },
        };
        Dab { at, constraint }
    }
}

impl Constraint {
    /// True if it asks for nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.direction.is_none()
            && self.angle.is_none()
            && self.scale.is_none()
            && self.right.is_none()
            && self.stretch.is_none()
            && self.shear.is_none()
    }

    /// A constraint that says of itself all that its anchor was found to mean: a position instead of a face, a direction
    /// instead of an angle, its own extent.
    #[must_use]
    pub fn explicit(mesh: &Mesh, anchor: &Anchor) -> Self {
        Self {
            position: Some(mesh.position(anchor.at).to_array()),
            direction: anchor.direction.map(|d| d.to_array()),
            scale: anchor.ln_scale.map(f64::exp),
            extent: Some(anchor.extent),
            weight: (anchor.weight != 1.0).then_some(anchor.weight),
            stretch: anchor.ln_stretch.map(f64::exp),
            shear: anchor.shear,
            ..Self::default()
        }
    }
}

/// A way over the surface, measured along its length in space.
struct Way {
    places: Vec<SurfacePoint>,
    points: Vec<DVec3>,
    /// Length from the beginning to each point.
    reached: Vec<f64>,
}

impl Way {
    /// `None` of no points. Points that lie on each other count once.
    fn new(mesh: &Mesh, way: &[SurfacePoint]) -> Option<Self> {
        let mut measured = Self { places: Vec::new(), points: Vec::new(), reached: Vec::new() };
        for &place in way {
            let point = mesh.position(place);
            let step = measured.points.last().map_or(0.0, |p| p.distance(point));
            if point.is_finite() && (step > 0.0 || measured.points.is_empty()) {
                measured.reached.push(measured.length() + step);
                measured.places.push(place);
                measured.points.push(point);
            }
        }
        (!measured.points.is_empty()).then_some(measured)
    }

    fn length(&self) -> f64 {
        self.reached.last().copied().unwrap_or(0.0)
    }

    /// The point after which `s` lies.
    fn before(&self, s: f64) -> usize {
        self.reached.partition_point(|&r| r <= s).saturating_sub(1)
    }

    /// The point of the way nearest to the length `s`. Points of the pointer lie on the surface; those between need not.
    fn at(&self, s: f64) -> SurfacePoint {
        let i = self.before(s);
        let j = (i + 1).min(self.points.len() - 1);
        self.places[if s - self.reached[i] <= self.reached[j] - s { i } else { j }]
    }

    fn point(&self, s: f64) -> DVec3 {
        let i = self.before(s);
        let j = (i + 1).min(self.points.len() - 1);
        let length = self.reached[j] - self.reached[i];
        if length > 0.0 { self.points[i].lerp(self.points[j], (s - self.reached[i]) / length) } else { self.points[i] }
    }

    /// From the way `half` before `s` to `half` after it.
    fn chord(&self, s: f64, half: f64) -> DVec3 {
        self.point((s + half).min(self.length())) - self.point((s - half).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{FieldOptions, constrained};
    use crate::mesh::nearest::Nearest;
    use crate::mesh::shapes;

    /// A way over the unit sphere along a great circle, from one angle to another, with trembling of a hand.
    fn great_circle(tree: &Nearest, axis: DVec3, range: [f64; 2], tremble: f64) -> Vec<SurfacePoint> {
        let (x, y) = axis.any_orthonormal_pair();
        let count = 200;
        let at = |i: u32| {
            let a = range[0] + (range[1] - range[0]) * f64::from(i) / f64::from(count);
            let off = tremble * (f64::from(i) * 2.4).sin();
            tree.nearest(x * a.cos() + y * a.sin() + axis * off).expect("finite").at
        };
        (0..=count).map(at).collect()
    }

    fn comb(radius: f64, wish: Wish) -> Comb {
        Comb { radius, weight: 1.0, wish }
    }

    fn along(dabs: Vec<Dab>) -> Constraints {
        Constraints { constraints: dabs.into_iter().map(|d| d.constraint).collect(), ..Constraints::default() }
    }

    #[test]
    fn the_field_follows_a_stroke_along_a_great_circle() {
        let mesh = shapes::sphere(5);
        let tree = Nearest::new(&mesh);
        let axis = DVec3::new(0.3, -0.5, 1.0).normalize();
        let dabs = stroke(&mesh, &great_circle(&tree, axis, [0.2, 2.6], 0.004), &comb(0.2, Wish::Direction));
        assert!((10..=24).contains(&dabs.len()), "a constraint a radius or so: {}", dabs.len());
        let file = along(dabs);
        let anchors = file.anchors(&mesh, None, DVec3::Y, 0.3).expect("usable");
        let (field, _) = constrained(&mesh, &anchors, &FieldOptions::default()).expect("a field");
        for place in great_circle(&tree, axis, [0.25, 2.55], 0.0) {
            let wanted = axis.cross(mesh.position(place)).normalize();
            let found = field.up[place.face as usize].as_dvec3().normalize();
            let off = found.dot(wanted).clamp(-1.0, 1.0).acos().to_degrees();
            assert!(off < 8.0, "{off} degrees off the stroke at {}", mesh.position(place));
        }
    }

    #[test]
    fn the_other_way_round_turns_the_field_about() {
        let mesh = shapes::sphere(4);
        let tree = Nearest::new(&mesh);
        let mut way = great_circle(&tree, DVec3::Z, [0.0, 1.0], 0.0);
        let there = stroke(&mesh, &way, &comb(0.2, Wish::Direction));
        way.reverse();
        let back = stroke(&mesh, &way, &comb(0.2, Wish::Direction));
        let direction = |d: &Dab| DVec3::from(d.constraint.direction.expect("a direction"));
        let (first, last) = (direction(&there[0]), direction(&back[back.len() - 1]));
        assert!(first.dot(last) < -0.98, "{first} at the beginning, {last} at the end of the way back");
    }

    #[test]
    fn a_click_says_no_direction_but_a_scale() {
        let mesh = shapes::sphere(3);
        let way = [SurfacePoint { face: 5, bary: glam::Vec3::splat(1.0 / 3.0) }; 3];
        assert!(stroke(&mesh, &way, &comb(0.2, Wish::Direction)).is_empty(), "no direction");
        let dabs = stroke(&mesh, &way, &comb(0.2, Wish::Scale(2.0)));
        assert_eq!(dabs.len(), 1, "one place");
        assert_eq!(dabs[0].constraint.scale, Some(2.0), "{dabs:?}");
        assert!(stroke(&mesh, &[], &comb(0.2, Wish::Scale(2.0))).is_empty(), "no way at all");
    }

    #[test]
    fn a_second_stroke_over_the_first_takes_its_place_and_leaves_other_wishes() {
        let mesh = shapes::sphere(5);
        let tree = Nearest::new(&mesh);
        let way = great_circle(&tree, DVec3::Z, [0.0, 2.0], 0.0);
        let directions = comb(0.2, Wish::Direction);
        let first = stroke(&mesh, &way, &directions);
        let mut file = along(first.clone());
        file.constraints[0].scale = Some(2.0);
        let anchors = file.anchors(&mesh, None, DVec3::Y, 0.3).expect("usable");
        overrule(&mut file, &anchors, &mesh, &first, &directions);
        assert_eq!(file.constraints.len(), 1, "all but the scale are gone: {file:?}");
        assert_eq!((file.constraints[0].scale, file.constraints[0].direction), (Some(2.0), None), "only the scale stays");
        let mut far = along(stroke(&mesh, &great_circle(&tree, DVec3::Z, [4.0, 5.0], 0.0), &directions));
        let before = far.clone();
        let anchors = far.anchors(&mesh, None, DVec3::Y, 0.3).expect("usable");
        overrule(&mut far, &anchors, &mesh, &first, &directions);
        assert_eq!(far, before, "what the stroke does not pass stays");
    }
}
