//! Small meshes of known shape, for tests.

use super::subdivide::subdivide;
use super::{CleanOptions, Mesh, clean};
use crate::random::Random;
use glam::Vec3;

/// A grid of `u` x `v` quads, each cut in two, on a parametric surface over [0, 1]^2; equal positions are welded.
pub(crate) fn parametric(u: u32, v: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut positions = Vec::new();
    for j in 0..=v {
        for i in 0..=u {
            // Closed surfaces meet themselves exactly if the parameter does.
            let p = at(f64::from(i) / f64::from(u), f64::from(j) / f64::from(v));
            positions.push(Vec3::from(p.map(|x| x as f32)));
        }
    }
    let mut faces = Vec::new();
    for j in 0..v {
        for i in 0..u {
            let a = j * (u + 1) + i;
            let (b, c, d) = (a + 1, a + u + 2, a + u + 1);
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    let options = CleanOptions { weld: 1e-6, orient: false };
    clean(&positions, &faces, &options).expect("a surface").mesh
}

/// The unit square in the plane z = 0, `n` x `n` quads whose inner vertices are shaken: triangles of all shapes, obtuse ones
/// too.
pub(crate) fn uneven_square(n: u32) -> Mesh {
    let mut mesh = parametric(n, n, |x, y| [x, y, 0.0]);
    let mut random = Random::new(1, 1);
    let shake = 0.22 / f64::from(n);
    for p in &mut mesh.positions {
        let (dx, dy) = (random.range(-shake, shake), random.range(-shake, shake));
        if p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0 {
            *p += Vec3::new(dx as f32, dy as f32, 0.0);
        }
    }
    mesh
}

/// A torus about the z axis, turned outward.
pub(crate) fn torus(around: u32, across: u32, radius: f64, tube: f64) -> Mesh {
    parametric(around, across, |u, v| {
        let (a, b) = (u * std::f64::consts::TAU, v * std::f64::consts::TAU);
        let r = radius + tube * b.cos();
        [r * a.cos(), r * a.sin(), tube * b.sin()]
    })
}

/// The unit sphere: an octahedron cut in four `rounds` times.
pub(crate) fn sphere(rounds: u32) -> Mesh {
    let positions = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let faces = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mut mesh = Mesh::new(positions, faces).expect("an octahedron");
    for _ in 0..rounds {
        mesh = subdivide(&mesh, &vec![true; mesh.face_count()]).expect("it fits").mesh;
        mesh.positions.iter_mut().for_each(|p| *p = p.normalize());
    }
    mesh
}

/// The cube [-1, 1]^3 with `n` x `n` quads a side.
pub(crate) fn cube(n: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let start = positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = [side; 3];
                    p[(axis + 1) % 3] = (2 * i) as f32 / n as f32 - 1.0;
                    p[(axis + 2) % 3] = (2 * j) as f32 / n as f32 - 1.0;
                    positions.push(Vec3::from(p));
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let a = start + i * (n + 1) + j;
                    let (b, c, d) = (a + n + 1, a + n + 2, a + 1);
                    faces.extend(if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
                }
            }
        }
    }
    clean(&positions, &faces, &CleanOptions::default()).expect("a cube").mesh
}
