//! Exemplars that change are read from animated files, numbered files and sheets, or refused in words.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use glam::{Vec2, Vec3};
use image::codecs::gif::GifEncoder;
use image::{Delay, Frame, Rgba, RgbaImage};
use lapped::exemplar::{Channel, Exemplar, FramesBy};
use lapped::format::{ExemplarOptions, FormatError, FrameOptions, FrameSource, Warning, read_exemplar};
use lapped::render::Picture;
use lapped::render::animation::Film;
use std::path::Path;

const SIZE: [u32; 2] = [12, 8];

/// A picture whose colours say which one it is.
fn picture(number: u8) -> RgbaImage {
    RgbaImage::from_fn(SIZE[0], SIZE[1], |x, y| Rgba([60 * number, 20 * x as u8, 30 * y as u8, 255]))
}

fn read(path: &Path, frames: FrameOptions) -> Result<(Exemplar, Vec<Warning>), FormatError> {
    read_exemplar(path, &ExemplarOptions { frames, ..ExemplarOptions::default() })
}

fn from(from: FrameSource) -> FrameOptions {
    FrameOptions { from, ..FrameOptions::default() }
}

/// Red of an exemplar's first pixel, as its file had it.
fn red(exemplar: &Exemplar) -> u8 {
    let color = exemplar.channel(Channel::BaseColor).unwrap().finest().bilinear(Vec2::splat(0.5));
    (lapped::exemplar::srgb::encode(color.x) * 255.0).round() as u8
}

fn apng(path: &Path, count: u8, per_second: u16) {
    let mut bytes = Vec::new();
    let mut film = Film::apng(&mut bytes, SIZE, u32::from(count), per_second).unwrap();
    for k in 0..count {
        let mut shown = Picture::filled(SIZE[0], SIZE[1], [0; 4]);
        shown.rgba = picture(k).into_raw();
        film.push(&shown).unwrap();
    }
    film.finish().unwrap();
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn animated_files_give_their_pictures_each_for_its_own_while() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fire.gif");
    let mut encoder = GifEncoder::new(std::fs::File::create(&path).unwrap());
    for (k, milliseconds) in [100, 300, 0].into_iter().enumerate() {
        // One colour a picture, which a palette holds exactly.
        let plain = RgbaImage::from_pixel(SIZE[0], SIZE[1], Rgba([60 * k as u8, 10, 200, 255]));
        encoder.encode_frame(Frame::from_parts(plain, 0, 0, Delay::from_numer_denom_ms(milliseconds, 1))).unwrap();
    }
    drop(encoder);
    let (fire, told) = read(&path, FrameOptions { per_second: Some(4.0), ..FrameOptions::default() }).unwrap();
    let frames = fire.frames().unwrap();
    assert_eq!((frames.by(), frames.count()), (FramesBy::Time, 3), "three pictures");
    assert_eq!(frames.seconds(), [0.1, 0.3, 0.25], "the last one does not say, so it takes the usual while");
    assert!(told.iter().any(|w| w.note && w.text.contains("3 frames")), "{told:?}");
    for (seconds, shown) in [(0.0, 0), (0.09, 0), (0.11, 60), (0.39, 60), (0.41, 120), (0.64, 120), (0.66, 0), (6.61, 60)] {
        assert_eq!(red(&fire.at(seconds)), shown, "at {seconds} s");
        assert!(fire.at(seconds).frames().is_none(), "what it is at a moment does not change");
    }

    let path = folder.path().join("fire.png");
    apng(&path, 4, 8);
    let (fire, _) = read(&path, FrameOptions::default()).unwrap();
    assert_eq!(fire.frames().unwrap().seconds(), [0.125; 4], "an animated PNG says so too");
    assert_eq!((0..5).map(|k| red(&fire.at(f64::from(k) * 0.125 + 0.01))).collect::<Vec<_>>(), [0, 60, 120, 180, 0], "in order");

    let (first, _) = read(&path, from(FrameSource::First)).unwrap();
    assert!(first.frames().is_none() && red(&first) == 0, "the first alone, if that is asked for");
}

#[test]
fn numbered_files_and_cells_of_a_sheet_are_frames() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    for k in 0..3_u8 {
        picture(k).save(file(&format!("wave_{:02}.png", k + 9))).unwrap();
    }
    picture(3).save(file("wave_13.png")).unwrap();
    let (wave, _) = read(&file("wave_09.png"), from(FrameSource::Sequence)).unwrap();
    assert_eq!(wave.frames().unwrap().count(), 3, "9, 10 and 11; 12 is missing");
    assert_eq!(wave.frames().unwrap().others().iter().map(red).collect::<Vec<_>>(), [60, 120], "in the order of their numbers");

    let sheet = RgbaImage::from_fn(2 * SIZE[0], 2 * SIZE[1], |x, y| {
        *picture((x / SIZE[0] + 2 * (y / SIZE[1])) as u8).get_pixel(x % SIZE[0], y % SIZE[1])
    });
    sheet.save(file("sheet.png")).unwrap();
    let options = FrameOptions { by: Some(FramesBy::View), ..from(FrameSource::Sprites([2, 2])) };
    let (cells, _) = read(&file("sheet.png"), options).unwrap();
    let frames = cells.frames().unwrap();
    assert_eq!(
        (cells.size(), frames.by(), frames.seconds().len()),
        (SIZE, FramesBy::View, 0),
        "of a cell's size, without durations"
    );
    for (k, frame) in std::iter::once(&cells).chain(frames.others()).enumerate() {
        let alone = file("alone.png");
        picture(k as u8).save(&alone).unwrap();
        let expected = read(&alone, FrameOptions::default()).unwrap().0;
        assert_eq!(
            frame.channel(Channel::BaseColor).unwrap().finest().data(),
            expected.channel(Channel::BaseColor).unwrap().finest().data(),
            "cell {k} row by row"
        );
    }
}

#[test]
fn what_is_no_animation_is_told_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    picture(1).save(file("still.png")).unwrap();
    picture(1).save(file("lone_7.png")).unwrap();
    RgbaImage::from_pixel(5, 5, Rgba([9; 4])).save(file("odd_2.png")).unwrap();
    picture(1).save(file("odd_1.png")).unwrap();
    apng(&file("cut.png"), 3, 12);
    let whole = std::fs::read(file("cut.png")).unwrap();
    std::fs::write(file("cut.png"), &whole[..whole.len() - 60]).unwrap();
    let by = |from| FrameOptions { by: Some(FramesBy::Light), from, ..FrameOptions::default() };
    for (name, options, told) in [
        ("still.png", by(FrameSource::File), "it holds one picture"),
        ("still.png", from(FrameSource::Sequence), "does not end in a number"),
        ("lone_7.png", from(FrameSource::Sequence), "lone_8.png after it"),
        ("odd_1.png", from(FrameSource::Sequence), "frame 2 is 5x5, the first 12x8"),
        ("still.png", from(FrameSource::Sprites([5, 2])), "no 5x2 cells of one size"),
        ("still.png", from(FrameSource::Sprites([0, 2])), "no 0x2 cells"),
        ("still.png", from(FrameSource::Sprites([1, 1])), "one cell has no frames"),
        ("cut.png", FrameOptions::default(), "cannot be decoded"),
    ] {
        let error = read(&file(name), options).unwrap_err().to_string();
        assert!(error.contains(told) && error.contains(name), "{name} says {told:?}: {error}");
    }
    let still = read(&file("still.png"), FrameOptions::default()).unwrap().0;
    assert!(still.frames().is_none(), "a still image is one");
}

#[test]
fn frames_that_do_not_belong_together_are_refused() {
    let plain = |w, h| Exemplar::new("e", lapped::exemplar::Image::from_fn(w, h, |_, _| Vec3::ONE));
    let mut grey = plain(4, 4);
    grey.set(Channel::Height, lapped::exemplar::Image::grey_from_fn(4, 4, |_, _| 0.5)).unwrap();
    for (others, seconds, told) in [
        (vec![], vec![], "only one frame"),
        (vec![plain(4, 5)], vec![1.0, 1.0], "frame 2 is 4x5"),
        (vec![plain(4, 4), grey], vec![1.0; 3], "frame 3 has baseColor, height"),
        (vec![plain(4, 4)], vec![1.0], "durations for 1 frames, not for 2"),
        (vec![plain(4, 4)], vec![1.0, 0.0], "shown for 0 seconds"),
        (vec![plain(4, 4)], vec![1.0, f64::NAN], "shown for NaN seconds"),
    ] {
        let error = plain(4, 4).set_frames(FramesBy::Time, others, seconds).unwrap_err().to_string();
        assert!(error.contains(told), "{told:?}: {error}");
    }
}

#[test]
fn names_of_a_sequence_may_have_dots_and_the_highest_number() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    picture(1).save(file("fire.v2_01.png")).unwrap();
    picture(2).save(file("fire.v2_02.png")).unwrap();
    let (fire, _) = read(&file("fire.v2_01.png"), from(FrameSource::Sequence)).unwrap();
    assert_eq!(fire.frames().unwrap().others().iter().map(red).collect::<Vec<_>>(), [120], "the dot stays in the name");
    let last = format!("x_{}.png", u64::MAX);
    picture(1).save(file(&last)).unwrap();
    let error = read(&file(&last), from(FrameSource::Sequence)).unwrap_err().to_string();
    assert!(error.contains("no number after it"), "{error}");
}

#[test]
fn frames_beyond_the_pixels_of_the_largest_image_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |k: u32| folder.path().join(format!("huge_{k:02}.png"));
    image::GrayImage::from_pixel(2048, 2048, image::Luma([9])).save(file(1)).unwrap();
    // Only the first is ever decoded.
    (2..=17).for_each(|k| std::fs::write(file(k), b"no image").unwrap());
    let error = read(&file(1), from(FrameSource::Sequence)).unwrap_err().to_string();
    assert!(error.contains("sequence of 17 of 2048 x 2048") && error.contains("megapixels"), "{error}");

    let path = folder.path().join("wide.gif");
    let mut gif = GifEncoder::new(std::fs::File::create(&path).unwrap());
    (0..2).for_each(|k| gif.encode_frame(Frame::new(RgbaImage::from_pixel(33_000, 1, Rgba([9 * k, 0, 0, 255])))).unwrap());
    drop(gif);
    let error = read(&path, FrameOptions::default()).unwrap_err().to_string();
    assert!(error.contains("pixels across"), "as wide as no still image may be: {error}");
}

#[test]
fn a_given_opacity_goes_before_that_of_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    apng(&file("fire.png"), 3, 8);
    image::GrayImage::from_pixel(SIZE[0], SIZE[1], image::Luma([51])).save(file("holes.png")).unwrap();
    let channels = [(Channel::Opacity, file("holes.png"))].into();
    let (fire, _) = read_exemplar(&file("fire.png"), &ExemplarOptions { channels, ..ExemplarOptions::default() }).unwrap();
    let frames = fire.frames().unwrap();
    for (k, frame) in std::iter::once(&fire).chain(frames.others()).enumerate() {
        let opacity = frame.channel(Channel::Opacity).unwrap().finest().data();
        assert!(opacity.iter().all(|a| (a - 0.2).abs() < 1e-6), "frame {k}: {}", opacity[0]);
    }
}

/// The checksum of a PNG's chunks.
fn crc(bytes: &[u8]) -> u32 {
    let bit = |c: u32| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &b| (0..8).fold(crc ^ u32::from(b), |c, _| bit(c)))
}

#[test]
fn pictures_of_an_animation_are_turned_as_their_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.png");
    apng(&path, 2, 8);
    let mut bytes = std::fs::read(&path).unwrap();
    // Orientation 6: a quarter turn. It goes behind the header's chunk.
    let mut chunk = b"eXIfMM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
    let sum = crc(&chunk);
    let length = (chunk.len() as u32 - 4).to_be_bytes();
    chunk.extend(sum.to_be_bytes());
    bytes.splice(33..33, length.into_iter().chain(chunk));
    std::fs::write(&path, bytes).unwrap();
    let (still, _) = read(&path, from(FrameSource::First)).unwrap();
    assert_eq!(still.size(), [SIZE[1], SIZE[0]], "as a still image is turned");
    let (moving, _) = read(&path, FrameOptions::default()).unwrap();
    assert_eq!(moving.size(), still.size());
    let colors = |e: &Exemplar| e.channel(Channel::BaseColor).unwrap().finest().data().to_vec();
    assert_eq!(colors(&moving), colors(&still), "pixel by pixel");
}

#[test]
fn frames_a_second_that_change_nothing_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    apng(&file("fire.png"), 2, 8);
    picture(1).save(file("still.png")).unwrap();
    let fps = |from| FrameOptions { per_second: Some(4.0), from, ..FrameOptions::default() };
    let told = |name: &str, options| {
        let (_, warnings) = read(&file(name), options).unwrap();
        warnings.into_iter().filter(|w| !w.note && w.text.contains("change nothing")).map(|w| w.text).collect::<Vec<_>>().join(" ")
    };
    assert!(told("still.png", fps(FrameSource::File)).contains("one picture"));
    assert!(told("fire.png", fps(FrameSource::File)).contains("how long each frame is shown"));
    assert!(told("fire.png", fps(FrameSource::First)).contains("only its first frame"));
    let by_view = FrameOptions { by: Some(FramesBy::View), ..fps(FrameSource::Sprites([2, 1])) };
    assert!(told("still.png", by_view).contains("do not go by time"));
    assert_eq!(told("still.png", fps(FrameSource::Sprites([2, 1]))), "", "they say how long cells are shown");
}

#[test]
fn a_channel_that_is_added_reaches_all_frames() {
    let plain = |v| Exemplar::new("e", lapped::exemplar::Image::from_fn(4, 4, |_, _| Vec3::splat(v)));
    let mut moving = plain(0.0);
    moving.set_frames(FramesBy::View, vec![plain(0.5), plain(1.0)], Vec::new()).unwrap();
    moving.set(Channel::Height, lapped::exemplar::Image::grey_from_fn(4, 4, |_, _| 0.5)).unwrap();
    assert!(moving.frames().unwrap().others().iter().all(|e| e.channels() == moving.channels()), "frames keep alike");
    let told = plain(0.0).set_frames(FramesBy::Time, vec![plain(1.0)], vec![f64::MAX; 2]).unwrap_err().to_string();
    assert!(told.contains("without end"), "{told}");
}
