//! Where the picture is taken from: a [`View`] says it in angles, independent of any mesh; framing a mesh with it gives a
//! [`Camera`] in world coordinates.
//!
//! The frame is exact: the smallest distance at which every point lies inside the picture, found from the points' extents
//! along the four side planes of the view pyramid. Everything is in double precision and relative to the mesh, so meshes
//! of any size and far from the origin look the same.

use super::RenderError;
use crate::mesh::Mesh;
use glam::{DQuat, DVec3};
use std::str::FromStr;

/// Share of the picture's half width and half height left free around a framed mesh.
const MARGIN: f64 = 0.07;

/// The near plane's distance as a share of the distance from the eye to the middle of what is framed.
const NEAR: f64 = 1e-4;

/// How points are projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Lines meet at the eye; the tangent of half the vertical angle of view.
    Perspective(f64),
    /// Lines are parallel; half the height of the picture in world units.
    Orthographic(f64),
}

/// Which way is up in the mesh's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// Y up, looking from +Z is the front: glTF and most others.
    #[default]
    Y,
    /// Z up, looking from -Y is the front: CAD, scanners, some modellers.
    Z,
}

/// A direction of view, independent of any mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Turn about the up axis, radians: 0 looks at the front, a quarter turn at the side on the viewer's right.
    pub yaw: f64,
    /// Height of the eye above the horizon, radians, -pi/2 to pi/2.
    pub pitch: f64,
    /// Magnification about the picture's middle; 1 just shows everything.
    pub zoom: f64,
    /// Vertical angle of view, radians; `None` is a parallel projection.
    pub angle: Option<f64>,
    /// Which way is up.
    pub up: UpAxis,
    /// The point in the world that is shown in the picture's middle; `None` shows the middle of everything.
    pub at: Option<DVec3>,
}

/// An eye in the world. The three axes are orthonormal; `right`, `up` and `-forward` are a right-handed frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye, world units.
    pub eye: DVec3,
    /// Towards the picture's right.
    pub right: DVec3,
    /// Towards the picture's top.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
    /// How points are projected.
    pub projection: Projection,
    /// Nothing nearer than this along `forward` is seen, world units.
    pub near: f64,
    /// Up in the world, for lights and ground.
    pub world_up: DVec3,
}

impl View {
    /// A view from a yaw and a pitch in degrees, with the standard lens.
    #[must_use]
    pub const fn degrees(yaw: f64, pitch: f64) -> Self {
        /// A longer lens than the eye's: little distortion, still some depth.
        const ANGLE: f64 = 28.0;
        Self {
            yaw: yaw.to_radians(),
            pitch: pitch.to_radians(),
            zoom: 1.0,
            angle: Some(ANGLE.to_radians()),
            up: UpAxis::Y,
            at: None,
        }
    }

    /// The named view, if there is one: `front`, `back`, `side` (or `right`), `left`, `top`, `bottom`, `three-quarter`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let (yaw, pitch) = match name {
            "front" => (0.0, 0.0),
            "back" => (180.0, 0.0),
            "side" | "right" => (90.0, 0.0),
            "left" => (-90.0, 0.0),
            "top" => (0.0, 90.0),
            "bottom" => (0.0, -90.0),
            "three-quarter" => (35.0, 20.0),
            _ => return None,
        };
        Some(Self::degrees(yaw, pitch))
    }

    /// What is seen, in words: `front right, from above`.
    #[must_use]
    pub fn describe(&self) -> String {
        const SIDES: [&str; 8] = ["front", "front right", "right", "back right", "back", "back left", "left", "front left"];
        /// Heights of the eye, degrees, from which it counts as raised, as high, and as straight above.
        const HEIGHTS: [f64; 3] = [12.0, 45.0, 80.0];
        let height = self.pitch.to_degrees();
        let steps = HEIGHTS.iter().filter(|&&h| height.abs() >= h).count();
        let eighth = (self.yaw.to_degrees() / 45.0).round().rem_euclid(8.0) as usize;
        let side = SIDES[eighth % 8];
        match (steps, height > 0.0) {
            (0, _) => side.to_owned(),
            (1, true) => format!("{side}, from above"),
            (1, false) => format!("{side}, from below"),
            (2, true) => format!("{side}, from high above"),
            (2, false) => format!("{side}, from far below"),
            (_, true) => "top".to_owned(),
            (_, false) => "bottom".to_owned(),
        }
    }

    /// The cameras of a full turn about the mesh's vertical axis in `count` equal steps, this view first. All stand equally
    /// far off, where the mesh stays in the picture as it turns.
    #[must_use]
    pub fn turntable(&self, mesh: &Mesh, aspect: f64, count: u32) -> Vec<Camera> {
        /// Places around the axis at which the turning mesh is looked at.
        const AROUND: u32 = 48;
        /// Slices of the mesh's height, each as wide as its widest point.
        const SLICES: usize = 64;
        let axis = match self.up {
            UpAxis::Y => DVec3::Y,
            UpAxis::Z => DVec3::Z,
        };
        let across = axis.any_orthonormal_vector();
        let (low, high) = mesh.bounds();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let middle = 0.5 * (low + high);
        let height = (high - low).dot(axis);
        let mut widest: [Option<f64>; SLICES] = [None; SLICES];
        for p in mesh.faces.as_flattened().iter().map(|&v| mesh.point(v) - middle) {
            let part = p.dot(axis) / height.max(f64::MIN_POSITIVE) + 0.5;
            let slice = &mut widest[((part * SLICES as f64) as usize).min(SLICES - 1)];
            let radius = (p - axis * p.dot(axis)).length();
            *slice = Some(slice.map_or(radius, |r| r.max(radius)));
        }
        let ring = |(slice, radius): (usize, f64)| {
            [slice, slice + 1].into_iter().flat_map(move |edge| {
                let up = axis * (height * (edge as f64 / SLICES as f64 - 0.5));
                (0..AROUND).map(move |k| {
                    let turn = DQuat::from_axis_angle(axis, std::f64::consts::TAU * f64::from(k) / f64::from(AROUND));
                    middle + up + turn * across * radius
                })
            })
        };
        let swept = widest.iter().enumerate().filter_map(|(slice, radius)| radius.map(|r| (slice, r))).flat_map(ring);
        let first = self.frame_points(swept, aspect);
        let turned = |k: u32| {
            let turn = DQuat::from_axis_angle(axis, std::f64::consts::TAU * f64::from(k) / f64::from(count.max(1)));
            let [right, up, forward] = [first.right, first.up, first.forward].map(|v| turn * v);
            Camera { eye: middle + turn * (first.eye - middle), right, up, forward, ..first }
        };
        (0..count).map(turned).collect()
    }

    /// The camera that shows all of a mesh's faces in a picture whose width is `aspect` times its height.
    #[must_use]
    pub fn frame(&self, mesh: &Mesh, aspect: f64) -> Camera {
        self.frame_points(mesh.faces.as_flattened().iter().map(|&v| mesh.point(v)), aspect)
    }

    /// The camera that shows all the points. Without points it looks at the origin from a unit away.
    #[must_use]
    pub fn frame_points(&self, points: impl Iterator<Item = DVec3>, aspect: f64) -> Camera {
        let turn = |v: DVec3| match self.up {
            UpAxis::Y => v,
            UpAxis::Z => DVec3::new(v.x, -v.z, v.y),
        };
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        let backward = DVec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        let up = backward.cross(right);
        let (right, up, forward) = (turn(right), turn(up), -turn(backward));

        let tangent = self.angle.map_or(0.0, |angle| (0.5 * angle).tan()) * (1.0 - MARGIN);
        let slope = DVec3::new(tangent * aspect, tangent, 0.0);
        let mut extent = Extent::default();
        let mut first = None;
        for p in points {
            // Relative to the first point: the extents keep their precision far from the origin.
            let p = p - *first.get_or_insert(p);
            extent.add(DVec3::new(p.dot(right), p.dot(up), p.dot(forward)), slope);
        }
        let Some(first) = first else {
            extent.add(DVec3::ZERO, slope);
            return self.place(DVec3::ZERO, [right, up, forward], turn(DVec3::Y), &extent, aspect);
        };
        self.place(first, [right, up, forward], turn(DVec3::Y), &extent, aspect)
    }

    fn place(&self, origin: DVec3, axes: [DVec3; 3], world_up: DVec3, extent: &Extent, aspect: f64) -> Camera {
        let [right, up, forward] = axes;
        let middle = 0.5 * (extent.high - extent.low);
        let size = extent.low + extent.high;
        // Something to stand off from even if all points are one.
        let reach = if size.max_element() > 0.0 { size.length() } else { 1.0 };
        let zoom = self.zoom.clamp(1e-3, 1e3);
        let (at, projection, distance) = match self.angle {
            Some(angle) => {
                let tangent = (0.5 * angle).tan();
                let inner = tangent * (1.0 - MARGIN);
                let [back_x, back_y] = [(0, inner * aspect), (1, inner)]
                    .map(|(axis, slope)| 0.5 * (extent.plane_high[axis] + extent.plane_low[axis]) / slope);
                // Never nearer to the nearest point than a small part of the whole: a flat mesh seen edge-on.
                let back = back_x.max(back_y).max(extent.low.z + 0.05 * reach);
                let x = 0.5 * (extent.plane_high.x - extent.plane_low.x);
                let y = 0.5 * (extent.plane_high.y - extent.plane_low.y);
                (DVec3::new(x, y, -back), Projection::Perspective(tangent / zoom), back + middle.z)
            }
            None => {
                let half = 0.5 * size.y.max(size.x / aspect) / (1.0 - MARGIN);
                let half = if half > 0.0 { half } else { 0.5 * reach };
                let back = extent.low.z + reach;
                (DVec3::new(middle.x, middle.y, -back), Projection::Orthographic(half / zoom), back + middle.z)
            }
        };
        let mut eye = origin + right * at.x + up * at.y + forward * at.z;
        if let Some(aim) = self.at {
            // Moved aside only: what is shown grows neither larger nor smaller.
            eye += right * (aim - eye).dot(right) + up * (aim - eye).dot(up);
        }
        Camera { eye, right, up, forward, projection, near: NEAR * distance, world_up }
    }
}

/// How far points reach: along the axes of view, and along the normals of the side planes of the view pyramid.
struct Extent {
    low: DVec3,
    high: DVec3,
    plane_low: DVec3,
    plane_high: DVec3,
}

impl Default for Extent {
    fn default() -> Self {
        let none = DVec3::NEG_INFINITY;
        Self { low: none, high: none, plane_low: none, plane_high: none }
    }
}

impl Extent {
    /// `low` is the reach in the negative direction. A point is inside the pyramid of an eye at e when
    /// `|p.x - e.x| <= slope.x (p.z - e.z)`: so `p.x - slope.x p.z` and `-p.x - slope.x p.z` bound where e can be.
    fn add(&mut self, p: DVec3, slope: DVec3) {
        self.low = self.low.max(-p);
        self.high = self.high.max(p);
        let shift = slope * p.z;
        self.plane_low = self.plane_low.max(-p - shift);
        self.plane_high = self.plane_high.max(p - shift);
    }
}

impl Camera {
    /// A world point relative to the eye along right, up and forward.
    #[inline]
    #[must_use]
    pub fn to_view(&self, p: DVec3) -> DVec3 {
        let p = p - self.eye;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    /// The ray through a place on the picture plane: its start and its direction, whose part along `forward` is 1.
    /// `plane` is (0, 0) at the picture's middle and (.., 1) at its top.
    #[inline]
    #[must_use]
    pub fn ray(&self, plane: [f64; 2]) -> (DVec3, DVec3) {
        let aside = |scale: f64| self.right * (plane[0] * scale) + self.up * (plane[1] * scale);
        match self.projection {
            Projection::Perspective(tangent) => (self.eye, self.forward + aside(tangent)),
            Projection::Orthographic(half) => (self.eye + aside(half), self.forward),
        }
    }
}

impl Default for View {
    fn default() -> Self {
        Self::degrees(35.0, 20.0)
    }
}

impl FromStr for View {
    type Err = RenderError;

    /// Reads a view as the command line has it: names and `key=value` pairs joined by commas, later ones winning. Angles
    /// are in degrees. Keys: `yaw`, `pitch`, `zoom`, `fov` (0: parallel projection), `up` (`y` or `z`), `at` (the point to
    /// aim at: three numbers).
    fn from_str(text: &str) -> Result<Self, RenderError> {
        let fail = |reason: String| RenderError::Camera { text: text.to_owned(), reason };
        let mut view = Self::default();
        let mut parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
        while let Some(part) = parts.next() {
            let Some((key, value)) = part.split_once('=') else {
                let named = Self::named(part).ok_or_else(|| {
                    fail(format!("{part:?} is no view: there are front, back, side, left, top, bottom and three-quarter"))
                })?;
                (view.yaw, view.pitch) = (named.yaw, named.pitch);
                continue;
            };
            let (key, value) = (key.trim(), value.trim());
            if key == "up" {
                view.up = match value {
                    "y" | "Y" => UpAxis::Y,
                    "z" | "Z" => UpAxis::Z,
                    _ => return Err(fail(format!("up is y or z, not {value:?}"))),
                };
                continue;
            }
            if key == "at" {
                let numbers = [Some(value), parts.next(), parts.next()].map(|n| n.and_then(|n| n.parse::<f64>().ok()));
                view.at = match numbers {
                    [Some(x), Some(y), Some(z)] if x.is_finite() && y.is_finite() && z.is_finite() => Some(DVec3::new(x, y, z)),
                    _ => return Err(fail("at needs three numbers, as in at=0,1.5,0".to_owned())),
                };
                continue;
            }
            let (low, high) = match key {
                "yaw" => (-3600.0, 3600.0),
                "pitch" => (-90.0, 90.0),
                "zoom" => (0.01, 100.0),
                "fov" => (0.0, 120.0),
                _ => return Err(fail(format!("{key:?} is no setting: there are yaw, pitch, zoom, fov, up and at"))),
            };
            let number: f64 = value.parse().map_err(|_| fail(format!("{key} needs a number, not {value:?}")))?;
            if !(low..=high).contains(&number) {
                return Err(fail(format!("{key} is {number}, but must lie between {low} and {high}")));
            }
            match key {
                "yaw" => view.yaw = number.to_radians(),
                "pitch" => view.pitch = number.to_radians(),
                "zoom" => view.zoom = number,
                // Below a tenth of a degree perspective is numerically and visibly parallel.
                _ => view.angle = (number >= 0.1).then(|| number.to_radians()),
            }
        }
        Ok(view)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn cloud(scale: f64, shift: DVec3) -> Vec<DVec3> {
        let mut r = Random::new(3, 0);
        (0..300).map(|_| DVec3::new(r.range(-1.0, 1.0), r.range(-0.3, 2.0), r.range(-0.7, 0.4)) * scale + shift).collect()
    }

    /// Largest |x| and |y| on the picture, 1 at its border.
    fn reach(camera: &Camera, points: &[DVec3], aspect: f64) -> [f64; 4] {
        let mut out = [f64::NEG_INFINITY; 4];
        for &p in points {
            let v = camera.to_view(p);
            assert!(v.z > camera.near, "every framed point lies in front of the near plane");
            let s = match camera.projection {
                Projection::Perspective(t) => t * v.z,
                Projection::Orthographic(h) => h,
            };
            let (x, y) = (v.x / s / aspect, v.y / s);
            out = [out[0].max(x), out[1].max(-x), out[2].max(y), out[3].max(-y)];
        }
        out
    }

    #[test]
    fn the_frame_is_tight_and_centred_at_every_size_and_place() {
        for (scale, shift) in [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1e6, DVec3::ZERO), (1.0, DVec3::splat(1e5))] {
            let points = cloud(scale, shift);
            for name in ["front", "back", "side", "left", "top", "bottom", "three-quarter"] {
                for fov in [0.0, 28.0, 90.0] {
                    for aspect in [0.5, 1.0, 2.0] {
                        let view: View = format!("{name},fov={fov}").parse().unwrap();
                        let camera = view.frame_points(points.iter().copied(), aspect);
                        let [right, left, top, bottom] = reach(&camera, &points, aspect);
                        let tightest = right.max(left).max(top).max(bottom);
                        assert!((tightest - (1.0 - MARGIN)).abs() < 1e-6, "{name} {fov} {aspect} {scale}: {tightest}");
                        let (dx, dy) = ((right - left).abs(), (top - bottom).abs());
                        assert!(dx.min(dy) < 1e-6, "{name} {fov} {aspect}: the tighter direction is centred, not off by {dx} {dy}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_aim_is_in_the_middle_and_sizes_stay() {
        let points = cloud(1.0, DVec3::ZERO);
        let plain = View::degrees(35.0, 20.0);
        let aim = points[17];
        let (from, to) = (
            plain.frame_points(points.iter().copied(), 1.5),
            View { at: Some(aim), ..plain }.frame_points(points.iter().copied(), 1.5),
        );
        let there = to.to_view(aim);
        assert!(there.x.abs() < 1e-12 && there.y.abs() < 1e-12, "in the middle: {there}");
        assert!((from.to_view(aim).z - there.z).abs() < 1e-12, "as far away as before");
    }

    #[test]
    fn on_a_turntable_the_mesh_stays_in_the_picture_and_the_eye_comes_round() {
        let mesh = crate::mesh::shapes::torus(24, 12, 1.0, 0.3);
        let cameras = View::degrees(10.0, 25.0).turntable(&mesh, 1.3, 12);
        for camera in &cameras {
            let [right, left, top, bottom] = reach(camera, &mesh.positions.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>(), 1.3);
            assert!(right.max(left).max(top).max(bottom) <= 1.0 - MARGIN + 1e-9, "inside the margin");
        }
        let distance = |c: &Camera| c.eye.length();
        assert!(cameras.iter().all(|c| (distance(c) - distance(&cameras[0])).abs() < 1e-9), "equally far off");
        assert!((cameras[6].forward.dot(DVec3::Y) - cameras[0].forward.dot(DVec3::Y)).abs() < 1e-12, "at one height");
        let level = |c: &Camera| (c.forward - DVec3::Y * c.forward.y).normalize();
        assert!(level(&cameras[6]).dot(level(&cameras[0])) < -0.999, "half way round after half of the steps");
    }

    #[test]
    fn views_have_names() {
        let name = |yaw, pitch| View::degrees(yaw, pitch).describe();
        assert_eq!(name(0.0, 0.0), "front", "straight on");
        assert_eq!(name(30.0, 18.0), "front right, from above", "three quarters");
        assert_eq!(name(-95.0, -20.0), "left, from below", "negative turns");
        assert_eq!(name(725.0, 60.0), "front, from high above", "more than a turn");
        assert_eq!(name(10.0, 90.0), "top", "straight down");
    }

    #[test]
    fn the_axes_are_right_handed_and_yaw_turns_to_the_right() {
        for up in [UpAxis::Y, UpAxis::Z] {
            let mut view = View::degrees(35.0, 20.0);
            view.up = up;
            let c = view.frame_points(cloud(1.0, DVec3::ZERO).into_iter(), 1.0);
            assert!((c.right.cross(c.up) + c.forward).length() < 1e-12, "right x up points at the viewer");
            assert!(c.up.dot(c.world_up) > 0.5, "the world's up is up in the picture");
        }
        let side = View::degrees(90.0, 0.0).frame_points(cloud(1.0, DVec3::ZERO).into_iter(), 1.0);
        assert!(side.forward.dot(DVec3::NEG_X) > 0.999, "a quarter turn looks from +x");
    }

    #[test]
    fn strings_are_read_and_wrong_ones_say_what_is_wrong() {
        let view: View = "back, zoom=1.5, fov=0, up=z".parse().unwrap();
        assert_eq!((view.zoom, view.angle, view.up), (1.5, None, UpAxis::Z), "settings");
        assert!((view.yaw - std::f64::consts::PI).abs() < 1e-12, "yaw of the named view");
        let aimed: View = "at=1, -2,0.5,zoom=3".parse().unwrap();
        assert_eq!((aimed.at, aimed.zoom), (Some(DVec3::new(1.0, -2.0, 0.5)), 3.0), "a point holds commas");
        for (text, word) in [
            ("at=1,2", "three"),
            ("yaw=x", "number"),
            ("spin=3", "spin"),
            ("pitch=120", "90"),
            ("upside", "upside"),
            ("zoom=NaN", "zoom"),
        ] {
            let message = text.parse::<View>().unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
