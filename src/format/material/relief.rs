//! What a normal map and a height map say about each other and themselves.
//!
//! A normal map is the gradient of a height: with slopes `p` along x and `q` along y (both axes of the image, y up), the
//! mixed derivatives `dp/dy` and `dq/dx` are the same function. A map of the DirectX convention has `q` with the other
//! sign, so they are opposite. Their correlation tells the convention from the map alone. The correlation of `p` with the
//! height's own slope along x, where conventions agree, tells whether bright means high or deep.

use crate::exemplar::Image;

/// Below this correlation the maps are too noisy, too flat or too unlike each other to say anything.
pub(crate) const TELLING: f64 = 0.15;

/// Correlation of the mixed derivatives: near 1 for the OpenGL convention (y up), near -1 for DirectX.
pub(crate) fn y_up(normal: &Image) -> f64 {
    correlate(normal.size(), |x, y| {
        let dp_dy = slopes(normal, x, y - 1).0 - slopes(normal, x, y + 1).0;
        let dq_dx = slopes(normal, x + 1, y).1 - slopes(normal, x - 1, y).1;
        (dp_dy, dq_dx)
    })
}

/// Correlation of the slopes along x of both maps: near 1 where bright is high, near -1 where bright is deep.
pub(crate) fn bright_is_high(normal: &Image, height: &Image) -> f64 {
    correlate(normal.size(), |x, y| {
        let rise = f64::from(height.grey(x + 1, y) - height.grey(x - 1, y));
        (slopes(normal, x, y).0, rise)
    })
}

/// Slopes of the surface along x and up along y, taking y as up.
fn slopes(normal: &Image, x: i64, y: i64) -> (f64, f64) {
    /// Steeper normals count as this steep, so that a few bad pixels cannot decide.
    const FLATTEST_Z: f32 = 0.1;
    let n = normal.pixel(x, y);
    let z = n.z.max(FLATTEST_Z);
    (f64::from(-n.x / z), f64::from(-n.y / z))
}

/// Correlation about zero over the inner pixels; 0 if one of the two is always 0.
fn correlate([width, height]: [u32; 2], pair: impl Fn(i64, i64) -> (f64, f64)) -> f64 {
    let (mut both, mut first, mut second) = (0.0, 0.0, 0.0);
    for y in 1..i64::from(height) - 1 {
        for x in 1..i64::from(width) - 1 {
            let (a, b) = pair(x, y);
            both += a * b;
            first += a * a;
            second += b * b;
        }
    }
    let size = (first * second).sqrt();
    if size > 0.0 { both / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{bright_is_high, y_up};
    use crate::exemplar::Image;
    use glam::Vec3;

    /// Bumps whose height is known, and their exact normals with y up.
    fn bumps() -> (Image, Image) {
        let height = |x: f32, y: f32| 0.5 + 0.2 * (x * 0.3 + y * 0.1).sin() + 0.2 * (y * 0.25 - x * 0.15).cos();
        let map = Image::grey_from_fn(64, 48, |x, y| height(x as f32, y as f32));
        let normals = Image::from_fn(64, 48, |x, y| {
            let (x, y) = (x as f32, y as f32);
            let dx = height(x + 0.5, y) - height(x - 0.5, y);
            let down = height(x, y + 0.5) - height(x, y - 0.5);
            Vec3::new(-5.0 * dx, 5.0 * down, 1.0).normalize()
        });
        (map, normals)
    }

    #[test]
    fn the_convention_shows_in_the_map_itself() {
        let (_, mut normals) = bumps();
        assert!(y_up(&normals) > 0.9, "y up: {}", y_up(&normals));
        normals.data_mut().chunks_exact_mut(3).for_each(|n| n[1] = -n[1]);
        assert!(y_up(&normals) < -0.9, "y down: {}", y_up(&normals));
    }

    #[test]
    fn the_sense_of_a_height_map_shows_against_the_normals() {
        let (mut height, normals) = bumps();
        assert!(bright_is_high(&normals, &height) > 0.9, "bright is high");
        height.data_mut().iter_mut().for_each(|h| *h = 1.0 - *h);
        assert!(bright_is_high(&normals, &height) < -0.9, "bright is deep");
    }
}
