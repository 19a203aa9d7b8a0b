//! The batches in which vertices are visited, each matched at once from what the ones before left.

use crate::random::Random;

/// All of so many vertices in random order, cut into `count` batches of equal size.
#[must_use]
pub fn batches(vertices: usize, count: usize, random: &mut Random) -> Vec<Vec<u32>> {
    let mut order: Vec<u32> = (0..vertices as u32).collect();
    random.shuffle(&mut order);
    let size = vertices.div_ceil(count.clamp(1, vertices.max(1))).max(1);
    // Within a batch the order does not matter, and neighbours share memory.
    order
        .chunks(size)
        .map(|b| {
            let mut b = b.to_vec();
            b.sort_unstable();
            b
        })
        .collect()
}
