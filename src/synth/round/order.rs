//! The order in which vertices are synthesised: a random one first, then always one with the most synthesised neighbours.
//!
//! Based on: Chen, Dong 2008, sec. 3: the vertex "whose neighbourhood covers the largest number of already synthesized vertices".
//!
//! Counted are the vertices beside a synthesised one and the samples around it, each for the vertex nearest to it: a vertex on one's
//! circle has one on its own. The order depends on the surface alone, so it is made first. Vertices wait in buckets by their count, the one that
//! came first to its count first; each count of each vertex is one entry, and old ones are passed over. Linear in all samples.
//! When nothing waits, another part of the surface begins at a vertex drawn at random.

use super::ground::Ground;
use crate::random::Random;
use std::collections::VecDeque;

/// All vertices of a ground in order, and how many starts there were.
pub(super) fn order(ground: &impl Ground, samples: usize, seed: u64) -> (Vec<u32>, usize) {
    let vertices = ground.len();
    let mut random = Random::new(seed, 0x0DE5);
    // Starts are tried in random order.
    let mut drawn: Vec<u32> = (0..vertices as u32).collect();
    random.shuffle(&mut drawn);
    let mut counts = vec![0_u32; vertices];
    let mut done = vec![false; vertices];
    let mut buckets: Vec<VecDeque<u32>> = Vec::new();
    let mut out = Vec::with_capacity(vertices);
    let (mut top, mut starts) = (0, 0);
    let mut raise = |v: u32, done: &[bool], buckets: &mut Vec<VecDeque<u32>>, top: &mut usize| {
        if !done[v as usize] {
            counts[v as usize] += 1;
            let count = counts[v as usize] as usize;
            if buckets.len() <= count {
                buckets.resize_with(count + 1, VecDeque::new);
            }
            buckets[count].push_back(v);
            *top = count.max(*top);
        }
    };
    for start in drawn {
        if done[start as usize] {
            continue;
        }
        starts += 1;
        let mut waiting = Some(start);
        while let Some(v) = waiting {
            if !std::mem::replace(&mut done[v as usize], true) {
                out.push(v);
                ground.beside(v, &mut |w| raise(w, &done, &mut buckets, &mut top));
                for tap in (0..samples).filter_map(|k| ground.tap(v, k)) {
                    raise(tap.main(), &done, &mut buckets, &mut top);
                }
            }
            waiting = loop {
                match buckets.get_mut(top).and_then(VecDeque::pop_front) {
                    Some(v) => break Some(v),
                    None if top == 0 => break None,
                    None => top -= 1,
                }
            };
        }
    }
    (out, starts)
}
