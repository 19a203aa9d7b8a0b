//! A flat mesh.

use glam::Vec3;
use lapped::mesh::Mesh;

/// A flat grid of `n` by `n` quads from -1 to 1 in x and y, facing +z.
pub(crate) fn flat(n: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let at = |k: u32| 2.0 * k as f32 / n as f32 - 1.0;
            positions.push(Vec3::new(at(i), at(j), 0.0));
            if i < n && j < n {
                let a = j * (n + 1) + i;
                faces.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
            }
        }
    }
    Mesh::new(positions, faces).unwrap()
}
