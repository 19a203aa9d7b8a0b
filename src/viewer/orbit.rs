//! A camera that goes around a point: turned, moved aside and brought nearer by hand.

use crate::job::project::ProjectView;
use crate::mesh::Mesh;
use crate::render::{Camera, Projection, UpAxis, View};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Radians a point of dragging turns.
const TURN: f64 = 0.008;
/// Nearest and farthest distance, as multiples of the distance that shows everything.
const DISTANCES: [f64; 2] = [1e-3, 50.0];
/// Points of a mesh that are looked at to frame it; beyond, every so many are.
const FRAMED: usize = 100_000;
/// Radians a second of the turntable.
const TURNTABLE: f64 = 0.6;
/// The near plane's distance as a share of the eye's from the point looked at.
const NEAR: f64 = 1e-4;

/// A camera around a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Turn about the up axis, radians; 0 looks at the front.
    pub yaw: f64,
    /// Height above the horizon, radians.
    pub pitch: f64,
    /// The point looked at.
    pub at: DVec3,
    /// Distance of the eye from it.
    pub distance: f64,
    /// Which way is up.
    pub up: UpAxis,
    /// The distance that shows everything.
    whole: f64,
}

impl Default for Orbit {
    fn default() -> Self {
        let View { yaw, pitch, up, .. } = View::default();
        Self { yaw, pitch, at: DVec3::ZERO, distance: 4.0, up, whole: 4.0 }
    }
}

impl Orbit {
    fn view(&self) -> View {
        View { yaw: self.yaw, pitch: self.pitch, up: self.up, ..View::default() }
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        // The axes of the view, from where it would frame a point.
        let framed = self.view().frame_points(std::iter::once(self.at), 1.0);
        let tangent = self.view().angle.map_or(1.0, |angle| (0.5 * angle).tan());
        let eye = self.at - framed.forward * self.distance;
        Camera { eye, projection: Projection::Perspective(tangent), near: NEAR * self.distance, ..framed }
    }

    /// Looks at all of a mesh from where it stands.
    pub fn frame(&mut self, mesh: &Mesh, aspect: f64) {
        let step = mesh.positions.len().div_ceil(FRAMED).max(1);
        let camera = self.view().frame_points(mesh.positions.iter().step_by(step).map(|p| p.as_dvec3()), aspect);
        let (low, high) = mesh.bounds();
        let middle = 0.5 * (low.as_dvec3() + high.as_dvec3());
        self.distance = (middle - camera.eye).dot(camera.forward).max(f64::MIN_POSITIVE);
        self.at = camera.eye + camera.forward * self.distance;
        self.whole = self.distance;
    }

    /// Turned by a drag of so many points.
    pub fn turn(&mut self, x: f64, y: f64) {
        self.yaw = (self.yaw - x * TURN).rem_euclid(TAU);
        self.pitch = (self.pitch + y * TURN).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Goes around by itself for so many seconds.
    pub fn turntable(&mut self, seconds: f64) {
        self.yaw = (self.yaw + seconds * TURNTABLE).rem_euclid(TAU);
    }

    /// Moved aside so that what is looked at follows a drag of so many points in a picture that is `height` points high.
    pub fn pan(&mut self, x: f64, y: f64, height: f64) {
        let camera = self.camera();
        let Projection::Perspective(tangent) = camera.projection else { return };
        let unit = 2.0 * tangent * self.distance / height.max(1.0);
        self.at += (camera.up * y - camera.right * x) * unit;
    }

    /// Brought nearer by a factor above 1, or farther.
    pub fn zoom(&mut self, factor: f64) {
        let [nearest, farthest] = DISTANCES.map(|d| d * self.whole);
        self.distance = (self.distance / factor.clamp(0.1, 10.0)).clamp(nearest, farthest);
    }

    /// As it is saved.
    #[must_use]
    pub fn saved(&self) -> ProjectView {
        let z_up = self.up == UpAxis::Z;
        ProjectView { turn: [self.yaw, self.pitch], at: self.at.into(), distance: self.distance, z_up }
    }

    /// As it was saved.
    #[must_use]
    pub fn restored(view: &ProjectView) -> Self {
        let ProjectView { turn: [yaw, pitch], at, distance, z_up } = *view;
        let up = if z_up { UpAxis::Z } else { UpAxis::Y };
        Self { yaw, pitch, at: at.into(), distance, up, whole: distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn framing_shows_what_a_picture_of_that_view_shows() {
        let mesh = shapes::torus(24, 12, 1.0, 0.3);
        let mut orbit = Orbit { yaw: 0.7, pitch: 0.3, ..Orbit::default() };
        orbit.frame(&mesh, 1.4);
        let expected = View { yaw: 0.7, pitch: 0.3, ..View::default() }.frame(&mesh, 1.4);
        let camera = orbit.camera();
        assert!((camera.eye - expected.eye).length() < 1e-6 * expected.eye.length(), "{camera:?} {expected:?}");
        assert!((camera.forward - expected.forward).length() < 1e-9, "the same way");
    }

    #[test]
    fn what_is_under_the_hand_follows_it() {
        let mut orbit = Orbit { at: DVec3::new(1.0, 2.0, 3.0), ..Orbit::default() };
        let point = orbit.at;
        orbit.pan(30.0, -12.0, 600.0);
        let seen = orbit.camera().to_view(point);
        let Projection::Perspective(tangent) = orbit.camera().projection else { unreachable!("always perspective") };
        let pixel = |v: f64| v / seen.z / tangent * 300.0;
        assert!((pixel(seen.x) - 30.0).abs() < 1e-9 && (pixel(seen.y) - 12.0).abs() < 1e-9, "{seen}");
        let again = Orbit::restored(&orbit.saved());
        assert_eq!(again.camera(), orbit.camera(), "saved and restored");
    }
}
