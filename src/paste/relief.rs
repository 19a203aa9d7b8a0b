//! Relief seen at a slant: a height channel shifts what is seen, as if the surface were carved as deep as it says.
//!
//! Based on: T. Kaneko et al., "Detailed shape representation with parallax mapping", ICAT 2001, with the ray followed step by
//! step to where it meets the relief, and between the last two steps straight on. The surface is at height 1; nothing stands
//! out of it, and outlines stay those of the mesh. Twin of `relief` in shaders/paste.wgsl.

use crate::exemplar::MipChain;
use glam::Vec2;

/// Steps of the search for the relief that a ray meets.
const STEPS: u32 = 16;

/// The least cosine between ray and normal for which the relief keeps its depth; at more of a slant it flattens.
pub(super) const LEAST_COSINE: f32 = 0.2;

/// The pixel whose relief the ray to `pixel` meets. A ray goes `slope` pixels aside for each one down; the deepest place is
/// `depth` pixels below the surface. `wrapped` brings a pixel back into the image.
pub(super) fn met(height: &MipChain, pixel: Vec2, slope: Vec2, depth: f32, lod: f32, wrapped: impl Fn(Vec2) -> Vec2) -> Vec2 {
    let (mut before, mut gap_before) = (0.0, 1.0);
    for step in 0..=STEPS {
        let down = step as f32 / STEPS as f32;
        let gap = (1.0 - down) - height.sample(wrapped(pixel - slope * depth * down), lod).x;
        if gap <= 0.0 {
            let part = if step > 0 { gap_before / (gap_before - gap) } else { 0.0 };
            return pixel - slope * depth * (before + (down - before) * part);
        }
        (before, gap_before) = (down, gap);
    }
    pixel - slope * depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::Image;

    #[test]
    fn a_ray_meets_a_level_floor_where_geometry_says() {
        for level in [0.0_f32, 0.25, 0.6, 1.0] {
            let floor = MipChain::new(Image::grey_from_fn(64, 64, |_, _| level));
            let slope = Vec2::new(0.7, -0.4);
            let found = met(&floor, Vec2::splat(32.0), slope, 8.0, 0.0, |p| p);
            let expected = Vec2::splat(32.0) - slope * 8.0 * (1.0 - level);
            assert!(found.distance(expected) < 1e-3, "height {level}: {found}, not {expected}");
        }
    }

    #[test]
    fn a_step_hides_what_lies_behind_it() {
        // High on the left of column 32, low on the right; seen from the left the wall hides the floor at its foot.
        let step = MipChain::new(Image::grey_from_fn(64, 64, |x, _| if x < 32 { 1.0 } else { 0.0 }));
        let from_left = met(&step, Vec2::new(38.0, 32.5), Vec2::new(1.0, 0.0), 8.0, 0.0, |p| p);
        assert!((from_left.x - 31.9).abs() < 1.0, "the wall: {from_left}");
        let from_right = met(&step, Vec2::new(38.0, 32.5), Vec2::new(-1.0, 0.0), 8.0, 0.0, |p| p);
        assert!((from_right.x - 46.0).abs() < 1e-3, "the floor beyond: {from_right}");
    }
}
