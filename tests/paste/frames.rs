//! An exemplar that changes lies under pastes that its first frame decides.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{Points, sheet};
use glam::Vec3;
use lapped::exemplar::{Channel, Exemplar, FramesBy, Image};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, paste_model};
use lapped::paste::Composite;
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::surface::{Sight, SurfaceTexture};

/// Blobs of greys below one half of red, green or blue.
fn blobs(channel: usize) -> Exemplar {
    let mut random = Random::new(4, 0);
    let greys: Vec<f32> = (0..16 * 16).map(|_| random.range(0.1, 0.5) as f32).collect();
    let pixel = |x: u32, y: u32| Vec3::AXES[channel] * greys[(y / 4 * 16 + x / 4) as usize];
    Exemplar::new("blobs", Image::from_fn(64, 64, pixel))
}

/// Red first, then green, then blue.
fn changing(by: FramesBy) -> Exemplar {
    let seconds = if by == FramesBy::Time { vec![0.5; 3] } else { Vec::new() };
    let mut exemplar = blobs(0);
    exemplar.set_frames(by, vec![blobs(1), blobs(2)], seconds).unwrap();
    exemplar
}

fn pasted(exemplar: Exemplar) -> Pasted {
    let job = PasteJob { scale: Scale::World(0.5), ..PasteJob::default() };
    paste_model(&sheet(16, 2.0), vec![ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() }], &job, &Silent).unwrap()
}

#[test]
fn time_changes_what_is_shown_and_no_paste() {
    let [still, moving] = [blobs(0), changing(FramesBy::Time)].map(pasted);
    assert_eq!(still.lapped.pastes, moving.lapped.pastes, "pastes are the first frame's");
    let (mesh, points) = (&moving.mesh, Points::new(&moving.mesh).list(2000));
    let first = Composite::new(mesh, &still.lapped);
    for (seconds, channel) in [(0.0, 0), (0.6, 1), (1.4, 2), (1.6, 0)] {
        let now = Composite::new(mesh, &moving.lapped).with_time(seconds);
        for &at in &points {
            let (red, shown) = (first.texel(at, 0.01).base_color.x, now.texel(at, 0.01).base_color);
            assert!(shown.distance(Vec3::AXES[channel] * red) < 1e-6, "at {seconds} s {shown} stands where {red} is at first");
        }
    }
}

#[test]
fn view_and_light_mix_the_frames_next_to_their_angle() {
    for by in [FramesBy::View, FramesBy::Light] {
        let made = pasted(changing(by));
        let composite = Composite::new(&made.mesh, &made.lapped);
        for at in Points::new(&made.mesh).list(50) {
            let normal = made.mesh.normal(at.face).as_vec3();
            let aside = normal.any_orthonormal_vector();
            let grey = composite.texel(at, 0.01).base_color;
            assert!(grey.y == 0.0 && grey.z == 0.0, "from nowhere it is the first frame: {grey}");
            // Degrees from the normal, and the shares of the three frames there.
            for (degrees, shares) in
                [(0.0, [1.0, 0.0, 0.0]), (22.5, [0.5, 0.5, 0.0]), (45.0, [0.0, 1.0, 0.0]), (90.0, [0.0, 0.0, 1.0])]
            {
                let angle = f32::to_radians(degrees);
                for side in [1.0, -1.0] {
                    let towards = side * (normal * angle.cos() + aside * angle.sin());
                    let sight = match by {
                        FramesBy::Light => Sight { to_eye: side * normal, to_light: towards },
                        _ => Sight { to_eye: towards, to_light: -towards },
                    };
                    let shown = composite.texel_seen(at, 0.01, &sight).base_color;
                    let expected = Vec3::from(shares) * grey.x;
                    assert!(shown.distance(expected) < 2e-3, "{by:?} {degrees} degrees on side {side}: {shown}, not {expected}");
                }
            }
            let behind = Sight { to_eye: normal, to_light: -normal };
            let last = composite.texel_seen(at, 0.01, &behind).base_color;
            assert_eq!(last.z > 0.0, by == FramesBy::Light, "light from behind grazes at most: {last}");
        }
    }
}

#[test]
fn transparent_frames_take_the_colours_around_them() {
    // Half of the second frame is clear, over black.
    let mut first = blobs(0);
    first.set(Channel::Opacity, Image::grey_from_fn(64, 64, |_, _| 1.0)).unwrap();
    let clear = |x: u32| x >= 32;
    let color = Image::from_fn(64, 64, |x, _| if clear(x) { Vec3::ZERO } else { Vec3::Y });
    let mut second = Exemplar::new("half", color);
    second.set(Channel::Opacity, Image::grey_from_fn(64, 64, |x, _| f32::from(!clear(x)))).unwrap();
    first.set_frames(FramesBy::Time, vec![second], vec![1.0, 1.0]).unwrap();
    lapped::exemplar::extend::extend_exemplar(&mut first).unwrap();
    let later = first.at(1.5);
    let green = later.channel(Channel::BaseColor).unwrap().finest();
    assert!(green.pixel(33, 5).y > 0.9, "no black is drawn in: {}", green.pixel(33, 5));
}
