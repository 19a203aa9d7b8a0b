//! Smaller texture patches: the same exemplar at the same scale under a narrower mask.
//!
//! 1. The depth below a patch's outline is that of each pixel below the nearest one without alpha.
//! 2. Drawn together towards the centre the outline keeps its shape; depth shrinks with it.
//! 3. Alpha rises with it over as many pixels as before: what fades fades as softly, unless that would leave nothing opaque.
//!
//! Only patches that slide are made smaller: the others' outlines follow something in the exemplar.

use super::distance::distance;
use super::mask::{self, CutOut, OPAQUE, feather_alpha};
use super::{Hull, Image, MipChain, TexturePatch};
use glam::{IVec2, Vec2};

/// A feather takes no more than this share of the depth of a smaller patch, so that its middle is opaque.
const MOST_FEATHER: f32 = 0.5;

/// Depth in pixels of its opaque part that a patch needs somewhere, as those it was made of: its centre lies there.
const LEAST_DEPTH: f32 = 2.0;

impl TexturePatch {
    /// Patches so many times as wide as this one. `None` where too little would be left of it; none at all if it does not slide.
    #[must_use]
    pub fn smaller(&self, shares: &[f32]) -> Vec<Option<Self>> {
        if !self.slides {
            return Vec::new();
        }
        let depth = Depth::of(self.mask.finest());
        shares.iter().map(|&share| self.drawn_together(&depth, share)).collect()
    }

    fn drawn_together(&self, depth: &Depth, share: f32) -> Option<Self> {
        let feather = depth.feather.min(MOST_FEATHER * share * depth.deepest);
        let (origin, size) = (IVec2::from_array(self.origin).as_vec2(), Vec2::new(depth.width as f32, depth.height as f32));
        let low = (self.centre + (origin - self.centre) * share).floor();
        let [width, height] = ((size * share).ceil() + 1.0).as_uvec2().to_array().map(|n| n as usize);
        let pixel = |i: usize| {
            let at = low + Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
            let below = depth.at(self.centre + (at - self.centre) / share - origin);
            feather_alpha(share * below, feather)
        };
        let alpha: Vec<f32> = (0..width * height).map(pixel).collect();
        let CutOut { mask, origin, .. } = mask::cut_out(&alpha, width)?;
        let origin = origin + low.as_ivec2();
        let opaque: Vec<bool> = mask.data().iter().map(|&a| a >= OPAQUE).collect();
        let (centre, _) = mask::deepest(&opaque, mask.size()[0] as usize).filter(|found| found.1 >= LEAST_DEPTH)?;
        let hull = Hull::of_mask(&mask, origin)?;
        Some(Self {
            origin: origin.to_array(),
            hull,
            centre: centre + origin.as_vec2(),
            mask: MipChain::mask(mask),
            ..self.clone()
        })
    }
}

/// How deep below its outline each pixel of a mask lies.
struct Depth {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    deepest: f32,
    /// The depth from which everything is opaque.
    feather: f32,
}

impl Depth {
    fn of(mask: &Image) -> Self {
        let [width, height] = mask.size().map(|n| n as usize);
        let outside: Vec<bool> = mask.data().iter().map(|&a| a <= 0.0).collect();
        let depth = distance(&outside, width);
        let deepest = depth.iter().copied().fold(0.0, f32::max);
        let soft = depth.iter().zip(mask.data()).filter(|(_, alpha)| **alpha < OPAQUE);
        let feather = soft.map(|(depth, _)| *depth).fold(1.0, f32::max);
        Self { width, height, depth, deepest, feather }
    }

    /// At a point of the mask, between the centres of its pixels; 0 beyond them.
    fn at(&self, point: Vec2) -> f32 {
        let from = (point - 0.5).floor();
        let part = point - 0.5 - from;
        let [x, y] = from.as_ivec2().to_array();
        let of = |x: i32, y: i32| {
            let inside = (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y);
            if inside { self.depth[y as usize * self.width + x as usize] } else { 0.0 }
        };
        let row = |y: i32| of(x, y) * (1.0 - part.x) + of(x + 1, y) * part.x;
        row(y) * (1.0 - part.y) + row(y + 1) * part.y
    }
}

#[cfg(test)]
mod tests {
    use crate::exemplar::mask::OPAQUE;
    use crate::exemplar::{Exemplar, Image, PatchOptions, PatchSource, PatchSpec, TexturePatch, make_patches};
    use glam::{IVec2, Vec2, Vec3};

    fn splotch(feather: f32) -> TexturePatch {
        let exemplar = Exemplar::new("grey", Image::from_fn(128, 96, |_, _| Vec3::splat(0.5)));
        let spec = [PatchSpec { source: PatchSource::Splotch, weight: 1.0 }];
        let options = PatchOptions { feather, splotches: 1, ..PatchOptions::default() };
        make_patches(&exemplar, 0, &spec, &options).expect("a splotch").0.remove(0)
    }

    fn area(patch: &TexturePatch) -> f32 {
        patch.mask.finest().data().iter().sum()
    }

    #[test]
    fn a_smaller_patch_lies_within_the_whole_and_fades_as_softly() {
        let whole = splotch(3.0);
        for share in [0.5, 0.25] {
            let small = whole.smaller(&[share]).remove(0).expect("it slides");
            let part = area(&small) / area(&whole);
            assert!((0.7 * share * share..share * share).contains(&part), "{part} of the area at {share}");
            let low = |p: &TexturePatch| IVec2::from_array(p.origin);
            let high = |p: &TexturePatch| low(p) + IVec2::from_array(p.mask.size().map(|n| n as i32));
            assert!(
                low(&small).cmpge(low(&whole)).all() && high(&small).cmple(high(&whole)).all(),
                "in the rectangle of the whole"
            );
            let soft = |p: &TexturePatch| p.mask.finest().data().iter().filter(|a| **a > 0.0 && **a < OPAQUE).count() as f32;
            let part = soft(&small) / soft(&whole);
            assert!((0.7 * share..1.3 * share).contains(&part), "{part} of the pixels that fade at {share}, so as many across");
            let at = (small.centre - Vec2::from(small.origin.map(|o| o as f32))).floor();
            assert_eq!(small.mask.finest().grey(at.x as i64, at.y as i64), 1.0, "opaque at the centre");
        }
    }

    #[test]
    fn a_wide_feather_leaves_a_middle() {
        let small = splotch(36.0).smaller(&[0.25]).remove(0).expect("it slides");
        assert!(small.mask.finest().data().iter().any(|&a| a >= OPAQUE));
    }

    #[test]
    fn what_follows_the_exemplar_or_would_be_a_dot_is_not_made_smaller() {
        let whole = splotch(3.0);
        assert!(whole.smaller(&[0.02])[0].is_none());
        assert!(TexturePatch { slides: false, ..whole }.smaller(&[0.5]).is_empty());
    }
}
