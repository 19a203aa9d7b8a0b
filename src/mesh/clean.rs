//! From whatever a file holds to an oriented manifold, and back.
//!
//! 1. Weld vertices at equal positions (exactly equal bits, or within a tolerance on request).
//! 2. Drop degenerate faces and second copies of a face.
//! 3. Turn faces so that neighbours agree; turn closed components that are inside out.
//! 4. Pair half-edges. Where more than two faces meet at an edge, the flattest pairs stay joined and the others part.
//! 5. Give each fan of faces around a vertex a vertex of its own.
//!
//! Nothing is refused but empty input, and nothing is lost: [`Cleaned::user_faces`] leads from each of the caller's faces
//! to the mesh face that stands for it, corner by corner.

use super::weld::weld_map;
use super::{Mesh, MeshError, NONE, check_input, ends, for_each_edge, signed_volume};
use glam::Vec3;
use serde::Serialize;

/// A triangle whose area is below this share of its longest edge squared has no usable plane: its height is then at the
/// rounding error of 32-bit positions.
const DEGENERATE_AREA: f64 = 1e-9;

/// How to clean.
#[derive(Debug, Clone, PartialEq)]
pub struct CleanOptions {
    /// Vertices closer than this (world units) become one. 0 welds exactly equal positions only.
    pub weld: f64,
    /// Make windings agree and turn closed components outward.
    pub orient: bool,
}

impl Default for CleanOptions {
    fn default() -> Self {
        Self { weld: 0.0, orient: true }
    }
}

/// What [`clean`] found and did.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct CleanReport {
    /// Vertices and faces given.
    pub vertices_in: usize,
    /// Faces given.
    pub faces_in: usize,
    /// Vertices and faces of the mesh.
    pub vertices: usize,
    /// Faces of the mesh.
    pub faces: usize,
    /// Vertices that no face uses.
    pub unreferenced_vertices: usize,
    /// Vertices that fell together with an earlier one.
    pub welded_vertices: usize,
    /// Faces dropped for want of area or for a repeated corner.
    pub degenerate_faces: usize,
    /// Faces dropped as second copies.
    pub duplicate_faces: usize,
    /// Faces turned so that neighbours agree.
    pub flipped_faces: usize,
    /// Closed components that were inside out and were turned.
    pub turned_components: usize,
    /// Components in which no winding agrees all round, like a Moebius strip; they are cut open.
    pub one_sided_components: usize,
    /// Edges with more than two faces, or with two that run the same way even after turning.
    pub non_manifold_edges: usize,
    /// Vertices with more than one fan of faces.
    pub non_manifold_vertices: usize,
    /// Connected components.
    pub components: usize,
    /// Components with a boundary.
    pub open_components: usize,
    /// The largest of those, by faces; [`MOST_TOLD`] at most.
    pub largest_open: Vec<OpenComponent>,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Closed loops of such edges.
    pub boundary_loops: usize,
    /// V - E + F.
    pub euler_characteristic: i64,
}

/// Open components that a report names.
pub const MOST_TOLD: usize = 12;

/// A component with a boundary.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct OpenComponent {
    /// The first of the caller's faces in it.
    pub first_face: usize,
    /// Its faces.
    pub faces: usize,
    /// Its edges with one face.
    pub boundary_edges: usize,
}

/// Where one of the caller's faces went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UserFace {
    /// Face of the mesh, or [`NONE`] if the face was dropped. Copies of a face share one.
    pub face: u32,
    /// Corner `k` of the caller's face is corner `corners[k]` of the mesh's.
    pub corners: [u8; 3],
}

/// A clean mesh and the way back.
#[derive(Debug, Clone)]
pub struct Cleaned {
    /// The mesh. Its faces keep the caller's order.
    pub mesh: Mesh,
    /// One per face given.
    pub user_faces: Vec<UserFace>,
    /// For each vertex of the mesh a vertex given (the first at its place).
    pub user_vertices: Vec<u32>,
    /// What was done.
    pub report: CleanReport,
}

/// Makes an oriented manifold of positions and triangles. Linear, but for sorting within each vertex's edges.
///
/// # Errors
/// If there are no faces, none has area, an index is out of range, or a coordinate is not finite.
pub fn clean(positions: &[Vec3], faces: &[[u32; 3]], options: &CleanOptions) -> Result<Cleaned, MeshError> {
    check_input(positions, faces)?;
    let mut report = CleanReport { vertices_in: positions.len(), faces_in: faces.len(), ..CleanReport::default() };

    let (weld, used) = weld_map(positions, faces, options.weld);
    report.unreferenced_vertices = used.iter().filter(|&&u| !u).count();
    report.welded_vertices = (0..weld.len()).filter(|&v| used[v] && weld[v] != v as u32).count();

    let (mut kept, user_faces) = keep_faces(positions, faces, &weld, &mut report);
    if kept.is_empty() {
        return Err(MeshError::NoArea { count: faces.len() });
    }
    let welded = kept.clone();
    if options.orient {
        orient(positions, &mut kept, &mut report);
    }
    let opposite = pair_half_edges(positions, &kept, &mut report);
    let (mesh, user_vertices) = part_fans(positions, kept.clone(), opposite, &mut report);

    tell_components(&mesh, &user_faces, &mut report);
    report.boundary_edges = mesh.boundary_edge_count();
    report.boundary_loops = mesh.boundary_loop_count();
    report.euler_characteristic = mesh.euler_characteristic();
    report.vertices = mesh.vertex_count();
    report.faces = mesh.face_count();

    let user_faces = user_faces
        .into_iter()
        .zip(faces)
        .map(|(face, corners)| match face {
            NONE => UserFace { face, corners: [0, 1, 2] },
            _ => {
                let mine = kept[face as usize];
                let place = |v: u32| mine.iter().position(|&w| w == weld[v as usize]).unwrap_or(0) as u8;
                UserFace { face, corners: corners.map(place) }
            }
        })
        .collect();
    report.flipped_faces = welded.iter().zip(&kept).filter(|(a, b)| a != b).count();
    Ok(Cleaned { mesh, user_faces, user_vertices, report })
}

/// How many components there are, and which of them are open.
fn tell_components(mesh: &Mesh, user_faces: &[u32], report: &mut CleanReport) {
    let (component, count) = mesh.components();
    let mut open = vec![OpenComponent { first_face: usize::MAX, ..OpenComponent::default() }; count];
    for (user, &face) in user_faces.iter().enumerate().filter(|(_, f)| **f != NONE) {
        let of = &mut open[component[face as usize] as usize];
        of.first_face = of.first_face.min(user);
    }
    for (f, &c) in component.iter().enumerate() {
        let of = &mut open[c as usize];
        of.faces += 1;
        of.boundary_edges += mesh.opposite[3 * f..3 * f + 3].iter().filter(|&&o| o == NONE).count();
    }
    open.retain(|c| c.boundary_edges > 0);
    report.components = count;
    report.open_components = open.len();
    open.sort_by_key(|c| (std::cmp::Reverse(c.faces), c.first_face));
    open.truncate(MOST_TOLD);
    report.largest_open = open;
}

/// Faces on welded vertices that are worth keeping, and for each face given its place among them.
fn keep_faces(positions: &[Vec3], faces: &[[u32; 3]], weld: &[u32], report: &mut CleanReport) -> (Vec<[u32; 3]>, Vec<u32>) {
    let welded: Vec<[u32; 3]> = faces.iter().map(|c| c.map(|v| weld[v as usize])).collect();
    let sound: Vec<bool> = welded.iter().map(|&c| !is_degenerate(positions, c)).collect();
    report.degenerate_faces = sound.iter().filter(|&&s| !s).count();

    // Copies share their sorted corners; the first stands for all.
    let sorted = |f: u32| {
        let mut c = welded[f as usize];
        c.sort_unstable();
        c
    };
    let mut order: Vec<u32> = (0..faces.len() as u32).filter(|&f| sound[f as usize]).collect();
    order.sort_unstable_by_key(|&f| (sorted(f), f));
    let mut first = vec![NONE; faces.len()];
    for copies in order.chunk_by(|&a, &b| sorted(a) == sorted(b)) {
        report.duplicate_faces += copies.len() - 1;
        for &f in copies {
            first[f as usize] = copies[0];
        }
    }
    let mut kept = Vec::with_capacity(faces.len());
    let mut place = vec![NONE; faces.len()];
    for f in 0..faces.len() {
        if first[f] == f as u32 {
            place[f] = kept.len() as u32;
            kept.push(welded[f]);
        }
    }
    let place_of = first.iter().map(|&f| if f == NONE { NONE } else { place[f as usize] }).collect();
    (kept, place_of)
}

fn is_degenerate(positions: &[Vec3], [a, b, c]: [u32; 3]) -> bool {
    if a == b || b == c || c == a {
        return true;
    }
    let [a, b, c] = [a, b, c].map(|v| positions[v as usize].as_dvec3());
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() <= DEGENERATE_AREA * longest
}

/// Turns faces until neighbours across two-faced edges agree. Each component keeps the winding most of its area has; a
/// closed one that is then inside out is turned whole. Where no winding agrees all round (a Moebius strip), the
/// half-edges that still clash are parted later.
fn orient(positions: &[Vec3], faces: &mut [[u32; 3]], report: &mut CleanReport) {
    let mut across = vec![NONE; 3 * faces.len()];
    let mut crowded = vec![false; 3 * faces.len()];
    for_each_edge(faces, |uses| match *uses {
        [_] => {}
        [g, h] => {
            across[g as usize] = h;
            across[h as usize] = g;
        }
        _ => uses.iter().for_each(|&h| crowded[h as usize] = true),
    });
    let area = |c: [u32; 3]| {
        let [a, b, c] = c.map(|v| positions[v as usize].as_dvec3());
        (b - a).cross(c - a).length()
    };
    let mut flip: Vec<Option<bool>> = vec![None; faces.len()];
    for seed in 0..faces.len() as u32 {
        if flip[seed as usize].is_some() {
            continue;
        }
        flip[seed as usize] = Some(false);
        let mut component = vec![seed];
        let (mut as_is, mut turned, mut closed, mut one_sided) = (0.0, 0.0, true, false);
        let mut at = 0;
        while at < component.len() {
            let f = component[at];
            at += 1;
            let mine = flip[f as usize] == Some(true);
            *(if mine { &mut turned } else { &mut as_is }) += area(faces[f as usize]);
            for h in 3 * f..3 * f + 3 {
                let o = across[h as usize];
                closed &= o != NONE && !crowded[h as usize];
                if o == NONE {
                    continue;
                }
                let same_way = ends(faces, h).0 == ends(faces, o).0;
                match flip[(o / 3) as usize] {
                    Some(theirs) => one_sided |= theirs != (mine != same_way),
                    None => {
                        flip[(o / 3) as usize] = Some(mine != same_way);
                        component.push(o / 3);
                    }
                }
            }
        }
        let majority = turned > as_is;
        for &f in &component {
            if flip[f as usize] == Some(!majority) {
                faces[f as usize].swap(1, 2);
            }
        }
        report.one_sided_components += usize::from(one_sided);
        if closed && !one_sided && signed_volume(positions, faces, &component) < 0.0 {
            report.turned_components += 1;
            for &f in &component {
                faces[f as usize].swap(1, 2);
            }
        }
    }
}

/// Half-edge opposites. At an edge with more than two faces the two that lie flattest and run opposite ways are joined
/// first, then the next two; what is left over becomes boundary.
fn pair_half_edges(positions: &[Vec3], faces: &[[u32; 3]], report: &mut CleanReport) -> Vec<u32> {
    let mut opposite = vec![NONE; 3 * faces.len()];
    let mut join = |g: u32, h: u32| {
        opposite[g as usize] = h;
        opposite[h as usize] = g;
    };
    let runs_from = |h: u32| ends(faces, h).0;
    let normal = |h: u32| {
        let [a, b, c] = faces[(h / 3) as usize].map(|v| positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    };
    for_each_edge(faces, |uses| match *uses {
        [_] => {}
        [g, h] if runs_from(g) != runs_from(h) => join(g, h),
        _ => {
            report.non_manifold_edges += 1;
            let mut pairs = Vec::new();
            for (i, &g) in uses.iter().enumerate() {
                for &h in uses[i + 1..].iter().filter(|&&h| runs_from(g) != runs_from(h)) {
                    pairs.push((normal(g).dot(normal(h)), g, h));
                }
            }
            pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut taken: Vec<u32> = Vec::new();
            for (_, g, h) in pairs {
                if !taken.contains(&g) && !taken.contains(&h) {
                    taken.extend([g, h]);
                    join(g, h);
                }
            }
        }
    });
    opposite
}

/// One vertex a fan: walks the fans of all faces and numbers vertices anew, in the order of first use.
pub(crate) fn part_fans(
    positions: &[Vec3],
    mut faces: Vec<[u32; 3]>,
    opposite: Vec<u32>,
    report: &mut CleanReport,
) -> (Mesh, Vec<u32>) {
    let count = 3 * faces.len() as u32;
    let mut vertex = vec![NONE; count as usize];
    let mut user_vertices = Vec::new();
    let mut fans = vec![0_u8; positions.len()];
    for start in 0..count {
        if vertex[start as usize] != NONE {
            continue;
        }
        let place = ends(&faces, start).0;
        let new = user_vertices.len() as u32;
        user_vertices.push(place);
        fans[place as usize] = fans[place as usize].saturating_add(1);
        report.non_manifold_vertices += usize::from(fans[place as usize] == 2);
        // Counter-clockwise until home or a boundary, then clockwise from the start.
        let mut h = start;
        loop {
            vertex[h as usize] = new;
            h = opposite[super::prev(h) as usize];
            if h == NONE || h == start {
                break;
            }
        }
        let mut back = opposite[start as usize];
        while back != NONE && vertex[super::next(back) as usize] == NONE {
            let h = super::next(back);
            vertex[h as usize] = new;
            back = opposite[h as usize];
        }
    }
    for (f, corners) in faces.iter_mut().enumerate() {
        corners.copy_from_slice(&vertex[3 * f..3 * f + 3]);
    }
    let positions = user_vertices.iter().map(|&v| positions[v as usize]).collect();
    (Mesh { positions, faces, opposite }, user_vertices)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f32, y: f32, z: f32) -> Vec3 {
        Vec3::new(x, y, z)
    }

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn tetrahedron() -> Vec<Vec3> {
        vec![v(0., 0., 0.), v(1., 0., 0.), v(0., 1., 0.), v(0., 0., 1.)]
    }

    fn cleaned(positions: &[Vec3], faces: &[[u32; 3]]) -> Cleaned {
        let c = clean(positions, faces, &CleanOptions::default()).expect("cleans");
        c.mesh.check().expect("a clean mesh keeps its invariants");
        c
    }

    #[test]
    fn clean_mesh_is_left_as_it_is() {
        let c = cleaned(&tetrahedron(), &TETRAHEDRON);
        assert_eq!(c.mesh.faces.len(), 4, "all faces stay");
        assert_eq!((c.report.flipped_faces, c.report.welded_vertices, c.report.euler_characteristic), (0, 0, 2), "{:?}", c.report);
    }

    #[test]
    fn inside_out_solid_is_turned_and_corners_lead_back() {
        let inward = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        let c = cleaned(&tetrahedron(), &inward);
        assert!(c.mesh.signed_volume() > 0.0, "the solid faces outward");
        assert_eq!((c.report.turned_components, c.report.flipped_faces), (1, 4), "{:?}", c.report);
        for (user, to) in inward.iter().zip(&c.user_faces) {
            for k in 0..3 {
                let mine = c.mesh.faces[to.face as usize][to.corners[k] as usize];
                assert_eq!(c.user_vertices[mine as usize], user[k], "corner {k} of {user:?}");
            }
        }
    }

    #[test]
    fn one_turned_face_is_turned_back() {
        let mut faces = TETRAHEDRON;
        faces[2].swap(0, 1);
        let c = cleaned(&tetrahedron(), &faces);
        assert_eq!((c.report.flipped_faces, c.report.boundary_edges), (1, 0), "{:?}", c.report);
    }

    #[test]
    fn fan_of_three_faces_on_an_edge_keeps_the_flattest_pair() {
        let p = [v(0., 0., 0.), v(1., 0., 0.), v(0., 1., 0.), v(0., -1., 0.1), v(0., 0., 1.)];
        let c = cleaned(&p, &[[0, 1, 2], [1, 0, 3], [1, 0, 4]]);
        assert_eq!(c.report.non_manifold_edges, 1, "{:?}", c.report);
        assert_eq!(c.mesh.neighbour(0, 0), 1, "the flat pair stays joined");
        assert_eq!(c.report.components, 2, "the fin is parted");
    }

    #[test]
    fn cones_that_touch_at_a_point_are_parted() {
        let p = [v(0., 0., 0.), v(1., 0., 1.), v(0., 1., 1.), v(-1., -1., 1.), v(1., 0., -1.), v(0., 1., -1.), v(-1., -1., -1.)];
        let faces = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [0, 4, 5], [0, 5, 6], [0, 6, 4]];
        let c = cleaned(&p, &faces);
        assert_eq!((c.report.non_manifold_vertices, c.mesh.vertex_count()), (1, 8), "{:?}", c.report);
    }

    #[test]
    fn moebius_strip_is_cut_open_rather_than_refused() {
        let n = 12;
        let mut p = Vec::new();
        for i in 0..n {
            let a = std::f32::consts::TAU * i as f32 / n as f32;
            let (radial, half) = (v(a.cos(), a.sin(), 0.), a / 2.);
            let across = radial * half.cos() + Vec3::Z * half.sin();
            p.extend([radial - across * 0.3, radial + across * 0.3]);
        }
        let mut faces = Vec::new();
        for i in 0..n {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
            faces.extend([[a, c, b], [b, c, d]]);
        }
        let c = cleaned(&p, &faces);
        assert_eq!(c.report.components, 1, "{:?}", c.report);
        assert_eq!((c.report.boundary_loops, c.report.non_manifold_edges), (1, 1), "a strip with one cut: {:?}", c.report);
        assert_eq!((c.report.one_sided_components, c.report.turned_components), (1, 0), "and told: {:?}", c.report);
        let told = OpenComponent { first_face: 0, faces: 24, boundary_edges: 26 };
        assert_eq!(c.report.largest_open, [told], "the open component: 24 edges of the strip's rim and two of the cut");
    }

    #[test]
    fn degenerate_and_copied_faces_go_but_copies_still_lead_to_their_face() {
        let mut faces = TETRAHEDRON.to_vec();
        faces.extend([[0, 1, 1], [1, 3, 0]]);
        let c = cleaned(&tetrahedron(), &faces);
        assert_eq!((c.report.degenerate_faces, c.report.duplicate_faces), (1, 1), "{:?}", c.report);
        assert_eq!(c.user_faces[4].face, NONE, "a face without area stands for nothing");
        assert_eq!(c.user_faces[5], UserFace { face: 1, corners: [1, 2, 0] }, "the copy");
    }

    #[test]
    fn seams_are_welded_exactly_and_within_a_tolerance() {
        let mut p = tetrahedron();
        p.push(v(1.0, -0.0, 0.0));
        let mut faces = TETRAHEDRON;
        faces[2][0] = 4;
        assert_eq!(cleaned(&p, &faces).report.boundary_edges, 0, "equal positions weld");
        p[4].x += 1e-4;
        assert_eq!(cleaned(&p, &faces).report.boundary_edges, 4, "near ones do not");
        let near = clean(&p, &faces, &CleanOptions { weld: 1e-3, ..CleanOptions::default() }).expect("cleans");
        assert_eq!(near.report.boundary_edges, 0, "unless asked");
    }

    #[test]
    fn bad_input_is_told_by_element() {
        let p = tetrahedron();
        let go = |p: &[Vec3], f: &[[u32; 3]]| clean(p, f, &CleanOptions::default()).map(|_| ()).unwrap_err();
        assert_eq!(go(&p, &[]), MeshError::Empty, "no faces");
        assert_eq!(go(&p, &[[0, 1, 9]]), MeshError::IndexOutOfRange { face: 0, vertex: 9, count: 4 }, "index");
        assert_eq!(go(&[p[0], v(f32::NAN, 0., 0.), p[2]], &[[0, 1, 2]]), MeshError::NotFinite { vertex: 1 }, "NaN");
        assert_eq!(go(&p, &[[0, 0, 1]]), MeshError::NoArea { count: 1 }, "no area");
    }
}
