//! What detail lies over, if detail alone is pasted.

use super::bake::at_corners;
use super::error::JobError;
use crate::exemplar::{Exemplar, Image, take_detail};
use crate::field::Guide;
use crate::format::Model;
use crate::mesh::Mesh;
use crate::mesh::clean::UserFace;
use crate::paste::{BaseColor, LappedTexture, base_color, own_base};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// What detail lies over. Written as it is read: `own`, `vertex`, `#8a5a3c`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Base {
    /// What is slow in the exemplars themselves, made smooth across pastes.
    #[default]
    Own,
    /// The model's vertex colours.
    Vertex,
    /// One colour, linear.
    Color(Vec3),
}

impl FromStr for Base {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "own" => Ok(Self::Own),
            "vertex" => Ok(Self::Vertex),
            _ => hex_color(text)
                .map(|c| Self::Color(c.map(crate::exemplar::srgb::decode)))
                .ok_or_else(|| "give own, vertex, or a colour like #8a5a3c".to_owned()),
        }
    }
}

impl TryFrom<String> for Base {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Base> for String {
    fn from(base: Base) -> Self {
        base.to_string()
    }
}

impl std::fmt::Display for Base {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Own => f.write_str("own"),
            Self::Vertex => f.write_str("vertex"),
            Self::Color(color) => {
                let [r, g, b] = color.to_array().map(crate::exemplar::srgb::to_byte);
                write!(f, "#{r:02x}{g:02x}{b:02x}")
            }
        }
    }
}

/// `RRGGBB`, with or without `#`, as sRGB from 0 to 1.
pub(super) fn hex_color(text: &str) -> Option<Vec3> {
    let hex = text.strip_prefix('#').unwrap_or(text);
    let number = u32::from_str_radix(hex, 16).ok().filter(|_| hex.len() == 6)?;
    let byte = |shift: u32| (number >> shift & 255) as f32 / 255.0;
    Some(Vec3::new(byte(16), byte(8), byte(0)))
}

impl Base {
    /// Asks for no more than the model has.
    ///
    /// # Errors
    /// If it asks for vertex colours and there are none.
    pub fn check(self, model: &Model) -> Result<(), JobError> {
        if self == Self::Vertex && model.colors.is_none() { Err(JobError::NoBase) } else { Ok(()) }
    }
}

/// Leaves exemplars their detail; returns the slow part of each, which [`Laid::add_base`](super::Laid::add_base) asks for.
pub fn split(exemplars: &mut [Exemplar], warnings: &mut Vec<String>) -> Vec<Image> {
    let one = |exemplar: &mut Exemplar| {
        let slowly = take_detail(exemplar);
        warnings.extend(slowly.told().map(|text| format!("{}: {text}", exemplar.name)));
        slowly.slow
    };
    exemplars.iter_mut().map(one).collect()
}

/// A base on each face of a mesh whose pastes are detail; `slow` is what [`split`] returned, `painted` gives vertex colours.
pub(super) fn of_mesh(
    base: Base,
    (mesh, guide): (&Mesh, &Guide),
    lapped: &LappedTexture,
    slow: Vec<Image>,
    painted: impl FnOnce() -> Vec<[BaseColor; 3]>,
) -> Vec<[BaseColor; 3]> {
    match base {
        Base::Own => own_base(mesh, guide, lapped, slow),
        Base::Color(color) => vec![[base_color(color); 3]; mesh.face_count()],
        Base::Vertex => painted(),
    }
}

/// A model's vertex colours on each face of a mesh, white where it has none.
pub(super) fn of_vertices(model: &Model, mesh: &Mesh, user_faces: &[UserFace]) -> Vec<[BaseColor; 3]> {
    let of = |_: &UserFace, v: u32| base_color(model.colors.as_ref().map_or(Vec3::ONE, |c| c[v as usize].truncate()));
    at_corners(model, mesh, user_faces, of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_read_as_they_are_written() {
        assert_eq!("own".parse(), Ok(Base::Own));
        assert_eq!("vertex".parse(), Ok(Base::Vertex));
        assert_eq!("#ff0000".parse(), Ok(Base::Color(Vec3::X)));
        for text in ["own", "vertex", "#8a5a3c"] {
            assert_eq!(text.parse::<Base>().unwrap().to_string(), text);
        }
        for wrong in ["", "red", "#ff", "#gg0000", "#1234567"] {
            assert!(wrong.parse::<Base>().is_err(), "{wrong:?} is no base");
        }
    }
}
