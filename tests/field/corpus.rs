//! Tangent fields on real meshes: scans, sculpts and parts with everything that is wrong with them. Takes the folder of meshes
//! from the environment variable `LAPPED_CORPUS` and does nothing without it.

use glam::{DVec3, Vec3};
use lapped::field::{
    Constraint, Constraints, FieldOptions, RefineOptions, TangentField, constrained, constrained_on, default_scale,
    refine_near_singularities, singularities, up, up_on,
};
use lapped::mesh::geodesic::Geodesic;
use lapped::mesh::nearest::Nearest;
use lapped::mesh::{CleanOptions, Mesh, NONE, SurfacePoint, clean};
use lapped::random::Random;
use std::path::Path;
use std::sync::LazyLock;

/// The OBJ meshes of the corpus, cleaned, by name; read once for all tests.
fn meshes() -> impl Iterator<Item = (&'static str, &'static Mesh)> {
    static MESHES: LazyLock<Vec<(String, Mesh)>> = LazyLock::new(read_meshes);
    MESHES.iter().map(|(name, mesh)| (name.as_str(), mesh))
}

fn read_meshes() -> Vec<(String, Mesh)> {
    let Some(corpus) = crate::folder::corpus() else { return Vec::new() };
    let folder = corpus.join("meshes");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("LAPPED_CORPUS has a folder `meshes`")
        .map(|entry| entry.expect("readable").file_name().into_string().expect("a plain name"))
        .filter(|name| name.ends_with(".obj"))
        .collect();
    names.sort();
    assert!(names.len() > 10, "the corpus has its OBJ meshes: {names:?}");
    names.into_iter().map(|name| (name.clone(), load(&folder.join(name)))).collect()
}

fn load(path: &Path) -> Mesh {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj(path, &options).expect("an OBJ file");
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for model in models {
        let first = positions.len() as u32;
        positions.extend(model.mesh.positions.chunks(3).map(|p| Vec3::new(p[0], p[1], p[2])));
        faces.extend(model.mesh.indices.chunks(3).map(|f| [first + f[0], first + f[1], first + f[2]]));
    }
    clean(&positions, &faces, &CleanOptions::default()).expect("a mesh").mesh
}

fn check_field(name: &str, mesh: &Mesh, field: &TangentField, length: f64) {
    assert_eq!(field.up.len(), mesh.face_count(), "{name}: a vector a face");
    for (f, t) in field.up.iter().enumerate() {
        let t = t.as_dvec3();
        assert!((t.length() / length - 1.0).abs() < 1e-4, "{name}: face {f} has length {} for {length}", t.length());
        assert!(t.dot(mesh.normal(f as u32)).abs() < 1e-4 * length, "{name}: face {f} leaves its plane");
    }
}

fn is_closed(mesh: &Mesh) -> bool {
    mesh.boundary_edge_count() == 0
}

fn index_sum(mesh: &Mesh, field: &TangentField) -> i64 {
    singularities(mesh, &field.up).iter().map(|s| i64::from(s.index)).sum()
}

fn wishes(mesh: &Mesh, count: usize, seed: u64) -> Constraints {
    let mut random = Random::new(seed, 0);
    let mut one = || Constraint {
        face: Some(random.below(mesh.face_count() as u64) as u32),
        angle: Some(random.range(-60.0, 60.0)),
        scale: Some(1.0),
        ..Constraint::default()
    };
    Constraints { constraints: (0..count).map(|_| one()).collect(), ..Constraints::default() }
}

#[test]
fn every_mesh_gets_a_whole_field_whose_indices_sum_to_its_euler_characteristic() {
    for (name, mesh) in meshes() {
        let scale = default_scale(mesh, 40.0, 1.0);
        let (field, _) = up(mesh, DVec3::Y, scale).expect("a field");
        check_field(name, mesh, &field, scale);
        let anchors = wishes(mesh, 5, 1).anchors(mesh, None, DVec3::Y, 0.1).expect("good constraints");
        let (guided, _) = constrained(mesh, &anchors, &FieldOptions { scale, ..FieldOptions::default() }).expect("a field");
        check_field(name, mesh, &guided, scale);
        if is_closed(mesh) {
            assert_eq!(index_sum(mesh, &field), mesh.euler_characteristic(), "{name}: projected axis");
            assert_eq!(index_sum(mesh, &guided), mesh.euler_characteristic(), "{name}: constraints");
        }
    }
}

#[test]
fn every_constraint_is_met_at_its_face() {
    for (name, mesh) in meshes() {
        let anchors = wishes(mesh, 12, 2).anchors(mesh, None, DVec3::Y, 0.1).expect("good constraints");
        let (field, statistics) = constrained(mesh, &anchors, &FieldOptions::default()).expect("a field");
        for anchor in &anchors {
            let off = field.up[anchor.at.face as usize].as_dvec3().angle_between(anchor.direction.expect("given"));
            assert!(off < 0.01, "{name}: {off} radians off at face {}", anchor.at.face);
        }
        assert!(statistics.filled_faces < mesh.face_count() / 50, "{name}: {} faces without a direction", statistics.filled_faces);
    }
}

#[test]
fn refined_meshes_keep_their_topology_and_lead_back() {
    for (name, mesh) in meshes() {
        let scale = default_scale(mesh, 80.0, 1.0);
        let anchors = wishes(mesh, 4, 3).anchors(mesh, None, DVec3::Y, 0.1).expect("good constraints");
        let options = FieldOptions { scale, ..FieldOptions::default() };
        let refine = RefineOptions::default();
        let by_axis = refine_near_singularities(mesh, &refine, |fine| up_on(mesh, fine, DVec3::Y, scale).map(|f| f.0));
        let by_wish = refine_near_singularities(mesh, &refine, |fine| constrained_on(mesh, fine, &anchors, &options).map(|f| f.0));
        for refined in [by_axis.expect("refines"), by_wish.expect("refines")] {
            let fine = &refined.subdivision;
            fine.mesh.check().unwrap_or_else(|problem| panic!("{name}: {problem}"));
            check_field(name, &fine.mesh, &refined.field, scale);
            assert_eq!(fine.mesh.euler_characteristic(), mesh.euler_characteristic(), "{name}: Euler characteristic");
            assert!((fine.mesh.total_area() / mesh.total_area() - 1.0).abs() < 1e-4, "{name}: area");
            assert!(fine.mesh.face_count() <= mesh.face_count() * 3 / 2 + 6000, "{name}: {:?}", refined.statistics);
            assert!(fine.parent.is_sorted() && fine.parent.last() == Some(&(mesh.face_count() as u32 - 1)), "{name}: parents");
        }
    }
}

#[test]
fn distance_along_the_surface_behaves_like_a_distance() {
    for (name, mesh) in meshes() {
        let (component, _) = mesh.components();
        let mut random = Random::new(4, 0);
        let points: Vec<SurfacePoint> = (0..6)
            .map(|_| SurfacePoint { face: random.below(mesh.face_count() as u64) as u32, bary: Vec3::splat(1.0 / 3.0) })
            .collect();
        let mut geodesic = Geodesic::new(mesh);
        let table: Vec<Vec<f64>> = points
            .iter()
            .map(|&p| {
                geodesic.search(&[p], f64::INFINITY);
                points.iter().map(|&q| geodesic.at(q)).collect()
            })
            .collect();
        for (i, p) in points.iter().enumerate() {
            for (j, q) in points.iter().enumerate() {
                let d = table[i][j];
                let joined = component[p.face as usize] == component[q.face as usize];
                assert_eq!(d.is_finite(), joined, "{name}: reached just within the component");
                if !joined {
                    continue;
                }
                let straight = mesh.position(*p).distance(mesh.position(*q));
                assert!(d >= straight * (1.0 - 1e-6), "{name}: {d} is shorter than straight, {straight}");
                assert!((d - table[j][i]).abs() <= 0.05 * d, "{name}: {d} there, {} back", table[j][i]);
                for between in &table {
                    assert!(d <= 1.05 * (between[i] + between[j]), "{name}: a detour is shorter than {d}");
                }
            }
        }
    }
}

#[test]
fn the_nearest_surface_point_of_a_surface_point_is_itself() {
    for (name, mesh) in meshes() {
        let tree = Nearest::new(mesh);
        let (low, high) = mesh.bounds();
        let size = f64::from(low.distance(high));
        for f in (0..mesh.face_count() as u32).step_by(97) {
            let at = mesh.centroid(f);
            let hit = tree.nearest(at).expect("a finite point");
            assert!(hit.distance < 1e-6 * size && hit.at.face != NONE, "{name}: {} from itself", hit.distance);
        }
    }
}
