//! The border between sRGB numbers in files and linear light inside (IEC 61966-2-1).

use glam::{Vec3, Vec4};

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
    use super::{byte_table, encode};

    #[test]
    fn every_byte_comes_back() {
        for (byte, linear) in byte_table().into_iter().enumerate() {
            assert_eq!((encode(linear) * 255.0).round() as usize, byte, "byte {byte} through linear light");
        }
    }
}
