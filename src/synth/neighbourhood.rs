//! The neighbourhoods of all vertices of a level: which vertices each template sample blends.
//!
//! Based on: Wei, Levoy 2001, sec. 3.3. They depend on the mesh and the directions only, so they are made once a level and
//! direction, and every pass of every exemplar gathers its samples from these tables.

use super::fan::{Fans, Frame};
use super::flatten::{Blend, Flattener, Placed};
use super::window::Window;
use crate::mesh::{Mesh, NONE, SurfacePoint};
use glam::{DVec3, Vec2};
use rayon::prelude::*;

/// Vertices that one task flattens.
const CHUNK: usize = 512;

/// Template samples of all vertices on one mesh.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    pub(super) per: usize,
    /// Of [`CHUNK`] vertices each, as the threads made them.
    blends: Vec<Vec<Blend>>,
}

/// What flattening met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Met {
    pub(super) flipped: u64,
    pub(super) uncovered: u64,
}

impl Samples {
    #[inline]
    pub(super) fn of(&self, vertex: u32) -> &[Blend] {
        &self.blends[vertex as usize / CHUNK][vertex as usize % CHUNK * self.per..][..self.per]
    }

    /// The numbers at a vertex's samples, one sample after another.
    #[inline]
    pub(super) fn gather(&self, vertex: u32, values: &Values, out: &mut Vec<f32>) {
        match values.components {
            1 => self.gather_fixed::<1>(vertex, values, out),
            3 => self.gather_fixed::<3>(vertex, values, out),
            4 => self.gather_fixed::<4>(vertex, values, out),
            7 => self.gather_fixed::<7>(vertex, values, out),
            n => {
                for blend in self.of(vertex) {
                    for k in 0..n {
                        out.push((0..3).map(|c| blend.shares[c] * values.data[blend.vertices[c] as usize * n + k]).sum());
                    }
                }
            }
        }
    }

    fn gather_fixed<const N: usize>(&self, vertex: u32, values: &Values, out: &mut Vec<f32>) {
        let all = values.data.as_chunks::<N>().0;
        for blend in self.of(vertex) {
            let [a, b, c] = blend.vertices.map(|v| &all[v as usize]);
            let [u, v, w] = blend.shares;
            out.extend_from_slice(&std::array::from_fn::<f32, N, _>(|k| u * a[k] + v * b[k] + w * c[k]));
        }
    }

    /// Flattens around `count` places and samples a square at each; `seeds` says where to start. The middle sample is left out
    /// on request.
    fn new<S>(fans: &Fans, count: usize, radius: i32, middle: bool, seeds: S) -> (Self, Met)
    where
        S: Fn(u32, &mut Vec<Placed>) + Sync,
    {
        let side = (2 * radius + 1) as usize;
        let (whole, per) = (side * side, side * side - usize::from(!middle));
        let nothing = Blend { vertices: [fans.len() as u32; 3], shares: [1.0, 0.0, 0.0] };
        let chunks = (0..count.div_ceil(CHUNK)).into_par_iter().map_init(
            || (Flattener::new(fans), Vec::new(), vec![None; whole]),
            |(flattener, begin, square), chunk| {
                (flattener.flipped, flattener.uncovered) = (0, 0);
                let mut blends = Vec::with_capacity(CHUNK * per);
                for v in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    begin.clear();
                    seeds(v as u32, begin);
                    flattener.square(begin, radius, square);
                    let kept = square.iter().enumerate().filter(|(i, _)| middle || *i != whole / 2);
                    blends.extend(kept.map(|(_, found)| found.unwrap_or(nothing)));
                }
                (blends, Met { flipped: flattener.flipped, uncovered: flattener.uncovered })
            },
        );
        let (blends, met): (Vec<Vec<Blend>>, Vec<Met>) = chunks.unzip();
        let sum = |a: Met, b: &Met| Met { flipped: a.flipped + b.flipped, uncovered: a.uncovered + b.uncovered };
        (Self { per, blends }, met.iter().fold(Met::default(), sum))
    }
}

/// Numbers at the vertices of a level, and after the last vertex those of a sample that nothing covers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Values {
    pub(super) components: usize,
    pub(super) data: Vec<f32>,
}

impl Values {
    pub(super) fn new(vertices: usize, default: &[f32]) -> Self {
        let components = default.len();
        Self { components, data: default.iter().copied().cycle().take((vertices + 1) * components).collect() }
    }

    #[inline]
    pub(super) fn of_mut(&mut self, vertex: u32) -> &mut [f32] {
        &mut self.data[vertex as usize * self.components..][..self.components]
    }

    #[inline]
    pub(super) fn of(&self, vertex: u32) -> &[f32] {
        &self.data[vertex as usize * self.components..][..self.components]
    }
}

/// A mesh with what is needed to flatten it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) frames: &'a [Frame],
    pub(super) fans: &'a Fans,
    pub(super) spacing: f64,
}

/// The neighbourhoods of one level, on its own mesh and on coarser ones.
#[derive(Debug, Clone)]
pub(super) struct Neighbourhoods {
    pub(super) own: Samples,
    pub(super) coarser: Vec<Samples>,
    pub(super) met: Met,
}

impl Neighbourhoods {
    /// Flattens around every vertex of `own`; `coarser` are the meshes of coarser levels, each with the vertices' parents on it.
    pub(super) fn new(own: Ground, coarser: &[(Ground, &[SurfacePoint])], window: Window, middle: bool) -> Self {
        let count = own.mesh.vertex_count();
        let start = |v: u32, out: &mut Vec<Placed>| out.push(Placed { vertex: v, at: Vec2::ZERO, turn: Vec2::X });
        let (samples, mut met) = Samples::new(own.fans, count, window.radius(), middle, start);
        let mut above = Vec::new();
        for ((ground, parents), radius) in coarser.iter().zip(window.coarser()) {
            let start = |v: u32, out: &mut Vec<Placed>| parent_seeds(&own, ground, parents, v, out);
            let (samples, found) = Samples::new(ground.fans, count, radius, true, start);
            met = Met { flipped: met.flipped + found.flipped, uncovered: met.uncovered + found.uncovered };
            above.push(samples);
        }
        Self { own: samples, coarser: above, met }
    }

    /// Numbers of a row with the vertex's own level and of one without.
    pub(super) fn lengths(&self, components: usize) -> [usize; 2] {
        let up: usize = self.coarser.iter().map(|s| s.per).sum();
        [(self.own.per + up) * components, up * components]
    }
}

/// The corners of a vertex's parent face, projected along the vertex's normal (sec. 3.3).
fn parent_seeds(own: &Ground, coarse: &Ground, parents: &[SurfacePoint], vertex: u32, out: &mut Vec<Placed>) {
    let (parent, frame) = (parents[vertex as usize], &own.frames[vertex as usize]);
    if parent.face == NONE {
        return;
    }
    let middle = coarse.mesh.position(parent);
    for w in coarse.mesh.faces[parent.face as usize] {
        let at = frame.project((coarse.mesh.point(w) - middle) / coarse.spacing);
        out.push(Placed { vertex: w, at, turn: frame.turn(&coarse.frames[w as usize]) });
    }
}

/// Where `point` of a coarser level lies in the frame of one of that face's corners, in that level's spacing.
pub(super) fn from_corner(coarse: &Ground, corner: u32, point: DVec3) -> Vec2 {
    coarse.frames[corner as usize].project((point - coarse.mesh.point(corner)) / coarse.spacing)
}

#[cfg(test)]
mod tests {
    use super::super::levels::Levels;
    use super::*;
    use glam::Vec3;

    /// A flat grid of vertices `step` apart, the first at (`start`, `start`), texture right along x.
    fn grid(side: u32, step: f32, start: f32) -> (Mesh, Vec<DVec3>) {
        let point = |i: u32| Vec3::new(start + (i % side) as f32 * step, start + (i / side) as f32 * step, 0.0);
        let corner = |i: u32, j: u32| j * side + i;
        let cells = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| (i, j)));
        let faces = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let mesh = Mesh::new((0..side * side).map(point).collect(), faces.collect()).expect("a grid");
        let right = vec![DVec3::X; mesh.vertex_count()];
        (mesh, right)
    }

    #[test]
    fn on_a_regular_grid_neighbourhoods_are_the_images_own() {
        let side = 16_u32;
        for step in [1.0, 0.037, 250.0] {
            let levels = Levels::new(vec![grid(side, step, 0.0)]);
            let around = levels.neighbourhoods(0, Window::new(7, 1), true);
            // A picture of its own number at each pixel; rows go down where y goes up.
            let mut values = Values::new((side * side) as usize, &[-1.0]);
            (0..side * side).for_each(|v| values.of_mut(v)[0] = v as f32);
            for v in 0..side * side {
                let (x, y) = ((v % side) as i32, (v / side) as i32);
                let mut row = Vec::new();
                around.own.gather(v, &values, &mut row);
                let inside = |x: i32, y: i32| (0..side as i32).contains(&x) && (0..side as i32).contains(&y);
                let samples = (-3..=3).flat_map(|dy| (-3..=3).map(move |dx| (x + dx, y - dy)));
                let expected: Vec<f32> =
                    samples.map(|(x, y)| if inside(x, y) { (y * side as i32 + x) as f32 } else { -1.0 }).collect();
                assert_eq!(row, expected, "vertex {v}, spacing {step}");
            }
        }
    }

    #[test]
    fn parents_windows_blend_the_coarse_grid_around_the_vertex() {
        let levels = Levels::new(vec![grid(16, 1.0, 0.0), grid(8, 2.0, 0.5)]);
        let around = levels.neighbourhoods(0, Window::new(5, 2), false);
        assert_eq!((around.own.per, around.coarser[0].per), (24, 9), "5x5 less the middle, and 3x3");
        // A ramp is kept by every interpolation.
        let mut values = Values::new(64, &[f32::NAN]);
        (0..64).for_each(|v| values.of_mut(v)[0] = (0.5 + 2.0 * (v % 8) as f32) + 10.0 * (0.5 + 2.0 * (v / 8) as f32));
        for v in (0..256_u32).filter(|v| (3..13).contains(&(v % 16)) && (3..13).contains(&(v / 16))) {
            let mut row = Vec::new();
            around.coarser[0].gather(v, &values, &mut row);
            for (k, is) in row.into_iter().enumerate() {
                let (dx, dy) = ((k % 3) as f32 - 1.0, 1.0 - (k / 3) as f32);
                let expected = ((v % 16) as f32 + 2.0 * dx) + 10.0 * ((v / 16) as f32 + 2.0 * dy);
                assert!((is - expected).abs() < 1e-3, "vertex {v}, sample {k}: {is} for {expected}");
            }
        }
    }

    #[test]
    fn on_a_sphere_everything_is_covered_and_lengths_are_true() {
        let sphere = crate::mesh::shapes::sphere(5);
        let right = vec![DVec3::new(0.3, 0.2, 0.9); sphere.vertex_count()];
        let levels = Levels::new(vec![(sphere, right)]);
        let around = levels.neighbourhoods(0, Window::new(7, 1), true);
        assert_eq!(around.met, Met::default(), "nothing flips and nothing stays uncovered");
        let (mesh, frames, d) = (&levels.finest().mesh, &levels.finest().frames, levels.finest().spacing);
        let mut farthest = 0.0_f64;
        for v in 0..mesh.vertex_count() as u32 {
            for (k, blend) in around.own.of(v).iter().enumerate() {
                let (x, y) = ((k % 7) as f64 - 3.0, 3.0 - (k / 7) as f64);
                let at: DVec3 = (0..3).map(|c| mesh.point(blend.vertices[c]) * f64::from(blend.shares[c])).sum();
                // The exact place on the unit sphere: along a great circle.
                let frame = &frames[v as usize];
                let way = (frame.right * x + frame.up * y) * d;
                let angle = way.length();
                let exact = frame.normal * angle.cos() + way.normalize_or_zero() * angle.sin();
                farthest = farthest.max(at.normalize().distance(exact) / d);
            }
        }
        assert!(farthest < 0.5, "a sample lies {farthest} spacings from where it should");
    }
}
