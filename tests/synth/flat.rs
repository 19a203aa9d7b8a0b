//! On a flat regular grid with a constant direction, synthesis is plain image synthesis: held against a twin that knows no mesh.

use glam::{DVec3, Vec3};
use lapped::exemplar::stack::Stack;
use lapped::exemplar::{Exemplar, Image, srgb};
use lapped::mesh::Mesh;
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::synth::{Levels, Place, SearchKind, Source, SynthOptions, Window, synthesize};

/// A flat grid of vertices `step` apart, texture right along x.
fn grid(side: usize, step: f32, start: f32) -> (Mesh, Vec<DVec3>) {
    let point = |i: usize| Vec3::new(start + (i % side) as f32 * step, start + (i / side) as f32 * step, 0.0);
    let mut faces = Vec::new();
    for j in 0..side as u32 - 1 {
        for i in 0..side as u32 - 1 {
            let a = j * side as u32 + i;
            faces.extend([[a, a + 1, a + side as u32 + 1], [a, a + side as u32 + 1, a + side as u32]]);
        }
    }
    let mesh = Mesh::new((0..side * side).map(point).collect(), faces).expect("a grid");
    let right = vec![DVec3::X; mesh.vertex_count()];
    (mesh, right)
}

fn noise(side: u32, seed: u64) -> Exemplar {
    let mut random = Random::new(seed, 0);
    let mut number = || srgb::decode(random.unit() as f32);
    Exemplar::new("noise", Image::from_fn(side, side, |_, _| Vec3::new(number(), number(), number())))
}

type Pixels = Vec<[f64; 3]>;

/// One level of the twin: a square image.
#[derive(Clone)]
struct Plane {
    side: i64,
    data: Pixels,
}

impl Plane {
    fn clamped(&self, x: i64, y: i64) -> [f64; 3] {
        self.data[(y.clamp(0, self.side - 1) * self.side + x.clamp(0, self.side - 1)) as usize]
    }

    /// Bilinear; the first pixel's middle is (0, 0).
    fn bilinear(&self, x: f64, y: f64) -> [f64; 3] {
        let ((x0, u), (y0, v)) = ((x.floor(), x - x.floor()), (y.floor(), y - y.floor()));
        let at = |dx, dy| self.clamped(x0 as i64 + dx, y0 as i64 + dy);
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        std::array::from_fn(|k| (a[k] * (1.0 - u) + b[k] * u) * (1.0 - v) + (c[k] * (1.0 - u) + d[k] * u) * v)
    }

    fn mean(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.data.iter().map(|p| p[k]).sum::<f64>() / self.data.len() as f64)
    }

    /// Half the size, kernel 1 3 3 1.
    fn coarser(&self) -> Self {
        let side = self.side / 2;
        let weights = [0.125, 0.375, 0.375, 0.125];
        let one = |i: i64| {
            let (x, y) = (2 * (i % side) - 1, 2 * (i / side) - 1);
            let mut sum = [0.0; 3];
            for (j, wy) in weights.iter().enumerate() {
                for (i, wx) in weights.iter().enumerate() {
                    let p = self.clamped(x + i as i64, y + j as i64);
                    (0..3).for_each(|k| sum[k] += wx * wy * p[k]);
                }
            }
            sum
        };
        Self { side, data: (0..side * side).map(one).collect() }
    }

    /// The result image between its pixels as a mesh interpolates it: two triangles a cell. Rows run upward here.
    fn triangles(&self, x: f64, y: f64, outside: [f64; 3]) -> [f64; 3] {
        let last = (self.side - 1) as f64;
        let snap = |t: f64| if (t - t.round()).abs() < 1e-6 { t.round() } else { t };
        let (x, y) = (snap(x), snap(y));
        if x < 0.0 || y < 0.0 || x > last || y > last {
            return outside;
        }
        let (x0, y0) = (x.floor().min(last - 1.0), y.floor().min(last - 1.0));
        let (u, v) = (x - x0, y - y0);
        let at = |dx: i64, dy: i64| self.data[((y0 as i64 + dy) * self.side + x0 as i64 + dx) as usize];
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        std::array::from_fn(|k| {
            if v <= u { a[k] * (1.0 - u) + b[k] * (u - v) + c[k] * v } else { a[k] * (1.0 - v) + c[k] * u + d[k] * (v - u) }
        })
    }
}

/// Wei's and Levoy's synthesis of a square image, rows upward, level by level, vertex by vertex in the order drawn.
fn twin(exemplar: &Plane, sides: &[usize], radii: &[i64], passes: usize, seed: u64) -> Vec<[i64; 2]> {
    let mut images = vec![exemplar.clone()];
    (1..sides.len()).for_each(|k| images.push(images[k - 1].coarser()));
    let mut above: Option<Plane> = None;
    let mut places = Vec::new();
    for (depth, level) in (0..sides.len()).rev().enumerate() {
        let (image, side, radius) = (&images[level], sides[level] as i64, radii[depth]);
        let margin = radius.min((image.side - 1) / 4);
        let inside = margin..image.side - margin;
        let candidates: Vec<[i64; 2]> = inside.clone().flat_map(|y| inside.clone().map(move |x| [x, y])).collect();
        let mut random = Random::new(seed, 0x5E7 + depth as u64);
        let count = (side * side) as usize;
        places = (0..count).map(|_| candidates[random.below(candidates.len() as u64) as usize]).collect::<Vec<_>>();
        let show = |[x, y]: [i64; 2]| image.clamped(x, y);
        let mut result = Plane { side, data: places.iter().map(|&p| show(p)).collect() };
        let up_radius = radius / 2;
        let up_of = |v: usize| -> Pixels {
            let Some(above) = &above else { return Vec::new() };
            let coarse = |t: i64| ((t as f64 - 0.5) / 2.0).clamp(0.0, above.side as f64 - 1.0);
            let (x, y) = (coarse(v as i64 % side), coarse(v as i64 / side));
            let outside = images[level + 1].mean();
            let window = (-up_radius..=up_radius).flat_map(|dy| (-up_radius..=up_radius).map(move |dx| (dx as f64, dy as f64)));
            window.map(|(dx, dy)| above.triangles(x + dx, y - dy, outside)).collect()
        };
        let up_there = |[x, y]: [i64; 2]| -> Pixels {
            let Some(coarse) = images.get(level + 1).filter(|_| depth > 0) else { return Vec::new() };
            let (x, y) = ((x as f64 + 0.5) / 2.0 - 0.5, (y as f64 + 0.5) / 2.0 - 0.5);
            let window = (-up_radius..=up_radius).flat_map(|dy| (-up_radius..=up_radius).map(move |dx| (dx as f64, dy as f64)));
            window.map(|(dx, dy)| coarse.bilinear(x + dx, y + dy)).collect()
        };
        let square = |at: &dyn Fn(i64, i64) -> [f64; 3]| -> Pixels {
            (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))).map(|(dx, dy)| at(dx, dy)).collect()
        };
        let rows: Vec<[Pixels; 2]> =
            candidates.iter().map(|&[x, y]| [square(&|dx, dy| image.clamped(x + dx, y + dy)), up_there([x, y])]).collect();
        let best = |own: Option<&Pixels>, up: &Pixels| -> [i64; 2] {
            let apart =
                |a: &Pixels, b: &Pixels| a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).powi(2))).sum::<f64>();
            let to = |row: &[Pixels; 2]| own.map_or(0.0, |own| apart(own, &row[0])) + apart(up, &row[1]);
            let mut found = (f64::INFINITY, 0);
            for (k, row) in rows.iter().enumerate() {
                let there = to(row);
                if there < found.0 {
                    found = (there, k);
                }
            }
            candidates[found.1]
        };
        let order = |random: &mut Random| {
            let mut order: Vec<usize> = (0..count).collect();
            (1..count).rev().for_each(|i| order.swap(i, random.below(i as u64 + 1) as usize));
            order
        };
        if depth > 0 {
            let _unused = order(&mut random);
            for v in 0..count {
                places[v] = best(None, &up_of(v));
            }
            result.data = places.iter().map(|&p| show(p)).collect();
        }
        for _ in 0..passes {
            for v in order(&mut random) {
                let (x, y) = (v as i64 % side, v as i64 / side);
                let mean = image.mean();
                let own = square(&|dx, dy| {
                    let (x, y) = (x + dx, y - dy);
                    if (0..side).contains(&x) && (0..side).contains(&y) { result.data[(y * side + x) as usize] } else { mean }
                });
                places[v] = best(Some(&own), &up_of(v));
                result.data[v] = show(places[v]);
            }
        }
        above = Some(result);
    }
    places
}

#[test]
fn the_whole_synthesiser_is_plain_image_synthesis() {
    let exemplar = noise(16, 3);
    let levels = Levels::new(vec![grid(20, 1.0, 0.0), grid(10, 2.0, 0.5)]);
    let source = Source::image(&Stack::new(&exemplar, None), 2);
    for (windows, radii, passes) in [([(3, 1), (5, 2)], [1, 2], 1), ([(1, 1), (3, 2)], [0, 1], 2)] {
        let options = SynthOptions {
            windows: windows.map(|(side, levels)| Window::new(side, levels)).into(),
            passes: vec![passes],
            search: SearchKind::Exhaustive,
            batches: usize::MAX,
            seed: 11,
            ..SynthOptions::paper()
        };
        let made = synthesize(&levels, &source, &options, &Silent, &mut |_| ()).expect("it can be done");
        let image = exemplar.channel(lapped::exemplar::Channel::BaseColor).expect("it has one").finest();
        let encoded = |i: i64| image.pixel(i % 16, i / 16).to_array().map(|c| f64::from(srgb::encode(c)));
        let plane = Plane { side: 16, data: (0..256).map(encoded).collect() };
        let expected = twin(&plane, &[20, 10], &radii, passes, 11);
        let found: Vec<[i64; 2]> = made
            .places
            .iter()
            .map(|p| match *p {
                Place::Pixel([x, y]) => [x as i64, y as i64],
                Place::Vertex(_) => [-1, -1],
            })
            .collect();
        let differ = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "of {} vertices, windows {windows:?}", found.len());
    }
}
