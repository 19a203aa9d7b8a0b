//! Random numbers that stay the same for ever: a PCG generator and our own distributions on top of it, because a
//! distribution from a library may change its values from one version to the next.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// A reproducible stream of random numbers.
#[derive(Debug, Clone)]
pub struct Random(Pcg64);

impl Random {
    /// Stream number `stream` of a seed; streams of one seed are independent of each other.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        // An odd multiplier spreads neighbouring seeds over the state.
        Self(Pcg64::new(u128::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15_F39C_C060_5CED_C835), u128::from(stream)))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0..count; 0 if `count` is 0. The bias of the product method is below 2^-32 for any count in use.
    pub fn below(&mut self, count: u64) -> u64 {
        ((u128::from(self.0.next_u64()) * u128::from(count)) >> 64) as u64
    }

    /// Brings items into random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Random;

    #[test]
    fn values_never_change_between_versions() {
        let mut r = Random::new(1, 2);
        let first: Vec<u64> = (0..4).map(|_| r.below(1000)).collect();
        assert_eq!(first, PINNED, "a changed generator changes every layout ever made");
    }
    const PINNED: [u64; 4] = [536, 230, 666, 531];

    #[test]
    fn streams_and_seeds_differ() {
        let draw = |seed, stream| Random::new(seed, stream).below(u64::MAX);
        assert_ne!(draw(1, 1), draw(1, 2), "streams");
        assert_ne!(draw(1, 1), draw(2, 1), "seeds");
    }
}
