//! Every surface patch that is laid is a disc, and a fit of it is the minimum that a direct solver finds.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::common::{Points, asset, patches};
use glam::{DMat2, DVec2, DVec3};
use lapped::exemplar::{PatchSource, TexturePatch};
use lapped::field::{Guide, default_scale, isotropic, up};
use lapped::mesh::disc::{Disc, Scratch, check_disc};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::paste::fit::{FitProblem, Fitter, IsotropicFit, Weights, energy};
use lapped::paste::frame::Frame;
use lapped::paste::grow::{PatchPlan, Predictor, Site};
use lapped::paste::lay::{FitChoice, Laid, lay};
use lapped::paste::{DISTORTION_DIRECTED, DISTORTION_ISOTROPIC};
use lapped::random::Random;

/// Width of the demo exemplar that the patches here are cut from, pixels.
const BRICKS_WIDTH: u32 = 384;

/// The guides of a mesh at a texture scale: the axis, and none.
fn guides(mesh: &Mesh, ratio: f64) -> [Guide; 2] {
    let scale = default_scale(mesh, ratio, 1.0);
    [Guide::Directed(up(mesh, DVec3::Y, scale).unwrap().0), isotropic(mesh, scale).unwrap()]
}

fn laid_with(
    mesh: &Mesh,
    guide: &Guide,
    patch: &TexturePatch,
    seed: SurfacePoint,
    predictor: Predictor,
    fit: FitChoice,
    scratch: &mut Scratch,
) -> Laid {
    let plan = PatchPlan::new(patch, BRICKS_WIDTH);
    let distortion = if guide.field().is_some() { DISTORTION_DIRECTED } else { DISTORTION_ISOTROPIC };
    lay(Site { mesh, guide, plan: &plan, seed, distortion, predictor, free: false }, 0.7, fit, scratch).unwrap()
}

/// Vertices, edges, faces, boundary loops and pieces of a set of faces, counted by corner indices alone.
fn topology(mesh: &Mesh, faces: &[u32]) -> (i64, usize, usize) {
    use std::collections::{BTreeMap, BTreeSet};
    let corners: Vec<[u32; 3]> = faces.iter().map(|&f| mesh.faces[f as usize]).collect();
    let vertices: BTreeSet<u32> = corners.iter().flatten().copied().collect();
    let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (i, c) in corners.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            edges.entry([a.min(b), a.max(b)]).or_default().push(i);
        }
    }
    // Pieces joined over edges, not merely at vertices.
    let mut piece: Vec<usize> = (0..faces.len()).collect();
    let root = |piece: &[usize], mut i: usize| {
        while piece[i] != i {
            i = piece[i];
        }
        i
    };
    for sharing in edges.values() {
        for pair in sharing.windows(2) {
            let (a, b) = (root(&piece, pair[0]), root(&piece, pair[1]));
            piece[a] = b;
        }
    }
    let pieces = (0..faces.len()).filter(|&i| piece[i] == i).count();
    // Boundary edges as a graph; a disc's is one cycle: every vertex has two of them, all hang together.
    let boundary: Vec<[u32; 2]> = edges.iter().filter(|(_, f)| f.len() == 1).map(|(e, _)| *e).collect();
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in &boundary {
        next.entry(*a).or_default().push(*b);
        next.entry(*b).or_default().push(*a);
    }
    let simple = next.values().all(|n| n.len() == 2);
    let mut seen = BTreeSet::new();
    let mut loops = 0;
    for &start in next.keys() {
        if seen.insert(start) {
            loops += 1;
            let mut stack = vec![start];
            while let Some(v) = stack.pop() {
                stack.extend(next[&v].iter().copied().filter(|&w| seen.insert(w)));
            }
        }
    }
    let euler = vertices.len() as i64 - edges.len() as i64 + faces.len() as i64;
    (euler, if simple { loops } else { usize::MAX }, pieces)
}

#[test]
fn every_patch_laid_is_a_disc_in_one_piece() {
    let shapes: Vec<TexturePatch> =
        [PatchSource::Whole, PatchSource::Splotch].into_iter().flat_map(|s| patches("bricks", s)).collect();
    let (mut patches_seen, mut faces_seen, mut most) = (0, 0, 0);
    for name in ["dragonling", "knot", "gear", "vase", "terrain"] {
        let mesh = asset(name);
        let mut scratch = Scratch::new(&mesh);
        let seeds = Points::new(&mesh).list(16);
        for ratio in [3.0, 30.0, 300.0] {
            for guide in &guides(&mesh, ratio) {
                for (i, &seed) in seeds.iter().enumerate() {
                    let predictor = if i % 4 == 3 { Predictor::SimilarTriangles } else { Predictor::Field };
                    let patch = &shapes[i % shapes.len()];
                    let laid = laid_with(&mesh, guide, patch, seed, predictor, FitChoice::default(), &mut scratch);
                    let disc = &laid.disc;
                    let found = check_disc(&mesh, &disc.faces);
                    assert!(found.is_ok(), "{name} at ratio {ratio}, seed {i}: {found:?}");
                    let counted = topology(&mesh, &disc.faces);
                    assert_eq!(counted, (1, 1, 1), "{name} at ratio {ratio}, seed {i}: Euler characteristic, loops, pieces");
                    assert!(disc.faces.contains(&seed.face), "the seed's face is in");
                    let unlike = disc
                        .faces
                        .iter()
                        .zip(&disc.corners)
                        .find(|(f, c)| c.map(|v| disc.vertices[v as usize]) != mesh.faces[**f as usize]);
                    assert!(unlike.is_none(), "{name}: a face's corners are others than the mesh's: {unlike:?}");
                    patches_seen += 1;
                    faces_seen += disc.faces.len();
                    most = most.max(disc.faces.len());
                }
            }
        }
    }
    eprintln!("{patches_seen} patches, {faces_seen} faces, at most {most}");
    assert!(most > 500 && faces_seen > 30 * patches_seen, "patches of many faces were among them: {faces_seen}, {most}");
}

#[test]
fn the_seed_point_stays_on_the_patchs_centre() {
    let shape = &patches("bricks", PatchSource::Circle)[0];
    let mesh = asset("dragonling");
    let mut scratch = Scratch::new(&mesh);
    for guide in &guides(&mesh, 20.0) {
        for &seed in &Points::new(&mesh).list(40) {
            let laid = laid_with(&mesh, guide, shape, seed, Predictor::Field, FitChoice::default(), &mut scratch);
            let slot = laid.disc.faces.iter().position(|&f| f == seed.face).unwrap();
            let uv = laid.disc.face_uv(slot);
            let at = (0..3).map(|k| uv[k] * f64::from(seed.bary[k])).sum::<DVec2>();
            assert!(at.length() < 1e-9, "the seed lies {at} from the centre");
        }
    }
}

/// The functional's terms on one face, by the definition: |phi(S) - s|^2 + |phi(T) - t|^2, phi the affine map to `uv`.
fn image_of_frame(mesh: &Mesh, face: u32, frame: &Frame, uv: [DVec2; 3]) -> DMat2 {
    let [a, b, c] = mesh.corners(face);
    let (p, q) = (b - a, c - a);
    // v = x p + y q in the least-squares sense, which is exact for v in the plane.
    let gram = DMat2::from_cols(DVec2::new(p.dot(p), p.dot(q)), DVec2::new(p.dot(q), q.dot(q))).inverse();
    let phi = |v: DVec3| {
        let x = gram * DVec2::new(p.dot(v), q.dot(v));
        x.x * (uv[1] - uv[0]) + x.y * (uv[2] - uv[0])
    };
    DMat2::from_cols(phi(frame.right), phi(frame.up))
}

fn square(m: DMat2) -> f64 {
    m.x_axis.length_squared() + m.y_axis.length_squared()
}

fn weight(mesh: &Mesh, face: u32, weights: Weights) -> f64 {
    if weights == Weights::Area { mesh.area(face) } else { 1.0 }
}

fn energy_of(mesh: &Mesh, disc: &Disc, frames: &[Frame], weights: Weights, uv: &[DVec2]) -> f64 {
    let term = |i: usize| {
        let face = disc.faces[i];
        let image = image_of_frame(mesh, face, &frames[i], disc.corners[i].map(|v| uv[v as usize]));
        weight(mesh, face, weights) * square(image - DMat2::IDENTITY)
    };
    (0..disc.faces.len()).map(term).sum()
}

/// The functional with each face's target turned as suits it best.
fn turning_energy(mesh: &Mesh, disc: &Disc, frames: &[Frame], uv: &[DVec2]) -> f64 {
    let term = |i: usize| {
        let face = disc.faces[i];
        let m = image_of_frame(mesh, face, &frames[i], disc.corners[i].map(|v| uv[v as usize]));
        // min over R of |M - R|^2 = |M|^2 + 2 - 2 max tr(R^T M).
        let most = DVec2::new(m.x_axis.x + m.y_axis.y, m.x_axis.y - m.y_axis.x).length();
        mesh.area(face) * (square(m) + 2.0 - 2.0 * most)
    };
    (0..disc.faces.len()).map(term).sum()
}

/// The minimum of the functional by dense Cholesky, vertex 0 held at the origin.
fn direct(mesh: &Mesh, disc: &Disc, frames: &[Frame], weights: Weights) -> Vec<DVec2> {
    let n = disc.vertices.len();
    let (mut matrix, mut rhs) = (vec![vec![0.0; n]; n], vec![DVec2::ZERO; n]);
    for (i, corners) in disc.corners.iter().enumerate() {
        let w = weight(mesh, disc.faces[i], weights);
        // The image of (S, T) is linear in the corners' coordinates: its coefficients are the images of unit steps.
        let slope = [0, 1, 2].map(|k| {
            let mut uv = [DVec2::ZERO; 3];
            uv[k] = DVec2::X;
            let m = image_of_frame(mesh, disc.faces[i], &frames[i], uv);
            DVec2::new(m.x_axis.x, m.y_axis.x)
        });
        for a in 0..3 {
            rhs[corners[a] as usize] += w * slope[a];
            for b in 0..3 {
                matrix[corners[a] as usize][corners[b] as usize] += w * slope[a].dot(slope[b]);
            }
        }
    }
    // L L^T of the rows and columns 1.., then forward and backward substitution.
    for j in 1..n {
        for k in 1..j {
            let l = matrix[j][k];
            matrix[j][j] -= l * l;
        }
        let pivot = matrix[j][j].sqrt();
        assert!(pivot > 0.0, "the matrix is positive definite once a vertex is held");
        matrix[j][j] = pivot;
        for i in j + 1..n {
            let dot: f64 = (1..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            matrix[i][j] = (matrix[i][j] - dot) / pivot;
        }
    }
    let mut x = vec![DVec2::ZERO; n];
    for i in 1..n {
        let sum: DVec2 = (1..i).map(|k| x[k] * matrix[i][k]).sum();
        x[i] = (rhs[i] - sum) / matrix[i][i];
    }
    for i in (1..n).rev() {
        let sum: DVec2 = (i + 1..n).map(|k| x[k] * matrix[k][i]).sum();
        x[i] = (x[i] - sum) / matrix[i][i];
    }
    x
}

/// Patches of 50 to 600 vertices on demo meshes, with what they were fitted by.
fn fitted(weights: Weights, isotropic: IsotropicFit, mut take: impl FnMut(&Mesh, &Guide, &Laid, &str)) {
    let shape = &patches("bricks", PatchSource::Splotch)[0];
    let mut taken = 0;
    for name in ["dragonling", "gear", "vase", "terrain"] {
        let mesh = asset(name);
        let mut scratch = Scratch::new(&mesh);
        for ratio in [4.0, 12.0, 36.0] {
            for guide in &guides(&mesh, ratio) {
                for (i, &seed) in Points::new(&mesh).list(4).iter().enumerate() {
                    let choice = FitChoice { weights, isotropic, once: false };
                    let laid = laid_with(&mesh, guide, shape, seed, Predictor::Field, choice, &mut scratch);
                    let vertices = laid.disc.vertices.len();
                    if (50..=600).contains(&vertices) {
                        taken += 1;
                        take(&mesh, guide, &laid, &format!("{name} at ratio {ratio}, seed {i}, {vertices} vertices"));
                    }
                }
            }
        }
    }
    assert!(taken >= 30, "{taken} patches of 50 to 600 vertices");
}

#[test]
fn the_fit_has_the_energy_of_a_direct_solve() {
    for weights in [Weights::Area, Weights::Uniform] {
        let mut worst = 0.0_f64;
        fitted(weights, IsotropicFit::Propagated, |mesh, _, laid, what| {
            let Laid { disc, frames, .. } = laid;
            let ours = energy_of(mesh, disc, frames, weights, &disc.uv);
            let least = energy_of(mesh, disc, frames, weights, &direct(mesh, disc, frames, weights));
            // A perfect fit has no energy to be relative to: what no eye could tell from perfect is one, too.
            let whole: f64 = disc.faces.iter().map(|&f| 2.0 * weight(mesh, f, weights)).sum();
            worst = worst.max((ours - least) / (least + 1e-8 * whole));
            assert!(ours <= least * (1.0 + 1e-4) + 1e-10 * whole, "{what}, {weights:?}: energy {ours}, direct {least}");
            assert!(ours >= least * (1.0 - 1e-9), "{what}: less than the least: {ours} below {least}");
            let problem = FitProblem { mesh, disc, frames, weights, isotropic: None };
            let told = energy(&problem, &disc.uv);
            assert!((told - ours).abs() <= 1e-9 * whole, "{what}: the energy is told as {told}, by definition it is {ours}");
        });
        eprintln!("{weights:?}: at most {worst:.2e} above the direct solve's energy");
        assert!(worst > 0.0, "an iterative solver stops a little above");
    }
}

#[test]
fn every_step_away_from_the_fit_raises_the_energy() {
    let mut random = Random::new(5, 5);
    fitted(Weights::Area, IsotropicFit::Propagated, |mesh, _, laid, what| {
        let Laid { disc, frames, .. } = laid;
        let at = |uv: &[DVec2]| energy_of(mesh, disc, frames, Weights::Area, uv);
        let here = at(&disc.uv);
        for round in 0..6 {
            let mut any = || DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
            let (shear, single) = (DMat2::from_cols(any(), any()), any());
            let step = |i: usize, q: DVec2| match round {
                0 => shear * q,
                1 => q.perp(),
                2 => q,
                3 => single * (6.0 * q.dot(single)).sin(),
                _ if i % 7 == round => single,
                _ => DVec2::ZERO,
            };
            for size in [1e-3, -1e-3, 0.1] {
                let moved: Vec<DVec2> = disc.uv.iter().enumerate().map(|(i, &q)| q + size * step(i, q)).collect();
                assert!(at(&moved) > here, "{what}: a step of kind {round} and size {size} lowers {here} to {}", at(&moved));
            }
        }
    });
}

#[test]
fn rounds_of_rotation_lower_the_energy_that_ignores_turning() {
    let mut gained = 0.0_f64;
    fitted(Weights::Area, IsotropicFit::Propagated, |mesh, guide, laid, what| {
        if guide.field().is_some() {
            return;
        }
        let Laid { disc, frames, .. } = laid;
        let whole: f64 = disc.faces.iter().map(|&f| mesh.area(f)).sum();
        let mut last = turning_energy(mesh, disc, frames, &disc.uv);
        for rounds in [1, 2, 6] {
            let isotropic = Some(IsotropicFit::Rotations(rounds));
            let mut fitter = Fitter::new(&FitProblem { mesh, disc, frames, weights: Weights::Area, isotropic });
            let draft = Disc { uv: fitter.draft(disc), ..disc.clone() };
            let uv = fitter.finish(&draft);
            let now = turning_energy(mesh, disc, frames, &uv);
            assert!(now <= last * (1.0 + 1e-3) + 1e-9 * whole, "{what}: {rounds} rounds raise the energy from {last} to {now}");
            gained = gained.max(1.0 - now / last.max(1e-9 * whole));
            last = now;
        }
    });
    eprintln!("rotation rounds lower the energy by up to {:.0} %", 100.0 * gained);
    assert!(gained > 0.2, "somewhere the rounds gain more than a fifth: {gained}");
}
