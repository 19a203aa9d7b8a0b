//! Squares whose sides are powers of two, packed into layers.
//!
//! Laid largest first along a Z-order curve each square lies at a multiple of its own side and no room is left between
//! them. So at every mip level down to its own single pixel a square keeps a place of its own.

/// Where a square lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) layer: u32,
    pub(super) at: [u32; 2],
}

/// The sides of layers are at least this, so that few small squares do not make many layers.
const LEAST_LAYER: u32 = 256;
/// Layers may grow until there are about so many.
const FEW_LAYERS: u64 = 8;

/// Squares in layers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Packing {
    /// Side of a layer.
    pub(super) side: u32,
    pub(super) layers: u32,
    /// One per square, in the order given.
    pub(super) places: Vec<Place>,
}

/// Packs squares of the given sides (powers of two, at most `longest`).
pub(super) fn pack(sides: &[u32], longest: u32) -> Packing {
    let area: u64 = sides.iter().map(|&s| u64::from(s) * u64::from(s)).sum();
    let largest = sides.iter().copied().max().unwrap_or(1);
    let mut side = largest.max(LEAST_LAYER.min(longest));
    // One layer no larger than what it holds; several grow.
    while side / 2 >= largest && area <= u64::from(side / 2) * u64::from(side / 2) {
        side /= 2;
    }
    while side * 2 <= longest && area > FEW_LAYERS * u64::from(side) * u64::from(side) {
        side *= 2;
    }
    let mut by_size: Vec<usize> = (0..sides.len()).collect();
    by_size.sort_by_key(|&i| (std::cmp::Reverse(sides[i]), i));
    let mut places = vec![Place { layer: 0, at: [0, 0] }; sides.len()];
    let layer_area = u64::from(side) * u64::from(side);
    let mut used = 0_u64;
    for i in by_size {
        let within = used % layer_area;
        places[i] = Place { layer: (used / layer_area) as u32, at: [even_bits(within), even_bits(within >> 1)] };
        used += u64::from(sides[i]) * u64::from(sides[i]);
    }
    Packing { side, layers: used.div_ceil(layer_area).max(1) as u32, places }
}

/// Every second bit, the lowest first.
fn even_bits(v: u64) -> u32 {
    (0..32).map(|bit| ((v >> (2 * bit)) as u32 & 1) << bit).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn squares_lie_apart_and_at_multiples_of_their_side() {
        let mut random = Random::new(5, 0);
        for count in [0, 1, 7, 300] {
            let sides: Vec<u32> = (0..count).map(|_| 1 << (random.range(0.0, 7.0) as u32)).collect();
            for longest in [64, 128, 2048] {
                let packing = pack(&sides, longest);
                let side = packing.side as usize;
                assert!(side <= longest.max(1) as usize, "layers of {side} keep to {longest}");
                let mut taken = vec![false; side * side * packing.layers as usize];
                for (place, &s) in packing.places.iter().zip(&sides) {
                    assert!(place.at.iter().all(|a| a % s == 0), "{place:?} at multiples of {s}");
                    for y in place.at[1]..place.at[1] + s {
                        for x in place.at[0]..place.at[0] + s {
                            let cell = &mut taken[(place.layer as usize * side + y as usize) * side + x as usize];
                            assert!(!std::mem::replace(cell, true), "{place:?} of {s} is free");
                        }
                    }
                }
                let area: u32 = sides.iter().map(|s| s * s).sum();
                let whole = packing.side * packing.side;
                assert!((packing.layers - 1) * whole < area.max(1), "no layer is empty");
            }
        }
    }
}
