//! Mutual tessellation: one mesh through the old vertices and the new ones.
//!
//! Each face of the original is triangulated by itself: a constrained Delaunay triangulation of its corners, the sites in
//! it and the cuts of its sides, laid in its plane. Where faces meet they share the cuts, so the pieces fit.

use super::features::Features;
use crate::mesh::{Mesh, MeshError, NONE, SurfacePoint};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Faces of the original triangulated by one task.
const CHUNK: usize = 4096;

/// All vertices, the original's first, then cuts, then sites.
pub(super) struct Mutual {
    pub(super) mesh: Mesh,
    /// Per half-edge: it lies on a line.
    pub(super) on_line: Vec<bool>,
    /// Where each new vertex lies.
    pub(super) at: Vec<SurfacePoint>,
}

/// A vertex laid in the plane of a face.
#[derive(Clone, Copy)]
struct Laid {
    at: Point2<f64>,
    vertex: u32,
    /// The sides of the face it lies on, a bit each.
    sides: u8,
}

impl HasPosition for Laid {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// The mutual tessellation of a mesh, its lines' cuts and sites that are sorted by face.
pub(super) fn tessellate(mesh: &Mesh, features: &Features, sites: &[SurfacePoint]) -> Result<Mutual, MeshError> {
    let old = mesh.vertex_count() as u32;
    let first_site = old + features.cuts.len() as u32;
    let mut on_sides: Vec<(u32, f64, u32)> = Vec::with_capacity(2 * features.cuts.len());
    for (i, &(h, share)) in features.cuts.iter().enumerate() {
        let vertex = old + i as u32;
        on_sides.push((h, share, vertex));
        let o = mesh.opposite[h as usize];
        if o != NONE {
            on_sides.push((o, 1.0 - share, vertex));
        }
    }
    on_sides.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));

    let faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
    let pieces: Vec<(Vec<[u32; 3]>, Vec<bool>)> = faces
        .par_chunks(CHUNK)
        .map(|chunk| {
            let (mut out, mut on_line) = (Vec::with_capacity(2 * chunk.len()), Vec::with_capacity(6 * chunk.len()));
            let mut site = sites.partition_point(|s| s.face < chunk[0]);
            let mut cut = on_sides.partition_point(|s| s.0 < 3 * chunk[0]);
            for &f in chunk {
                let (site_end, cut_end) = (
                    site + sites[site..].iter().take_while(|s| s.face == f).count(),
                    cut + on_sides[cut..].iter().take_while(|s| s.0 < 3 * f + 3).count(),
                );
                let laid = lay(mesh, f, &sites[site..site_end], first_site + site as u32, &on_sides[cut..cut_end]);
                let lines = [0, 1, 2].map(|k| features.on_line[(3 * f + k) as usize]);
                triangulate(&laid, |triangle| {
                    out.push(triangle.map(|v: Laid| v.vertex));
                    for k in 0..3 {
                        let shared = triangle[k].sides & triangle[(k + 1) % 3].sides;
                        on_line.push((0..3).any(|side| shared & 1 << side != 0 && lines[side]));
                    }
                });
                (site, cut) = (site_end, cut_end);
            }
            (out, on_line)
        })
        .collect();
    let mut all = Vec::with_capacity(pieces.iter().map(|p| p.0.len()).sum());
    let mut on_line = Vec::with_capacity(3 * all.capacity());
    for (faces, lines) in pieces {
        all.extend(faces);
        on_line.extend(lines);
    }
    let on_cut = |&(h, share): &(u32, f64)| {
        let mut bary = DVec3::ZERO;
        bary[(h % 3) as usize] = 1.0 - share;
        bary[((h + 1) % 3) as usize] = share;
        SurfacePoint { face: h / 3, bary: bary.as_vec3() }
    };
    let at: Vec<SurfacePoint> = features.cuts.iter().map(on_cut).chain(sites.iter().copied()).collect();
    let mut positions = mesh.positions.clone();
    positions.extend(at.iter().map(|&p| mesh.position(p).as_vec3()));
    Ok(Mutual { mesh: Mesh::new(positions, all)?, on_line, at })
}

/// The vertices of one face in its plane, its longest side as unit of length: corners, then cuts, then sites.
fn lay(mesh: &Mesh, face: u32, sites: &[SurfacePoint], first_site: u32, cuts: &[(u32, f64, u32)]) -> Vec<Laid> {
    let [a, b, c] = mesh.corners(face);
    let unit = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let x = (b - a).normalize_or_zero();
    let y = mesh.normal(face).cross(x);
    let flat = |p: DVec3| DVec2::new((p - a).dot(x), (p - a).dot(y)) / unit;
    let corners = [flat(a), flat(b), flat(c)];
    let point = |p: DVec2| Point2::new(p.x, p.y);
    let mut out = Vec::with_capacity(3 + cuts.len() + sites.len());
    for k in 0..3 {
        let sides = 1 << k | 1 << ((k + 2) % 3);
        out.push(Laid { at: point(corners[k]), vertex: mesh.faces[face as usize][k], sides });
    }
    for &(h, share, vertex) in cuts {
        let k = (h % 3) as usize;
        out.push(Laid { at: point(corners[k].lerp(corners[(k + 1) % 3], share)), vertex, sides: 1 << k });
    }
    for (i, site) in sites.iter().enumerate() {
        let w = site.bary.as_dvec3();
        let at = corners[0] + (corners[1] - corners[0]) * w.y + (corners[2] - corners[0]) * w.z;
        out.push(Laid { at: point(at), vertex: first_site + i as u32, sides: 0 });
    }
    out
}

/// Triangles of a face, counter-clockwise.
fn triangulate(laid: &[Laid], mut emit: impl FnMut([Laid; 3])) {
    match *laid {
        [a, b, c] => return emit([a, b, c]),
        [a, b, c, m] if m.sides == 0 => return [[a, b, m], [b, c, m], [c, a, m]].into_iter().for_each(emit),
        _ => {}
    }
    // The sides, cut by cut.
    let mut edges = Vec::with_capacity(3);
    for k in 0..3 {
        let mut from = k;
        for (i, _) in laid.iter().enumerate().skip(3).filter(|(_, v)| v.sides == 1 << k) {
            edges.push([from, i]);
            from = i;
        }
        edges.push([from, (k + 1) % 3]);
    }
    // Neither fails for finite points and sides that do not cross; a face that did would stay whole, without its points.
    let Ok(made) = ConstrainedDelaunayTriangulation::<Laid>::bulk_load_cdt(laid.to_vec(), edges) else {
        return emit([laid[0], laid[1], laid[2]]);
    };
    for face in made.inner_faces() {
        let triangle = face.vertices().map(|v| *v.data());
        // Rounding may leave a cut beside its side: what lies between them has no width.
        if triangle[0].sides & triangle[1].sides & triangle[2].sides == 0 {
            emit(triangle);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::features::{features, lines};
    use super::super::sites::sites;
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_surface_stays_and_holds_all_vertices() {
        for (mesh, crease) in [
            (shapes::sphere(2), None),
            (shapes::cube(1), Some(0.5)),
            (shapes::uneven_square(5), None),
            (shapes::torus(9, 7, 1.0, 0.3), Some(0.1)),
        ] {
            let (component, _) = mesh.components();
            for count in [5, 700] {
                let spacing = (mesh.total_area() / count as f64).sqrt();
                let lines = features(&mesh, lines(&mesh, crease), spacing);
                let points = sites(&mesh, &component, &[count], &[mesh.total_area()], 7);
                let mutual = tessellate(&mesh, &lines, &points).expect("a manifold");
                mutual.mesh.check().expect("invariants");
                let (a, b) = (mutual.mesh.total_area(), mesh.total_area());
                assert!((a / b - 1.0).abs() < 1e-6, "area {a} of {b}");
                assert_eq!(mutual.mesh.euler_characteristic(), mesh.euler_characteristic(), "Euler characteristic");
                let vertices = mesh.vertex_count() + lines.cuts.len() + count;
                let faces = mutual.mesh.faces.as_flattened();
                assert_eq!(mutual.mesh.vertex_count(), vertices, "vertices");
                assert!((0..vertices as u32).all(|v| faces.contains(&v)), "every vertex is used");
                let on: f64 = mutual
                    .mesh
                    .opposite
                    .iter()
                    .enumerate()
                    .filter(|&(h, &o)| mutual.on_line[h] && (o == NONE || (h as u32) < o))
                    .map(|(h, _)| {
                        let h = h as u32;
                        mutual.mesh.point(mutual.mesh.origin(h)).distance(mutual.mesh.point(mutual.mesh.origin(crate::mesh::next(h))))
                    })
                    .sum();
                let all = super::super::features::line_length(&mesh, &lines.on_line);
                assert!((on - all).abs() < 1e-5 * all.max(1.0), "lines are {on} long, {all} before");
            }
        }
    }
}
