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
    let (fire, told) = read(&path, FrameOptions { per_second: 4.0, ..FrameOptions::default() }).unwrap();
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
