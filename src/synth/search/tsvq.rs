//! Tree-structured vector quantization.
//!
//! Based on: Wei, Levoy, "Fast texture synthesis using tree-structured vector quantization", SIGGRAPH 2000, sec. 4: a binary tree of
//! codewords, each the centroid of the candidates below it, split in two by the generalised Lloyd algorithm; a query goes down to
//! the nearer codeword at every node, and takes the best of the few candidates of the leaf it comes to.

use super::{Choice, Nearby, Search};
use crate::numeric::rows::{Rows, distance_squared};

/// A node with no more candidates than this is not split further.
const LEAF: usize = 4;
/// Rounds of Lloyd's algorithm at each split.
const ROUNDS: usize = 4;

/// A codebook.
pub(in super::super) struct Tsvq {
    /// Candidates in the order of the leaves.
    rows: Rows,
    names: Vec<u32>,
    codewords: Rows,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    /// Candidates below.
    start: u32,
    end: u32,
    /// The first of two children, whose codewords have the same numbers; 0 for a leaf.
    child: u32,
}

impl Tsvq {
    pub(in super::super) fn new(rows: &Rows) -> Self {
        let mut names: Vec<u32> = (0..rows.len() as u32).collect();
        let mut codewords = Rows::new(rows.dims());
        codewords.push(&[]);
        let mut nodes = vec![Node { start: 0, end: names.len() as u32, child: 0 }];
        let mut at = 0;
        while at < nodes.len() {
            let node = nodes[at];
            let below = &mut names[node.start as usize..node.end as usize];
            if below.len() > LEAF
                && let Some((low, words)) = split(rows, below)
            {
                nodes[at].child = nodes.len() as u32;
                let middle = node.start + low as u32;
                nodes.push(Node { start: node.start, end: middle, child: 0 });
                nodes.push(Node { start: middle, end: node.end, child: 0 });
                words.iter().for_each(|w| codewords.push(w));
            }
            at += 1;
        }
        Self { rows: rows.select(&names), names, codewords, nodes }
    }

    fn find(&self, query: &[f32]) -> u32 {
        let mut node = self.nodes[0];
        while node.child != 0 {
            let [a, b] = [0, 1].map(|k| distance_squared(query, self.codewords.row((node.child + k) as usize)));
            node = self.nodes[(node.child + u32::from(b < a)) as usize];
        }
        let to = |&i: &u32| distance_squared(query, self.rows.row(i as usize));
        let best = (node.start..node.end).min_by(|a, b| to(a).total_cmp(&to(b)));
        best.map_or(0, |i| self.names[i as usize])
    }
}

/// Puts the candidates of one half first; returns how many, and both centroids. `None` if all are the same.
fn split(rows: &Rows, names: &mut [u32]) -> Option<(usize, [Vec<f32>; 2])> {
    let row = |i: u32| rows.row(i as usize);
    let farthest = |from: &[f32]| -> u32 {
        let far = |a: &&u32, b: &&u32| distance_squared(from, row(**a)).total_cmp(&distance_squared(from, row(**b)));
        names.iter().max_by(far).copied().unwrap_or(names[0])
    };
    // Two candidates far apart begin.
    let a = farthest(&centroid(rows, names));
    let b = farthest(row(a));
    let mut words = [row(a).to_vec(), row(b).to_vec()];
    if distance_squared(&words[0], &words[1]) == 0.0 {
        return None;
    }
    let mut nearer = Vec::new();
    for _ in 0..ROUNDS {
        nearer = names.iter().map(|&i| distance_squared(row(i), &words[1]) < distance_squared(row(i), &words[0])).collect();
        let part =
            |second: bool| -> Vec<u32> { names.iter().zip(&nearer).filter(|(_, s)| **s == second).map(|(i, _)| *i).collect() };
        let parts = [part(false), part(true)];
        if parts.iter().any(Vec::is_empty) {
            return None;
        }
        words = parts.map(|p| centroid(rows, &p));
    }
    let (low, high): (Vec<_>, Vec<_>) = names.iter().zip(&nearer).partition(|(_, s)| !**s);
    let count = low.len();
    let order: Vec<u32> = low.into_iter().chain(high).map(|(i, _)| *i).collect();
    names.copy_from_slice(&order);
    Some((count, words))
}

fn centroid(rows: &Rows, names: &[u32]) -> Vec<f32> {
    let mut sum = vec![0.0_f32; rows.dims()];
    for &i in names {
        sum.iter_mut().zip(rows.row(i as usize)).for_each(|(s, x)| *s += x);
    }
    sum.iter_mut().for_each(|s| *s /= names.len() as f32);
    sum
}

impl Search for Tsvq {
    fn choose(&self, queries: &Rows, _nearby: &Nearby) -> Vec<Choice> {
        queries.iter().map(|q| Choice::Row(self.find(q))).collect()
    }
}
