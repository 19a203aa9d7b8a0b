//! What a pane shows: ways of drawing the texture, and figures in colours.

use super::synth::Method;
use crate::exemplar::srgb;
use crate::render::{Background, Lighting};
use glam::Vec3;

/// What a pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Mode {
    /// The texture, each face drawn once.
    #[default]
    Single,
    /// The texture, paste over paste.
    Layered,
    /// The texture, drawn by the processor as in pictures.
    Reference,
    /// The texture baked into an atlas.
    Atlas,
    /// The exemplar synthesised by Wei and Levoy instead of pasted.
    WeiLevoy,
    /// The exemplar synthesised by Chen and Dong instead of pasted.
    ChenDong,
    /// Each paste in a colour of its own.
    Pastes,
    /// How many pastes each face draws, and where none covers it.
    Draws,
    /// How far the topmost paste is from the scale asked for.
    Stretch,
    /// The mesh without texture.
    Bare,
}

impl Mode {
    /// All of them, in the order in which they are offered.
    pub const ALL: [Self; 10] = [
        Self::Single,
        Self::Layered,
        Self::Reference,
        Self::Atlas,
        Self::WeiLevoy,
        Self::ChenDong,
        Self::Pastes,
        Self::Draws,
        Self::Stretch,
        Self::Bare,
    ];

    /// True for those whose subject [`super::side`] makes when they are looked at.
    #[must_use]
    pub const fn is_made(self) -> bool {
        !matches!(self, Self::Single | Self::Layered | Self::Reference) && self.method().is_none()
    }

    /// The method, if it shows a synthesis.
    #[must_use]
    pub const fn method(self) -> Option<Method> {
        match self {
            Self::WeiLevoy => Some(Method::WeiLevoy),
            Self::ChenDong => Some(Method::ChenDong),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Single => "Single pass",
            Self::Layered => "Layered",
            Self::Reference => "Reference",
            Self::Atlas => "Atlas",
            Self::WeiLevoy => Method::WeiLevoy.name(),
            Self::ChenDong => Method::ChenDong.name(),
            Self::Pastes => "Pastes",
            Self::Draws => "Draws per face",
            Self::Stretch => "Stretch",
            Self::Bare => "Bare mesh",
        }
    }

    /// What it is, for who does not know.
    #[must_use]
    pub const fn hint(self) -> &'static str {
        match self {
            Self::Single => "Each face is drawn once; its pastes are walked from the top down until nothing more shows",
            Self::Layered => "The paper's runtime pasting: pastes one over another in paint order, alpha blended",
            Self::Reference => {
                "Drawn by the processor, every sample by itself, with shadows: as pictures are. Appears when the view is at rest"
            }
            Self::Atlas => "The texture baked into an atlas of charts, as other tools show it. Takes a while to bake",
            Self::WeiLevoy => Method::WeiLevoy.hint(),
            Self::ChenDong => Method::ChenDong.hint(),
            Self::Draws => "How many pastes lie on each face; where the surface is not covered it is marked",
            Self::Stretch => "The scale of the topmost paste against the one that the field asks for",
            Self::Pastes => "Each paste (one texture patch on one surface patch) in its own colour, with its alpha",
            Self::Bare => "The mesh alone",
        }
    }
}

/// Light on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Light {
    /// Three soft lamps under a sky.
    #[default]
    Studio,
    /// Little modelling: colours as they are.
    Even,
    /// From everywhere alike.
    Flat,
}

impl Light {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Studio, Self::Even, Self::Flat];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Studio => "Studio",
            Self::Even => "Even",
            Self::Flat => "Flat",
        }
    }

    /// The lamps.
    #[must_use]
    pub fn lighting(self) -> Lighting {
        match self {
            Self::Studio => Lighting::studio(),
            Self::Even => Lighting::even(),
            Self::Flat => Lighting::furnace(),
        }
    }
}

/// What is behind the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backdrop {
    /// As the interface's theme has it.
    #[default]
    Theme,
    /// White.
    White,
    /// Middle grey.
    Grey,
    /// Black.
    Black,
}

impl Backdrop {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Theme, Self::White, Self::Grey, Self::Black];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Theme => "As the theme",
            Self::White => "White",
            Self::Grey => "Grey",
            Self::Black => "Black",
        }
    }

    /// The grey of it, sRGB.
    #[must_use]
    pub const fn grey(self, dark: bool) -> u8 {
        match (self, dark) {
            (Self::Theme, true) => 46,
            (Self::Theme, false) => 226,
            (Self::White, _) => 255,
            (Self::Grey, _) => 128,
            (Self::Black, _) => 0,
        }
    }

    /// The background of frames.
    #[must_use]
    pub fn background(self, dark: bool) -> Background {
        Background::Plain(Vec3::splat(srgb::decode(f32::from(self.grey(dark)) / 255.0)))
    }
}
