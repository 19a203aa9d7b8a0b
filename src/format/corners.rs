//! From polygons of corners, as files hold them, to triangles of vertices.

use super::polygon::triangulate;
use crate::mesh::NONE;
use glam::Vec3;
use std::collections::HashMap;

/// Cuts polygons into triangles of corner indices. Polygon `p` has the corners `ends[p - 1]..ends[p]`.
///
/// Also returns the polygon of each triangle, unless each polygon is one.
pub(crate) fn cut_polygons(ends: &[u32], position: impl Fn(u32) -> Vec3) -> (Vec<[u32; 3]>, Option<Vec<u32>>) {
    let corners = ends.last().map_or(0, |&e| e as usize);
    let mut faces = Vec::with_capacity(corners.saturating_sub(2 * ends.len()));
    let mut polygons = Vec::new();
    let (mut outline, mut triangles) = (Vec::new(), Vec::new());
    let mut start = 0;
    for (polygon, &end) in ends.iter().enumerate() {
        if end - start == 3 && polygons.is_empty() {
            faces.push([start, start + 1, start + 2]);
        } else {
            // The first polygon that is no triangle: so far each was one.
            if polygons.is_empty() {
                polygons.extend(0..polygon as u32);
            }
            outline.clear();
            outline.extend((start..end).map(&position));
            triangulate(&outline, &mut triangles);
            faces.extend(triangles.iter().map(|t| t.map(|k| start + k)));
            polygons.extend(triangles.iter().map(|_| polygon as u32));
        }
        start = end;
    }
    let all_triangles = faces.len() == ends.len() && ends.iter().enumerate().all(|(p, &e)| e as usize == 3 * (p + 1));
    (faces, (!all_triangles).then_some(polygons))
}

/// First triangle that belongs to polygon `polygon` or a later one.
pub(crate) fn first_face(polygons: Option<&[u32]>, faces: usize, polygon: u32) -> u32 {
    match polygons {
        Some(of) => of.partition_point(|&p| p < polygon) as u32,
        None => polygon.min(faces as u32),
    }
}

/// A corner: its vertex in the file, and what stands for its attributes.
pub(crate) type Corner = (u32, [u32; 2]);

/// Turns faces of corners into faces of vertices, one vertex for each distinct corner. Returns them: first the file's own
/// vertices, each with the attributes of the first corner there (`None` if no face uses it), then the further ones.
pub(crate) fn join_corners(
    faces: &mut [[u32; 3]],
    vertices: usize,
    corner: impl Fn(u32) -> Corner,
) -> Vec<(u32, Option<[u32; 2]>)> {
    let mut kept: Vec<(u32, Option<[u32; 2]>)> = (0..vertices as u32).map(|v| (v, None)).collect();
    let mut further: HashMap<Corner, u32> = HashMap::new();
    for index in faces.as_flattened_mut() {
        let (vertex, attributes) = corner(*index);
        let first = kept[vertex as usize].1.get_or_insert(attributes);
        *index = if *first == attributes {
            vertex
        } else {
            *further.entry((vertex, attributes)).or_insert_with(|| {
                kept.push((vertex, Some(attributes)));
                kept.len() as u32 - 1
            })
        };
    }
    debug_assert!(kept.len() < NONE as usize, "corners are fewer than 32-bit indices");
    kept
}
