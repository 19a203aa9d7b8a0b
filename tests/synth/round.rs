//! Round neighbourhoods: circles and samples against closed forms, what is kept against what is made anew, and everything that is
//! wrong with meshes and exemplars.

use glam::{DVec3, Vec3};
use lapped::exemplar::stack::Stack;
use lapped::exemplar::{Channel, Exemplar, Image, Wrap};
use lapped::job::{
    Density, Direction, Marched, Refined, RoundJob, RoundJobError, Rounded, Steer, march, synthesize_marched,
    synthesize_plane_image,
};
use lapped::mesh::{CleanOptions, Cleaned, Mesh, clean};
use lapped::progress::{Progress, Silent};
use lapped::random::Random;
use lapped::synth::round::{CacheError, Grid, Marching, Metric, RoundError, RoundOptions, Template, synthesize_round};
use lapped::synth::{Frame, Place};
use std::f64::consts::TAU;

/// A flat grid of vertices a step apart, turned a little so that no line of it is the plane's own.
fn grid(side: usize, step: f64) -> Mesh {
    let (x, y) = (DVec3::new(0.8, 0.6, 0.0), DVec3::new(-0.36, 0.48, 0.8));
    let point = |i: usize| ((x * (i % side) as f64 + y * (i / side) as f64) * step).as_vec3();
    let mut faces = Vec::new();
    for j in 0..side as u32 - 1 {
        for i in 0..side as u32 - 1 {
            let a = j * side as u32 + i;
            faces.extend([[a, a + 1, a + side as u32 + 1], [a, a + side as u32 + 1, a + side as u32]]);
        }
    }
    Mesh::new((0..side * side).map(point).collect(), faces).expect("a grid")
}

/// The unit sphere: an octahedron cut in four again and again.
fn sphere(rounds: u32) -> Mesh {
    let mut positions = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut faces: Vec<[u32; 3]> = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..rounds {
        let mut middle = std::collections::BTreeMap::new();
        let mut of = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(((positions[a as usize] + positions[b as usize]) / 2.0).normalize());
                positions.len() as u32 - 1
            })
        };
        let cut = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (of(a, b, &mut positions), of(b, c, &mut positions), of(c, a, &mut positions));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(cut).collect();
    }
    Mesh::new(positions, faces).expect("a sphere")
}

fn cleaned(mesh: &Mesh) -> Cleaned {
    clean(&mesh.positions, &mesh.faces, &CleanOptions::default()).expect("a mesh")
}

fn shape(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Cleaned {
    let positions: Vec<Vec3> = positions.iter().map(|&p| p.into()).collect();
    clean(&positions, faces, &CleanOptions::default()).expect("a mesh")
}

/// Waves in colour and height that tile.
fn waves(side: u32) -> Exemplar {
    let wave = |x: u32, y: u32| {
        let at = |v: u32, n: f32| (v as f32 * n * std::f32::consts::TAU / side as f32).sin();
        0.5 + 0.2 * at(x, 2.0) * at(y, 2.0) + 0.2 * at(x + y, 1.0)
    };
    let mut out = Exemplar::new("waves", Image::from_fn(side, side, |x, y| Vec3::new(wave(x, y), 0.3, 1.0 - wave(x, y))));
    out.set(Channel::Height, Image::grey_from_fn(side, side, wave)).expect("it fits");
    out.wrap = Wrap::Repeat;
    out
}

fn noise(w: u32, h: u32) -> Exemplar {
    let mut random = Random::new(1, 1);
    Exemplar::new("noise", Image::from_fn(w, h, |_, _| Vec3::splat(random.unit() as f32)))
}

fn job(vertices: usize) -> RoundJob {
    RoundJob { density: Density::Vertices(vertices), ..RoundJob::default() }
}

fn run(mesh: &Cleaned, exemplar: &Exemplar, job: &RoundJob) -> Result<(Marched, Rounded), RoundJobError> {
    let (marched, _) = march(&mesh.mesh, exemplar, job, None, &Silent)?;
    let made = synthesize_marched(mesh, &marched, exemplar, job, &Silent)?;
    Ok((marched, made))
}

#[test]
fn on_a_plane_circles_and_samples_are_the_analytic_ones() {
    let (side, step) = (24, 0.37);
    let mesh = grid(side, step);
    let template = Template::new(3);
    // Circles through vertices, and between them.
    for pixel in [step, 0.83 * step] {
        let marching = Marching::new(&mesh, Grid { pixel, circles: 3, levels: 2 }, &Silent).expect("circles");
        let middle = (side / 2 * side + side / 2) as u32;
        for (circle, radius) in [1.0, 2.0, 3.0, 4.0, 6.0].into_iter().enumerate() {
            let length = marching.length(middle, circle).expect("a whole circle");
            assert!((length / (TAU * radius * pixel) - 1.0).abs() < 1e-6, "circle {radius}: {length}");
        }
        let normal = mesh.normal(0);
        for turn in 0..7 {
            let right = Frame::new(normal, DVec3::new(0.8, 0.6, 0.0)).right;
            let up = normal.cross(right);
            let (sine, cosine) = (f64::from(turn) * 0.9).sin_cos();
            let (right, up) = (right * cosine + up * sine, up * cosine - right * sine);
            for level in 0..2 {
                let places = marching.places(&mesh, &[(middle, right)], level, &template);
                for (sample, place) in template.samples().iter().zip(&places[0]) {
                    let [x, y] = sample.offset.as_dvec2().to_array();
                    let exact = mesh.point(middle) + (right * x + up * y) * pixel * f64::from(1 << level);
                    let off = mesh.position(place.expect("inside the plane")).distance(exact) / pixel;
                    assert!(off < 3e-3, "{sample:?} of level {level}, turned {turn}: off by {off} pixels");
                }
            }
        }
    }
}

#[test]
fn on_a_sphere_lengths_and_shares_are_the_closed_form() {
    let mut last = f64::INFINITY;
    for rounds in [4, 5, 6] {
        let mesh = sphere(rounds);
        let pixel = 0.05;
        let marching = Marching::new(&mesh, Grid { pixel, circles: 4, levels: 1 }, &Silent).expect("circles");
        assert_eq!(marching.statistics().incomplete, 0, "every circle of a sphere is whole");
        let template = Template::new(4);
        let (mut longest, mut farthest) = (0.0_f64, 0.0_f64);
        let frame = |v: u32| Frame::new(mesh.point(v).normalize(), DVec3::new(0.1, 0.9, 0.3));
        let of: Vec<(u32, DVec3)> = (0..mesh.vertex_count() as u32).step_by(7).map(|v| (v, frame(v).right)).collect();
        for (&(v, _), places) in of.iter().zip(marching.places(&mesh, &of, 0, &template)) {
            let frame = frame(v);
            for circle in 0..4 {
                let exact = TAU * (circle as f64 + 1.0) * pixel;
                longest = longest.max((marching.length(v, circle).expect("whole") / exact - 1.0).abs());
            }
            for (sample, place) in template.samples().iter().zip(places) {
                let way = (frame.right * f64::from(sample.offset.x) + frame.up * f64::from(sample.offset.y)) * pixel;
                let exact = way + frame.normal * (1.0 - way.length_squared()).sqrt();
                farthest = farthest.max(mesh.position(place.expect("covered")).distance(exact) / pixel);
            }
        }
        assert!(longest < 0.5 * last && farthest < 0.2, "{rounds} rounds: lengths off by {longest}, samples by {farthest} pixels");
        last = last.min(longest).max(1e-3);
    }
}

#[test]
fn samples_follow_the_surface_where_it_bends() {
    // A sheet folded by a right angle along y: circles are longer than in the plane, and samples are spread along them evenly.
    let (side, step) = (41, 0.25);
    let bent = |x: f64| if x < 0.0 { DVec3::new(x, 0.0, 0.0) } else { DVec3::new(0.0, 0.0, -x) };
    let half = (side as f64 - 1.0) / 2.0;
    let point = |i: usize| (bent(((i % side) as f64 - half) * step) + DVec3::Y * (i / side) as f64 * step).as_vec3();
    let mesh = Mesh::new((0..side * side).map(point).collect(), grid(side, 1.0).faces).expect("a sheet");
    let marching = Marching::new(&mesh, Grid { pixel: step, circles: 3, levels: 1 }, &Silent).expect("circles");
    let middle = (side / 2 * side + side / 2) as u32;
    for circle in 0..3 {
        let radius = (circle as f64 + 1.0) * step;
        // On each half a quarter turn about the edge seen slantwise: half an ellipse with axes r and r sqrt 2, twice.
        let (a, b) = (radius * 2.0_f64.sqrt(), radius);
        let h = ((a - b) / (a + b)).powi(2);
        let ellipse = std::f64::consts::PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
        let length = marching.length(middle, circle).expect("a whole circle");
        assert!((length / ellipse - 1.0).abs() < 0.03, "circle {circle}: {length} for {ellipse}");
    }
    let template = Template::new(3);
    let places = &marching.places(&mesh, &[(middle, DVec3::Y)], 0, &template)[0];
    // Along the fold as far as in the plane, across it farther, since the surface goes down there.
    for (sample, place) in template.samples().iter().zip(places) {
        let far = mesh.position(place.expect("covered")).distance(mesh.point(middle)) / step;
        let radius = f64::from(sample.offset.length());
        let wide = match (sample.share * 4.0).round() as i32 % 2 {
            _ if (sample.share * 4.0).fract() != 0.0 => continue,
            0 => radius,
            _ => radius * 2.0_f64.sqrt(),
        };
        assert!((far / wide - 1.0).abs() < 0.03, "{sample:?} lies {far} away, not {wide}");
    }
}

fn every_place_is_inside(made: &Rounded) {
    let finite = made.texture.all().iter().flat_map(|(_, v)| v).all(|x| (-1e-6..=1.0 + 1e-6).contains(x));
    assert!(finite, "values are those of the exemplar");
}

#[test]
fn a_new_direction_from_kept_circles_equals_a_fresh_run() {
    let mesh = cleaned(&sphere(4));
    let exemplar = waves(32);
    let first = RoundJob { direction: Direction::Steered(Steer::Up(DVec3::Y)), ..job(1500) };
    let (marched, one) = run(&mesh, &exemplar, &first).expect("it can be done");
    let bytes = marched.marching.to_bytes();
    let second = RoundJob { direction: Direction::Steered(Steer::Up(DVec3::X)), ..first };
    let (kept, told) = march(&mesh.mesh, &exemplar, &second, Some(&bytes), &Silent).expect("it can be done");
    assert!(!kept.fresh && told.is_none(), "kept circles serve another direction");
    assert_eq!(kept.marching, marched.marching, "they come back as they were");
    let turned = synthesize_marched(&mesh, &kept, &exemplar, &second, &Silent).expect("it can be done");
    let (_, fresh) = run(&mesh, &exemplar, &second).expect("it can be done");
    assert_eq!(turned.texture.all(), fresh.texture.all(), "the same as if they were marched again");
    assert_ne!(turned.texture.all(), one.texture.all(), "another direction is another texture");
}

#[test]
fn files_of_circles_that_do_not_fit_are_told() {
    let mesh = sphere(2);
    let marching = Marching::new(&mesh, Grid { pixel: 0.2, circles: 2, levels: 1 }, &Silent).expect("circles");
    let bytes = marching.to_bytes();
    assert_eq!(Marching::from_bytes(&bytes, &mesh), Ok(marching), "whole");
    for cut in [0, 1, 7, 8, 11, 12, 40, bytes.len() / 2, bytes.len() - 1] {
        assert!(Marching::from_bytes(&bytes[..cut], &mesh).is_err(), "cut short at {cut}");
    }
    for at in (0..bytes.len()).step_by(13) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x40;
        assert!(Marching::from_bytes(&changed, &mesh).is_err(), "changed at {at}");
    }
    assert_eq!(Marching::from_bytes(b"solid of something else", &mesh), Err(CacheError::Other), "another file");
    assert_eq!(Marching::from_bytes(&bytes, &sphere(1)), Err(CacheError::Mesh), "another mesh");
    let mut moved = mesh.clone();
    moved.positions[3].x += 1e-6;
    assert_eq!(Marching::from_bytes(&bytes, &moved), Err(CacheError::Mesh), "a vertex moved");
    let exemplar = waves(32);
    let wanted = job(mesh.vertex_count());
    let (again, told) = march(&mesh, &exemplar, &wanted, Some(&bytes), &Silent).expect("it can be done");
    assert!(again.fresh && told == Some(CacheError::Circles), "other circles are marched now: {told:?}");
}

#[test]
fn the_same_for_any_number_of_threads_and_every_run() {
    let mesh = cleaned(&sphere(4));
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&mesh, &waves(32), &job(1500)).expect("it can be done"))
    };
    let (one, three) = (made(1), made(3));
    assert_eq!(one.0.marching.to_bytes(), three.0.marching.to_bytes(), "circles");
    assert_eq!(one.1.texture.all(), three.1.texture.all(), "texture");
    assert_eq!(made(3).1.texture.all(), three.1.texture.all(), "again");
}

#[test]
fn every_part_has_its_start_and_every_vertex_its_place() {
    let one = sphere(3);
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for k in 0..3 {
        let first = positions.len() as u32;
        positions.extend(one.positions.iter().map(|p| *p + Vec3::X * (3 * k) as f32));
        faces.extend(one.faces.iter().map(|f| f.map(|v| v + first)));
    }
    let mesh = clean(&positions, &faces, &CleanOptions::default()).expect("three spheres");
    let (_, made) = run(&mesh, &noise(32, 32), &job(positions.len())).expect("it can be done");
    let coarsest = made.report.levels[0];
    assert_eq!(coarsest.starts, 3, "each sphere begins once");
    assert!((3..=6).contains(&coarsest.drawn), "places are drawn where nothing is known: {}", coarsest.drawn);
    every_place_is_inside(&made);
}

#[test]
fn neighbours_continue_each_other_and_parts_of_the_metric_can_be_left_out() {
    let mesh = grid(40, 1.0);
    let right = vec![DVec3::new(0.8, 0.6, 0.0); mesh.vertex_count()];
    let normal = mesh.normal(0);
    let frames: Vec<Frame> = right.iter().map(|&r| Frame::new(normal, r)).collect();
    let stacks = Stack::new(&noise(32, 32), None).pyramid(1);
    let marching = Marching::new(&mesh, Grid { pixel: 1.0, circles: 3, levels: 1 }, &Silent).expect("circles");
    let all = Metric::default();
    let without = [
        all,
        Metric { sums: false, ..all },
        Metric { deviation: false, ..all },
        Metric { region: false, ..all },
        Metric { outliers: false, ..all },
        Metric { candidates: false, ..all },
        Metric::plain(),
    ];
    let made = without.map(|metric| {
        let options = RoundOptions { metric, ..RoundOptions::default() };
        synthesize_round(&mesh, &frames, &marching, &stacks, &options, &Silent).expect("it can be done")
    });
    for (made, metric) in made.iter().zip(without) {
        let at = |v: usize| match made.places[v] {
            Place::Pixel(at) => at,
            Place::Vertex(_) => panic!("an image has pixels"),
        };
        let pairs = (0..39 * 40).filter(|v| v % 40 < 39);
        let goes_on = |v: &usize| {
            let ([x, y], [u, w]) = (at(*v), at(v + 1));
            (u - x - 1.0).abs() < 0.1 && (w - y).abs() < 0.1
        };
        let share = pairs.clone().filter(goes_on).count() as f64 / pairs.count() as f64;
        // Nothing in noise looks like anything else in it, so that what continues is best.
        let least = if metric.candidates { 0.6 } else { 0.3 };
        assert!(share > least, "{metric:?}: {share} of the neighbours continue each other");
    }
}

#[test]
fn coarse_meshes_are_refined_and_needles_retiled() {
    let exemplar = waves(32);
    let tetrahedron = shape(
        &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
        &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    );
    let (marched, made) = run(&tetrahedron, &exemplar, &job(2000)).expect("it can be done");
    assert_eq!(marched.refined, Refined::Cut, "its own vertices stay");
    assert_eq!(&marched.mesh.positions[..4], &tetrahedron.mesh.positions[..], "and are the first");
    let longest = |mesh: &Mesh| {
        let edges = mesh.faces.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]);
        edges.map(|[a, b]| mesh.point(a).distance(mesh.point(b))).fold(0.0, f64::max)
    };
    assert!(longest(&marched.mesh) <= 2.0 * made.report.pixel, "no edge is longer than two pixels");
    let needle = shape(&[[0.0; 3], [100.0, 0.0, 0.0], [100.0, 0.3, 0.0], [0.0, 0.3, 0.0]], &[[0, 1, 2], [0, 2, 3]]);
    let (marched, _) = run(&needle, &exemplar, &job(3000)).expect("it can be done");
    assert_eq!(marched.refined, Refined::Retiled, "needles would become far too many");
    let fine = cleaned(&sphere(4));
    let (marched, _) = run(&fine, &exemplar, &job(1026)).expect("it can be done");
    assert_eq!(marched.refined, Refined::No, "a mesh of even faces is taken as it is");
    assert_eq!(marched.mesh, fine.mesh, "with its own vertices");
}

#[test]
fn exemplars_smaller_than_a_neighbourhood_and_of_one_colour() {
    let mesh = cleaned(&sphere(3));
    for (w, h) in [(1, 1), (2, 1), (3, 3), (1, 40), (6, 5), (17, 9)] {
        for wrap in [Wrap::Clamp, Wrap::Repeat] {
            let mut exemplar = noise(w, h);
            exemplar.wrap = wrap;
            let (_, made) = run(&mesh, &exemplar, &job(300)).unwrap_or_else(|e| panic!("{w}x{h} {wrap:?}: {e}"));
            every_place_is_inside(&made);
            let plane = synthesize_plane_image([20, 9], &exemplar, &RoundJob::default(), &Silent);
            assert_eq!(plane.unwrap_or_else(|e| panic!("{w}x{h} {wrap:?}: {e}")).0.size(), [20, 9], "an image of that size");
        }
    }
    let color = Vec3::new(0.2, 0.5, 0.1);
    let plain = Exemplar::new("plain", Image::from_fn(32, 32, |_, _| color));
    let (_, made) = run(&mesh, &plain, &job(300)).expect("a result");
    let off = made.texture.all()[0].1.chunks(3).map(|c| Vec3::from_slice(c).distance(color)).fold(0.0, f32::max);
    assert!(off < 1e-5, "one colour stays that colour, but for {off}");
}

#[test]
fn boundaries_and_spikes_degrade_where_they_are_and_are_counted() {
    let exemplar = noise(32, 32);
    // A square: circles near its edges are open.
    let side = 30;
    let square = cleaned(&grid(side, 1.0));
    let (marched, made) = run(&square, &exemplar, &job(side * side)).expect("it can be done");
    let s = marched.marching.statistics();
    assert!(s.open > 0 && s.missing == 0, "{s:?}");
    let inner = (side - 14).pow(2) as u64;
    let rest = (side * side) as u64 - s.incomplete;
    assert!(rest >= inner && rest <= (side as u64 - 10).pow(2), "{rest} vertices are farther than six pixels from the edge");
    every_place_is_inside(&made);
    // A spike out of a sheet: the circles about its tip are given up, those of the sheet are not.
    let mut spiky = grid(side, 1.0);
    let tip = side / 2 * side + side / 2;
    let normal = spiky.normal(0).as_vec3();
    spiky.positions[tip] += normal * 40.0;
    let job = RoundJob { direction: Direction::Steered(Steer::Up(DVec3::Z)), ..job(side * side) };
    let marching = Marching::new(&spiky, Grid { pixel: 1.0, circles: 3, levels: 1 }, &Silent).expect("circles");
    let s = marching.statistics();
    assert!(s.missing > 0 && s.missing < 150, "only around the tip: {s:?}");
    let (_, made) = run(&cleaned(&spiky), &exemplar, &job).expect("it can be done");
    every_place_is_inside(&made);
    // A few faces, parts, and a lone triangle.
    let triangle = shape(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    for vertices in [4, 50, 700] {
        let (_, made) = run(&triangle, &exemplar, &self::job(vertices)).unwrap_or_else(|e| panic!("{vertices}: {e}"));
        every_place_is_inside(&made);
    }
}

#[test]
fn sizes_do_not_matter() {
    let exemplar = waves(32);
    let unit = sphere(4);
    let (_, usual) = run(&cleaned(&unit), &exemplar, &job(1000)).expect("it can be done");
    for scale in [1e-6_f32, 1e6] {
        let mut scaled = unit.clone();
        // Powers of two change no digit.
        let scale = 2.0_f32.powf(scale.log2().round());
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        let (_, made) = run(&cleaned(&scaled), &exemplar, &job(1000)).expect("it can be done");
        assert_eq!(made.texture.all(), usual.texture.all(), "scaled by {scale}");
    }
}

#[test]
fn a_plane_shows_the_exemplar_again_and_keeps_channels_together() {
    let exemplar = waves(32);
    let (image, report) = synthesize_plane_image([70, 50], &exemplar, &RoundJob::default(), &Silent).expect("it can be done");
    assert_eq!((image.size(), report.levels.len()), ([70, 50], 2), "its size and levels");
    let (color, height) = (image.channel(Channel::BaseColor).expect("colour"), image.channel(Channel::Height).expect("height"));
    let mut off = 0.0_f32;
    for y in 0..50 {
        for x in 0..70 {
            off = off.max((color.finest().pixel(x, y).x - height.finest().grey(x, y)).abs());
        }
    }
    // Red is the height in the exemplar; both are sampled at the same places.
    assert!(off < 1e-5, "red and height differ by {off}");
    let again = synthesize_plane_image([70, 50], &exemplar, &RoundJob::default(), &Silent).expect("it can be done");
    assert_eq!(again.0.channel(Channel::BaseColor), image.channel(Channel::BaseColor), "the same every time");
}

/// Cancels after a while.
struct Impatient(std::sync::atomic::AtomicU64, u64);

impl Progress for Impatient {
    fn stage(&self, _: &str, _: u64) {}
    fn done(&self, _: u64) {}
    fn cancelled(&self) -> bool {
        self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= self.1
    }
}

#[test]
fn wrong_requests_are_told_and_work_can_be_stopped() {
    let mesh = cleaned(&sphere(3));
    let exemplar = waves(32);
    for after in [0, 1, 2, 5, 9] {
        let impatient = Impatient(0.into(), after);
        let done = march(&mesh.mesh, &exemplar, &job(300), None, &impatient)
            .and_then(|(m, _)| synthesize_marched(&mesh, &m, &exemplar, &job(300), &impatient));
        assert!(done.is_err_and(|e| e.to_string() == "stopped"), "stopped after {after} questions");
    }
    let bad = |grid: Grid| Marching::new(&mesh.mesh, grid, &Silent).expect_err("no circles").to_string();
    for grid in [
        Grid { pixel: 0.0, circles: 3, levels: 1 },
        Grid { pixel: f64::NAN, circles: 3, levels: 1 },
        Grid { pixel: 0.1, circles: 0, levels: 1 },
        Grid { pixel: 0.1, circles: 3, levels: 99 },
    ] {
        assert!(bad(grid).contains("cannot be marched"), "{grid:?}");
    }
    let fine = bad(Grid { pixel: 1e7, circles: 3, levels: 1 });
    assert!(fine.contains("ask for more vertices"), "{fine}");
    let marching = Marching::new(&mesh.mesh, Grid { pixel: 0.1, circles: 3, levels: 1 }, &Silent).expect("circles");
    let frames = vec![Frame::new(DVec3::Z, DVec3::X); mesh.mesh.vertex_count()];
    let stacks = Stack::new(&exemplar, None).pyramid(2);
    let done = synthesize_round(&mesh.mesh, &frames, &marching, &stacks, &RoundOptions::default(), &Silent);
    assert_eq!(done, Err(RoundError::Mismatch), "circles of one level do not do for two");
    let scale = RoundJob { density: Density::Scale(-1.0), ..RoundJob::default() };
    assert!(run(&mesh, &exemplar, &scale).is_err_and(|e| e.to_string().contains("a scale of -1")), "a scale that is none");
}
