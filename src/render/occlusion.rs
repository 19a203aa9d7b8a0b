//! Ambient occlusion in the picture plane: how much of its surroundings each pixel's surface hides from itself.
//!
//! Based on: M. McGuire et al., "The Alchemy screen-space ambient obscurance algorithm", HPG 2011: the mean of
//! `max(0, v.n) / |v|` over surface points around, v leading there, faded out towards a radius in world units. We look
//! along fixed directions, turned in a 4x4 pattern of pixels, and then average over that pattern where depth allows: no
//! random numbers, hardly any noise.

use super::lens::Lens;
use super::raster::Visibility;
use crate::mesh::Mesh;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// How far a point looks for what hides it, as a share of the diagonal of the mesh's bounds.
pub(super) const RADIUS: f64 = 0.09;
/// Directions looked along from each pixel.
const DIRECTIONS: usize = 6;
/// Steps along each direction, spaced quadratically.
const STEPS: usize = 5;
/// The side of the pattern in which directions are turned.
const PATTERN: usize = 4;
/// The longest look, as a share of the picture's height: bounds the work and the reach of what lies just before the eye.
const LONGEST: f64 = 0.15;
/// Sines below this count as level: coarse triangles must not shade their neighbours.
const LEVEL: f32 = 0.12;
/// What full obscurance takes away.
const STRENGTH: f32 = 1.5;

/// Openness, 0 (hidden) to 1, of each pixel; 1 where there is nothing. `normals` are the smooth corner normals.
#[must_use]
pub fn openness(mesh: &Mesh, normals: &[[Vec3; 3]], seen: &Visibility) -> Vec<f32> {
    let (grid, camera) = (seen.grid(), seen.camera());
    let (width, height, samples) = (grid.width as usize, grid.height as usize, grid.samples as usize);
    let (low, high) = mesh.bounds();
    let radius = RADIUS * (high - low).as_dvec3().length();
    // Positions relative to the eye in units of the radius: single precision then serves at every scale.
    let points: Vec<Option<(Vec3, Vec3)>> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let hit = seen.hit(mesh, (i % width) * samples + samples / 2, (i / width) * samples + samples / 2)?;
            let view = camera.to_view(hit.position) / radius;
            let corner = normals[hit.at.face as usize];
            let n = corner[0] * hit.at.bary.x + corner[1] * hit.at.bary.y + corner[2] * hit.at.bary.z;
            let n = if hit.front { n.as_dvec3() } else { -n.as_dvec3() };
            let n = DVec3::new(n.dot(camera.right), n.dot(camera.up), n.dot(camera.forward));
            Some((view.as_vec3(), n.normalize_or_zero().as_vec3()))
        })
        .collect();
    let lens = Lens::new(camera, grid);
    let raw: Vec<f32> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            points[i].map_or(1.0, |here| look_around(&points, [width, height], i, here, pixels(&lens, here.0, radius, samples)))
        })
        .collect();
    smooth(&raw, &points, [width, height])
}

/// The radius in pixels at a point.
fn pixels(lens: &Lens, at: Vec3, radius: f64, samples: usize) -> f64 {
    let at = at.as_dvec3() * radius;
    lens.project(at).distance(lens.project(at + DVec3::X * radius)) / samples as f64
}

fn look_around(points: &[Option<(Vec3, Vec3)>], [width, height]: [usize; 2], i: usize, here: (Vec3, Vec3), reach: f64) -> f32 {
    let (x, y) = (i % width, i / width);
    let reach = reach.min(LONGEST * height as f64);
    // An ordering of the pattern's cells in which neighbours differ much.
    const TURN: [[u8; PATTERN]; PATTERN] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    let turn = f64::from(TURN[y % PATTERN][x % PATTERN]) / (PATTERN * PATTERN) as f64;
    let mut hidden = 0.0;
    for d in 0..DIRECTIONS {
        let angle = std::f64::consts::TAU * (d as f64 + turn) / DIRECTIONS as f64;
        let direction = DVec2::from_angle(angle);
        for s in 0..STEPS {
            let share = (s as f64 + 0.5 + 0.5 * turn) / STEPS as f64;
            let at = DVec2::new(x as f64, y as f64) + direction * (1.0 + reach * share * share);
            if at.x < 0.0 || at.y < 0.0 || at.x >= width as f64 - 0.5 || at.y >= height as f64 - 0.5 {
                continue;
            }
            let Some((there, _)) = points[at.y.round() as usize * width + at.x.round() as usize] else { continue };
            let v = there - here.0;
            let length = v.length();
            if length > 0.0 && length < 1.0 {
                let rise = v.dot(here.1) / length;
                hidden += (rise - LEVEL).max(0.0) * (1.0 - length * length);
            }
        }
    }
    (1.0 - STRENGTH * hidden / (DIRECTIONS * STEPS) as f32).max(0.0)
}

/// The mean over one pattern, among pixels of about the same depth.
fn smooth(raw: &[f32], points: &[Option<(Vec3, Vec3)>], [width, height]: [usize; 2]) -> Vec<f32> {
    (0..raw.len())
        .into_par_iter()
        .map(|i| {
            let Some((here, normal)) = points[i] else { return 1.0 };
            let (x, y) = (i % width, i / width);
            let (mut sum, mut count) = (0.0, 0.0);
            for v in y.saturating_sub(PATTERN / 2)..(y + PATTERN / 2).min(height) {
                for u in x.saturating_sub(PATTERN / 2)..(x + PATTERN / 2).min(width) {
                    let j = v * width + u;
                    // Off the tangent plane by less than a small part of the radius: the same surface.
                    if points[j].is_some_and(|(there, _)| (there - here).dot(normal).abs() < 0.1) {
                        sum += raw[j];
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 { sum / count } else { raw[i] }
        })
        .collect()
}
