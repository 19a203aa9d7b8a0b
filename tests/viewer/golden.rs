//! The main panels against pictures of them that are kept here, so that nothing changes its looks unseen.
//!
//! The pictures are a quarter of the window's size along each side, which leaves layout, colours and the texture, and forgives another
//! adapter its edges. `LAPPED_NEW_PICTURES=1` draws them anew; look at them then.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::Bench;
use egui::Key;
use image::imageops::{FilterType, resize};
use lapped::viewer::Mode;
use std::path::PathBuf;

const SIZE: [f32; 2] = [1280.0, 720.0];
/// Of the window's pixels so many along each side make one of a kept picture.
const SHRUNK: u32 = 4;
/// Steps of 255 by which pixels may differ on the mean, and beyond which one is another one.
const MEAN: f64 = 2.5;
const FAR: u8 = 48;
/// Share of the pixels that may be others: seconds are told in words, and adapters differ along edges.
const OTHERS: f64 = 0.02;

impl Bench {
    /// Compares the window with the picture kept under a name.
    fn looks_as_kept(&mut self, name: &str) -> Result<(), String> {
        self.harness.run_steps(3);
        let picture = self.picture(&format!("panel-{name}"));
        let small = resize(&picture, picture.width() / SHRUNK, picture.height() / SHRUNK, FilterType::Triangle);
        let kept = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/viewer/panels/{name}.png"));
        if std::env::var_os("LAPPED_NEW_PICTURES").is_some() {
            std::fs::create_dir_all(kept.parent().unwrap()).unwrap();
            image::DynamicImage::ImageRgba8(small).into_rgb8().save(kept).unwrap();
            return Ok(());
        }
        let kept = image::open(&kept).unwrap().into_rgba8();
        if kept.dimensions() != small.dimensions() {
            return Err(format!("{name}: {:?} became {:?}", kept.dimensions(), small.dimensions()));
        }
        let (mut sum, mut others) = (0.0, 0_usize);
        for (a, b) in kept.pixels().zip(small.pixels()) {
            let apart = a.0[..3].iter().zip(&b.0[..3]).map(|(a, b)| a.abs_diff(*b));
            sum += apart.clone().map(f64::from).sum::<f64>() / 3.0;
            others += usize::from(apart.max() > Some(FAR));
        }
        let all = kept.pixels().len() as f64;
        let (mean, share) = (sum / all, others as f64 / all);
        if mean > MEAN || share > OTHERS {
            return Err(format!("{name}: pixels differ by {mean:.2} on the mean, {:.2} % by more than {FAR}", 100.0 * share));
        }
        Ok(())
    }
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn the_main_panels_look_as_they_did() {
    let mut bench = Bench::new(SIZE, 1.0);
    bench.settle();
    let mut found = vec![bench.looks_as_kept("welcome")];
    bench.begin("vase", "bricks");
    // Times of frames are others every time.
    bench.app_mut().open_panels.figures = false;
    bench.settle();
    found.push(bench.looks_as_kept("textured"));
    bench.comb();
    found.push(bench.looks_as_kept("comb"));
    bench.key(Key::C);
    bench.key(Key::X);
    while !bench.app().cut.as_ref().is_some_and(|cut| cut.cutter().has_edges()) {
        bench.harness.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    found.push(bench.looks_as_kept("cut"));
    bench.key(Key::X);
    bench.key(Key::O);
    found.push(bench.looks_as_kept("watch"));
    bench.key(Key::O);
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 12_000);
    bench.app_mut().viewport.split = Some(0.5);
    bench.app_mut().viewport.modes = [Mode::Single, Mode::ChenDong];
    bench.settle();
    found.push(bench.looks_as_kept("synthesis"));
    bench.app_mut().viewport.split = None;
    bench.key(Key::F1);
    found.push(bench.looks_as_kept("help"));
    bench.key(Key::Escape);
    bench.key(Key::L);
    bench.settle();
    found.push(bench.looks_as_kept("light"));
    let others: Vec<String> = found.into_iter().filter_map(Result::err).collect();
    assert!(others.is_empty(), "{}; the window as it is lies in target/viewer", others.join("; "));
}
