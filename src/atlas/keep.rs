//! The mesh's own texture coordinates as an atlas, where they are injective.

use super::measure::overlap;
use super::{Atlas, AtlasError, MAX_SIZE, charts::margin};
use crate::mesh::Mesh;
use glam::Vec2;
use std::collections::HashMap;

/// Makes an atlas of coordinates at the faces' corners, (0, 0) at the top left. Islands of faces that share coordinates are
/// its charts.
///
/// # Errors
/// If coordinates lie outside 0 to 1, or two faces cover the same texel; says where.
pub fn keep(mesh: &Mesh, uv: &[[Vec2; 3]], size: u32, mips: u32) -> Result<Atlas, AtlasError> {
    if !(16..=MAX_SIZE).contains(&size) {
        return Err(AtlasError::Size(size));
    }
    if uv.len() != mesh.face_count() {
        return Err(AtlasError::Keep("it has none".into()));
    }
    let outside = |p: &Vec2| !(p.cmpge(Vec2::ZERO).all() && p.cmple(Vec2::ONE).all());
    let beyond = uv.as_flattened().iter().filter(|p| outside(p)).count();
    if beyond > 0 {
        let share = 100.0 * beyond as f64 / (3 * uv.len()) as f64;
        return Err(AtlasError::Keep(format!("{share:.1} % of the corners lie outside 0 to 1, so parts of the image repeat")));
    }
    let (mut vertices, mut places, mut corners) = (Vec::new(), Vec::new(), Vec::with_capacity(uv.len()));
    let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    for (face, uv) in mesh.faces.iter().zip(uv) {
        corners.push([0, 1, 2].map(|k| {
            // Equal numbers, whatever the sign of a zero.
            let place = uv[k] + Vec2::ZERO;
            *known.entry((face[k], place.to_array().map(f32::to_bits))).or_insert_with(|| {
                vertices.push(face[k]);
                places.push(place);
                places.len() as u32 - 1
            })
        }));
    }
    let (chart, count) = islands(&corners, vertices.len());
    let atlas = Atlas { chart, corners, vertices, uv: places, page: vec![0; count], pages: 1, size, margin: margin(mips) };
    let found = overlap(mesh, &atlas, size);
    if found.doubled_texels > 0 {
        let first = first_overlap(mesh, &atlas);
        return Err(AtlasError::Keep(format!(
            "{} of {} texels lie under two faces{first}",
            found.doubled_texels,
            u64::from(size) * u64::from(size)
        )));
    }
    Ok(atlas)
}

/// Numbers the sets of faces that share atlas vertices.
fn islands(corners: &[[u32; 3]], vertices: usize) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for &[a, b, c] in corners {
        let a = root(&mut parent, a);
        for other in [b, c] {
            let other = root(&mut parent, other);
            parent[other as usize] = a;
        }
    }
    let mut number = vec![u32::MAX; vertices];
    let mut count = 0;
    let chart = corners
        .iter()
        .map(|c| {
            let r = root(&mut parent, c[0]) as usize;
            if number[r] == u32::MAX {
                number[r] = count;
                count += 1;
            }
            number[r]
        })
        .collect();
    (chart, count as usize)
}

/// Where the first pair of faces meets, in words.
fn first_overlap(mesh: &Mesh, atlas: &Atlas) -> String {
    let n = i64::from(atlas.size);
    let mut owner = vec![u32::MAX; (n * n) as usize];
    for f in 0..mesh.face_count() as u32 {
        let Some(triangle) = super::raster::Triangle::new(atlas.face_texels(f)) else { continue };
        let mut met = None;
        triangle.samples(0..n, 1, |x, y, _| {
            if (0..n).contains(&x) && (0..n).contains(&y) {
                let at = &mut owner[(y * n + x) as usize];
                if *at != u32::MAX && met.is_none() {
                    met = Some((*at, x, y));
                }
                *at = f;
            }
        });
        if let Some((other, x, y)) = met {
            let [u, v] = [x, y].map(|c| (c as f64 + 0.5) / n as f64);
            return format!(", first faces {other} and {f} at ({u:.4}, {v:.4})");
        }
    }
    String::new()
}
