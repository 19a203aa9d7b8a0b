//! The border between sRGB numbers in files and linear light inside (IEC 61966-2-1).

use glam::{Vec3, Vec4};
use std::sync::LazyLock;

/// An encoded value as linear light; values outside 0 to 1 follow the curve's continuation.
#[must_use]
pub fn decode(encoded: f32) -> f32 {
    let e = f64::from(encoded);
    let linear = if e.abs() <= 0.04045 { e / 12.92 } else { e.signum() * ((e.abs() + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// Linear light as an encoded value; the inverse of [`decode`].
#[must_use]
pub fn encode(linear: f32) -> f32 {
    let l = f64::from(linear);
    let encoded = if l.abs() <= 0.003_130_8 { l * 12.92 } else { l.signum() * (1.055 * l.abs().powf(1.0 / 2.4) - 0.055) };
    encoded as f32
}

/// [`encode`] within 5e-6, in a fraction of the time; what lies outside 0 to 1 is encoded as there.
#[must_use]
pub fn encode_near(linear: f32) -> f32 {
    /// Steps of the square root of light, over which the curve is nearly straight.
    const STEPS: usize = 2048;
    static TABLE: LazyLock<Vec<f32>> =
        LazyLock::new(|| (0..=STEPS + 1).map(|i| encode((i as f32 / STEPS as f32).powi(2))).collect());
    if !(0.0..=1.0).contains(&linear) {
        return encode(linear);
    }
    let at = linear.sqrt() * STEPS as f32;
    let (below, part) = (at as usize, at.fract());
    let [low, high] = [TABLE[below], TABLE[below + 1]];
    low + (high - low) * part
}

/// Linear light as the nearest of the 256 values of an 8-bit image; what lies outside 0 to 1 is clamped, NaN is 0.
#[must_use]
pub fn to_byte(linear: f32) -> u8 {
    /// Steps in which guesses are kept: fine enough that a guess is off by three at most.
    const STEPS: usize = 4096;
    /// Guesses, and the light from which each byte is the nearest.
    static TABLES: LazyLock<(Vec<u8>, [f32; 256])> = LazyLock::new(|| {
        let from = std::array::from_fn(|k| decode((k as f32 - 0.5) / 255.0));
        let guess = (0..=STEPS).map(|i| (encode(i as f32 / STEPS as f32) * 255.0).round() as u8).collect();
        (guess, from)
    });
    let (guess, from) = &*TABLES;
    let mut byte = usize::from(guess[(linear.clamp(0.0, 1.0) * STEPS as f32) as usize]);
    while byte < 255 && linear >= from[byte + 1] {
        byte += 1;
    }
    byte as u8
}

/// A colour with encoded red, green and blue as linear light; alpha stays.
pub(crate) fn decode_color(c: Vec4) -> Vec4 {
    Vec3::from_array([c.x, c.y, c.z].map(decode)).extend(c.w)
}

/// Linear light of the 256 values of an 8-bit image.
pub(crate) fn byte_table() -> [f32; 256] {
    std::array::from_fn(|k| decode(k as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::{byte_table, decode, encode, encode_near, to_byte};

    #[test]
    fn every_byte_comes_back() {
        for (byte, linear) in byte_table().into_iter().enumerate() {
            assert_eq!((encode(linear) * 255.0).round() as usize, byte, "byte {byte} through linear light");
            assert_eq!(usize::from(to_byte(linear)), byte, "byte {byte} by table");
        }
    }

    #[test]
    fn the_near_curve_is_near() {
        for k in -10..=100_010 {
            let linear = k as f32 / 100_000.0;
            assert!((encode_near(linear) - encode(linear)).abs() < 5e-6, "{linear}");
        }
    }

    #[test]
    fn the_table_agrees_with_the_curve_between_bytes() {
        for k in 0..=100_000 {
            let linear = k as f32 / 100_000.0;
            let encoded = encode(linear) * 255.0;
            // At the very middle between two bytes either is right.
            if (encoded.fract() - 0.5).abs() > 1e-3 {
                assert_eq!(f32::from(to_byte(linear)), encoded.round(), "{linear}");
            }
        }
        assert_eq!([f32::NAN, -1.0, 2.0].map(to_byte), [0, 0, 255], "beyond the range");
        assert_eq!(to_byte(decode(1.0)), 255, "white");
    }
}
