//! The result of pasting: texture patches and the ordered pastes of them.

use crate::exemplar::{Exemplar, TexturePatch};
use glam::Vec2;

/// One texture patch laid on one surface patch (LT 3.5).
#[derive(Debug, Clone, PartialEq)]
pub struct Paste {
    /// Which texture patch.
    pub patch: u16,
    /// The faces of the surface patch.
    pub faces: Vec<u32>,
    /// Texture coordinates of each face's corners, over the patch's mask: (0, 0) its top left, (1, 1) its bottom right
    /// corner. Outside [0, 1] alpha is 0.
    pub uv: Vec<[Vec2; 3]>,
    /// Shift of the content under the mask, pixels of the exemplar.
    pub offset: Vec2,
}

/// Exemplars, texture patches and pastes in paint order: later ones lie on top.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LappedTexture {
    /// The exemplars that patches refer to.
    pub exemplars: Vec<Exemplar>,
    /// The texture patches that pastes refer to.
    pub patches: Vec<TexturePatch>,
    /// The pastes, bottom first.
    pub pastes: Vec<Paste>,
}
