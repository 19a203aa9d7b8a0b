//! The soft shadow where a mesh stands: how much of the sky its underside hides from the ground.
//!
//! The ground is the plane through the mesh's lowest point, or a given one below it. Seen from straight below, the mesh is a height map `h`; a cell
//! of it with area dA hides `h^2 / (pi (h^2 + d^2)^2) dA` of an overcast sky from a ground point at distance d (the form
//! factor of two parallel patches). Summed over all cells that is the shadow.

use super::camera::{Camera, Projection};
use super::lens::Grid;
use super::raster::Visibility;
use crate::mesh::{Mesh, NONE};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Cells along one side of the shadow map.
const CELLS: u32 = 144;
/// Half the side of the map, as a share of the half diagonal of what stands on it.
const REACH: f64 = 1.5;

/// The shadow of a mesh on the ground below it.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundShadow {
    /// Middle of the map, on the ground.
    pub(super) middle: DVec3,
    pub(super) axes: [DVec3; 2],
    up: DVec3,
    /// Half the side of the map, world units.
    pub(super) half: f64,
    hidden: Vec<f32>,
}

impl GroundShadow {
    /// The shadow of a mesh with `up` as its up direction (unit). The ground is at height `floor`, along `up`, or at the mesh's
    /// lowest point where that is lower.
    #[must_use]
    pub fn new(mesh: &Mesh, up: DVec3, floor: Option<f64>) -> Self {
        let across = up.any_orthonormal_vector();
        let down = across.cross(up);
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for p in mesh.faces.as_flattened().iter().map(|&v| mesh.point(v)) {
            let p = DVec3::new(p.dot(across), p.dot(down), p.dot(up));
            (low, high) = (low.min(p), high.max(p));
        }
        low.z = floor.map_or(low.z, |floor| floor.min(low.z));
        let size = high - low;
        let half = REACH * 0.5 * size.truncate().length().max(0.4 * size.z).max(f64::MIN_POSITIVE);
        let centre = 0.5 * (low + high);
        let middle = across * centre.x + down * centre.y + up * low.z;
        let distance = size.z.max(half);
        let camera = Camera {
            eye: middle - up * distance,
            right: across,
            up: down,
            forward: up,
            projection: Projection::Orthographic(half),
            near: 0.0,
            world_up: up,
        };
        let grid = Grid { width: CELLS, height: CELLS, samples: 1 };
        let hidden =
            Visibility::new(mesh, &camera, grid).map_or_else(|_| Vec::new(), |seen| hidden_sky(mesh, &seen, half, distance));
        Self { middle, axes: [across, down], up, half, hidden }
    }

    /// The up direction it was made for.
    #[must_use]
    pub const fn up(&self) -> DVec3 {
        self.up
    }

    /// The share of the sky that is hidden at each cell, rows from the top; empty if there is no map.
    #[cfg(feature = "gpu")]
    pub(super) fn cells(&self) -> &[f32] {
        &self.hidden
    }

    /// The share of the sky, 0 to 1, that is hidden from where a ray meets the ground; 0 if it does not meet it from above.
    #[must_use]
    pub fn along(&self, start: DVec3, direction: DVec3) -> f32 {
        let (height, fall) = ((start - self.middle).dot(self.up), -direction.dot(self.up));
        if height <= 0.0 || fall <= 0.0 || self.hidden.is_empty() {
            return 0.0;
        }
        let at = start - self.middle + direction * (height / fall);
        let place = DVec2::new(at.dot(self.axes[0]), at.dot(self.axes[1])) / self.half;
        // Fade out before the map ends.
        let fade = 1.0 - smooth_step(0.6, 1.0, place.length());
        if fade <= 0.0 {
            return 0.0;
        }
        let cell = (place * DVec2::new(0.5, -0.5) + 0.5) * f64::from(CELLS) - 0.5;
        let base = cell.floor();
        let w = cell - base;
        let value = |dx: i64, dy: i64| {
            let limit = i64::from(CELLS) - 1;
            let (x, y) = ((base.x as i64 + dx).clamp(0, limit), (base.y as i64 + dy).clamp(0, limit));
            f64::from(self.hidden[(y * i64::from(CELLS) + x) as usize])
        };
        let top = value(0, 0) * (1.0 - w.x) + value(1, 0) * w.x;
        let bottom = value(0, 1) * (1.0 - w.x) + value(1, 1) * w.x;
        (fade * (top * (1.0 - w.y) + bottom * w.y)) as f32
    }
}

fn hidden_sky(mesh: &Mesh, seen: &Visibility, half: f64, distance: f64) -> Vec<f32> {
    let cells = CELLS as usize;
    let cell = 2.0 * half / f64::from(CELLS);
    let mut occluders = Vec::new();
    for y in 0..cells {
        for x in 0..cells {
            if seen.face(x, y) != NONE
                && let Some(hit) = seen.hit(mesh, x, y)
            {
                // In cells. Nearer to the ground than about a cell, the cells' own pattern would show.
                let height = ((hit.depth - distance) / cell).max(1.2) as f32;
                occluders.push((x as f32, y as f32, height * height));
            }
        }
    }
    (0..cells * cells)
        .into_par_iter()
        .map(|i| {
            let (x, y) = ((i % cells) as f32, (i / cells) as f32);
            let sum: f32 = occluders
                .iter()
                .map(|&(ox, oy, h2)| {
                    let r2 = h2 + (ox - x) * (ox - x) + (oy - y) * (oy - y);
                    h2 / (r2 * r2)
                })
                .sum();
            (sum * std::f32::consts::FRAC_1_PI).min(1.0)
        })
        .collect()
}

/// 0 below `from`, 1 above `to`, smooth between.
fn smooth_step(from: f64, to: f64, value: f64) -> f64 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A square of side 2 at a height above the ground, with a tiny speck on the ground below.
    fn table(height: f32) -> Mesh {
        let square = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, height, z));
        let speck = [(0.0, 0.0), (0.0, 1e-4), (1e-4, 0.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
        let positions = square.into_iter().chain(speck).collect();
        Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]]).unwrap()
    }

    #[test]
    fn under_the_middle_of_a_square_the_form_factor_is_the_textbook_one() {
        for height in [0.5_f32, 1.0, 2.0] {
            let shadow = GroundShadow::new(&table(height), DVec3::Y, None);
            // Point below the corner of a rectangle a x b at distance h, four corners: sides a = b = 1.
            let x = 1.0 / f64::from(height);
            let k = x / (1.0 + x * x).sqrt();
            let expected = 4.0 / std::f64::consts::TAU * 2.0 * k * (k).atan();
            let found = f64::from(shadow.along(DVec3::new(0.0, 5.0, 0.0), DVec3::NEG_Y));
            assert!((found - expected).abs() < 0.03, "height {height}: {found}, expected {expected}");
        }
    }

    #[test]
    fn there_is_no_shadow_from_below_nor_far_away() {
        let shadow = GroundShadow::new(&table(0.5), DVec3::Y, None);
        assert_eq!(shadow.along(DVec3::new(0.0, -1.0, 0.0), DVec3::Y), 0.0, "from below");
        assert_eq!(shadow.along(DVec3::new(0.0, 1.0, 0.0), DVec3::Y), 0.0, "looking up");
        assert_eq!(shadow.along(DVec3::new(9.0, 1.0, 0.0), DVec3::NEG_Y), 0.0, "far away");
    }
}
