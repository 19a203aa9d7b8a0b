//! Turns of what a paste shows under its mask.

use glam::Vec2;
use std::f64::consts::TAU;

/// Turns there are: a degree and a half apart, and those of 2, 3, 4, 5 and 6 ways are among them.
pub const TURNS: u32 = 240;

/// A turn of an exemplar under a mask: where a pixel of the mask lies right of its middle, the exemplar is read below its window's for a
/// quarter of a turn, as y points down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Turn(u8);

impl Turn {
    /// As the exemplar is.
    pub const NONE: Self = Self(0);

    /// So many [`TURNS`]th parts of a full turn; full ones are left out.
    #[must_use]
    pub const fn new(parts: u32) -> Self {
        Self((parts % TURNS) as u8)
    }

    /// Parts of a full turn, in [`TURNS`]ths.
    #[must_use]
    pub const fn parts(self) -> u32 {
        self.0 as u32
    }

    /// Cosine and sine. Of quarters they are exact.
    #[must_use]
    pub fn rotation(self) -> Vec2 {
        match u32::from(self.0) * 4 / TURNS {
            0 if self.0 == 0 => Vec2::X,
            1 if self.parts() * 4 == TURNS => Vec2::Y,
            2 if self.parts() * 2 == TURNS => Vec2::NEG_X,
            3 if self.parts() * 4 == 3 * TURNS => Vec2::NEG_Y,
            _ => {
                let (sine, cosine) = (TAU * f64::from(self.0) / f64::from(TURNS)).sin_cos();
                Vec2::new(cosine as f32, sine as f32)
            }
        }
    }

    /// Turns a step from the mask's middle into one of the exemplar.
    #[must_use]
    pub fn apply(self, step: Vec2) -> Vec2 {
        if self == Self::NONE { step } else { self.rotation().rotate(step) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_turn_is_exact_and_full_ones_are_none() {
        let step = Vec2::new(3.0, 5.0);
        assert_eq!(Turn::new(TURNS / 4).apply(step), Vec2::new(-5.0, 3.0));
        assert_eq!(Turn::new(TURNS / 2).apply(step), -step);
        assert_eq!(Turn::new(3 * TURNS / 4).apply(step), Vec2::new(5.0, -3.0));
        assert_eq!((Turn::new(TURNS), Turn::new(TURNS + 7)), (Turn::NONE, Turn::new(7)));
        let third = Turn::new(TURNS / 3).rotation();
        assert!((third - Vec2::new(-0.5, 0.75_f32.sqrt())).length() < 1e-7, "{third}");
    }
}
