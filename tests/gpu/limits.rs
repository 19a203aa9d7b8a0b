//! What does not fit an adapter is split, made smaller or refused with words; failures are errors, never panics.

use crate::common::{checks, compare, flat, pasted, renderer, renderers, round_patch, scattered};
use glam::{Vec2, Vec3};
use lapped::paste::{AGREES, Composite, LappedTexture, Paste, Turn};
use lapped::render::gpu::{Canvas, Gpu, GpuError, GpuOptions, Path, shaders};
use lapped::render::{DrawOptions, Grid, Stage, View, Visibility};

const SMALL: Grid = Grid { width: 96, height: 96, samples: 2 };

#[test]
fn every_shader_is_valid() {
    use wgpu::naga;
    for (name, parts) in shaders::PASSES {
        let text = parts.concat();
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)));
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {e:?}"));
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("// "), "{} begins by saying what it does", path.display());
        assert!(shaders::PASSES.iter().any(|(_, parts)| parts.contains(&text.as_str())), "{} is used", path.display());
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn missing_adapters_are_told_with_those_there_are() {
    let asked = Gpu::new(&GpuOptions { adapter: Some("voodoo".into()), limits: None });
    let Err(GpuError::NoSuchAdapter { wanted, there }) = asked.map(|_| ()) else { panic!("there is no voodoo adapter") };
    assert!(wanted == "voodoo" && there.contains("vulkan") && there.contains("gl"), "names those there are: {there}");
    let beyond = Gpu::new(&GpuOptions { adapter: Some("99".into()), limits: None });
    assert!(matches!(beyond.map(|_| ()), Err(GpuError::NoSuchAdapter { .. })), "nor is there number 99");
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn pictures_without_pixels_are_refused() {
    let (mesh, options) = (flat(2), DrawOptions::default());
    let stage = Stage::new(&mesh, &options);
    let camera = View::default().frame(&mesh, 1.0);
    for renderer in renderers() {
        let subject = renderer.load(&stage, &LappedTexture::default()).unwrap();
        for (width, height) in [(0, 9), (9, 0), (1 << 16, 9)] {
            let drawn = renderer.draw(&subject, &stage, &camera, Grid { width, height, samples: 1 }, Path::Single);
            assert!(matches!(drawn, Err(GpuError::Picture(_))), "{width} x {height}: {drawn:?}");
        }
        for size in [[0, 4], [1 << 15, 4]] {
            let canvas = Canvas::new(renderer, &subject, size, Path::Layered);
            assert!(matches!(canvas, Err(GpuError::Limit { .. })), "{size:?} samples");
        }
        renderer.gpu().check().unwrap();
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn a_lost_device_is_an_error() {
    let (mesh, options) = (flat(2), DrawOptions::default());
    let stage = Stage::new(&mesh, &options);
    let camera = View::default().frame(&mesh, 1.0);
    let renderer = renderer("vulkan", None);
    let subject = renderer.load(&stage, &LappedTexture::default()).unwrap();
    renderer.gpu().device.destroy();
    let drawn = renderer.draw(&subject, &stage, &camera, SMALL, Path::Single);
    assert!(matches!(drawn, Err(GpuError::Lost { .. } | GpuError::Refused { .. })), "drawing on it: {drawn:?}");
    assert!(renderer.load(&stage, &LappedTexture::default()).is_err(), "loading onto it");
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn lists_that_do_not_fit_one_binding_are_split_and_nothing_changes() {
    let pasted = pasted("knot", &["weave"], 60.0, true);
    let options = DrawOptions::default();
    let stage = Stage::new(&pasted.mesh, &options);
    let camera = View::default().frame(&pasted.mesh, 1.0);
    for name in ["vulkan", "gl"] {
        let whole = renderer(name, None);
        let mut limits = whole.gpu().limits.clone();
        limits.max_storage_buffer_binding_size = 80 << 10;
        let split = renderer(name, Some(limits));
        let subjects = [&whole, &split].map(|r| r.load(&stage, &pasted.lapped).unwrap());
        assert!(subjects[0].page_count() == 1 && subjects[1].page_count() > 3, "80 KiB make pages");
        for path in [Path::Single, Path::Layered] {
            let a = whole.draw(&subjects[0], &stage, &camera, SMALL, path).unwrap();
            let b = split.draw(&subjects[1], &stage, &camera, SMALL, path).unwrap();
            assert_eq!(a, b, "{path:?} on {name}");
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn textures_larger_than_the_adapter_takes_are_made_smaller_and_said_so() {
    let pasted = pasted("vase", &["stone"], 20.0, false);
    let options = DrawOptions::default();
    let stage = Stage::new(&pasted.mesh, &options);
    let grid = Grid { width: 120, height: 120, samples: 2 };
    let camera = View::default().frame(&pasted.mesh, 1.0);
    let expected =
        stage.draw(&Composite::new(&pasted.mesh, &pasted.lapped), &Visibility::new(&pasted.mesh, &camera, grid).unwrap());
    for name in ["vulkan", "gl"] {
        let mut limits = renderer(name, None).gpu().limits.clone();
        limits.max_texture_dimension_2d = 160;
        let renderer = renderer(name, Some(limits));
        let subject = renderer.load(&stage, &pasted.lapped).unwrap();
        let warnings = subject.patches().warnings().join("\n");
        assert!(warnings.contains("stone") && warnings.contains("1/4"), "says what and how much: {warnings}");
        // The picture has more samples than a texture may: it is drawn in tiles.
        let drawn = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
        let found = compare(&pasted.mesh, &camera, grid, &expected, &drawn);
        assert!(found.inside < 6.0 && found.outside < 0.1, "still the same picture, less sharp: {found:?}");
        let too_large = Grid { width: 161, height: 4, samples: 1 };
        let drawn = renderer.draw(&subject, &stage, &camera, too_large, Path::Single);
        assert!(matches!(drawn, Err(GpuError::Limit { needs: 161, .. })), "more pixels than a texture may have: {drawn:?}");
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn thousands_of_patches_and_tens_of_thousands_of_pastes_are_drawn() {
    let mesh = flat(180);
    let patches = (0..4096).map(|k| round_patch(5 + k % 60, [(k % 97) as i32, (k % 89) as i32])).collect();
    let lapped = scattered(&mesh, patches, checks(128), 65_536);
    let options = DrawOptions { occlusion: false, ..DrawOptions::default() };
    let stage = Stage::new(&mesh, &options);
    let grid = Grid { width: 300, height: 300, samples: 2 };
    let camera = "front".parse::<View>().unwrap().frame(&mesh, 1.0);
    let expected = stage.draw(&Composite::new(&mesh, &lapped), &Visibility::new(&mesh, &camera, grid).unwrap());
    for renderer in renderers() {
        let subject = renderer.load(&stage, &lapped).unwrap();
        assert_eq!(subject.patches().patch_count(), 4096, "all of them");
        for path in [Path::Single, Path::Layered] {
            let found = compare(&mesh, &camera, grid, &expected, &renderer.draw(&subject, &stage, &camera, grid, path).unwrap());
            assert!(found.inside < 1.0, "{path:?} on {}: {found:?}", renderer.gpu().adapter());
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn lists_of_more_than_128_mebibytes_are_drawn() {
    let mesh = flat(512);
    let faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
    // Nine layers over everything, the mask's middle stretched over all faces.
    let uv: Vec<[Vec2; 3]> =
        faces.iter().map(|&f| mesh.corners(f).map(|p| Vec2::new(0.5 + 0.2 * p.x as f32, 0.5 - 0.2 * p.y as f32))).collect();
    let layer = |k: u32| Paste {
        patch: 0,
        faces: faces.clone(),
        uv: uv.clone(),
        offset: Vec2::splat(k as f32),
        turn: Turn::NONE,
        cut: None,
        agreement: AGREES,
    };
    let pastes: Vec<Paste> = (0..9).map(layer).collect();
    let lapped = LappedTexture { exemplars: vec![checks(64)], patches: vec![round_patch(32, [0, 0])], pastes, layers: Vec::new() };
    let options = DrawOptions { occlusion: false, ..DrawOptions::default() };
    let stage = Stage::new(&mesh, &options);
    let camera = "front".parse::<View>().unwrap().frame(&mesh, 1.0);
    let expected = stage.draw(&Composite::new(&mesh, &lapped), &Visibility::new(&mesh, &camera, SMALL).unwrap());
    for renderer in renderers() {
        let subject = renderer.load(&stage, &lapped).unwrap();
        let [_, lists, _] = subject.bytes();
        assert!(lists > 128 << 20 && subject.page_count() > 1, "{lists} bytes in {} pages", subject.page_count());
        let drawn = renderer.draw(&subject, &stage, &camera, SMALL, Path::Single).unwrap();
        let found = compare(&mesh, &camera, SMALL, &expected, &drawn);
        assert!(found.inside < 1.0, "on {}: {found:?}", renderer.gpu().adapter());
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn bare_colour_is_the_same_everywhere() {
    let (mesh, options) = (flat(1), DrawOptions { bare: Vec3::new(0.2, 0.3, 0.4), occlusion: false, ..DrawOptions::default() });
    let stage = Stage::new(&mesh, &options);
    let camera = "front".parse::<View>().unwrap().frame(&mesh, 1.0);
    let pictures = renderers().each_ref().map(|renderer| {
        let subject = renderer.load(&stage, &LappedTexture::default()).unwrap();
        renderer.draw(&subject, &stage, &camera, SMALL, Path::Single).unwrap()
    });
    let middle = pictures.each_ref().map(|p| p.pixel(48, 48));
    assert_eq!(middle[0], middle[1], "both interfaces");
}
