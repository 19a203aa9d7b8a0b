//! Which vertices stand at one place: at equal positions, or within a tolerance of an earlier one.

use super::NONE;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// For each vertex the first one at its place, and whether a face uses it. Unused vertices weld to nothing.
pub(super) fn weld_map(positions: &[Vec3], faces: &[[u32; 3]], tolerance: f64) -> (Vec<u32>, Vec<bool>) {
    let mut used = vec![false; positions.len()];
    for &v in faces.as_flattened() {
        used[v as usize] = true;
    }
    let mut weld: Vec<u32> = (0..positions.len() as u32).collect();
    let farthest = positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    // A tolerance below the steps of the largest coordinates can only mean equal positions, and its grid would have more
    // cells than numbers.
    if tolerance > f64::from(farthest) * f64::from(f32::EPSILON) / 4.0 {
        weld_near(positions, &used, tolerance, &mut weld);
    } else {
        // -0 and +0 are the same place.
        let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut order: Vec<u32> = (0..positions.len() as u32).filter(|&v| used[v as usize]).collect();
        order.sort_unstable_by_key(|&v| (key(positions[v as usize]), v));
        for same in order.chunk_by(|&a, &b| key(positions[a as usize]) == key(positions[b as usize])) {
            for &v in same {
                weld[v as usize] = same[0];
            }
        }
    }
    (weld, used)
}

/// Welds within a tolerance: each vertex goes to the first earlier representative within reach, found on a grid.
fn weld_near(positions: &[Vec3], used: &[bool], tolerance: f64, weld: &mut [u32]) {
    let cell = |p: DVec3| (p / tolerance).floor().to_array().map(|c| c as i64);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for v in 0..positions.len() {
        if !used[v] {
            continue;
        }
        let p = positions[v].as_dvec3();
        let [x, y, z] = cell(p);
        let mut found = NONE;
        for dx in -1..=1 {
            for dy in -1..=1 {
                for dz in -1..=1 {
                    let Some(here) = grid.get(&[x + dx, y + dy, z + dz]) else { continue };
                    for &r in here {
                        if positions[r as usize].as_dvec3().distance(p) <= tolerance {
                            found = found.min(r);
                        }
                    }
                }
            }
        }
        if found == NONE {
            grid.entry([x, y, z]).or_default().push(v as u32);
        } else {
            weld[v] = found;
        }
    }
}
