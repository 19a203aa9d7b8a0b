//! A kd-tree over rows for approximate search: the best row of a few leaves, the nearest leaves first.
//!
//! Based on: Arya, Mount, "Algorithms for fast vector quantization", DCC 1993: cells wait in a queue, ordered by their distance
//! from the query, which grows side by side on the way down.

use super::rows::{Rows, distance_squared};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Rows of a leaf at most.
const LEAF: usize = 12;

/// The tree.
#[derive(Debug, Clone)]
pub struct KdTree {
    nodes: Vec<Node>,
    /// Rows in the order of the leaves.
    rows: Rows,
    names: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    start: u32,
    end: u32,
    /// The first of two neighbouring children; 0 for a leaf.
    child: u32,
    axis: u32,
    cut: f32,
}

impl KdTree {
    /// Builds the tree; n log n.
    #[must_use]
    pub fn new(rows: &Rows) -> Self {
        let mut names: Vec<u32> = (0..rows.len() as u32).collect();
        let mut nodes = vec![Node { start: 0, end: names.len() as u32, child: 0, axis: 0, cut: 0.0 }];
        let mut at = 0;
        while at < nodes.len() {
            let node = nodes[at];
            let below = &mut names[node.start as usize..node.end as usize];
            if below.len() > LEAF {
                let (axis, spread) = widest(rows, below);
                if spread > 0.0 {
                    let key = |i: &u32| rows.row(*i as usize)[axis];
                    let half = below.len() / 2;
                    // Names settle what values leave open, so that the order never depends on the sort.
                    below.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
                    let cut = key(&below[half]);
                    let middle = node.start + half as u32;
                    let child = nodes.len() as u32;
                    nodes[at] = Node { child, axis: axis as u32, cut, ..node };
                    nodes.push(Node { start: node.start, end: middle, child: 0, axis: 0, cut: 0.0 });
                    nodes.push(Node { start: middle, end: node.end, child: 0, axis: 0, cut: 0.0 });
                }
            }
            at += 1;
        }
        Self { nodes, rows: rows.select(&names), names }
    }

    /// Something to search with.
    #[must_use]
    pub fn finder(&self) -> Finder<'_> {
        Finder { tree: self, queue: BinaryHeap::new() }
    }
}

/// The axis along which rows spread most, and how far. A few dozen rows tell.
fn widest(rows: &Rows, names: &[u32]) -> (usize, f32) {
    let step = names.len().div_ceil(64).max(1);
    let mut bounds = vec![(f32::INFINITY, f32::NEG_INFINITY); rows.dims()];
    for &i in names.iter().step_by(step) {
        for (b, &x) in bounds.iter_mut().zip(rows.row(i as usize)) {
            *b = (b.0.min(x), b.1.max(x));
        }
    }
    let spread = |b: &(f32, f32)| b.1 - b.0;
    let best = (0..bounds.len()).max_by(|&a, &b| spread(&bounds[a]).total_cmp(&spread(&bounds[b])).then(b.cmp(&a)));
    best.map_or((0, 0.0), |k| (k, spread(&bounds[k])))
}

/// A search with its queue.
#[derive(Debug)]
pub struct Finder<'a> {
    tree: &'a KdTree,
    queue: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Finder<'_> {
    /// The nearest row among those of `leaves` leaves, if it is nearer than `within` (a squared distance), and its own squared
    /// distance; with as many leaves as there are, the nearest of all.
    #[inline(always)]
    pub fn nearest(&mut self, query: &[f32], leaves: usize, within: f32) -> Option<(u32, f32)> {
        let tree = self.tree;
        let mut best = (within, u32::MAX);
        let mut left = leaves;
        self.queue.clear();
        self.queue.push(Reverse((0, 0)));
        while let Some(Reverse((bits, index))) = self.queue.pop() {
            // Distances are not negative, and such floats are ordered as their bits are.
            let away = f32::from_bits(bits);
            if left == 0 || away >= best.0 {
                break;
            }
            let mut node = tree.nodes[index as usize];
            while node.child != 0 {
                let side = query[node.axis as usize] - node.cut;
                let (near, far) = if side < 0.0 { (node.child, node.child + 1) } else { (node.child + 1, node.child) };
                // A bound, if not the tightest: the distance to this cut, or to the cell as it was.
                let there = away.max(side * side);
                if there < best.0 {
                    self.queue.push(Reverse((there.to_bits(), far)));
                }
                node = tree.nodes[near as usize];
            }
            for k in node.start..node.end {
                let squared = distance_squared(query, tree.rows.row(k as usize));
                if squared < best.0 || (squared == best.0 && best.1 != u32::MAX && tree.names[k as usize] < best.1) {
                    best = (squared, tree.names[k as usize]);
                }
            }
            left -= 1;
        }
        (best.1 != u32::MAX).then_some((best.1, best.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn all_leaves_find_the_nearest_and_a_few_come_close() {
        let mut random = Random::new(5, 0);
        let mut rows = Rows::zeros(2000, 6);
        rows.data_mut().iter_mut().for_each(|x| *x = random.unit() as f32);
        let tree = KdTree::new(&rows);
        let mut finder = tree.finder();
        let (mut few, mut least) = (0.0, 0.0);
        for _ in 0..200 {
            let query: Vec<f32> = (0..6).map(|_| random.unit() as f32).collect();
            let near = |i: &usize| distance_squared(&query, rows.row(*i));
            let truth = (0..rows.len()).min_by(|a, b| near(a).total_cmp(&near(b))).expect("there are rows");
            assert_eq!(finder.nearest(&query, usize::MAX, f32::INFINITY).expect("one").0 as usize, truth, "all leaves");
            assert_eq!(finder.nearest(&query, usize::MAX, near(&truth)), None, "nothing is nearer than the nearest");
            few += finder.nearest(&query, 8, f32::INFINITY).expect("one").1.sqrt();
            least += near(&truth).sqrt();
        }
        assert!(few < 1.1 * least, "eight leaves are {} times as far", few / least);
    }
}
