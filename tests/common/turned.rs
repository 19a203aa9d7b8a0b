//! A paste whose content is turned, and the same content turned beforehand.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use glam::{Vec2, Vec3};
use lapped::exemplar::{Channel, Exemplar, Hull, Image, MipChain, TexturePatch};
use lapped::paste::{AGREES, LappedTexture, Paste, Turn};

const SIDE: u32 = 64;

fn wave(x: f32, y: f32) -> Vec3 {
    Vec3::new((0.31 * x).sin(), (0.23 * y + 0.4 * (0.17 * x).cos()).sin(), (0.11 * (x - 2.0 * y)).cos())
}

/// An exemplar with all that turns: colour, normals, relief; seen as it is, or after it was turned by a quarter itself.
pub(crate) fn waves(turned: bool) -> Exemplar {
    // A quarter of a turn takes what is seen right of the middle from below it.
    let from = |x: u32, y: u32| if turned { ((SIDE - 1 - y) as f32, x as f32) } else { (x as f32, y as f32) };
    let normal = move |x: u32, y: u32| {
        let (x, y) = from(x, y);
        let n = (wave(y, x) + Vec3::new(0.0, 0.0, 3.0)).normalize();
        if turned { Vec3::new(-n.y, n.x, n.z) } else { n }
    };
    let mut exemplar = Exemplar::new("waves", Image::from_fn(SIDE, SIDE, |x, y| wave(from(x, y).0, from(x, y).1) * 0.4 + 0.5));
    exemplar.set(Channel::Normal, Image::from_fn(SIDE, SIDE, normal)).unwrap();
    let height = |x: u32, y: u32| 0.5 + 0.5 * wave(from(x, y).0, from(x, y).1).x;
    exemplar.set(Channel::Height, Image::grey_from_fn(SIDE, SIDE, height)).unwrap();
    exemplar
}

/// One paste all over a sheet of two faces, which lies askew on its mask.
pub(crate) fn one_paste(exemplar: Exemplar, turn: Turn) -> LappedTexture {
    let patch = TexturePatch {
        exemplar: 0,
        origin: [0, 0],
        mask: MipChain::new(Image::grey_from_fn(SIDE, SIDE, |_, _| 1.0)),
        hull: Hull::new(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]),
        centre: Vec2::splat(0.5 * SIDE as f32),
        weight: 1.0,
        slides: true,
    };
    let place = |x: f32, y: f32| Vec2::new(0.3, 0.25) + x * Vec2::new(0.4, 0.07) + y * Vec2::new(-0.09, 0.5);
    let uv = vec![[place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0)], [place(0.0, 0.0), place(1.0, 1.0), place(0.0, 1.0)]];
    let paste = Paste { patch: 0, faces: vec![0, 1], uv, offset: Vec2::ZERO, turn, cut: None, agreement: AGREES };
    LappedTexture { exemplars: vec![exemplar], patches: vec![patch], pastes: vec![paste], layers: Vec::new() }
}
