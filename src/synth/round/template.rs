//! Where the samples of a round neighbourhood lie: the crossings of circles 1, 2, 3, ... pixels wide about the middle with the lines
//! of the pixel grid (Chen, Dong 2008, sec. 4.2 and fig. 2). Circle m has 8 m - 4 of them.

use glam::Vec2;
use std::f64::consts::TAU;

/// The most circles a neighbourhood can have.
pub const MOST_CIRCLES: usize = 6;

/// A sample of a template.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Right and up from the middle, pixels.
    pub offset: Vec2,
    /// Its place on its circle as a share of the circle's length, from texture right counter-clockwise, in [0, 1).
    pub share: f64,
}

/// The samples of all circles, from the innermost outward, each circle's in counter-clockwise order.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    samples: Vec<Sample>,
    /// One past the last sample of each circle.
    ends: Vec<usize>,
}

impl Template {
    /// The template of 1 to [`MOST_CIRCLES`] circles.
    #[must_use]
    pub fn new(circles: usize) -> Self {
        let (mut samples, mut ends) = (Vec::new(), Vec::new());
        for m in 1..=circles.clamp(1, MOST_CIRCLES) as i32 {
            let mut points: Vec<(i32, Vec2)> = Vec::new();
            for i in 1 - m..m {
                let far = f64::from(m * m - i * i).sqrt();
                for far in [far, -far] {
                    for (x, y) in [(f64::from(i), far), (far, f64::from(i))] {
                        // Points with two whole coordinates are met along both lines.
                        let key = ((y.atan2(x) / TAU).rem_euclid(1.0) * 1e6).round() as i32 % 1_000_000;
                        if !points.iter().any(|p| p.0 == key) {
                            points.push((key, Vec2::new(x as f32, y as f32)));
                        }
                    }
                }
            }
            points.sort_by_key(|p| p.0);
            samples.extend(points.into_iter().map(|(_, offset)| {
                let share = (f64::from(offset.y).atan2(f64::from(offset.x)) / TAU).rem_euclid(1.0);
                Sample { offset, share: if share < 1.0 { share } else { 0.0 } }
            }));
            ends.push(samples.len());
        }
        Self { samples, ends }
    }

    /// All samples.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// One past the last sample of each circle.
    #[must_use]
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// How many circles.
    #[must_use]
    pub const fn circles(&self) -> usize {
        self.ends.len()
    }

    /// The samples of a circle, counted from 0.
    #[must_use]
    pub fn range(&self, circle: usize) -> std::ops::Range<usize> {
        (if circle == 0 { 0 } else { self.ends[circle - 1] })..self.ends[circle]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_cross_the_grid_where_they_should() {
        let template = Template::new(MOST_CIRCLES);
        for m in 1..=MOST_CIRCLES {
            let samples = &template.samples()[template.range(m - 1)];
            // Circle 5 passes through eight places with two whole coordinates, each of which is one sample and not two.
            assert_eq!(samples.len(), 8 * m - 4 - if m == 5 { 8 } else { 0 }, "circle {m}");
            for s in samples {
                let [x, y] = s.offset.to_array();
                assert!((s.offset.length() - m as f32).abs() < 1e-5, "{s:?} lies on circle {m}");
                assert!((x - x.round()).abs().min((y - y.round()).abs()) < 1e-5, "{s:?} lies on a line of the grid");
            }
            assert!(samples.windows(2).all(|w| w[0].share < w[1].share), "circle {m} goes around once");
            assert_eq!(samples[0].share, 0.0, "circle {m} starts at texture right");
        }
    }
}
