//! Symmetry: what is asked for on one side of a plane asked for on the other as well.
//!
//! Texture up is a vector like any other and is mirrored as it is. Texture right is not: a mirrored exemplar is another one, so
//! right stays to the right of up, and what leans over leans over the other way.

use super::constraints::Constraint;
use crate::mesh::Mesh;
use glam::DVec3;

/// A direction with less than this share of itself along the plane runs through it.
const THROUGH: f64 = 0.5;

/// A plane of symmetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    /// A point of the plane.
    pub through: DVec3,
    /// Its unit normal.
    pub normal: DVec3,
}

impl Mirror {
    /// The plane square to an axis (0, 1, 2: x, y, z) through the middle of a mesh's bounds.
    #[must_use]
    pub fn middle(mesh: &Mesh, axis: usize) -> Self {
        let (low, high) = mesh.bounds();
        let normal = DVec3::AXES[axis.min(2)];
        Self { through: 0.5 * (low.as_dvec3() + high.as_dvec3()), normal }
    }

    /// The mirror image of a point.
    #[must_use]
    pub fn point(&self, p: DVec3) -> DVec3 {
        p - self.normal * (2.0 * (p - self.through).dot(self.normal))
    }

    /// The mirror image of a vector.
    #[must_use]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        v - self.normal * (2.0 * v.dot(self.normal))
    }

    /// The mirror image of a constraint that has a position and no angle (see [`Constraint::explicit`]).
    #[must_use]
    pub fn constraint(&self, c: &Constraint) -> Constraint {
        let vector = |v: [f64; 3]| self.vector(DVec3::from(v));
        Constraint {
            position: c.position.map(|p| self.point(DVec3::from(p)).to_array()),
            direction: c.direction.map(|d| vector(d).to_array()),
            right: c.right.map(|r| (-vector(r)).to_array()),
            shear: c.shear.map(|s| -s),
            ..c.clone()
        }
    }

    /// A constraint and its mirror image. Nearer to the plane than `near` the two would stand against each other: there it is one
    /// constraint on the plane, whose direction runs along it; one that runs through it stays alone as it is.
    #[must_use]
    pub fn both(&self, c: &Constraint, near: f64) -> Vec<Constraint> {
        let off = c.position.map_or(f64::INFINITY, |p| (DVec3::from(p) - self.through).dot(self.normal));
        if off.abs() >= near {
            return vec![c.clone(), self.constraint(c)];
        }
        let mut one = c.clone();
        if let Some(direction) = c.direction.map(DVec3::from) {
            let along = direction - self.normal * direction.dot(self.normal);
            if along.length() < THROUGH * direction.length() {
                return vec![one];
            }
            one.direction = Some(along.to_array());
        }
        one.position = c.position.map(|p| (DVec3::from(p) - self.normal * off).to_array());
        vec![one]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constraints, FieldOptions, constrained};
    use crate::mesh::nearest::Nearest;
    use crate::mesh::shapes;

    #[test]
    fn mirrored_constraints_make_a_mirrored_field() {
        let mesh = shapes::sphere(4);
        let mirror = Mirror::middle(&mesh, 0);
        let wish = |position: [f64; 3], direction: [f64; 3]| Constraint {
            position: Some(position),
            direction: Some(direction),
            scale: Some(1.5),
            shear: Some(0.4),
            extent: Some(0.4),
            ..Constraint::default()
        };
        let one_side = [wish([0.8, 0.5, 0.3], [0.1, 0.2, 1.0]), wish([0.6, -0.6, 0.4], [1.0, 0.4, 0.3])];
        let constraints = one_side.iter().flat_map(|c| mirror.both(c, 0.05)).collect();
        let file = Constraints { constraints, ..Constraints::default() };
        let anchors = file.anchors(&mesh, None, DVec3::Y, 0.3).expect("usable");
        let (field, _) = constrained(&mesh, &anchors, &FieldOptions::default()).expect("a field");
        let tree = Nearest::new(&mesh);
        let mut looked_at = 0;
        for f in 0..mesh.face_count() as u32 {
            let place = mesh.centroid(f);
            // On the plane itself a field that crosses it has two answers.
            if place.x < 0.1 {
                continue;
            }
            let twin = tree.nearest(mirror.point(place)).expect("finite").at.face;
            let (s, t) = field.basis(&mesh, f);
            let (other_s, other_t) = field.basis(&mesh, twin);
            assert!(other_t.distance(mirror.vector(t)) < 1e-3, "up {t} at {place} became {other_t}");
            let frame = |s: DVec3, t: DVec3, f| [s.dot(t.cross(mesh.normal(f))), s.dot(t)].map(|x| x / t.length_squared());
            let (here, there) = (frame(s, t, f), frame(other_s, other_t, twin));
            assert!((here[0] - there[0]).abs() < 1e-3, "as wide on both sides: {here:?} and {there:?}");
            assert!((here[1] + there[1]).abs() < 1e-3, "leaning the other way: {here:?} and {there:?}");
            looked_at += 1;
        }
        assert!(looked_at > 800, "nearly a half of the sphere: {looked_at}");
    }

    #[test]
    fn a_full_basis_is_never_turned_inside_out() {
        let mirror = Mirror { through: DVec3::ZERO, normal: DVec3::X };
        // In the plane z = 0 seen from +z, right of +y is +x.
        let c = Constraint {
            position: Some([1.0, 0.0, 0.0]),
            direction: Some([0.2, 1.0, 0.0]),
            right: Some([2.0, 0.3, 0.0]),
            ..Constraint::default()
        };
        let m = mirror.constraint(&c);
        let [up, right] = [m.direction, m.right].map(|v| DVec3::from(v.expect("kept")));
        assert!(right.cross(up).z > 0.0, "right {right} lies right of {up}");
        let [was_up, was_right] = [c.direction, c.right].map(|v| DVec3::from(v.expect("given")));
        assert!((right.dot(up) + was_right.dot(was_up)).abs() < 1e-12, "it leans the other way");
        assert!((right.length() - was_right.length()).abs() < 1e-12, "and is as long");
    }

    #[test]
    fn on_the_plane_there_is_one_constraint_along_it() {
        let mirror = Mirror { through: DVec3::ZERO, normal: DVec3::X };
        let at = |direction: [f64; 3]| Constraint {
            position: Some([0.01, 0.0, 1.0]),
            direction: Some(direction),
            ..Constraint::default()
        };
        let both = mirror.both(&at([0.3, 1.0, 0.0]), 0.1);
        assert_eq!(both.len(), 1, "one: {both:?}");
        assert_eq!((both[0].position, both[0].direction), (Some([0.0, 0.0, 1.0]), Some([0.0, 1.0, 0.0])), "on the plane");
        assert_eq!(mirror.both(&at([1.0, 0.1, 0.0]), 0.1), [at([1.0, 0.1, 0.0])], "straight through it stays as it is");
        assert_eq!(mirror.both(&at([0.3, 1.0, 0.0]), 0.001).len(), 2, "off the plane there are two");
    }
}
