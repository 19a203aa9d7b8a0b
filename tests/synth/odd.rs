//! What nobody should give, and somebody will: a result or clear words, never a panic.

use glam::Vec3;
use lapped::exemplar::{Exemplar, Image, Wrap};
use lapped::job::{Density, SynthJob, SynthJobError, Synthesized, synthesize_on};
use lapped::mesh::{CleanOptions, Cleaned, clean};
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::synth::{SearchKind, SynthOptions};

fn mesh(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Cleaned {
    let positions: Vec<Vec3> = positions.iter().map(|&p| p.into()).collect();
    clean(&positions, faces, &CleanOptions::default()).expect("a mesh")
}

fn tetrahedron() -> Cleaned {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    mesh(&corners, &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
}

fn run(mesh: &Cleaned, exemplar: &Exemplar, vertices: usize, search: SearchKind) -> Result<Synthesized, SynthJobError> {
    let options = SynthOptions { search, ..SynthOptions::default() };
    let job = SynthJob { density: Density::Vertices(vertices), options, ..SynthJob::default() };
    synthesize_on(mesh, exemplar, &job, &Silent, &mut |_, _, _| ())
}

fn noise(w: u32, h: u32) -> Exemplar {
    let mut random = Random::new(1, 1);
    Exemplar::new("noise", Image::from_fn(w, h, |_, _| Vec3::splat(random.unit() as f32)))
}

#[test]
fn exemplars_smaller_than_a_neighbourhood_and_of_one_colour() {
    let mesh = tetrahedron();
    for search in [SearchKind::Fast, SearchKind::Tsvq, SearchKind::Exhaustive] {
        for (w, h) in [(1, 1), (2, 1), (3, 3), (1, 40), (6, 5), (17, 9)] {
            for wrap in [Wrap::Clamp, Wrap::Repeat] {
                let mut exemplar = noise(w, h);
                exemplar.wrap = wrap;
                let made = run(&mesh, &exemplar, 300, search).unwrap_or_else(|e| panic!("{w}x{h} {wrap:?} {search:?}: {e}"));
                let finite = made.texture.all().iter().flat_map(|(_, v)| v).all(|x| (-1e-6..=1.0 + 1e-6).contains(x));
                assert!(finite, "{w}x{h} {wrap:?} {search:?}");
            }
        }
        let plain = Exemplar::new("plain", Image::from_fn(32, 32, |_, _| Vec3::new(0.2, 0.5, 0.1)));
        let made = run(&mesh, &plain, 300, search).expect("a result");
        let off =
            made.texture.all()[0].1.chunks(3).map(|c| Vec3::from_slice(c).distance(Vec3::new(0.2, 0.5, 0.1))).fold(0.0, f32::max);
        assert!(off < 1e-5, "{search:?}: one colour stays that colour, but for {off}");
    }
}

#[test]
fn surfaces_of_a_few_faces_in_parts_and_with_edges() {
    let exemplar = noise(32, 32);
    let triangle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    let two = mesh(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 1.0]],
        &[[0, 1, 2], [3, 4, 5]],
    );
    for (name, mesh) in [("tetrahedron", tetrahedron()), ("triangle", triangle), ("two triangles", two)] {
        for vertices in [1, 4, 50, 700] {
            match run(&mesh, &exemplar, vertices, SearchKind::Fast) {
                Ok(made) => {
                    let finite = made.texture.all().iter().flat_map(|(_, v)| v).all(|x| x.is_finite());
                    assert!(finite, "{name}, {vertices} vertices");
                }
                Err(error) => assert!(error.to_string().contains("too few"), "{name}, {vertices} vertices: {error}"),
            }
        }
    }
}

#[test]
fn tiny_and_huge_meshes_get_the_same_texture() {
    let exemplar = noise(32, 32);
    let at = |size: f32| {
        let corners =
            [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(|c: [f32; 3]| c.map(|x| x * size));
        let made = run(&mesh(&corners, &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]), &exemplar, 600, SearchKind::Fast);
        made.expect("a result").report.synth.levels.iter().map(|l| (l.vertices, l.uncovered_samples)).collect::<Vec<_>>()
    };
    // Powers of two change nothing but exponents.
    assert_eq!(at(1.0), at(2.0_f32.powi(20)), "huge");
    assert_eq!(at(1.0), at(2.0_f32.powi(-20)), "tiny");
}

#[test]
fn scales_that_ask_for_nothing_or_too_much() {
    for scale in [0.0, -1.0, f64::NAN, 1e-9, 1e9] {
        let job = SynthJob { density: Density::Scale(scale), ..SynthJob::default() };
        let found = synthesize_on(&tetrahedron(), &noise(32, 32), &job, &Silent, &mut |_, _, _| ());
        assert!(found.is_err_and(|e| e.to_string().contains("vertices")), "scale {scale}");
    }
}
