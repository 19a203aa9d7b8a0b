//! n-way fields on the program's own meshes and those of `LAPPED_CORPUS`.

use lapped::assets;
use lapped::field::nway::{Measure, NWayOptions, NWaySolver, Over, Start, comb, energy, on_pyramid};
use lapped::format::{Model, read_model};
use lapped::mesh::pyramid::pyramid;
use lapped::mesh::retile::RetileOptions;
use lapped::mesh::{CleanOptions, Mesh, clean};
use lapped::progress::Silent;

fn cleaned(name: &str, model: &Model) -> (String, Mesh) {
    (name.to_owned(), clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a mesh").mesh)
}

/// The program's own.
fn meshes() -> Vec<(String, Mesh)> {
    let own = |name| cleaned(name, &assets::mesh(name).expect("a demo mesh"));
    assets::mesh_names().map(own).filter(|(_, m)| m.face_count() < 40_000).collect()
}

#[test]
fn indices_sum_to_the_euler_characteristic_and_errors_never_rise() {
    sums_and_errors(meshes());
}

#[test]
fn on_corpus_meshes_indices_sum_to_the_euler_characteristic_and_errors_never_rise() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let read = |name| cleaned(name, &read_model(&corpus.join("meshes").join(name)).expect("a corpus mesh"));
    sums_and_errors(["bunny-npm.obj", "torus.obj", "fandisk.obj", "duck.glb", "suzanne.obj", "cow.obj"].map(read));
}

fn sums_and_errors(meshes: impl IntoIterator<Item = (String, Mesh)>) {
    for (name, mesh) in meshes {
        for n in [1, 2, 4, 6] {
            for over in [Over::Vertices, Over::Faces] {
                let solver = NWaySolver::new(&mesh, over, n);
                let (field, s) = solver.solve(&[], &NWayOptions { nearest: true, ..NWayOptions::default() }, &Silent);
                let label = format!("{name}, n {n}, {over:?}");
                for errors in [&s.smooth_errors, &s.nearest_errors] {
                    assert!(errors.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-9) + 1e-15), "{label}: {errors:?}");
                }
                if mesh.boundary_edge_count() == 0 {
                    assert_eq!(s.index_sum, i64::from(n) * mesh.euler_characteristic(), "{label}: sum of indices");
                }
                if over == Over::Faces {
                    let combed = comb(&mesh, &solver, &field, 0.3).expect("a field over faces");
                    let bad =
                        combed.field.up.iter().enumerate().find(|(f, t)| {
                            (t.length() - 0.3).abs() > 1e-4 || t.as_dvec3().dot(mesh.normal(*f as u32)).abs() > 1e-4
                        });
                    assert_eq!(bad, None, "{label}: a vector in each face's plane");
                }
            }
        }
    }
}

#[test]
fn told_errors_are_those_of_the_field() {
    for (name, mesh) in meshes().into_iter().take(3) {
        let solver = NWaySolver::new(&mesh, Over::Vertices, 4);
        let (field, s) = solver.solve(&[], &NWayOptions::default(), &Silent);
        let whole = energy(&solver.table, 4, &field.powers, &[], Measure::Smooth);
        let told = *s.smooth_errors.last().expect("relaxed");
        assert!((whole - told).abs() < 1e-6 * whole.max(1e-6), "{name}: {told} told, {whole} found");
    }
}

#[test]
fn the_smooth_start_ends_about_as_low_as_a_random_one_over_a_pyramid_or_lower() {
    let model = assets::mesh("vase").expect("a demo mesh");
    let mesh = clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a mesh").mesh;
    let made = pyramid(&mesh, &RetileOptions { vertices: 4000, ..RetileOptions::default() }, 3, &Silent).expect("enough vertices");
    for n in [1, 2, 4] {
        let random = on_pyramid(&made, n, &NWayOptions { start: Start::Random, ..NWayOptions::default() }, &Silent);
        let solver = NWaySolver::new(&made.levels[0].mesh, Over::Vertices, n);
        let (smooth, _) = solver.solve(&[], &NWayOptions::default(), &Silent);
        let error = |powers: &[glam::DVec2]| energy(&solver.table, n, powers, &[], Measure::Smooth);
        let (by_levels, by_start) = (error(&random.fields[0].powers), error(&smooth.powers));
        assert!(by_levels < 10.0 * by_start, "n {n}: {by_levels} by levels, {by_start} from the smooth start");
        assert!(by_start < 1.15 * by_levels, "n {n}: {by_levels} by levels, {by_start} from the smooth start");
    }
}
