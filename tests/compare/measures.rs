//! The measures of fidelity: nothing is told apart from itself, and planted faults are told, the worse the more.

use glam::{DVec3, Vec3};
use lapped::compare::fidelity;
use lapped::compare::measures::{
    Border, Pieces, Placed, Reference, chart_borders, coherence, histogram_distance, laplacian_energy, of_image, repetition,
    seam_visibility, sliced_wasserstein, unrolls,
};
use lapped::exemplar::{Channel, ChannelSet, Exemplar, Image, Wrap, srgb};
use lapped::mesh::walk::Walker;
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::random::Random;
use lapped::surface::{SurfaceTexture, Texel};

/// Blobs at random places that tile, `side` pixels wide.
fn blobs(side: u32, seed: u64) -> Exemplar {
    let mut random = Random::new(seed, 0);
    let count = side * side / 60;
    let all: Vec<[f32; 4]> = (0..count)
        .map(|_| {
            [random.range(0.0, f64::from(side)), random.range(0.0, f64::from(side)), random.unit(), random.unit()].map(|x| x as f32)
        })
        .collect();
    let pixel = |x: u32, y: u32| {
        let near = |a: f32, b: f32| {
            let d = (a - b).rem_euclid(side as f32);
            d.min(side as f32 - d)
        };
        let mut sum = Vec3::splat(0.3);
        for b in &all {
            let d = near(x as f32 + 0.5, b[0]).powi(2) + near(y as f32 + 0.5, b[1]).powi(2);
            sum += Vec3::new(b[2] - 0.4, b[3] - 0.5, 0.3 - b[2] * b[3]) * (-d / 8.0).exp();
        }
        sum.clamp(Vec3::ZERO, Vec3::ONE).map(srgb::decode)
    };
    let mut out = Exemplar::new("blobs", Image::from_fn(side, side, pixel));
    out.wrap = Wrap::Repeat;
    out
}

fn pieces(exemplar: &Exemplar, seed: u64) -> Pieces {
    of_image(exemplar, 28, 400, seed, [0.0, 1.0])
}

/// Every piece changed pixel by pixel.
fn changed(pieces: &Pieces, change: impl Fn(&[[f32; 3]], usize) -> [f32; 3]) -> Pieces {
    let one = |piece: &Vec<[f32; 3]>| (0..piece.len()).map(|i| change(piece, i)).collect();
    Pieces { side: pieces.side, data: pieces.data.iter().map(one).collect() }
}

fn blurred(pieces: &Pieces) -> Pieces {
    let side = pieces.side;
    changed(pieces, |piece, i| {
        let (x, y) = (i % side, i / side);
        let near = |t: usize| [t.saturating_sub(1), t, (t + 1).min(side - 1)];
        let all: Vec<[f32; 3]> = near(y).into_iter().flat_map(|y| near(x).map(|x| piece[y * side + x])).collect();
        std::array::from_fn(|k| all.iter().map(|p| p[k]).sum::<f32>() / 9.0)
    })
}

#[test]
fn pieces_are_at_no_distance_from_themselves() {
    let all = pieces(&blobs(64, 1), 1);
    assert_eq!(sliced_wasserstein(&all, &all), 0.0, "sliced Wasserstein distance");
    let (there, back) = coherence(&all, &all);
    // The middles of the pieces are among their patches.
    assert!(there.p99 < 1e-3 && back.p99 < 1e-3, "{there:?}, {back:?}");
    let other = pieces(&blobs(64, 1), 2);
    let same = sliced_wasserstein(&all, &other);
    let different = sliced_wasserstein(&all, &pieces(&blobs(64, 9), 2).clone());
    assert!(same < different, "other pieces of the same exemplar: {same}, of another: {different}");
}

#[test]
fn blur_takes_energy_and_noise_adds_it() {
    let all = pieces(&blobs(64, 1), 1);
    let (once, twice) = (blurred(&all), blurred(&blurred(&all)));
    let energy = [&all, &once, &twice].map(laplacian_energy);
    assert!(energy[0] > 1.5 * energy[1] && energy[1] > 1.2 * energy[2], "{energy:?}");
    let noisy = changed(&all, |piece, i| piece[i].map(|x| x + if i % 2 == 0 { 0.03 } else { -0.03 }));
    assert!(laplacian_energy(&noisy) > energy[0], "{} from {}", laplacian_energy(&noisy), energy[0]);
    let distances = [&once, &twice].map(|p| sliced_wasserstein(p, &all));
    assert!(0.0 < distances[0] && distances[0] < distances[1], "blur is farther: {distances:?}");
}

#[test]
fn seams_are_told_by_the_tail_of_coherence() {
    let exemplar = blobs(64, 1);
    let (all, whole) = (pieces(&exemplar, 1), pieces(&exemplar, 2));
    let mut tails = Vec::new();
    for share in [0, 20, 5] {
        // One in so many pieces has its right half from another piece.
        let mut data = all.data.clone();
        for k in (0..data.len()).filter(|k| share > 0 && k % share == 0) {
            let other = &all.data[(k + 7) % all.data.len()];
            (0..data[k].len()).filter(|i| i % all.side >= all.side / 2).for_each(|i| data[k][i] = other[i]);
        }
        let (there, _) = coherence(&Pieces { side: all.side, data }, &whole);
        tails.push((there.p99, there.mean));
    }
    assert!(tails[0].0 < tails[1].0 && tails[0].1 < tails[1].1 && tails[1].1 < tails[2].1, "{tails:?}");
    let (_, back) = coherence(&whole, &whole);
    let few = Pieces { side: all.side, data: vec![all.data[0].clone(); 50] };
    let (there, missing) = coherence(&few, &all);
    assert!(there.p99 < 1e-3 && missing.mean > 10.0 * back.mean.max(1e-4), "one piece again and again is coherent, not complete");
}

#[test]
fn a_verbatim_copy_is_coherent_wherever_it_is_cut() {
    // As fine as pixels are: between them it looks least like itself.
    let mut random = Random::new(5, 0);
    let pixels: Vec<f32> = (0..96 * 96).map(|_| random.range(0.1, 0.9) as f32).collect();
    let grain = |tiles: bool| {
        let mut out = Exemplar::new("grain", Image::from_fn(96, 96, |x, y| Vec3::splat(pixels[(y * 96 + x) as usize])));
        out.wrap = if tiles { Wrap::Repeat } else { Wrap::Clamp };
        out
    };
    for tiles in [false, true] {
        let exemplar = grain(tiles);
        let copy = Reference::new(&exemplar).measure_image(&exemplar, 9);
        // Its right half slid along its left one: a seam down the middle, and nothing else but where rows begin again.
        let torn = Image::from_fn(96, 96, |x, y| {
            let from = if x < 48 { y } else { (y + 37) % 96 };
            Vec3::splat(pixels[(from * 96 + x) as usize])
        });
        let torn = Reference::new(&exemplar).measure_image(&Exemplar::new("torn", torn), 9);
        assert!(copy.coherence.p99 < 0.6 * torn.coherence.p99, "{:?} of {:?}", copy.coherence, torn.coherence);
    }
}

#[test]
fn pieces_unroll_on_flat_faces_and_not_over_the_tip_of_a_spike() {
    let base = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let corners = base.into_iter().chain([Vec3::new(0.0, 0.0, 40.0)]).collect();
    let mesh = Mesh::new(corners, vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]).expect("a spike");
    let exemplar = blobs(64, 1);
    let (walker, texture) = (Walker::new(&mesh), Sheet(&exemplar, &mesh));
    let at = Placed { on: &walker, texture: &texture, right: &|_| DVec3::X, pixel: 1.0 };
    let point = |tip: f32| SurfacePoint { face: 0, bary: Vec3::new((1.0 - tip) / 2.0, (1.0 - tip) / 2.0, tip) };
    assert!(unrolls(&at, 6, point(0.3)), "it lies in a face");
    assert!(!unrolls(&at, 24, point(0.95)), "ways around the tip lead apart");
}

#[test]
fn repetition_is_told() {
    let far = of_image(&blobs(256, 4), 120, 4, 1, [0.0, 1.0]);
    let near = of_image(&blobs(50, 4), 120, 4, 1, [0.0, 1.0]);
    let (few, many) = (repetition(&far), repetition(&near));
    assert!(many > 0.95 && few < 0.7, "every 50 pixels: {many}; every 256: {few}");
}

/// A flat sheet that shows an exemplar, one pixel a unit.
struct Sheet<'a>(&'a Exemplar, &'a Mesh);

impl SurfaceTexture for Sheet<'_> {
    fn channels(&self) -> ChannelSet {
        self.0.channels()
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        let p = self.1.position(at);
        let image = self.0.channel(Channel::BaseColor).expect("colour").finest();
        let [w, h] = image.size().map(i64::from);
        let (x, y) = (p.x - 0.5, -p.y - 0.5);
        let pixel = |dx: i64, dy: i64| image.pixel((x.floor() as i64 + dx).rem_euclid(w), (y.floor() as i64 + dy).rem_euclid(h));
        let (u, v) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let color = pixel(0, 0).lerp(pixel(1, 0), u).lerp(pixel(0, 1).lerp(pixel(1, 1), u), v);
        Texel { base_color: color, alpha: 1.0, ..Texel::empty(Vec3::Z) }
    }
}

#[test]
fn an_exemplar_laid_on_a_sheet_is_as_good_as_itself() {
    let exemplar = blobs(64, 1);
    let corners = [[0.0, 0.0], [900.0, 0.0], [900.0, 900.0], [0.0, 900.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a square");
    let sheet = Sheet(&exemplar, &mesh);
    let good = fidelity(&mesh, &sheet, &|_| DVec3::X, 1.0, &exemplar);
    let (r, f) = (good.result, good.floor);
    assert!(r.swd < f.swd, "the whole against itself, {}, and its halves, {}", r.swd, f.swd);
    assert!((r.energy - 1.0).abs() < 0.05, "energy {}", r.energy);
    assert!(r.coherence.p99 <= f.coherence.p99, "coherence {:?}, floor {:?}", r.coherence, f.coherence);
    // Read in another direction or at another scale it is something else.
    let larger = fidelity(&mesh, &sheet, &|_| DVec3::X, 1.6, &exemplar);
    assert!(larger.result.swd > 2.0 * r.swd, "too fine: {} from {}", larger.result.swd, r.swd);
}

#[test]
fn colours_that_are_shifted_or_missing_are_told_wherever_they_lie() {
    let all = pieces(&blobs(64, 1), 1);
    assert_eq!(histogram_distance(&all, &all), 0.0, "no distance from itself");
    let shuffled = changed(&all, |piece, i| piece[(i * 37) % piece.len()]);
    assert!(histogram_distance(&all, &shuffled) < 1e-3, "places do not count");
    let floor = histogram_distance(&all, &pieces(&blobs(64, 1), 2));
    let lighter = [2, 8, 20].map(|steps| {
        let shift = steps as f32 / 255.0;
        histogram_distance(&changed(&all, |piece, i| piece[i].map(|x| x + shift)), &all)
    });
    assert!(floor < lighter[0] && lighter[0] < lighter[1] && lighter[1] < lighter[2], "{floor}, then {lighter:?}");
    // Seven of the directions see all three components move together, some not at all.
    assert!(lighter[1] / lighter[0] > 3.9 && lighter[1] / lighter[0] < 4.1, "four times the shift: {lighter:?}");
    let poor = changed(&all, |piece, i| if piece[i][0] > 0.6 { [0.3; 3] } else { piece[i] });
    assert!(histogram_distance(&poor, &all) > 3.0 * floor, "colours that are missing");
}

#[test]
fn seams_are_seen_where_borders_are_and_nowhere_else() {
    let exemplar = blobs(64, 1);
    let corners = [[0.0, 0.0], [300.0, 0.0], [300.0, 300.0], [0.0, 300.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a square");
    let own = pieces(&exemplar, 3);
    // Places along the diagonal, where two faces meet.
    let across = DVec3::new(1.0, -1.0, 0.0);
    let borders: Vec<Border> = (1..200)
        .map(|k| {
            let t = k as f32 / 200.0;
            Border { at: SurfacePoint { face: 0, bary: Vec3::new(1.0 - t, 0.0, t) }, across }
        })
        .collect();
    let whole = Sheet(&exemplar, &mesh);
    let none = seam_visibility(&mesh, &whole, &borders, 1.0, &own);
    assert_eq!(none.places, 199, "all places are looked at");
    assert!((none.ratio - 1.0).abs() < 0.25 && none.beyond < 0.05, "where nothing meets: {none:?}");
    // The second face shows another place of the exemplar, the same a little lighter, or the same.
    let mut seen = Vec::new();
    for (shift, light) in [(23.0, 0.0), (0.0, 0.05), (0.0, 0.2)] {
        let cut = Cut { sheet: Sheet(&exemplar, &mesh), shift, light };
        seen.push(seam_visibility(&mesh, &cut, &borders, 1.0, &own));
    }
    assert!(seen.iter().all(|s| s.ratio > 1.3 * none.ratio && s.beyond > none.beyond), "{none:?}, then {seen:?}");
    assert!(seen[2].ratio > seen[1].ratio && seen[2].beyond > 0.9, "the more the lighter: {seen:?}");
}

#[test]
fn chart_borders_lie_on_both_sides_of_seams() {
    let model = lapped::assets::mesh("gear").expect("a demo mesh");
    let mesh = lapped::mesh::clean(&model.positions, &model.faces, &Default::default()).expect("it is clean").mesh;
    let options = lapped::atlas::UnwrapOptions { size: 256, mips: 0, ..Default::default() };
    let atlas = lapped::atlas::unwrap(&mesh, &options, &lapped::progress::Silent).expect("it unwraps");
    let step = 1e-4 * f64::from((mesh.bounds().1 - mesh.bounds().0).max_element());
    let borders = chart_borders(&mesh, &atlas, 50.0 * step);
    assert!(borders.len() > 100, "{} places", borders.len());
    let crossed = borders.iter().filter(|b| {
        let there = lapped::mesh::walk::walk(&mesh, b.at, b.across.normalize() * 20.0 * step);
        atlas.corners[there.face as usize] != atlas.corners[b.at.face as usize] && there.face != b.at.face
    });
    let share = crossed.count() as f64 / borders.len() as f64;
    assert!(share > 0.95, "{share} of the steps lead over the border");
}

/// A sheet whose second face shows the exemplar shifted, or lighter.
struct Cut<'a> {
    sheet: Sheet<'a>,
    shift: f64,
    light: f32,
}

impl SurfaceTexture for Cut<'_> {
    fn channels(&self) -> ChannelSet {
        self.sheet.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        if at.face == 0 {
            return self.sheet.texel(at, footprint);
        }
        let there = lapped::mesh::walk::walk(self.sheet.1, at, DVec3::NEG_X * self.shift);
        let texel = self.sheet.texel(there, footprint);
        let lighter = texel.base_color.map(|c| srgb::decode((srgb::encode(c) + self.light).min(1.0)));
        Texel { base_color: lighter, ..texel }
    }
}
