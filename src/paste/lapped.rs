//! The result of pasting: texture patches and the ordered pastes of them (LT 3.5).

use super::cut::Cut;
use super::turn::Turn;
use crate::exemplar::{DETAIL, Exemplar, TexturePatch};
use crate::mesh::SurfacePoint;
use glam::{Vec2, Vec3};

/// One texture patch laid on one surface patch.
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
    /// Turn of the content about the mask's middle.
    pub turn: Turn,
    /// Where it ends inside its mask; `None`: where the mask does.
    pub cut: Option<Box<Cut>>,
    /// How much what it shows along its border agrees with what lies below, in 255ths ([`contrast`](super::contrast)); [`AGREES`] mixes
    /// them as alpha says and no more.
    pub agreement: u8,
}

/// [`Paste::agreement`] of a paste that is simply laid over.
pub const AGREES: u8 = 255;

/// Exemplars, texture patches and pastes in paint order: later ones lie on top.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LappedTexture {
    /// The exemplars that patches refer to.
    pub exemplars: Vec<Exemplar>,
    /// The texture patches that pastes refer to.
    pub patches: Vec<TexturePatch>,
    /// The pastes, bottom first.
    pub pastes: Vec<Paste>,
    /// The layers that the pastes belong to, one after the other in paint order; together they hold every paste. Empty: all
    /// pastes are one layer of weight 1.
    pub layers: Vec<Layer>,
}

/// Pastes of one region of the surface, and how much of them shows where. Within a layer pastes lie over each other as
/// ever; the layer as a whole is then mixed with the ones below it by its weight.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// What the region is called; may be empty.
    pub name: String,
    /// How many pastes it has.
    pub pastes: u32,
    /// Per face, the weight at its three corners, 0 to 1, linear between them. Empty: 1 everywhere.
    pub weights: Vec<[f32; 3]>,
    /// Per face, the colour at its three corners that its pastes are the detail of ([`DETAIL`]): linear light, 65535 is 1, linear between
    /// corners. Empty: they bring their own.
    pub base: Vec<[BaseColor; 3]>,
}

/// Red, green and blue of a base in 16 bits each, linear light.
pub type BaseColor = [u16; 3];

/// A colour, linear, as one of a base; what is beyond 0 and 1 is clipped.
#[must_use]
pub fn base_color(color: Vec3) -> BaseColor {
    color.to_array().map(|c| (c.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u16)
}

impl Layer {
    /// Its weight at a point.
    #[inline]
    #[must_use]
    pub fn weight(&self, at: SurfacePoint) -> f32 {
        self.weights.get(at.face as usize).map_or(1.0, |w| Vec3::from(*w).dot(at.bary).clamp(0.0, 1.0))
    }

    /// What the base colour of its pastes is multiplied by at a point: the base over [`DETAIL`]; 1 without one.
    #[inline]
    #[must_use]
    pub fn gain(&self, at: SurfacePoint) -> Vec3 {
        let own = |corner: &BaseColor| Vec3::from(corner.map(f32::from)) / (f32::from(u16::MAX) * DETAIL);
        self.base.get(at.face as usize).map_or(Vec3::ONE, |c| (0..3).map(|k| own(&c[k]) * at.bary[k]).sum())
    }
}

/// For each face the pastes on it, bottom first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FaceLists {
    /// Where each face's list begins in `entries`, and one more.
    pub start: Vec<u32>,
    /// The paste, and the face's place among that paste's faces.
    pub entries: Vec<(u32, u32)>,
}

impl FaceLists {
    /// Sorts the faces of all pastes by face. Face indices of at least `face_count` are left out.
    #[must_use]
    pub fn new(face_count: usize, pastes: &[Paste]) -> Self {
        let inside = |f: u32| (f as usize) < face_count;
        let mut start = vec![0_u32; face_count + 1];
        for &f in pastes.iter().flat_map(|p| &p.faces).filter(|&&f| inside(f)) {
            start[f as usize + 1] += 1;
        }
        for f in 0..face_count {
            start[f + 1] += start[f];
        }
        let mut fill = start.clone();
        let mut entries = vec![(0, 0); start[face_count] as usize];
        for (paste, p) in pastes.iter().enumerate() {
            for (slot, &f) in p.faces.iter().enumerate().filter(|(_, f)| inside(**f)) {
                let place = &mut fill[f as usize];
                entries[*place as usize] = (paste as u32, slot as u32);
                *place += 1;
            }
        }
        Self { start, entries }
    }

    /// The pastes on a face, bottom first.
    #[inline]
    #[must_use]
    pub fn of(&self, face: u32) -> &[(u32, u32)] {
        &self.entries[self.start[face as usize] as usize..self.start[face as usize + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn face_lists_hold_each_paste_in_paint_order() {
        let paste = |faces: &[u32]| Paste {
            patch: 0,
            faces: faces.to_vec(),
            uv: vec![[Vec2::ZERO; 3]; faces.len()],
            offset: Vec2::ZERO,
            turn: Turn::NONE,
            cut: None,
            agreement: AGREES,
        };
        let lists = FaceLists::new(3, &[paste(&[2, 0]), paste(&[0]), paste(&[1, 9, 0])]);
        assert_eq!(lists.of(0), [(0, 1), (1, 0), (2, 2)], "bottom first, with slots");
        assert_eq!(lists.of(1), [(2, 0)], "one paste");
        assert_eq!(lists.entries.len(), 5, "the face out of range is left out");
    }
}
