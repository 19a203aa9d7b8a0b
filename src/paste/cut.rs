//! Cuts: a border of a paste's own, inside its mask.
//!
//! A mask is shared by all pastes of a texture patch; where its border shows least differs from paste to paste. So a paste may
//! end before its mask does: for each of [`CUT_STEPS`] ways out of the mask's middle a cut holds how far alpha reaches, and how
//! softly it ends. Alpha is the mask's times the cut's.
//!
//! Ways and distances are those of squares about the middle, not of circles: exact in floating point on every processor, and nearer
//! to the shape of splotches, which fill their exemplar.

use glam::Vec2;

/// Ways out of the middle. They begin at the right edge's upper corner and go down, as even steps along the mask's edges.
pub const CUT_STEPS: usize = 128;
/// Steps along one edge.
const SIDE: f32 = CUT_STEPS as f32 / 4.0;
/// What one unit of a stored distance stands for: 204 is the mask's edge, 255 lies beyond the mask.
const DISTANCE: f32 = 1.0 / 204.0;
/// What one unit of a stored softness stands for; 0 is one of it.
const SOFTNESS: f32 = 1.0 / 512.0;
/// The distance that does not cut.
const BEYOND: u8 = 255;

/// How far a paste reaches inside its mask. Distances go from 0 in the mask's middle to 1 at its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cut {
    /// For each way out of the middle: the distance at which alpha is one half, and the width over which it falls, as stored.
    steps: [[u8; 2]; CUT_STEPS],
    /// As stored distances: how far everything is left whole, whatever the way.
    inner: u8,
}

/// Where a point lies: how far along the ways, and the distance.
#[derive(Debug, Clone, Copy)]
struct Polar {
    way: f32,
    distance: f32,
}

impl Polar {
    /// Of coordinates over the mask, 0 to 1.
    #[inline]
    fn new(uv: Vec2) -> Self {
        let d = uv * 2.0 - 1.0;
        let (x, y) = (d.x.abs(), d.y.abs());
        let distance = x.max(y);
        let part = |minor: f32| (1.0 + minor / distance.max(1e-30)) * 0.5;
        let side = match () {
            () if x >= y && d.x >= 0.0 => part(d.y),
            () if x >= y => 2.0 + part(-d.y),
            () if d.y >= 0.0 => 1.0 + part(-d.x),
            () => 3.0 + part(d.x),
        };
        Self { way: side * SIDE, distance }
    }
}

impl Cut {
    /// One that cuts nothing away.
    #[must_use]
    pub const fn none() -> Self {
        Self { steps: [[BEYOND, 0]; CUT_STEPS], inner: BEYOND - 1 }
    }

    /// From stored distances and softnesses.
    #[must_use]
    pub fn from_steps(steps: [[u8; 2]; CUT_STEPS]) -> Self {
        let whole = |[distance, width]: [u8; 2]| f32::from(distance) - 0.5 * (f32::from(width) + 1.0) * SOFTNESS / DISTANCE;
        let inner = steps.into_iter().map(whole).fold(f32::INFINITY, f32::min);
        // Casts saturate, so what is negative is 0.
        Self { steps, inner: inner as u8 }
    }

    /// One that lets alpha fall from 1 to 0 around a distance, over a width, on those ways for which they are given.
    #[must_use]
    pub fn new(step: impl Fn(usize) -> Option<[f32; 2]>) -> Self {
        let stored = |value: f32, unit: f32| (value / unit).round().clamp(0.0, 254.0) as u8;
        let step = |way| step(way).map_or([BEYOND, 0], |[d, w]| [stored(d, DISTANCE), stored(w - SOFTNESS, SOFTNESS)]);
        Self::from_steps(std::array::from_fn(step))
    }

    /// Stored distances (in 204ths of the way to the edge; 255: uncut) and softnesses (in 512ths of it, less one).
    #[must_use]
    pub const fn steps(&self) -> &[[u8; 2]; CUT_STEPS] {
        &self.steps
    }

    /// A point of the mask, 0 to 1, on a way at a distance.
    #[must_use]
    pub fn point(way: usize, distance: f32) -> Vec2 {
        let place = (way % CUT_STEPS) as f32 / SIDE;
        let minor = place.fract() * 2.0 - 1.0;
        let d = match place as u32 {
            0 => Vec2::new(1.0, minor),
            1 => Vec2::new(-minor, 1.0),
            2 => Vec2::new(-1.0, -minor),
            _ => Vec2::new(minor, -1.0),
        };
        (d * distance + 1.0) * 0.5
    }

    /// The way nearest to a point of the mask (0 to 1), and the point's distance.
    #[must_use]
    pub fn place(uv: Vec2) -> (usize, f32) {
        let at = Polar::new(uv);
        (at.way.round() as usize % CUT_STEPS, at.distance)
    }

    /// Cuts nothing away any more at all points no further than `reach` from one, as [`bounds`](Self::bounds) takes it. Returns whether
    /// it did.
    pub fn mend(&mut self, uv: Vec2, reach: f32) -> bool {
        let mut steps = self.steps;
        ways_within(&Polar::new(uv), reach, |way| steps[way][0] = BEYOND);
        let changed = steps != self.steps;
        *self = Self::from_steps(steps);
        changed
    }

    /// True if it cuts nothing away.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.steps.iter().all(|step| step[0] == BEYOND)
    }

    #[inline]
    fn step(&self, way: usize) -> [f32; 2] {
        let [distance, width] = self.steps[way % CUT_STEPS];
        [f32::from(distance) * DISTANCE, (f32::from(width) + 1.0) * SOFTNESS]
    }

    /// Distance and width on a way that need not be a whole one; not negative.
    #[inline]
    fn between(&self, way: f32) -> [f32; 2] {
        let first = way as usize;
        let part = way - first as f32;
        let ([d0, w0], [d1, w1]) = (self.step(first), self.step(first + 1));
        [d0 + part * (d1 - d0), w0 + part * (w1 - w0)]
    }

    /// Alpha at a point of the mask (0 to 1). `blur` is the least width over which it falls: a pixel's.
    #[inline]
    #[must_use]
    pub fn alpha(&self, uv: Vec2, blur: f32) -> f32 {
        let at = Polar::new(uv);
        let [distance, width] = self.between(at.way);
        ((distance - at.distance) / width.max(blur) + 0.5).clamp(0.0, 1.0)
    }

    /// The distance from the middle up to which alpha is 1, on all ways and for all blurs up to `blur`.
    #[inline]
    #[must_use]
    pub fn inner(&self, blur: f32) -> f32 {
        f32::from(self.inner) * DISTANCE - 0.5 * blur
    }

    /// Bounds of alpha at all points no further than `reach` from one, both over the mask (reach by its longer coordinate; a mask is
    /// 1 wide), and for all blurs up to `blur`.
    #[must_use]
    pub fn bounds(&self, uv: Vec2, reach: f32, blur: f32) -> [f32; 2] {
        let at = Polar::new(uv);
        let inner = at.distance - 2.0 * reach;
        let mut low = [f32::INFINITY; 2];
        let mut high = [0.0_f32; 2];
        let mut take = |[distance, width]: [f32; 2]| {
            low = [low[0].min(distance), low[1].min(width)];
            high = [high[0].max(distance), high[1].max(width.max(blur))];
        };
        match aside(&at, reach) {
            None => (0..CUT_STEPS).for_each(|way| take(self.step(way))),
            // Between ways both run straight, so they are largest and least at ways and at the ends.
            Some(aside) => {
                let [from, to] = [at.way - aside, at.way + aside].map(|way| way + CUT_STEPS as f32);
                take(self.between(from));
                take(self.between(to));
                (from.ceil() as usize..=to.floor() as usize).for_each(|way| take(self.step(way)));
            }
        }
        // A ramp is steeper, so further from one half, where it is narrow.
        let ramp = |ahead: f32, narrow: f32, wide: f32| {
            let width = if ahead >= 0.0 { wide } else { narrow };
            (ahead / width + 0.5).clamp(0.0, 1.0)
        };
        let least = ramp(low[0] - at.distance - 2.0 * reach, low[1], high[1]);
        let most = ramp(high[0] - inner.max(0.0), high[1], low[1]);
        [least, most]
    }
}

/// How many ways a step of `reach` over the mask leads aside at most; `None` if anywhere.
#[inline]
fn aside(at: &Polar, reach: f32) -> Option<f32> {
    let inner = at.distance - 2.0 * reach;
    let aside = SIDE * 2.0 * reach / inner;
    (inner > 0.0 && aside < 2.0 * SIDE).then_some(aside)
}

/// Names all ways that matter to points no further than `reach` from one, both over the mask.
fn ways_within(at: &Polar, reach: f32, name: impl FnMut(usize)) {
    match aside(at, reach) {
        None => (0..CUT_STEPS).for_each(name),
        Some(aside) => {
            let from = (at.way - aside).floor() as i64;
            let to = (at.way + aside).floor() as i64 + 1;
            (from..=to).map(|way| way.rem_euclid(CUT_STEPS as i64) as usize).for_each(name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn random_cut(random: &mut Random) -> Cut {
        let steps: Vec<_> = (0..CUT_STEPS)
            .map(|_| {
                let step = [random.range(0.3, 1.1) as f32, random.range(0.005, 0.3) as f32];
                (random.unit() < 0.8).then_some(step)
            })
            .collect();
        Cut::new(|way| steps[way])
    }

    #[test]
    fn one_that_cuts_nothing_leaves_alpha_whole_everywhere_on_the_mask() {
        let mut random = Random::new(1, 0);
        for _ in 0..1000 {
            let uv = Vec2::new(random.unit() as f32, random.unit() as f32);
            assert_eq!(Cut::none().alpha(uv, 0.2), 1.0, "at {uv}");
        }
    }

    #[test]
    fn a_way_and_its_point_agree_all_around() {
        for way in 0..CUT_STEPS {
            let (back, distance) = Cut::place(Cut::point(way, 0.7));
            assert_eq!(back, way);
            assert!((distance - 0.7).abs() < 1e-6, "way {way}: {distance}");
        }
    }

    #[test]
    fn alpha_is_one_half_at_the_distance_set_and_continuous_all_around() {
        let cut = Cut::new(|_| Some([0.6, 0.1]));
        for way in 0..CUT_STEPS {
            let alpha = |distance: f32| cut.alpha(Cut::point(way, distance), 0.0);
            assert!((alpha(0.6) - 0.5).abs() < 0.03, "way {way}: {}", alpha(0.6));
            assert_eq!([alpha(0.5), alpha(0.7)], [1.0, 0.0], "way {way}: inside and outside");
        }
        let mut random = Random::new(2, 0);
        let cut = random_cut(&mut random);
        for edge in 0..4 {
            let corner = Cut::point(edge * CUT_STEPS / 4, 0.6);
            let [a, b] = [-1e-5, 1e-5].map(|d| cut.alpha(corner + Vec2::new(d, -d), 0.05));
            assert!((a - b).abs() < 0.01, "over the corner {corner}: {a}, {b}");
        }
    }

    #[test]
    fn bounds_of_a_point_are_its_alpha() {
        let mut random = Random::new(4, 0);
        for _ in 0..1000 {
            let cut = random_cut(&mut random);
            let uv = Vec2::new(random.unit() as f32, random.unit() as f32);
            let (alpha, [least, most]) = (cut.alpha(uv, 0.0), cut.bounds(uv, 0.0, 0.0));
            assert!((least - alpha).abs() < 1e-3 && (most - alpha).abs() < 1e-3, "{alpha} is neither {least} nor {most}");
        }
    }

    #[test]
    fn bounds_hold_for_every_point_within_reach() {
        let mut random = Random::new(3, 0);
        for _ in 0..300 {
            let cut = random_cut(&mut random);
            let uv = Vec2::new(random.unit() as f32, random.unit() as f32);
            let reach = random.range(0.0, 0.1) as f32;
            let blur = random.range(0.0, 0.1) as f32;
            let [least, most] = cut.bounds(uv, reach, blur);
            if (uv * 2.0 - 1.0).abs().max_element() <= cut.inner(blur) {
                assert_eq!(cut.alpha(uv, blur), 1.0, "{uv} lies inside");
            }
            for _ in 0..50 {
                let aside = Vec2::new(random.range(-1.0, 1.0) as f32, random.range(-1.0, 1.0) as f32) * reach;
                let alpha = cut.alpha(uv + aside, blur);
                assert!((least - 1e-4..=most + 1e-4).contains(&alpha), "{alpha} is not within {least} and {most}");
                if (uv + aside).clamp(Vec2::ZERO, Vec2::ONE) == uv + aside {
                    let mut mended = cut;
                    mended.mend(uv, reach);
                    assert_eq!(mended.alpha(uv + aside, blur), 1.0, "mended around {uv}");
                }
            }
        }
    }
}
