//! Images and material sets as exemplars: every format, depth and kind of pixel, on files that use it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

use glam::Vec3;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat};
use lapped::exemplar::srgb;
use lapped::exemplar::{Channel, Exemplar, Image};
use lapped::format::{ExemplarOptions, FormatError, NormalConvention, Warning, read_exemplar, read_mask, save_image};
use std::path::Path;

/// An exemplar and its warnings, without the notes.
fn read(path: &Path) -> (Exemplar, Vec<Warning>) {
    let (exemplar, mut told) = read_exemplar(path, &ExemplarOptions::default()).unwrap();
    told.retain(|t| !t.note);
    (exemplar, told)
}

fn pixel(exemplar: &Exemplar, channel: Channel, x: i64, y: i64) -> Vec3 {
    exemplar.channel(channel).unwrap().finest().pixel(x, y)
}

/// A colour picture that is different at every pixel and every component.
fn colors() -> image::RgbImage {
    image::RgbImage::from_fn(12, 9, |x, y| image::Rgb([(20 * x) as u8, (25 * y) as u8, (7 * x + 9 * y) as u8]))
}

#[test]
fn lossless_formats_give_exact_linear_light() {
    let folder = tempfile::tempdir().unwrap();
    for (ending, format) in [
        ("png", ImageFormat::Png),
        ("tga", ImageFormat::Tga),
        ("bmp", ImageFormat::Bmp),
        ("tiff", ImageFormat::Tiff),
        ("webp", ImageFormat::WebP),
    ] {
        let path = folder.path().join(format!("a.{ending}"));
        DynamicImage::from(colors()).save_with_format(&path, format).unwrap();
        let (exemplar, warnings) = read(&path);
        assert_eq!(exemplar.size(), [12, 9], "{ending}: size");
        for (x, y, p) in colors().enumerate_pixels() {
            let expected = Vec3::from_array(p.0.map(|c| srgb::decode(f32::from(c) / 255.0)));
            assert_eq!(pixel(&exemplar, Channel::BaseColor, x.into(), y.into()), expected, "{ending}: pixel {x} {y}");
        }
        assert_eq!(exemplar.name, "a", "{ending}: named by its stem");
        assert!(warnings.is_empty(), "{ending}: {warnings:?}");
    }
}

#[test]
fn jpeg_is_close() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jpg");
    let smooth = image::RgbImage::from_fn(32, 32, |x, y| image::Rgb([(100 + x) as u8, (100 + y) as u8, 90]));
    DynamicImage::from(smooth).save(&path).unwrap();
    let (exemplar, _) = read(&path);
    let found = pixel(&exemplar, Channel::BaseColor, 16, 16).to_array().map(srgb::encode);
    assert!((Vec3::from_array(found) * 255.0 - Vec3::new(116.0, 116.0, 90.0)).abs().max_element() < 6.0, "{found:?}");
}

#[test]
fn float_formats_are_linear_already() {
    let folder = tempfile::tempdir().unwrap();
    let light = image::Rgb32FImage::from_fn(5, 4, |x, y| image::Rgb([x as f32 * 0.5, y as f32 * 0.25, 3.0]));
    for ending in ["exr", "hdr"] {
        let path = folder.path().join(format!("a.{ending}"));
        DynamicImage::from(light.clone()).save(&path).unwrap();
        let (exemplar, _) = read(&path);
        let found = pixel(&exemplar, Channel::BaseColor, 4, 2);
        assert!((found - Vec3::new(2.0, 0.5, 3.0)).abs().max_element() < 0.02, "{ending}: {found}");
    }
}

#[test]
fn sixteen_bits_and_grey_and_alpha_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.png");
    let deep = image::ImageBuffer::<image::Rgba<u16>, _>::from_fn(3, 3, |x, y| {
        image::Rgba([(x * 777) as u16, 1, 40000, if y == 1 { 300 } else { 65535 }])
    });
    DynamicImage::from(deep).save(&path).unwrap();
    let (exemplar, _) = read(&path);
    let expected = Vec3::new(srgb::decode(777.0 / 65535.0), srgb::decode(1.0 / 65535.0), srgb::decode(40000.0 / 65535.0));
    assert_eq!(pixel(&exemplar, Channel::BaseColor, 1, 0), expected, "16-bit colour");
    assert_eq!(pixel(&exemplar, Channel::Opacity, 0, 1).x, 300.0 / 65535.0, "16-bit alpha");

    let path = folder.path().join("grey.png");
    let grey = image::GrayAlphaImage::from_fn(2, 2, |x, y| image::LumaA([50, if x == y { 255 } else { 0 }]));
    DynamicImage::from(grey).save(&path).unwrap();
    let (exemplar, _) = read(&path);
    assert_eq!(pixel(&exemplar, Channel::BaseColor, 1, 0), Vec3::splat(srgb::decode(50.0 / 255.0)), "grey becomes a colour");
    assert_eq!(pixel(&exemplar, Channel::Opacity, 1, 0).x, 0.0, "alpha of grey");
    assert_eq!(read_mask(&path).unwrap().grey(1, 1), 1.0, "a mask is an image's alpha, if it has any");

    let path = folder.path().join("opaque.png");
    DynamicImage::from(image::RgbaImage::from_pixel(4, 1, image::Rgba([1, 2, 3, 255]))).save(&path).unwrap();
    assert!(read(&path).0.channel(Channel::Opacity).is_none(), "an opaque image has no opacity channel");
}

/// A PNG of these chunks.
fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in chunks.iter().copied().chain([(b"IEND", &[][..])]) {
        png.extend((data.len() as u32).to_be_bytes());
        png.extend(kind);
        png.extend(data);
        let crc = kind.iter().chain(data).fold(!0_u32, |mut crc, &b| {
            crc ^= u32::from(b);
            (0..8).for_each(|_| crc = if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 });
            crc
        });
        png.extend((!crc).to_be_bytes());
    }
    png
}

#[test]
fn palette_images_are_unfolded() {
    // A 4 x 1 PNG with two colours in its palette, two bits a pixel, the second one transparent.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("palette.png");
    // One stored deflate block: filter 0, then indices 0 1 0 1; Adler-32 of these two bytes.
    let data = [0x78, 0x01, 1, 2, 0, 0xFD, 0xFF, 0, 0b0001_0001, 0, 0x13, 0, 0x12];
    let header = [0, 0, 0, 4, 0, 0, 0, 1, 2, 3, 0, 0, 0];
    std::fs::write(&path, png(&[(b"IHDR", &header), (b"PLTE", &[255, 0, 0, 0, 0, 255]), (b"tRNS", &[255, 0]), (b"IDAT", &data)]))
        .unwrap();
    let (exemplar, _) = read(&path);
    assert_eq!(pixel(&exemplar, Channel::BaseColor, 0, 0), Vec3::X, "first entry");
    assert_eq!(pixel(&exemplar, Channel::BaseColor, 3, 0), Vec3::Z, "second entry keeps its colour though transparent");
    assert_eq!(pixel(&exemplar, Channel::Opacity, 3, 0).x, 0.0, "transparency of the palette");
}

#[test]
fn embedded_orientation_is_applied() {
    // EXIF with orientation 6: the camera was turned, the image must be turned a quarter clockwise.
    let exif: &[u8] = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.png");
    let mut file = Vec::new();
    let mut encoder = image::codecs::png::PngEncoder::new(&mut file);
    encoder.set_exif_metadata(exif.to_vec()).unwrap();
    encoder.write_image(&[255, 0, 0, 0, 255, 0, 0, 0, 255], 3, 1, ExtendedColorType::Rgb8).unwrap();
    std::fs::write(&path, file).unwrap();
    let (exemplar, _) = read(&path);
    assert_eq!(exemplar.size(), [1, 3], "turned upright");
    assert_eq!(pixel(&exemplar, Channel::BaseColor, 0, 0), Vec3::X, "red is on top");
}

#[test]
fn saved_images_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.png");
    let original = Image::from_fn(16, 16, |x, y| Vec3::from_array([x * 16, y * 16, x * y].map(|c| srgb::decode(c as f32 / 255.0))));
    save_image(&path, &original).unwrap();
    let (exemplar, _) = read(&path);
    assert_eq!(exemplar.channel(Channel::BaseColor).unwrap().finest(), &original, "8-bit sRGB values are exact");
}

// ---- material sets

/// Bumps, and their normals with y up.
fn relief(size: u32) -> (image::GrayImage, image::RgbImage) {
    let height = |x: f32, y: f32| 0.5 + 0.2 * (x * 0.4 + y * 0.15).sin() + 0.2 * (y * 0.3 - x * 0.1).cos();
    let grey = image::GrayImage::from_fn(size, size, |x, y| image::Luma([(height(x as f32, y as f32) * 255.0) as u8]));
    let normals = image::RgbImage::from_fn(size, size, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let n = Vec3::new(-8.0 * (height(x + 0.5, y) - height(x - 0.5, y)), 8.0 * (height(x, y + 0.5) - height(x, y - 0.5)), 1.0);
        image::Rgb((n.normalize() * 127.5 + 127.5).to_array().map(|c| c.round() as u8))
    });
    (grey, normals)
}

fn y_down(mut normals: image::RgbImage) -> image::RgbImage {
    normals.pixels_mut().for_each(|p| p.0[1] = 255 - p.0[1]);
    normals
}

fn grey(value: u8, size: u32) -> image::GrayImage {
    image::GrayImage::from_pixel(size, size, image::Luma([value]))
}

#[test]
fn a_set_is_found_from_its_colour_image_its_folder_or_its_prefix() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (height, normals) = relief(32);
    image::RgbImage::from_pixel(32, 32, image::Rgb([200, 100, 50])).save(at("Bricks097_2K-PNG_Color.png")).unwrap();
    height.save(at("Bricks097_2K-PNG_Displacement.png")).unwrap();
    normals.save(at("Bricks097_2K-PNG_NormalGL.png")).unwrap();
    y_down(normals.clone()).save(at("Bricks097_2K-PNG_NormalDX.png")).unwrap();
    grey(51, 32).save(at("Bricks097_2K-PNG_Roughness.png")).unwrap();
    grey(102, 32).save(at("Bricks097_2K-PNG_AmbientOcclusion.png")).unwrap();
    grey(255, 32).save(at("Bricks097_2K-PNG_Metalness.png")).unwrap();
    let (by_image, warnings) = read(&at("Bricks097_2K-PNG_Color.png"));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(by_image.channels().iter().count(), 6, "all six channels: {:?}", by_image.channels());
    assert_eq!(pixel(&by_image, Channel::Roughness, 0, 0).x, 51.0 / 255.0, "data is never decoded as sRGB");
    let first = normals.get_pixel(5, 6).0.map(|c| f32::from(c) / 255.0 * 2.0 - 1.0);
    assert_eq!(pixel(&by_image, Channel::Normal, 5, 6), Vec3::from_array(first), "the OpenGL map is taken, as it is");
    assert_eq!(by_image, read(folder.path()).0, "by folder");
    assert_eq!(by_image, read(&at("Bricks097")).0, "by prefix");
    let alone = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
    let (alone, _) = read_exemplar(&at("Bricks097_2K-PNG_Color.png"), &alone).unwrap();
    assert_eq!(alone.channels().iter().count(), 1, "alone");

    image::RgbImage::new(8, 8).save(at("moss_diff_1k.png")).unwrap();
    let several = read_exemplar(folder.path(), &ExemplarOptions::default()).unwrap_err().to_string();
    assert!(several.contains("2 material sets") && several.contains("moss"), "{several}");
    assert_eq!(read(&at("moss")).0.size(), [8, 8], "by prefix among several");
}

#[test]
fn packed_maps_and_gloss_are_taken_apart() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::new(4, 4).save(at("rock_diff_1k.png")).unwrap();
    image::RgbImage::from_pixel(4, 4, image::Rgb([51, 102, 153])).save(at("rock_arm_1k.png")).unwrap();
    let (rock, _) = read(&at("rock_diff_1k.png"));
    let found = [Channel::Occlusion, Channel::Roughness, Channel::Metallic].map(|c| pixel(&rock, c, 0, 0).x);
    assert_eq!(found, [0.2, 0.4, 0.6], "occlusion, roughness, metallic in red, green, blue");

    image::RgbImage::new(4, 4).save(at("tile_Albedo.png")).unwrap();
    grey(204, 4).save(at("tile_Gloss.png")).unwrap();
    let rough = pixel(&read(&at("tile_Albedo.png")).0, Channel::Roughness, 0, 0).x;
    assert!((rough - 0.2).abs() < 1e-6, "gloss is the opposite of roughness: {rough}");
}

#[test]
fn normal_conventions_and_height_senses_are_told_from_the_maps() {
    let (height, normals) = relief(64);
    let bright_deep = image::GrayImage::from_fn(64, 64, |x, y| image::Luma([255 - height.get_pixel(x, y).0[0]]));
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::new(64, 64).save(at("a_color.png")).unwrap();
    let mut expected: Option<Exemplar> = None;
    for down in [false, true] {
        for deep in [false, true] {
            let n = if down { y_down(normals.clone()) } else { normals.clone() };
            n.save(at("a_normal.png")).unwrap();
            if deep { &bright_deep } else { &height }.save(at("a_height.png")).unwrap();
            let (exemplar, warnings) = read(&at("a_color.png"));
            assert_eq!(warnings.len(), usize::from(deep), "turning the heights over is told: {warnings:?}");
            let wanted = expected.get_or_insert_with(|| exemplar.clone());
            for channel in [Channel::Normal, Channel::Height] {
                let of = |e: &Exemplar| e.channel(channel).unwrap().finest().data().to_vec();
                let worst = of(&exemplar).iter().zip(of(wanted)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(worst < 1e-6, "{channel:?} comes out the same for y down {down}, bright deep {deep}: {worst}");
            }
        }
    }
    let named = at("a_normal_dx.png");
    y_down(normals.clone()).save(&named).unwrap();
    let auto =
        ExemplarOptions { channels: [(Channel::Normal, named)].into(), bright_is_high: Some(true), ..ExemplarOptions::default() };
    let told = read_exemplar(&at("a_color.png"), &auto).unwrap().1;
    assert!(told.len() == 1 && told[0].note && told[0].text.contains("DirectX"), "the decision is told: {told:?}");
    let stated =
        ExemplarOptions { normal: Some(NormalConvention::OpenGl), bright_is_high: Some(true), ..ExemplarOptions::default() };
    let (exemplar, warnings) = read_exemplar(&at("a_color.png"), &stated).unwrap();
    assert!(warnings.is_empty(), "what is stated is believed: {warnings:?}");
    assert_eq!(pixel(&exemplar, Channel::Height, 3, 3).x, f32::from(bright_deep.get_pixel(3, 3).0[0]) / 255.0, "as it is");
}

#[test]
fn channels_of_other_sizes_are_resampled_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::new(16, 8).save(at("a_color.png")).unwrap();
    let ramp = image::GrayImage::from_fn(64, 32, |x, _| image::Luma([4 * x as u8]));
    ramp.save(at("a_height.png")).unwrap();
    grey(100, 4).save(at("other file.png")).unwrap();
    let mut options = ExemplarOptions::default();
    options.channels.insert(Channel::Roughness, at("other file.png"));
    let (exemplar, warnings) = read_exemplar(&at("a_color.png"), &options).unwrap();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    let found = pixel(&exemplar, Channel::Height, 8, 4).x * 255.0;
    assert!((found - 4.0 * 33.5).abs() < 1.0, "pixel 8 of 16 covers pixels 32 to 35 of 64: {found}");
    assert!((pixel(&exemplar, Channel::Roughness, 15, 7).x - 100.0 / 255.0).abs() < 1e-6, "a constant stays one");
}

#[test]
fn hopeless_images_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let refusal = |name: &str| {
        let message = read_exemplar(&at(name), &ExemplarOptions::default()).unwrap_err().to_string();
        assert!(message.contains(name) && !message.contains('\n'), "{message:?} names the file in one line");
        message
    };
    DynamicImage::from(image::RgbaImage::new(8, 8)).save(at("clear.png")).unwrap();
    assert!(refusal("clear.png").contains("transparent"), "fully transparent");

    std::fs::write(at("empty.png"), "").unwrap();
    assert!(refusal("empty.png").contains("empty"), "no bytes");
    std::fs::write(at("text.png"), "hello").unwrap();
    assert!(refusal("text.png").contains("no image"), "not an image");
    std::fs::write(at("mesh.png"), b"glTF\x02\0\0\0").unwrap();
    assert!(refusal("mesh.png").contains("no image"), "a mesh");

    for name in ["cut.png", "cut.jpg", "cut.webp", "cut.tiff", "cut.bmp", "cut.tga", "cut.exr"] {
        let noise = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * y) as u8, (x * 31) as u8, (y * 17) as u8]));
        let whole = if name.ends_with("exr") { DynamicImage::from(noise).into_rgb32f().into() } else { DynamicImage::from(noise) };
        whole.save(at(name)).unwrap();
        let bytes = std::fs::read(at(name)).unwrap();
        std::fs::write(at(name), &bytes[..bytes.len() / 3]).unwrap();
        // Baseline decoders may show what there is of a JPEG; all else says that it is damaged.
        match read_exemplar(&at(name), &ExemplarOptions::default()) {
            Ok(_) => assert_eq!(name, "cut.jpg", "{name} is not read as if it were whole"),
            Err(e) => assert!(matches!(e, FormatError::Malformed { .. }), "{name}: {e:?}"),
        }
    }

    // A few bytes that declare 60000 x 60000 pixels, or 16384 x 16384 of four 16-bit components.
    for (name, side, depth) in [("bomb.png", 60_000_u32, [8, 2]), ("sixteen-k.png", 16_384, [16, 6])] {
        let mut header = [side.to_be_bytes(), side.to_be_bytes()].concat();
        header.extend(depth);
        header.extend([0, 0, 0]);
        std::fs::write(at(name), png(&[(b"IHDR", &header), (b"IDAT", &[0x78, 0x01])])).unwrap();
        let message = refusal(name);
        assert!(message.contains("pixels") && message.contains("scale it down"), "{message}");
    }
}

#[test]
fn a_single_pixel_is_an_exemplar() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dot.png");
    image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0])).save(&path).unwrap();
    assert_eq!(pixel(&read(&path).0, Channel::BaseColor, 0, 0), Vec3::X, "one pixel");
}

#[test]
fn light_is_evened_out_if_asked_for_and_that_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lit.png");
    image::RgbImage::from_fn(80, 60, |x, y| image::Rgb([120 + x as u8, 120 + x as u8, 90 + (y % 5) as u8])).save(&path).unwrap();
    let side = |exemplar: &Exemplar, x: i64| (0..60).map(|y| pixel(exemplar, Channel::BaseColor, x, y).x).sum::<f32>();
    let (as_it_is, told) = read_exemplar(&path, &ExemplarOptions::default()).unwrap();
    assert!(told.is_empty() && side(&as_it_is, 78) > 2.5 * side(&as_it_is, 1), "nobody asked: {told:?}");
    let even = ExemplarOptions { equalize: true, ..ExemplarOptions::default() };
    let (evened, told) = read_exemplar(&path, &even).unwrap();
    let ratio = side(&evened, 78) / side(&evened, 1);
    assert!((0.85..1.15).contains(&ratio), "left and right are as bright: {ratio}");
    assert!(told.len() == 1 && told[0].note && told[0].text.contains("evened out"), "{told:?}");
}
