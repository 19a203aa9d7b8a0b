//! Mutual tessellation: one mesh through the old vertices and the new ones.
//!
//! Each face of the original is triangulated by itself: a constrained Delaunay triangulation of its corners, the sites in
//! it and the cuts of its sides, laid in its plane. Where faces meet they share the cuts, so the pieces fit.

use super::features::Features;
use crate::mesh::{MAX_FACES, Mesh, MeshError, NONE, SurfacePoint, next};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Faces of the original triangulated by one task.
const CHUNK: usize = 4096;

/// One mesh through all vertices, the original's first, then cuts, then sites.
pub(super) struct Mutual {
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) opposite: Vec<u32>,
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

/// Triangles of some faces of the original.
#[derive(Default)]
struct Pieces {
    faces: Vec<[u32; 3]>,
    /// Half-edges are counted from the first of these pieces; [`NONE`] along the sides of the original's faces.
    opposite: Vec<u32>,
    on_line: Vec<bool>,
    /// Along the sides: the side (a half-edge of the original), the vertex where the piece starts, and its half-edge here.
    sides: Vec<(u32, u32, u32)>,
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
    let chunks: Vec<Pieces> = faces
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut out = Pieces::default();
            let mut site = sites.partition_point(|s| s.face < chunk[0]);
            let mut cut = on_sides.partition_point(|s| s.0 < 3 * chunk[0]);
            for &f in chunk {
                let site_end = site + sites[site..].iter().take_while(|s| s.face == f).count();
                let cut_end = cut + on_sides[cut..].iter().take_while(|s| s.0 < 3 * f + 3).count();
                let laid = lay(mesh, f, &sites[site..site_end], first_site + site as u32, &on_sides[cut..cut_end]);
                out.add(f, &triangulate(&laid), features);
                (site, cut) = (site_end, cut_end);
            }
            out
        })
        .collect();
    let on_cut = |&(h, share): &(u32, f64)| {
        let mut bary = DVec3::ZERO;
        bary[(h % 3) as usize] = 1.0 - share;
        bary[((h + 1) % 3) as usize] = share;
        SurfacePoint { face: h / 3, bary: bary.as_vec3() }
    };
    let at = features.cuts.iter().map(on_cut).chain(sites.iter().copied()).collect();
    joined(mesh, chunks, at)
}

/// Puts pieces together along the sides they share. By sides and not by vertices: a mesh may have two edges between the same two
/// vertices.
fn joined(mesh: &Mesh, chunks: Vec<Pieces>, at: Vec<SurfacePoint>) -> Result<Mutual, MeshError> {
    let count = chunks.iter().map(|p| p.faces.len()).sum();
    if count > MAX_FACES {
        return Err(MeshError::TooLarge { count, max: MAX_FACES });
    }
    let mut out = Mutual { faces: Vec::with_capacity(count), opposite: Vec::new(), on_line: Vec::new(), at };
    out.opposite.reserve(3 * count);
    out.on_line.reserve(3 * count);
    let mut sides = Vec::new();
    for piece in chunks {
        let first = 3 * out.faces.len() as u32;
        out.faces.extend(piece.faces);
        out.opposite.extend(piece.opposite.into_iter().map(|o| if o == NONE { NONE } else { first + o }));
        out.on_line.extend(piece.on_line);
        sides.extend(piece.sides.into_iter().map(|(side, from, h)| (side, from, first + h)));
    }
    // Pieces come face by face, so those of a side lie together.
    let mut start = vec![0_u32; mesh.opposite.len() + 1];
    sides.sort_unstable_by_key(|s| s.0);
    sides.iter().for_each(|s| start[s.0 as usize + 1] += 1);
    (0..mesh.opposite.len()).for_each(|h| start[h + 1] += start[h]);
    let of = |side: u32| &sides[start[side as usize] as usize..start[side as usize + 1] as usize];
    for side in 0..mesh.opposite.len() as u32 {
        let beyond = mesh.opposite[side as usize];
        if beyond == NONE || beyond < side {
            continue;
        }
        for &(_, _, h) in of(side) {
            let end = out.faces[(next(h) / 3) as usize][(next(h) % 3) as usize];
            if let Some(&(_, _, o)) = of(beyond).iter().find(|s| s.1 == end) {
                out.opposite[h as usize] = o;
                out.opposite[o as usize] = h;
            }
        }
    }
    Ok(out)
}

impl Pieces {
    /// Takes in the triangles of one face.
    fn add(&mut self, face: u32, triangles: &[[Laid; 3]], features: &Features) {
        let first = 3 * self.faces.len() as u32;
        let mut inner: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (i, triangle) in triangles.iter().enumerate() {
            self.faces.push(triangle.map(|v| v.vertex));
            for k in 0..3 {
                let h = first + 3 * i as u32 + k as u32;
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                let side = (a.sides & b.sides).trailing_zeros();
                self.opposite.push(NONE);
                self.on_line.push(side < 3 && features.on_line[(3 * face + side) as usize]);
                if side < 3 {
                    self.sides.push((3 * face + side, a.vertex, h));
                } else {
                    inner.push((a.vertex.min(b.vertex), a.vertex.max(b.vertex), h));
                }
            }
        }
        inner.sort_unstable();
        for pair in inner.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [(_, _, g), (_, _, h)] = *pair {
                self.opposite[g as usize] = h;
                self.opposite[h as usize] = g;
            }
        }
    }
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
fn triangulate(laid: &[Laid]) -> Vec<[Laid; 3]> {
    match *laid {
        [a, b, c] => return vec![[a, b, c]],
        [a, b, c, m] if m.sides == 0 => return vec![[a, b, m], [b, c, m], [c, a, m]],
        _ => {}
    }
    // The sides, cut by cut.
    let mut edges = Vec::with_capacity(laid.len());
    for k in 0..3 {
        let mut from = k;
        for (i, _) in laid.iter().enumerate().skip(3).filter(|(_, v)| v.sides == 1 << k) {
            edges.push([from, i]);
            from = i;
        }
        edges.push([from, (k + 1) % 3]);
    }
    // It does not fail for finite points and sides that do not cross; a face where it did would stay whole.
    let Ok(made) = ConstrainedDelaunayTriangulation::<Laid>::bulk_load_cdt(laid.to_vec(), edges) else {
        return vec![[laid[0], laid[1], laid[2]]];
    };
    // Rounding may leave a cut beside its side: what lies between them has no width.
    let within = |t: &[Laid; 3]| t[0].sides & t[1].sides & t[2].sides == 0;
    made.inner_faces().map(|face| face.vertices().map(|v| *v.data())).filter(within).collect()
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
                let mutual = tessellate(&mesh, &lines, &points).expect("it fits");
                let mut positions = mesh.positions.clone();
                positions.extend(mutual.at.iter().map(|&p| mesh.position(p).as_vec3()));
                let made = Mesh { positions, faces: mutual.faces, opposite: mutual.opposite };
                made.check().expect("invariants");
                let (a, b) = (made.total_area(), mesh.total_area());
                assert!((a / b - 1.0).abs() < 1e-6, "area {a} of {b}");
                assert_eq!(made.euler_characteristic(), mesh.euler_characteristic(), "Euler characteristic");
                let vertices = mesh.vertex_count() + lines.cuts.len() + count;
                let faces = made.faces.as_flattened();
                assert_eq!(made.vertex_count(), vertices, "vertices");
                assert!((0..vertices as u32).all(|v| faces.contains(&v)), "every vertex is used");
                let once = |h: &u32| {
                    mutual.on_line[*h as usize] && (made.opposite[*h as usize] == NONE || *h < made.opposite[*h as usize])
                };
                let length = |h: u32| made.point(made.origin(h)).distance(made.point(made.origin(next(h))));
                let on: f64 = (0..made.opposite.len() as u32).filter(once).map(length).sum();
                let all = super::super::features::line_length(&mesh, &lines.on_line);
                assert!((on - all).abs() < 1e-5 * all.max(1.0), "lines are {on} long, {all} before");
            }
        }
    }
}
