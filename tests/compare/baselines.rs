//! What people do today: each baseline shows the exemplar, at its scale, in the places and with the faults it is known for.

use glam::{Vec2, Vec3};
use lapped::atlas::{UnwrapOptions, unwrap};
use lapped::compare::baselines::hex::hex_texel;
use lapped::compare::baselines::{HexOptions, Sheet, Tile, Tiling, Triplanar, TriplanarOptions};
use lapped::compare::measures::{Pieces, laplacian_energy, repetition};
use lapped::exemplar::{Channel, Exemplar, Image, Wrap, srgb};
use lapped::mesh::{CleanOptions, Mesh, SurfacePoint, clean};
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::surface::SurfaceTexture;

/// An exemplar that tells its pixels apart: red goes right, green goes down.
fn ramps(side: u32) -> Exemplar {
    let pixel = |x: u32, y: u32| Vec3::new((x as f32 + 0.5) / side as f32, (y as f32 + 0.5) / side as f32, 0.2);
    let mut out = Exemplar::new("ramps", Image::from_fn(side, side, pixel));
    out.wrap = Wrap::Repeat;
    out
}

/// A square of two triangles with corners at these places.
fn square(corners: [Vec3; 4]) -> Mesh {
    Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a square")
}

fn asset(name: &str) -> Mesh {
    let model = lapped::assets::mesh(name).expect("a demo mesh");
    clean(&model.positions, &model.faces, &CleanOptions::default()).expect("it is clean").mesh
}

fn random_point(mesh: &Mesh, random: &mut Random) -> SurfacePoint {
    let face = random.below(mesh.face_count() as u64) as u32;
    let (root, v) = (random.unit().sqrt() as f32, random.unit() as f32);
    SurfacePoint { face, bary: Vec3::new(1.0 - root, root * (1.0 - v), root * v) }
}

/// Whether a colour is the one of these pixels, away from where the ramps begin again.
fn is_at(color: Vec3, place: Vec2) -> bool {
    let expected = place.rem_euclid(Vec2::ONE);
    let near = expected.min_element() < 0.05 || expected.max_element() > 0.95;
    near || (color.truncate() - expected).abs().max_element() < 0.01
}

#[test]
fn a_projected_plane_is_the_exemplar_upright_and_to_scale_from_each_side() {
    let exemplar = ramps(64);
    // Seen from in front: right and down in the exemplar are these directions of the world.
    let sides = [
        (Vec3::Z, Vec3::X, Vec3::NEG_Y),
        (Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y),
        (Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y),
        (Vec3::NEG_X, Vec3::Z, Vec3::NEG_Y),
        (Vec3::Y, Vec3::X, Vec3::Z),
    ];
    for (normal, right, down) in sides {
        let mesh = square([-right + down, right + down, right - down, -right - down]);
        assert!(mesh.normal(0).as_vec3().dot(normal) > 0.999, "the square looks to {normal}");
        let texture = Triplanar::new(&mesh, &exemplar, 0.4, TriplanarOptions::default());
        let mut random = Random::new(1, 0);
        for _ in 0..500 {
            let at = random_point(&mesh, &mut random);
            let p = mesh.position(at).as_vec3();
            let texel = texture.texel(at, 0.0);
            let place = Vec2::new(p.dot(right), p.dot(down)) / 0.4;
            assert!(is_at(texel.base_color, place), "{normal}: {} at {place}", texel.base_color);
            assert_eq!(texel.alpha, 1.0, "everything is covered");
        }
    }
}

#[test]
fn projections_blend_without_a_jump_and_weigh_the_axes_by_the_normal() {
    let (mesh, exemplar) = (asset("knot"), ramps(64));
    let texture = Triplanar::new(&mesh, &exemplar, 1.0, TriplanarOptions::default());
    assert_eq!(texture.weights(Vec3::NEG_Y), [0.0, 1.0, 0.0], "from below, one plane");
    let diagonal = texture.weights(Vec3::ONE.normalize());
    assert!(diagonal.iter().all(|w| (w - 1.0 / 3.0).abs() < 1e-5), "on the diagonal all alike: {diagonal:?}");
    let mut random = Random::new(2, 0);
    let unit =
        |random: &mut Random| Vec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0) as f32)).normalize_or(Vec3::X);
    for _ in 0..1000 {
        let (a, b) = (unit(&mut random), unit(&mut random));
        let near = (a + 0.01 * b).normalize();
        let (v, w) = (texture.weights(a), texture.weights(near));
        assert!((v.iter().sum::<f32>() - 1.0).abs() < 1e-5, "weights add up: {v:?}");
        assert!((0..3).all(|k| (v[k] - w[k]).abs() < 0.1), "a small turn changes little: {v:?} to {w:?}");
    }
}

#[test]
fn tiles_on_charts_have_one_scale_and_repeat_by_it() {
    let (mesh, exemplar) = (asset("gear"), ramps(64));
    let atlas = unwrap(&mesh, &UnwrapOptions { size: 512, mips: 0, ..UnwrapOptions::default() }, &Silent).expect("it unwraps");
    let scale = 0.05 * f64::from((mesh.bounds().1 - mesh.bounds().0).max_element());
    let texture = Tiling::new(&mesh, &atlas, &exemplar, scale);
    let mut random = Random::new(3, 0);
    let (mut right, mut all) = (0, 0);
    for _ in 0..3000 {
        let at = random_point(&mesh, &mut random);
        // A step within the face changes the ramps by its length over the scale.
        let centre = SurfacePoint { face: at.face, bary: at.bary.lerp(Vec3::splat(1.0 / 3.0), 0.1) };
        let step = (mesh.position(centre) - mesh.position(at)).length() / scale;
        let (a, b) = (texture.texel(at, 0.0).base_color, texture.texel(centre, 0.0).base_color);
        let moved = f64::from((a - b).truncate().length());
        if step > 0.02 && step < 0.2 && moved < 0.3 {
            right += usize::from((moved / step - 1.0).abs() < 0.15);
            all += 1;
        }
    }
    assert!(all > 300 && right * 100 > all * 90, "{right} of {all} steps are to scale");
}

/// Blobs at random places that tile.
fn blobs(side: u32) -> Exemplar {
    let mut random = Random::new(4, 0);
    let all: Vec<[f32; 3]> = (0..side * side / 50)
        .map(|_| [random.range(0.0, f64::from(side)), random.range(0.0, f64::from(side)), random.unit()].map(|x| x as f32))
        .collect();
    let pixel = |x: u32, y: u32| {
        let near = |a: f32, b: f32| {
            let d = (a - b).rem_euclid(side as f32);
            d.min(side as f32 - d)
        };
        let light = all.iter().fold(0.4, |sum, b| {
            let d = near(x as f32 + 0.5, b[0]).powi(2) + near(y as f32 + 0.5, b[1]).powi(2);
            sum + (b[2] - 0.5) * (-d / 8.0).exp()
        });
        Vec3::splat(srgb::decode(light.clamp(0.0, 1.0)))
    };
    let mut out = Exemplar::new("blobs", Image::from_fn(side, side, pixel));
    out.wrap = Wrap::Repeat;
    out
}

/// A piece of the plane, pixel by pixel.
fn piece(side: usize, pixel: impl Fn(Vec2) -> Vec3) -> Pieces {
    let at = |i: usize| pixel(Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5)).to_array().map(srgb::encode);
    Pieces { side, data: vec![(0..side * side).map(at).collect()] }
}

#[test]
fn hexagons_do_not_repeat_and_keep_the_colours_and_most_of_the_contrast() {
    let exemplar = blobs(64);
    let tile = Tile::new(&exemplar, 1.0);
    let options = HexOptions::default();
    let plain = piece(160, |p| tile.texel(p, 0.0).base_color);
    let hex = piece(160, |p| hex_texel(&tile, p, 0.0, &options).base_color);
    let (repeated, broken) = (repetition(&plain), repetition(&hex));
    assert!(repeated > 0.95 && broken < 0.8, "tiles repeat at {repeated}, hexagons at {broken}");
    let mean = |pieces: &Pieces| pieces.data[0].iter().map(|p| p[0]).sum::<f32>() / pieces.data[0].len() as f32;
    assert!((mean(&plain) - mean(&hex)).abs() < 0.03, "the same lightness: {} and {}", mean(&plain), mean(&hex));
    let energy = laplacian_energy(&hex) / laplacian_energy(&plain);
    // Where one hexagon gives way to the next there are edges that the exemplar has not.
    assert!((0.8..1.6).contains(&energy), "detail over the exemplar's: {energy}");
    // Without sharpened weights, blending takes more of it away.
    let soft = HexOptions { power: 1.0, contrast: 0.0, ..options };
    let blurred = laplacian_energy(&piece(160, |p| hex_texel(&tile, p, 0.0, &soft).base_color)) / laplacian_energy(&plain);
    assert!(blurred < 0.8 * energy, "{blurred} without, {energy} with sharpened weights");
}

#[test]
fn normals_come_out_in_the_space_of_the_mesh() {
    let mut exemplar = ramps(16);
    let tilted = Vec3::new(0.48, 0.36, 0.8);
    exemplar.set(Channel::Normal, Image::from_fn(16, 16, |_, _| tilted)).expect("of the same size");
    let mesh = square([Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)]);
    let atlas = unwrap(&mesh, &UnwrapOptions { size: 64, mips: 0, ..UnwrapOptions::default() }, &Silent).expect("it unwraps");
    let options = TriplanarOptions { sheet: Sheet::Hex(HexOptions::default()), ..TriplanarOptions::default() };
    let projected =
        [Triplanar::new(&mesh, &exemplar, 0.5, TriplanarOptions::default()), Triplanar::new(&mesh, &exemplar, 0.5, options)];
    let tiled = Tiling::new(&mesh, &atlas, &exemplar, 0.5);
    let mut random = Random::new(5, 0);
    for _ in 0..200 {
        let at = random_point(&mesh, &mut random);
        for texture in &projected {
            let normal = texture.texel(at, 0.0).normal;
            assert!((normal - tilted).length() < 1e-3, "right is +x and up is +y: {normal}");
        }
        // A chart may lie turned, but a normal leans as much and outward.
        let normal = tiled.texel(at, 0.0).normal;
        assert!((normal.z - tilted.z).abs() < 1e-3 && (normal.length() - 1.0).abs() < 1e-3, "leans as much: {normal}");
    }
}
