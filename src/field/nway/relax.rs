//! Relaxation: each node in turn takes the direction that fits its neighbours best, until nothing changes.
//!
//! Based on: Wei, Levoy 2001, sec. 3.1, whose error of a node is the sum over its neighbours of the squared angle between the two
//! directions, less the nearest multiple of a full turn over n.
//!
//! That error has steps where the nearest multiple changes, and relaxation stands still in one of very many minima with dozens of
//! singularities too many. So it is done first with the smooth function that has the same minima in the small, 2 (1 - cos n
//! phi) / n^2, whose least value over one node is found exactly; and then with the paper's own, by moving to the mean of what
//! is left of the angles. Both fall with every step.

use super::connection::{Connection, Neighbour, unit, wrapped};
use glam::DVec2;
use rayon::prelude::*;

/// Which error is relaxed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// 2 (1 - cos n phi) / n^2.
    Smooth,
    /// The square of phi less the nearest multiple of a full turn over n (the paper's).
    Nearest,
}

/// A wish at each node: the n-th power of a direction, as long as the wish is strong; zero for none.
pub type Wishes = [DVec2];

/// How far a node goes: beyond the best place, to which 1 would take it, towards its mirror image, 2, at which it would gain nothing
/// (successive over-relaxation; Young 1954). The error still never rises, and falls as far in a third of the sweeps.
const OVER: f64 = 1.7;

/// Relaxation ends when a sweep gains less than this share of the error,
const SETTLED: f64 = 3e-4;
/// or after this many sweeps.
const SWEEPS: usize = 300;

/// Nodes whose errors are summed by one thread.
const PIECE: usize = 1024;

/// The error of a whole field: each pair of neighbours once, weighted, and the wishes.
#[must_use]
pub fn energy(table: &Connection, n: u32, powers: &[DVec2], wishes: &Wishes, measure: Measure) -> f64 {
    let degree = f64::from(n);
    // The paper's error is of angles; taken once for each node they need no arc tangent for each pair.
    let angles = if measure == Measure::Nearest { angles(powers) } else { Vec::new() };
    let of_node = |i: u32| {
        let here = powers[i as usize];
        let pair = |there: Neighbour| {
            let apart = match measure {
                Measure::Smooth => error(here, powers[there.node as usize].rotate(unit(degree * there.turn)), degree, measure),
                Measure::Nearest => {
                    (wrapped(angles[there.node as usize] + degree * there.turn - angles[i as usize]) / degree).powi(2)
                }
            };
            0.5 * there.weight * apart
        };
        let wish = wishes.get(i as usize).copied().unwrap_or_default();
        let strength = wish.length();
        let wished = if strength > 0.0 { strength * error(here, wish / strength, degree, measure) } else { 0.0 };
        table.neighbours(i).map(pair).sum::<f64>() + wished
    };
    // Summed in pieces that do not depend on the threads.
    let nodes: Vec<u32> = (0..table.len() as u32).collect();
    let sums: Vec<f64> = nodes.par_chunks(PIECE).map(|some| some.iter().map(|&i| of_node(i)).sum()).collect();
    sums.iter().sum()
}

/// The angles of unit complex numbers.
pub(super) fn angles(powers: &[DVec2]) -> Vec<f64> {
    powers.par_iter().map(|p| p.to_angle()).collect()
}

fn error(a: DVec2, b: DVec2, degree: f64, measure: Measure) -> f64 {
    match measure {
        Measure::Smooth => a.distance_squared(b) / (degree * degree),
        Measure::Nearest => (a.perp_dot(b).atan2(a.dot(b)) / degree).powi(2),
    }
}

/// Relaxes a field given as n-th powers of unit complex numbers. Returns the error before and after each sweep.
pub fn relax(table: &Connection, n: u32, powers: &mut [DVec2], wishes: &Wishes, measure: Measure) -> Vec<f64> {
    let degree = f64::from(n);
    let carries: Vec<DVec2> = table.turns().par_iter().map(|turn| unit(degree * turn)).collect();
    let mut errors = vec![energy(table, n, powers, wishes, measure)];
    for _ in 0..SWEEPS {
        let (mut at, mut gain) = (0, 0.0);
        for i in 0..table.len() as u32 {
            let here = powers[i as usize];
            let wish = wishes.get(i as usize).copied().unwrap_or_default();
            let (mut sum, mut angle, mut weight) = (wish, 0.0, wish.length());
            if measure == Measure::Nearest && weight > 0.0 {
                angle += weight * here.angle_to(wish);
            }
            for there in table.neighbours(i) {
                let carried = powers[there.node as usize].rotate(carries[at]);
                at += 1;
                match measure {
                    Measure::Smooth => sum += carried * there.weight,
                    Measure::Nearest => {
                        angle += there.weight * here.perp_dot(carried).atan2(here.dot(carried));
                        weight += there.weight;
                    }
                }
            }
            powers[i as usize] = match measure {
                Measure::Smooth => {
                    // What a node gains is known without looking at the whole field again.
                    let length = sum.length();
                    let best = sum.try_normalize().unwrap_or(here);
                    let before = here.dot(best);
                    let mirrored = best * (2.0 * before) - here;
                    let beyond = best.lerp(mirrored, OVER - 1.0).try_normalize().filter(|_| before > 0.0).unwrap_or(best);
                    gain += length * (beyond.dot(best) - before).max(0.0);
                    beyond
                }
                Measure::Nearest if weight > 0.0 => here.rotate(unit(OVER * wrapped(angle / weight))).normalize_or(here),
                Measure::Nearest => here,
            };
        }
        let before = errors[errors.len() - 1];
        let after = match measure {
            Measure::Smooth => before - 2.0 * gain / (degree * degree),
            Measure::Nearest => energy(table, n, powers, wishes, measure),
        };
        errors.push(after);
        if before - after <= SETTLED * before {
            break;
        }
    }
    errors
}
