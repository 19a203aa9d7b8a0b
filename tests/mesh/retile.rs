//! Re-tiling on the program's own meshes, on those of `LAPPED_CORPUS`, and on the hardest ones there are: the topology stays, faces
//! are sound, the count and the distance are kept, and what cannot be done is told.

use glam::Vec3;
use lapped::assets;
use lapped::format::read_model;
use lapped::mesh::distance::farthest;
use lapped::mesh::retile::{RetileError, RetileOptions, Retiled, retile};
use lapped::mesh::{CleanOptions, Mesh, clean};
use lapped::progress::Silent;

fn cleaned(positions: &[Vec3], faces: &[[u32; 3]]) -> Mesh {
    clean(positions, faces, &CleanOptions::default()).expect("a mesh").mesh
}

fn own(name: &str) -> Mesh {
    let model = assets::mesh(name).expect("a demo mesh");
    cleaned(&model.positions, &model.faces)
}

fn to(mesh: &Mesh, vertices: usize) -> Result<Retiled, RetileError> {
    retile(mesh, &RetileOptions { vertices, ..RetileOptions::default() }, &Silent)
}

/// What holds for every re-tiled mesh, however hard the original was.
fn check(name: &str, mesh: &Mesh, made: &Retiled) {
    assert_eq!(made.mesh.check(), Ok(()), "{name}");
    assert_eq!(made.mesh.euler_characteristic(), mesh.euler_characteristic(), "{name}: Euler characteristic");
    assert_eq!(made.mesh.components().1, mesh.components().1, "{name}: components");
    assert_eq!(made.mesh.boundary_loop_count(), mesh.boundary_loop_count(), "{name}: boundary loops");
    assert_eq!(made.statistics.evenness.degenerate_faces, 0, "{name}: faces without width");
    let (low, high) = mesh.bounds();
    let size = f64::from(low.distance(high));
    assert_eq!(made.at.len(), made.mesh.vertex_count(), "{name}: a surface point for each vertex");
    for (v, &at) in made.at.iter().enumerate() {
        let off = mesh.position(at).distance(made.mesh.point(v as u32));
        assert!(off < 1e-5 * size, "{name}: vertex {v} is {off} from its surface point");
    }
}

/// Largest distance between a mesh and what was made of it, both ways, in edges of the latter.
fn hausdorff(mesh: &Mesh, made: &Retiled) -> f64 {
    let edge = made.statistics.evenness.mean_edge;
    farthest(mesh, &made.mesh, 0.25 * edge).max(farthest(&made.mesh, mesh, 0.25 * edge)) / edge
}

#[test]
fn neighbours_are_near_in_memory_too() {
    for vertices in [2_000, 20_000] {
        let made = to(&own("dragonling"), vertices).expect("enough vertices");
        let faces = &made.mesh.faces;
        let away: f64 = faces.iter().map(|f| f64::from(f[0].abs_diff(f[1]))).sum::<f64>() / faces.len() as f64;
        // Numbers drawn at random would be a third of all away; along a curve it grows as the root.
        assert!(away < 3.0 * (vertices as f64).sqrt(), "{vertices} vertices: {away} numbers away on the mean");
    }
}

#[test]
fn own_meshes_keep_their_shape_at_a_quarter_the_same_and_four_times() {
    for name in ["knot", "gear", "vase", "terrain"] {
        let mesh = own(name);
        for times in [0.25, 1.0, 4.0] {
            let asked = (mesh.vertex_count() as f64 * times) as usize;
            let crease = (name == "gear").then_some(0.6);
            let options = RetileOptions { vertices: asked, crease, ..RetileOptions::default() };
            let made = retile(&mesh, &options, &Silent).expect("enough vertices");
            // Between the teeth its lines lie closer than an edge at a quarter of its vertices.
            let even = if name == "gear" { 0.3 } else { 0.2 };
            let name = format!("{name} x {times}");
            check(&name, &mesh, &made);
            assert!(made.mesh.vertex_count().abs_diff(asked) * 100 <= asked, "{name}: {} for {asked}", made.mesh.vertex_count());
            let e = made.statistics.evenness;
            assert!(e.edge_variation < even, "{name}: edges vary by {}", e.edge_variation);
            assert!(hausdorff(&mesh, &made) < 0.5, "{name}: {} edges away", hausdorff(&mesh, &made));
        }
    }
}

#[test]
fn corpus_meshes_keep_their_topology_and_their_place() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let folder = corpus.join("meshes");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("LAPPED_CORPUS has a folder `meshes`")
        .map(|entry| entry.expect("readable").file_name().into_string().expect("a plain name"))
        .collect();
    names.sort();
    for name in names {
        let model = read_model(&folder.join(&name)).expect("a corpus mesh");
        let mesh = cleaned(&model.positions, &model.faces);
        if mesh.vertex_count() > if crate::folder::whole() { 40_000 } else { 8_000 } {
            continue;
        }
        for times in [0.25, 1.0, 4.0] {
            let asked = (mesh.vertex_count() as f64 * times) as usize;
            let label = format!("{name} x {times}");
            let made = to(&mesh, asked).expect(&label);
            let found = made.mesh.vertex_count();
            assert!(found.abs_diff(asked) * 100 <= asked, "{label}: {found} vertices for {asked}");
            // Needles and crossing sheets are worse; the bound is what tells a bad step from a hard mesh.
            assert!(made.statistics.evenness.edge_variation < 0.5, "{label}: {:?}", made.statistics);
            check(&label, &mesh, &made);
            // Where parts of a mesh are thinner than an edge, or touch, the surfaces come apart a little farther.
            let thin = ["blade", "cow", "dino", "dragon", "mannequin", "suzanne", "teapot"].iter().any(|n| name.starts_with(n));
            let most = if thin { 0.95 } else { 0.53 };
            assert!(hausdorff(&mesh, &made) < most, "{label}: {} edges away", hausdorff(&mesh, &made));
        }
    }
}

#[test]
fn the_same_options_make_the_same_mesh_on_any_number_of_threads() {
    let mesh = own("vase");
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| to(&mesh, 2000).expect("enough vertices").mesh)
    };
    assert_eq!(on(1), on(3), "one thread and three");
}

#[test]
fn creases_stay_sharp_on_request() {
    let mesh = own("gear");
    let options = RetileOptions { vertices: 4000, crease: Some(0.6), ..RetileOptions::default() };
    let made = retile(&mesh, &options, &Silent).expect("enough vertices");
    check("gear", &mesh, &made);
    let plain = to(&mesh, 4000).expect("enough vertices");
    let (sharp, blunt) = (hausdorff(&mesh, &made), hausdorff(&mesh, &plain));
    assert!(sharp < 0.6 * blunt, "with creases {sharp}, without {blunt}");
}

#[test]
fn size_does_not_matter() {
    let mesh = own("knot");
    let at = |size: f32| {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|&p| p * size).collect();
        to(&cleaned(&positions, &mesh.faces), 1500).expect("enough vertices").statistics.evenness.edge_variation
    };
    for size in [1e-6, 1e6] {
        assert!((at(size) - at(1.0)).abs() < 0.02, "at {size}: {} instead of {}", at(size), at(1.0));
    }
}

#[test]
fn counts_that_make_no_surface_are_refused_in_words() {
    let mesh = own("knot");
    for asked in [0, 3] {
        let told = to(&mesh, asked).expect_err("too few").to_string();
        assert!(told.contains("too few") && told.contains("at least 4"), "{asked}: {told}");
    }
    let told = to(&mesh, 1 << 40).expect_err("too many").to_string();
    assert!(told.contains("too many"), "{told}");
    for crease in [0.0, -1.0, f64::NAN, 4.0] {
        let options = RetileOptions { vertices: 500, crease: Some(crease), ..RetileOptions::default() };
        assert!(matches!(retile(&mesh, &options, &Silent), Err(RetileError::Crease(_))), "crease {crease}");
    }
}

fn tetrahedron(at: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p + at).to_vec();
    (p, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
}

#[test]
fn a_sphere_of_four_faces_can_stay_and_grow() {
    let (positions, faces) = tetrahedron(Vec3::ZERO);
    let mesh = cleaned(&positions, &faces);
    for asked in [4, 5, 20, 3000] {
        let made = to(&mesh, asked).expect("four are enough");
        check(&format!("tetrahedron to {asked}"), &mesh, &made);
        assert!(made.mesh.vertex_count().abs_diff(asked) * 100 <= asked.max(100), "{} for {asked}", made.mesh.vertex_count());
    }
}

#[test]
fn strips_and_needles_stay_what_they_are() {
    let strip = |width: f32, pieces: u32| {
        let positions: Vec<Vec3> = (0..=pieces).flat_map(|i| [0.0, width].map(|y| Vec3::new(i as f32, y, 0.0))).collect();
        let faces: Vec<[u32; 3]> =
            (0..pieces).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]]).collect();
        cleaned(&positions, &faces)
    };
    for (width, pieces) in [(1.0, 40), (0.01, 40), (50.0, 30)] {
        let mesh = strip(width, pieces);
        for asked in [8, 60, 1000] {
            let made = to(&mesh, asked).expect("enough vertices");
            check(&format!("strip {width} wide to {asked}"), &mesh, &made);
        }
    }
    let single = cleaned(&[Vec3::ZERO, Vec3::X * 100.0, Vec3::Y], &[[0, 1, 2]]);
    for asked in [3, 4, 200] {
        check(&format!("one needle to {asked}"), &single, &to(&single, asked).expect("enough vertices"));
    }
}

#[test]
fn ten_thousand_components_all_stay() {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for i in 0..10_000_u32 {
        let (p, f) = tetrahedron(Vec3::new((i % 100) as f32, (i / 100) as f32, 0.0) * 2.0);
        positions.extend(p);
        faces.extend(f.iter().map(|c| c.map(|v| v + 4 * i)));
    }
    let mesh = cleaned(&positions, &faces);
    assert!(to(&mesh, 39_999).is_err(), "four each are needed");
    for asked in [40_000, 60_000] {
        let made = to(&mesh, asked).expect("enough vertices");
        check(&format!("10,000 to {asked}"), &mesh, &made);
        assert!(made.mesh.vertex_count().abs_diff(asked) * 100 <= asked, "{} for {asked}", made.mesh.vertex_count());
    }
}
