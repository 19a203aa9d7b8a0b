//! The closed path of least cost around the middle of a mask, a ring for each way.
//!
//! Dynamic programming: once around twice to find a place that the best path passes, then once around from there and back to it.

use super::super::cut::CUT_STEPS;
use super::{CLIMB, Comparison, FLOOR, HARD, Plan, RINGS, RISE, distance};

/// Rings that are looked at together; all are a multiple.
const LANES: usize = 8;

/// A closed path.
pub(super) struct Path {
    /// A ring per way.
    pub rings: [usize; CUT_STEPS],
    /// Weights and squared differences along the mask's border, and squared differences along the path; hard edges among them.
    pub sums: [f64; 3],
    /// What the mask's border and the path cost, hard edges counted as they show.
    pub price: [f64; 2],
}

/// The closed path of least difference.
pub(super) fn shortest(plan: &Plan, compared: &Comparison) -> Path {
    let hard = |way: usize, ring: usize| compared.hard.get(way).map_or([0.0; 2], |rings| rings[ring]);
    let cell = |way: usize, ring: usize| plan.cell[way * RINGS + ring] as usize;
    let error = |way: usize, ring: usize| compared.around[cell(way, ring)];
    // From the mask's border on, all rings stand for it.
    let cost: Vec<[f32; RINGS]> = (0..CUT_STEPS)
        .map(|way| {
            std::array::from_fn(|ring| {
                let inside = ring + 1 < plan.end[way];
                let open = ring < compared.first || inside && distance(ring) < compared.least[way];
                if open { f32::INFINITY } else { FLOOR + error(way, ring) + HARD * hard(way, ring)[0] }
            })
        })
        .collect();
    let twice = around(&cost, compared.first, 2, None);
    let rings = around(&cost, compared.first, 1, Some(twice[CUT_STEPS]));
    let mut path = Path { rings: [0; CUT_STEPS], sums: [0.0; 3], price: [0.0; 2] };
    for (way, (ring, chosen)) in path.rings.iter_mut().zip(rings).enumerate() {
        *ring = chosen;
        let at = |ring: usize| f64::from(error(way, ring));
        let sharp = |ring: usize| hard(way, ring).map(f64::from);
        let ([border, weight], [left, _]) = (sharp(RINGS - 1), sharp(chosen));
        path.sums[0] += f64::from(compared.error[cell(way, RINGS - 1)][1]) + weight;
        path.sums[1] += at(RINGS - 1) + border;
        path.sums[2] += at(chosen) + left;
        path.price[0] += at(RINGS - 1) + f64::from(HARD) * border;
        path.price[1] += at(chosen) + f64::from(HARD) * left;
    }
    path
}

/// The cheapest path so many times around, from way 0 back to it: at a ring given, or anywhere from the first on. One ring more than
/// ways passed.
fn around(cost: &[[f32; RINGS]], first: usize, times: usize, ends: Option<usize>) -> Vec<usize> {
    let length: [f32; CLIMB + 1] = std::array::from_fn(|climb| (1.0 + (climb as f32 * RISE).powi(2)).sqrt() * 0.5);
    let start: [f32; RINGS] = std::array::from_fn(|ring| if ends.is_none_or(|e| e == ring) { 0.0 } else { f32::INFINITY });
    let (mut total, mut before) = (with_margins(&start), with_margins(&cost[0]));
    // The step up from the last ring, counted from the steepest down.
    let mut from: Vec<[u8; RINGS]> = Vec::with_capacity(times * CUT_STEPS);
    for way in 1..=times * CUT_STEPS {
        let here = &cost[way % CUT_STEPS];
        let (mut next, mut came) = ([f32::INFINITY; RINGS], [0; RINGS]);
        for block in first / LANES..RINGS / LANES {
            let rings = block * LANES..(block + 1) * LANES;
            let (sums, steps) = cheapest_steps(&total[rings.start..], &before[rings.start..], &here[rings.clone()], &length);
            next[rings.clone()].copy_from_slice(&sums);
            came[rings].copy_from_slice(&steps);
        }
        (total, before) = (with_margins(&next), with_margins(here));
        from.push(came);
    }
    let cheapest = || (first..RINGS).rev().min_by(|&a, &b| total[CLIMB + a].total_cmp(&total[CLIMB + b])).unwrap_or(RINGS - 1);
    let mut rings = vec![ends.unwrap_or_else(cheapest)];
    for came in from.iter().rev() {
        let ring = rings[rings.len() - 1];
        rings.push((ring + usize::from(came[ring])).saturating_sub(CLIMB));
    }
    rings.reverse();
    rings
}

/// For [`LANES`] rings next to each other, what the cheapest step to each costs in all, and which it is, from the steepest down.
/// `total` and `before` begin [`CLIMB`] rings below them.
fn cheapest_steps(total: &[f32], before: &[f32], here: &[f32], length: &[f32; CLIMB + 1]) -> ([f32; LANES], [u8; LANES]) {
    let (mut least, mut steps) = ([f32::INFINITY; LANES], [0.0_f32; LANES]);
    for step in 0..=2 * CLIMB {
        let length = length[step.abs_diff(CLIMB)];
        let (total, before) = (&total[step..][..LANES], &before[step..][..LANES]);
        // Without a branch, and with numbers of one width: compiled to a few instructions for several rings.
        for lane in 0..LANES {
            let sum = total[lane] + length * (before[lane] + here[lane]);
            let less = sum < least[lane];
            least[lane] = if less { sum } else { least[lane] };
            steps[lane] = if less { step as f32 } else { steps[lane] };
        }
    }
    (least, steps.map(|step| step as u8))
}

/// Nothing beyond the first and last rings.
fn with_margins(rings: &[f32; RINGS]) -> [f32; RINGS + 2 * CLIMB] {
    let mut out = [f32::INFINITY; RINGS + 2 * CLIMB];
    out[CLIMB..CLIMB + RINGS].copy_from_slice(rings);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// What a path costs.
    fn price(cost: &[[f32; RINGS]], rings: &[usize]) -> f32 {
        let step = |(way, pair): (usize, &[usize])| {
            let rise = pair[0].abs_diff(pair[1]) as f32 * RISE;
            0.5 * (cost[way][pair[0]] + cost[(way + 1) % CUT_STEPS][pair[1]]) * rise.hypot(1.0)
        };
        rings.windows(2).enumerate().map(step).sum()
    }

    #[test]
    fn a_path_follows_a_valley_and_comes_back_to_where_it_began() {
        let valley = |way: usize| {
            let turn = std::f32::consts::TAU * way as f32 / CUT_STEPS as f32;
            (RINGS as f32 * (0.5 + 0.4 * (2.0 * turn).sin())) as usize
        };
        let cost: Vec<[f32; RINGS]> =
            (0..CUT_STEPS).map(|way| std::array::from_fn(|ring| if ring == valley(way) { 0.01 } else { 1.0 })).collect();
        let start = around(&cost, 0, 2, None)[CUT_STEPS];
        let rings = around(&cost, 0, 1, Some(start));
        assert_eq!(rings.first(), rings.last(), "closed");
        for way in 0..CUT_STEPS {
            assert_eq!(rings[way], valley(way), "way {way}");
        }
    }

    #[test]
    fn no_closed_path_through_its_beginning_is_cheaper() {
        let mut random = Random::new(4, 0);
        let cost: Vec<[f32; RINGS]> = (0..CUT_STEPS).map(|_| std::array::from_fn(|_| random.unit() as f32)).collect();
        let rings = around(&cost, 0, 1, Some(7));
        let best = price(&cost, &rings);
        for _ in 0..2000 {
            // Another path that leaves it for a while.
            let mut other = rings.clone();
            let way = 1 + random.below(CUT_STEPS as u64 - 2) as usize;
            other[way] = (other[way] + random.below(3) as usize).saturating_sub(1).min(RINGS - 1);
            if other.windows(2).all(|w| w[0].abs_diff(w[1]) <= CLIMB) {
                assert!(price(&cost, &other) >= best - 1e-4, "cheaper by way {way}");
            }
        }
    }
}
