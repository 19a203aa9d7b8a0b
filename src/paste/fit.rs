//! Fitting a surface patch to the tangent field (LT 3.4).
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 3.4; for isotropic textures also Levy et al., "Least Squares
//! Conformal Maps", 2002 (the functional the authors of Lapped Textures later recommended) and Liu et al., "A
//! Local/Global Approach to Mesh Parameterization", 2008 (the rotation refit).
//!
//! The map phi sends each face's S and T to phi(S) and phi(T). We minimise the sum over faces of
//! `w (|phi(S) - s|^2 + |phi(T) - t|^2)`, where s and t are the texture's axes. With phi linear on a face,
//! `phi(S) = sum_i phi_i (grad_i . S)`, so the matrix holds inner products of the hat functions' gradients along S and T;
//! u and v share it and are solved in one pass.
//!
//! 1. Assemble the matrix; it is singular by a translation only.
//! 2. Conjugate gradients from the grown coordinates, preconditioned by [`Multigrid`]: a draft while the patch may still
//!    grow, the whole way when it does not.
//! 3. Isotropic textures: the propagated directions are only a start. Either turn each face's target to the rotation
//!    nearest to what it got and solve again on the same matrix (default), or minimise `|phi(S) + rot90 phi(T)|^2`.
//! 4. Translate so that the seed point lies on the centre again: the pin, without touching the matrix.
//!
//! Where we differ: `w` is the face's area, so that the answer does not depend on how the surface is cut into
//! triangles ([`Weights::Uniform`] is the paper's 1).

use super::frame::{Frame, singular_values};
use crate::mesh::Mesh;
use crate::mesh::disc::Disc;
use crate::numeric::{CgOptions, Multigrid, Pair, Preconditioner, Sparse, Stop, solve};
use glam::{DMat2, DVec2, DVec3};

/// Conjugate gradients stop when no more than this share of the functional's value is left to gain, for a fit that is
/// recorded: a hundredth of what anyone could measure, and far below a pixel.
const LEFT: f64 = 1e-6;

/// The same for a fit after which the patch may still grow: no coordinate is off by more than a pixel or so.
const LEFT_OF_DRAFT: f64 = 1e-3;

/// Where the fit is (nearly) exact, a share of it says nothing: this little, against the functional of a map that shrinks
/// everything to a point, moves no coordinate by a hundredth of a pixel.
const NOTHING: f64 = 1e-10;

/// Residual, relative to the right-hand side, at which the conformal functional is good enough.
const CONFORMAL_TOLERANCE: f64 = 1e-6;

/// Iterations at most; multigrid needs about 15, needle meshes up to a hundred.
const MAX_ITERATIONS: usize = 500;

/// The conformal functional is much worse conditioned, and its answer is scaled and turned afterwards.
const CONFORMAL_ITERATIONS: usize = 2000;

/// Weight of a face in the functional.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// Its area.
    #[default]
    Area,
    /// 1 (the paper's).
    Uniform,
}

/// How isotropic patches are fitted beyond the propagated directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IsotropicFit {
    /// To the propagated directions alone (the paper's).
    Propagated,
    /// Rounds of turning each face's target to the nearest rotation and solving again.
    Rotations(u32),
    /// The linear conformal functional, then the mean scale and direction restored.
    Conformal,
}

impl Default for IsotropicFit {
    fn default() -> Self {
        // Two rounds gain most of what many do (measured in docs/performance.md).
        Self::Rotations(2)
    }
}

/// A fit to do.
#[derive(Debug, Clone, Copy)]
pub struct FitProblem<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// The patch; its coordinates are the start.
    pub disc: &'a Disc,
    /// Frames of its faces.
    pub frames: &'a [Frame],
    /// Weights of its faces.
    pub weights: Weights,
    /// `Some` for isotropic textures.
    pub isotropic: Option<IsotropicFit>,
}

/// Gradients of the hat functions of a face, and its weight in the functional.
fn gradients(problem: &FitProblem, index: usize) -> ([DVec3; 3], f64) {
    let p = problem.mesh.corners(problem.disc.faces[index]);
    let area_vector = (p[1] - p[0]).cross(p[2] - p[0]);
    let length = area_vector.length();
    let scaled = area_vector / (length * length);
    let gradient = [0, 1, 2].map(|k| scaled.cross(p[(k + 2) % 3] - p[(k + 1) % 3]));
    let weight = match problem.weights {
        Weights::Area => 0.5 * length,
        Weights::Uniform => 1.0,
    };
    (gradient, weight)
}

/// Per face, the hat functions' slopes along S and T, and the weight.
#[derive(Debug)]
struct Element {
    along_s: [f64; 3],
    along_t: [f64; 3],
    weight: f64,
}

fn elements(problem: &FitProblem) -> Vec<Element> {
    (0..problem.disc.faces.len())
        .map(|i| {
            let (gradient, weight) = gradients(problem, i);
            let Frame { right, up, .. } = problem.frames[i];
            Element { along_s: gradient.map(|g| g.dot(right)), along_t: gradient.map(|g| g.dot(up)), weight }
        })
        .collect()
}

fn assemble(problem: &FitProblem, elements: &[Element]) -> Sparse {
    Sparse::assemble(problem.disc.vertices.len(), &problem.disc.corners, |i| {
        let Element { along_s: s, along_t: t, weight } = &elements[i];
        [0, 1, 2].map(|a| [0, 1, 2].map(|b| weight * (s[a] * s[b] + t[a] * t[b])))
    })
}

/// The right-hand side for targets phi(S), phi(T) = columns of `target(image)`, and the functional's value at `uv`. The
/// targets may depend on the face's image at `uv`.
fn right_hand_side(corners: &[[u32; 3]], elements: &[Element], uv: &[DVec2], target: impl Fn(DMat2) -> DMat2) -> (Vec<Pair>, f64) {
    let mut rhs = vec![[0.0; 2]; uv.len()];
    let mut value = 0.0;
    for (e, corners) in elements.iter().zip(corners) {
        let image = image(e, corners.map(|v| uv[v as usize]));
        let target = target(image);
        let off = image - target;
        value += e.weight * (off.x_axis.length_squared() + off.y_axis.length_squared());
        for k in 0..3 {
            let v = e.weight * (e.along_s[k] * target.x_axis + e.along_t[k] * target.y_axis);
            let sum = &mut rhs[corners[k] as usize];
            sum[0] += v.x;
            sum[1] += v.y;
        }
    }
    (rhs, value)
}

/// Image of (S, T) on a face.
fn image(element: &Element, uv: [DVec2; 3]) -> DMat2 {
    let along = |slopes: &[f64; 3]| uv[0] * slopes[0] + uv[1] * slopes[1] + uv[2] * slopes[2];
    DMat2::from_cols(along(&element.along_s), along(&element.along_t))
}

/// The rotation nearest to a matrix.
fn nearest_rotation(m: DMat2) -> DMat2 {
    DMat2::from_angle((m.x_axis.y - m.y_axis.x).atan2(m.x_axis.x + m.y_axis.y))
}

/// The matrix of one patch, assembled and preconditioned once, to be solved several times.
#[derive(Debug)]
pub struct Fitter {
    elements: Vec<Element>,
    matrix: Sparse,
    multigrid: Multigrid,
    isotropic: Option<IsotropicFit>,
    iterations: usize,
}

impl Fitter {
    /// Assembles the matrix.
    #[must_use]
    pub fn new(problem: &FitProblem) -> Self {
        let elements = elements(problem);
        let matrix = assemble(problem, &elements);
        let multigrid = Multigrid::new(&matrix);
        Self { elements, matrix, multigrid, isotropic: problem.isotropic, iterations: 0 }
    }

    /// Conjugate gradient iterations so far.
    #[must_use]
    pub const fn iterations(&self) -> usize {
        self.iterations
    }

    /// Coordinates near the minimum, good enough to see whether the patch has to grow; up to a translation. For isotropic
    /// textures this is where the targets are turned.
    #[must_use]
    pub fn draft(&mut self, disc: &Disc) -> Vec<DVec2> {
        let mut uv = disc.uv.clone();
        match self.isotropic {
            Some(IsotropicFit::Conformal) => self.conformal(&disc.corners, &mut uv),
            Some(IsotropicFit::Rotations(rounds)) => {
                self.solve(&disc.corners, &mut uv, false, LEFT_OF_DRAFT);
                for _ in 1..rounds {
                    self.solve(&disc.corners, &mut uv, true, LEFT_OF_DRAFT);
                }
            }
            Some(IsotropicFit::Propagated) | None => self.solve(&disc.corners, &mut uv, false, LEFT_OF_DRAFT),
        }
        uv
    }

    /// The minimum from the coordinates of a draft, up to a translation.
    #[must_use]
    pub fn finish(&mut self, disc: &Disc) -> Vec<DVec2> {
        let mut uv = disc.uv.clone();
        match self.isotropic {
            Some(IsotropicFit::Conformal) => {}
            Some(IsotropicFit::Rotations(1..)) => self.solve(&disc.corners, &mut uv, true, LEFT),
            _ => self.solve(&disc.corners, &mut uv, false, LEFT),
        }
        uv
    }

    /// Minimises the functional with the texture's axes as targets, or with each face's turned to what it has, until this
    /// share of it is left to gain.
    fn solve(&mut self, corners: &[[u32; 3]], uv: &mut [DVec2], turned: bool, share: f64) {
        let Self { elements, matrix, multigrid, .. } = self;
        let (rhs, start) =
            right_hand_side(corners, elements, uv, |image| if turned { nearest_rotation(image) } else { DMat2::IDENTITY });
        let floor = NOTHING * elements.iter().map(|e| 2.0 * e.weight).sum::<f64>();
        let mut x: Vec<Pair> = uv.iter().map(DVec2::to_array).collect();
        let stop = Stop::Gain { start, share, floor };
        let options = CgOptions { stop, max_iterations: MAX_ITERATIONS, coupled: false };
        self.iterations += solve(|x, y| matrix.times(x, y), &rhs, &mut x, multigrid, options).iterations;
        uv.iter_mut().zip(&x).for_each(|(q, x)| *q = DVec2::from(*x));
    }
}

impl Fitter {
    /// Minimises `sum w |phi(S) + rot90 phi(T)|^2`, which is the Dirichlet energy less twice the signed area it maps to.
    /// Two vertices are held, or the map would shrink to a point; their distance and direction mean nothing, so scale and
    /// rotation are restored from all faces together.
    fn conformal(&mut self, corners: &[[u32; 3]], uv: &mut [DVec2]) {
        let Self { elements, matrix, multigrid, .. } = self;
        let n = uv.len();
        // The area term couples u with v: w (grad_a x grad_b) in the basis (S, T), antisymmetric.
        let signed_area = Sparse::assemble(n, corners, |i| {
            let Element { along_s: s, along_t: t, weight } = &elements[i];
            [0, 1, 2].map(|a| [0, 1, 2].map(|b| weight * (s[a] * t[b] - t[a] * s[b])))
        });
        // Hold the seed vertex and the one furthest from it.
        let start = uv[0];
        let far = (0..n).max_by(|&a, &b| uv[a].distance_squared(start).total_cmp(&uv[b].distance_squared(start))).unwrap_or(0);
        let held = [0, far];
        let product = |x: &[Pair], y: &mut [Pair]| {
            for i in 0..n {
                let (d, a) = (matrix.row_times(i, x), signed_area.row_times(i, x));
                y[i] = [d[0] - a[1], d[1] + a[0]];
            }
        };
        let fixed: Vec<Pair> = (0..n).map(|i| if held.contains(&i) { uv[i].to_array() } else { [0.0; 2] }).collect();
        let mut rhs = vec![[0.0; 2]; n];
        product(&fixed, &mut rhs);
        rhs.iter_mut().for_each(|r| *r = [-r[0], -r[1]]);
        held.iter().for_each(|&h| rhs[h] = [0.0; 2]);
        let free_product = |x: &[Pair], y: &mut [Pair]| {
            product(x, y);
            held.iter().for_each(|&h| y[h] = [0.0; 2]);
        };
        let mut x: Vec<Pair> = (0..n).map(|i| if held.contains(&i) { [0.0; 2] } else { uv[i].to_array() }).collect();
        let options = CgOptions { stop: Stop::Residual(CONFORMAL_TOLERANCE), max_iterations: CONFORMAL_ITERATIONS, coupled: true };
        let stats = solve(free_product, &rhs, &mut x, &mut Holding { inner: multigrid, held }, options);
        self.iterations += stats.iterations;
        uv.iter_mut().zip(x.iter().zip(&fixed)).for_each(|(q, (x, f))| *q = DVec2::new(x[0] + f[0], x[1] + f[1]));

        // The similarity that brings the images of (S, T) nearest to the propagated targets, weighted as in the functional.
        let (mut turn, mut size) = (DVec2::ZERO, 0.0);
        for (i, e) in self.elements.iter().enumerate() {
            let m = image(e, corners[i].map(|v| uv[v as usize]));
            turn += e.weight * DVec2::new(m.x_axis.x + m.y_axis.y, m.y_axis.x - m.x_axis.y);
            size += e.weight * (m.x_axis.length_squared() + m.y_axis.length_squared());
        }
        let total: f64 = self.elements.iter().map(|e| 2.0 * e.weight).sum();
        let rotation = turn.normalize_or(DVec2::X);
        let scale = if size > 0.0 { (total / size).sqrt() } else { 1.0 };
        uv.iter_mut().for_each(|q| *q = scale * rotation.rotate(*q));
    }
}

/// Keeps held unknowns at zero.
struct Holding<'a> {
    inner: &'a mut Multigrid,
    held: [usize; 2],
}

impl Preconditioner for Holding<'_> {
    fn apply(&mut self, residual: &[Pair], out: &mut [Pair]) {
        self.inner.apply(residual, out);
        self.held.iter().for_each(|&h| out[h] = [0.0; 2]);
    }
}

/// The functional's value at the disc's coordinates; for tests and statistics.
#[must_use]
pub fn energy(problem: &FitProblem, uv: &[DVec2]) -> f64 {
    let all = elements(problem);
    all.iter()
        .zip(&problem.disc.corners)
        .map(|(e, c)| {
            let off = image(e, c.map(|v| uv[v as usize])) - DMat2::IDENTITY;
            e.weight * (off.x_axis.length_squared() + off.y_axis.length_squared())
        })
        .sum()
}

/// How a fitted face deviates from what the field asks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Area of the face, world units squared.
    pub area: f64,
    /// The larger of the map's largest stretch and the inverse of its smallest, at least 1; infinite if mirrored.
    pub stretch: f64,
    /// Angle between phi(T) and the texture's up, radians.
    pub angle: f64,
}

/// Deviations of all faces of a patch.
pub fn deviations<'a>(mesh: &'a Mesh, disc: &'a Disc, frames: &'a [Frame]) -> impl Iterator<Item = Deviation> + 'a {
    (0..disc.faces.len()).map(move |i| {
        let area = mesh.area(disc.faces[i]);
        let m = frames[i].image(&mesh.corners(disc.faces[i]), &disc.face_uv(i)).unwrap_or(DMat2::ZERO);
        let (large, small) = singular_values(m);
        let stretch = if small > 0.0 { large.max(1.0 / small) } else { f64::INFINITY };
        Deviation { area, stretch, angle: m.y_axis.x.abs().atan2(m.y_axis.y) }
    })
}
