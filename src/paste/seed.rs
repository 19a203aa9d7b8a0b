//! Where the next paste goes (LT 3.3): a random point that is not covered yet.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 3.3.
//!
//! Faces are drawn with a chance proportional to their uncovered area, from a tree of partial sums, so that a draw costs
//! log n and never a scan. While little is covered, faces where a patch will be hard to lay flat weigh more: pastes
//! that distort there will be covered by later ones.

use crate::random::Random;

/// Partial sums of weights that can be changed and drawn from in log n (a Fenwick tree).
#[derive(Debug, Clone)]
pub struct WeightedDraw {
    /// `tree[i]` is the sum of the weights of a run that ends at item `i`, 1-based.
    tree: Vec<u64>,
    weight: Vec<u64>,
    total: u64,
}

impl WeightedDraw {
    /// From the weights of all items.
    #[must_use]
    pub fn new(weight: Vec<u64>) -> Self {
        let mut tree = vec![0; weight.len() + 1];
        for i in 1..tree.len() {
            tree[i] += weight[i - 1];
            let parent = i + (i & i.wrapping_neg());
            if parent < tree.len() {
                tree[parent] += tree[i];
            }
        }
        let total = weight.iter().sum();
        Self { tree, weight, total }
    }

    /// Sum of all weights.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.total
    }

    /// Changes a weight.
    pub fn set(&mut self, item: u32, weight: u64) {
        let old = std::mem::replace(&mut self.weight[item as usize], weight);
        self.total = self.total - old + weight;
        let mut i = item as usize + 1;
        while i < self.tree.len() {
            self.tree[i] = (self.tree[i] + weight).wrapping_sub(old);
            i += i & i.wrapping_neg();
        }
    }

    /// Draws an item with a chance proportional to its weight; `None` if all weights are 0.
    pub fn draw(&self, random: &mut Random) -> Option<u32> {
        if self.total == 0 {
            return None;
        }
        let mut left = random.below(self.total);
        let mut at = 0;
        let mut step = self.tree.len().next_power_of_two() >> 1;
        while step > 0 {
            let next = at + step;
            if next < self.tree.len() && self.tree[next] <= left {
                left -= self.tree[next];
                at = next;
            }
            step >>= 1;
        }
        Some(at as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_follow_the_weights_after_changes() {
        let mut draw = WeightedDraw::new(vec![5, 0, 1, 7, 3]);
        draw.set(0, 0);
        draw.set(1, 4);
        let mut random = Random::new(9, 0);
        let mut counts = [0_u32; 5];
        for _ in 0..30_000 {
            counts[draw.draw(&mut random).unwrap() as usize] += 1;
        }
        for (count, weight) in counts.into_iter().zip([0.0, 4.0, 1.0, 7.0, 3.0]) {
            let expected = 30_000.0 * weight / 15.0;
            assert!((f64::from(count) - expected).abs() < 300.0, "{counts:?}");
        }
        (0..5).for_each(|i| draw.set(i, 0));
        assert_eq!(draw.draw(&mut random), None, "nothing left");
    }
}
