//! Which part of a model a region covers, and how strongly: by names of faces, vertex colours, or a mask over the model's
//! own texture coordinates.
//!
//! The result is a weight at each corner of each face of the clean mesh, 0 to 1. Names give whole faces; a soft border then
//! falls off over a distance along the surface, outside of them. Colours and masks are as soft as they are painted, and as
//! fine as the faces: they are read at the corners.

use super::base::hex_color;
use crate::exemplar::Image;
use crate::format::{FaceGroup, Model};
use crate::mesh::geodesic::Geodesic;
use crate::mesh::{Cleaned, Mesh, NONE, SurfacePoint};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;
use std::str::FromStr;

/// A colour matches fully up to this share of the tolerance, and not at all from the tolerance on.
const FULL_MATCH: f32 = 0.5;

/// How far a vertex colour may be from the one asked for, by default: a quarter of the way from black to white.
pub const TOLERANCE: f32 = 0.25;

/// Corners with a smaller weight show nothing in an 8-bit picture.
const NOTHING: f32 = 1.0 / 512.0;

/// Names of one kind that an error lists.
const MOST_NAMES: usize = 8;

/// What a region covers.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Area {
    /// All of the model.
    #[default]
    Everything,
    /// Faces whose name of this kind matches; `*` stands for any letters.
    Named(NameKind, String),
    /// Where the vertex colour (sRGB, 0 to 1) is nearer than the tolerance.
    Color {
        /// The colour.
        color: Vec3,
        /// Distance at which nothing is left; black and white are 1 apart.
        tolerance: f32,
    },
    /// A component of the vertex colour is the weight: 0 red, 1 green, 2 blue, 3 alpha.
    Component(usize),
    /// A grey image over the model's texture coordinates is the weight.
    Mask(Image),
}

/// Kinds of names that faces have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameKind {
    /// Object, or node of a scene.
    Object,
    /// Group within the object.
    Group,
    /// Material.
    Material,
}

impl NameKind {
    fn of(self, group: &FaceGroup) -> &str {
        match self {
            Self::Object => &group.object,
            Self::Group => &group.group,
            Self::Material => &group.material,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Group => "group",
            Self::Material => "material",
        }
    }
}

/// Why a region covers nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AreaError {
    /// No face has such a name.
    #[error("no face has a {kind} named {wanted:?}: {there}")]
    NoName {
        /// Kind of name.
        kind: &'static str,
        /// The name asked for.
        wanted: String,
        /// The names there are, and what to do.
        there: String,
    },
    /// The model lacks what the region goes by.
    #[error("the mesh has no {0}, by which this region is chosen: export it with them, or choose the region by a name")]
    Lacks(&'static str),
    /// The weight is 0 everywhere.
    #[error("this region is empty: its weight is 0 on every face; check the {0}")]
    Empty(&'static str),
    /// A border that is no length.
    #[error("a border of {0} is no length: give world units, 0 or more")]
    Border(f64),
    /// A border where softness is painted.
    #[error("a border of {0} goes with objects, groups and materials only: paint soft edges into the colours or the mask")]
    PaintedBorder(f64),
}

impl Area {
    /// The weight at each corner of each face of the clean mesh. `None`: 1 everywhere.
    ///
    /// # Errors
    /// If the model lacks what the area goes by, or nothing is chosen.
    pub fn weights(&self, model: &Model, cleaned: &Cleaned, border: f64) -> Result<Option<Vec<[f32; 3]>>, AreaError> {
        if !(border >= 0.0 && border.is_finite()) {
            return Err(AreaError::Border(border));
        }
        let weights = match self {
            Self::Everything => return Ok(None),
            Self::Named(kind, pattern) => {
                let inside = named_faces(model, cleaned, *kind, pattern)?;
                if border > 0.0 { soft(&cleaned.mesh, &inside, border) } else { hard(&inside) }
            }
            _ if border > 0.0 => return Err(AreaError::PaintedBorder(border)),
            Self::Color { color, tolerance } => {
                let colors = model.colors.as_ref().ok_or(AreaError::Lacks("vertex colours"))?;
                let near = |v: u32| {
                    let srgb = colors[v as usize].truncate().to_array().map(crate::exemplar::srgb::encode);
                    let distance = Vec3::from(srgb).distance(*color) / 3_f32.sqrt();
                    ((tolerance - distance) / (tolerance * (1.0 - FULL_MATCH))).clamp(0.0, 1.0)
                };
                at_corners(model, cleaned, near)
            }
            Self::Component(k) => {
                let colors = model.colors.as_ref().ok_or(AreaError::Lacks("vertex colours"))?;
                at_corners(model, cleaned, |v| colors[v as usize][*k])
            }
            Self::Mask(mask) => {
                let uvs = model.uvs.as_ref().ok_or(AreaError::Lacks("texture coordinates"))?;
                let size = Vec2::from(mask.size().map(|s| s as f32));
                // Beyond the image it is repeated, as by default in glTF; 1 itself is its last pixel.
                let inside = |t: f32| if (0.0..=1.0).contains(&t) { t } else { t.rem_euclid(1.0) };
                let read = |v: u32| {
                    let Vec2 { x, y } = uvs[v as usize];
                    mask.bilinear(Vec2::new(inside(x), inside(y)) * size).x
                };
                at_corners(model, cleaned, read)
            }
        };
        if weights.as_flattened().iter().all(|&w| w < NOTHING) {
            return Err(AreaError::Empty(if matches!(self, Self::Mask(_)) { "mask" } else { "vertex colours" }));
        }
        Ok(Some(weights))
    }
}

/// True if anything of a face with these weights shows.
#[must_use]
pub fn shows(weights: &[f32; 3]) -> bool {
    weights.iter().any(|&w| w >= NOTHING)
}

/// Faces of the clean mesh with a matching name.
fn named_faces(model: &Model, cleaned: &Cleaned, kind: NameKind, pattern: &str) -> Result<Vec<bool>, AreaError> {
    let mut inside = vec![false; cleaned.mesh.face_count()];
    let mut any = false;
    for group in model.groups.iter().filter(|g| !kind.of(g).is_empty() && matches(pattern, kind.of(g))) {
        for to in &cleaned.user_faces[group.start as usize..(group.start + group.count) as usize] {
            if to.face != NONE {
                inside[to.face as usize] = true;
                any = true;
            }
        }
    }
    if any {
        return Ok(inside);
    }
    let names: BTreeSet<&str> = model.groups.iter().map(|g| kind.of(g)).filter(|n| !n.is_empty()).collect();
    let listed: Vec<String> = names.iter().take(MOST_NAMES).map(|n| format!("{n:?}")).collect();
    let more = if names.len() > MOST_NAMES { ", ..." } else { "" };
    let there = if names.is_empty() {
        format!("the mesh names no {}s; see what it has with `lapped inspect`", kind.name())
    } else {
        format!("use one of {}{more}", listed.join(", "))
    };
    Err(AreaError::NoName { kind: kind.name(), wanted: pattern.to_owned(), there })
}

/// True if a name matches a pattern in which `*` stands for any letters. What stands between two stars is found as early
/// as possible, which never hurts what follows.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((start, rest)) = pattern.split_once('*') else { return pattern == name };
    let (middle, end) = rest.rsplit_once('*').unwrap_or(("", rest));
    let Some(mut left) = name.strip_prefix(start).and_then(|tail| tail.strip_suffix(end)) else { return false };
    middle.split('*').all(|part| {
        let found = left.find(part).map(|at| &left[at + part.len()..]);
        left = found.unwrap_or(left);
        found.is_some()
    })
}

fn hard(inside: &[bool]) -> Vec<[f32; 3]> {
    inside.iter().map(|&i| [f32::from(u8::from(i)); 3]).collect()
}

/// 1 on the faces inside, from their rim falling to 0 over `border`, smoothly.
fn soft(mesh: &Mesh, inside: &[bool], border: f64) -> Vec<[f32; 3]> {
    let mut touched = vec![[false; 2]; mesh.vertex_count()];
    for (corners, &i) in mesh.faces.iter().zip(inside) {
        corners.iter().for_each(|&v| touched[v as usize][usize::from(i)] = true);
    }
    let mut sources = Vec::new();
    for (f, corners) in (0..).zip(&mesh.faces).filter(|(f, _)| inside[*f as usize]) {
        for k in (0..3).filter(|&k| touched[corners[k] as usize] == [true; 2]) {
            let mut bary = Vec3::ZERO;
            bary[k] = 1.0;
            sources.push(SurfacePoint { face: f, bary });
        }
    }
    let mut distances = Geodesic::new(mesh);
    distances.search(&sources, border);
    let weight = |v: u32| {
        let [_, member] = touched[v as usize];
        let t = if member { 0.0 } else { (distances.vertex(v) / border).min(1.0) };
        (1.0 - t * t * (3.0 - 2.0 * t)) as f32
    };
    mesh.faces.iter().map(|c| c.map(weight)).collect()
}

/// A weight per vertex of the model, at the corners of the clean mesh's faces. Of several copies of a face the first counts.
fn at_corners(model: &Model, cleaned: &Cleaned, weight: impl Fn(u32) -> f32) -> Vec<[f32; 3]> {
    let mut weights = vec![[0.0; 3]; cleaned.mesh.face_count()];
    for (corners, to) in model.faces.iter().zip(&cleaned.user_faces).rev().filter(|(_, to)| to.face != NONE) {
        for k in 0..3 {
            weights[to.face as usize][to.corners[k] as usize] = weight(corners[k]).clamp(0.0, 1.0);
        }
    }
    weights
}

/// How an area is written at the command line; the mask's file is not read here.
#[derive(Debug, Clone, PartialEq)]
pub enum Where {
    /// An area that needs no file.
    Area(Area),
    /// A mask image.
    Mask(std::path::PathBuf),
}

impl FromStr for Where {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "give everything, object=NAME, group=NAME, material=NAME, color=#RRGGBB (or #RRGGBB~0.3 with a tolerance), \
             paint=red|green|blue|alpha, or mask=FILE.png"
                .to_owned()
        };
        if text == "everything" {
            return Ok(Self::Area(Area::Everything));
        }
        let (key, value) = text.split_once('=').ok_or_else(wrong)?;
        let named = |kind| Ok(Self::Area(Area::Named(kind, value.to_owned())));
        match key.trim() {
            _ if value.is_empty() => Err(wrong()),
            "object" => named(NameKind::Object),
            "group" => named(NameKind::Group),
            "material" => named(NameKind::Material),
            "mask" => Ok(Self::Mask(value.into())),
            "paint" => {
                let components = ["red", "green", "blue", "alpha"];
                components.iter().position(|c| *c == value).map(|k| Self::Area(Area::Component(k))).ok_or_else(wrong)
            }
            "color" => {
                let (hex, tolerance) = value.split_once('~').unwrap_or((value, ""));
                let color = hex_color(hex).ok_or_else(wrong)?;
                let tolerance = if tolerance.is_empty() { TOLERANCE } else { tolerance.parse().map_err(|_| wrong())? };
                let usable = tolerance > 0.0 && tolerance <= 1.0;
                usable.then_some(Self::Area(Area::Color { color, tolerance })).ok_or_else(wrong)
            }
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Area, NameKind, Where, matches};

    #[test]
    fn stars_stand_for_any_letters() {
        for (pattern, name) in [
            ("a", "a"),
            ("*", ""),
            ("*", "b"),
            ("a*", "ab"),
            ("*b", "ab"),
            ("a*c", "abc"),
            ("a**c", "ac"),
            ("*b*d*", "abcde"),
            ("w*l*", "wall 2"),
        ] {
            assert!(matches(pattern, name), "{pattern} matches {name}");
        }
        for (pattern, name) in
            [("a", "b"), ("", "a"), ("a*", "ba"), ("*b", "bc"), ("ab*bc", "abc"), ("*x*", "abc"), ("a*b*c", "acb")]
        {
            assert!(!matches(pattern, name), "{pattern} does not match {name}");
        }
    }

    #[test]
    fn areas_are_written_as_they_are_read() {
        let named = Where::Area(Area::Named(NameKind::Material, "brick=red".into()));
        assert_eq!("material=brick=red".parse(), Ok(named), "names may hold anything");
        let color = Where::Area(Area::Color { color: glam::Vec3::new(1.0, 0.0, 0.2), tolerance: 0.5 });
        assert_eq!("color=#ff0033~0.5".parse(), Ok(color), "a colour and how far it may be");
        for wrong in ["", "red", "color=#ff", "color=#ff0000~2", "paint=ochre", "material=", "kind=x"] {
            assert!(wrong.parse::<Where>().is_err(), "{wrong:?} is no area");
        }
    }
}
