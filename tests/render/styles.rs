//! The preview styles on surfaces where every figure is known.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use crate::common::{flat, plain};
use glam::{DVec2, Vec2, Vec3};
use lapped::exemplar::{Exemplar, Hull, Image, MipChain, TexturePatch};
use lapped::field::{Guide, TangentField};
use lapped::mesh::Mesh;
use lapped::paste::{AGREES, LappedTexture, Paste, Turn};
use lapped::render::{Background, Picture, PreviewStyle, RenderError, SheetOptions, Subject, View, preview};

/// The field whose texture is `scale` units wide with +y up.
fn field(mesh: &Mesh, scale: f32) -> Guide {
    Guide::Directed(TangentField::along(vec![Vec3::Y * scale; mesh.face_count()]))
}

/// Pastes of a round mask that covers two units of the plane from one end to the other, at the given places and widths.
fn pasted(mesh: &Mesh, at: &[(Vec2, f32)]) -> LappedTexture {
    let mask = Image::grey_from_fn(64, 64, |x, y| {
        let distance = (Vec2::new(x as f32, y as f32) - 31.5).length();
        (30.0 - distance).clamp(0.0, 1.0)
    });
    let exemplar = Exemplar::new("plain", Image::from_fn(64, 64, |_, _| Vec3::splat(0.5)));
    let patch = TexturePatch {
        exemplar: 0,
        origin: [0, 0],
        mask: MipChain::mask(mask),
        hull: Hull::new(vec![Vec2::ZERO, Vec2::new(0.0, 64.0), Vec2::splat(64.0), Vec2::new(64.0, 0.0)]),
        centre: Vec2::splat(32.0),
        weight: 1.0,
        slides: false,
    };
    let paste = |&(middle, width): &(Vec2, f32)| {
        let uv = |v: u32| {
            let from = (mesh.positions[v as usize].truncate() - middle) / width;
            Vec2::new(0.5 + from.x, 0.5 - from.y)
        };
        let faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
        Paste {
            patch: 0,
            uv: mesh.faces.iter().map(|f| f.map(uv)).collect(),
            faces,
            offset: Vec2::ZERO,
            turn: Turn::NONE,
            cut: None,
            agreement: AGREES,
        }
    };
    LappedTexture {
        exemplars: vec![exemplar],
        patches: vec![patch],
        pastes: at.iter().map(paste).collect(),
        ..LappedTexture::default()
    }
}

/// One view from the front, 100 pixels for 2.15 units.
fn show(mesh: &Mesh, lapped: &LappedTexture, guide: &Guide, style: PreviewStyle) -> Picture {
    let view: View = "front,fov=0".parse().unwrap();
    let mut options = SheetOptions { views: vec![(String::new(), view)], size: [100, 100], samples: 2, ..SheetOptions::default() };
    options.draw.background = Background::Transparent;
    let texture = plain(mesh, Vec3::splat(0.5));
    let subject = Subject { mesh, texture: &texture, lapped: Some(lapped), guide: Some(guide) };
    preview(&subject, style, &options).unwrap()
}

/// Pixel of a place on the plane.
fn at(picture: &Picture, x: f64, y: f64) -> [i32; 3] {
    let p = DVec2::new(x, -y) * 46.5 + 50.0;
    let [r, g, b, _] = picture.pixel(p.x as u32, p.y as u32);
    [r, g, b].map(i32::from)
}

fn is_alarm([r, g, b]: [i32; 3]) -> bool {
    r > 180 && g < 90 && b > 90
}

fn spread([r, g, b]: [i32; 3]) -> i32 {
    r.max(g).max(b) - r.min(g).min(b)
}

#[test]
fn an_exact_paste_is_neutral_a_squeezed_one_warm_a_drawn_out_one_cool() {
    let mesh = flat(8);
    let guide = field(&mesh, 2.0);
    let middle = |width: f32| at(&show(&mesh, &pasted(&mesh, &[(Vec2::ZERO, width)]), &guide, PreviewStyle::Stretch), 0.1, 0.2);
    assert!(spread(middle(2.0)) < 12, "as asked: {:?}", middle(2.0));
    let (squeezed, drawn) = (middle(1.4), middle(2.8));
    assert!(squeezed[0] > squeezed[2] + 40, "squeezed is warm: {squeezed:?}");
    assert!(drawn[2] > drawn[0] + 40, "drawn out is cool: {drawn:?}");
    let mut mirrored = pasted(&mesh, &[(Vec2::ZERO, 2.0)]);
    for corner in mirrored.pastes[0].uv.iter_mut().flatten() {
        corner.x = 1.0 - corner.x;
    }
    let flipped = at(&show(&mesh, &mirrored, &guide, PreviewStyle::Stretch), 0.1, 0.2);
    assert!(is_alarm(flipped), "a mirrored paste is marked: {flipped:?}");
}

#[test]
fn coverage_shows_bare_surface_and_counts_draws() {
    let mesh = flat(8);
    let guide = field(&mesh, 2.0);
    let picture = |n: usize| show(&mesh, &pasted(&mesh, &vec![(Vec2::ZERO, 2.0); n]), &guide, PreviewStyle::Coverage);
    let brightness: Vec<i32> = (1..9).map(|n| at(&picture(n), 0.1, 0.2).iter().sum()).collect();
    let darker = brightness.windows(2).all(|w| w[1] < w[0]);
    assert!(darker, "more draws are darker: {brightness:?}");
    let one = picture(1);
    // The mask reaches 30 of 32 pixels from the middle: 0.9375 units.
    for (x, y, bare) in [(0.9, 0.0, false), (0.97, 0.0, true), (0.8, 0.8, true), (0.6, 0.6, false)] {
        assert_eq!(is_alarm(at(&one, x, y)), bare, "bare at {x} {y}: {:?}", at(&one, x, y));
    }
}

#[test]
fn pastes_have_colours_of_their_own_and_outlines_only_where_the_topmost_changes() {
    let mesh = flat(8);
    let lapped = pasted(&mesh, &[(Vec2::ZERO, 2.0), (Vec2::new(0.5, 0.0), 0.8)]);
    let picture = show(&mesh, &lapped, &field(&mesh, 2.0), PreviewStyle::Pastes);
    let (below, above) = (at(&picture, -0.5, 0.0), at(&picture, 0.5, 0.0));
    let difference: i32 = (0..3).map(|k| (below[k] - above[k]).abs()).sum();
    assert!(difference > 60, "two colours: {below:?} and {above:?}");
    assert!(spread(at(&picture, 0.8, 0.8)) < 12, "grey where there is none");
    // The upper paste's rim is 30/64 of its width from its middle; the row through it crosses the rim twice.
    let dark = |x: i32| at(&picture, f64::from(x) / 46.5, 0.0).iter().sum::<i32>() < 260;
    let crossings: Vec<i32> = (-40..42).filter(|&x| dark(x) && !dark(x - 1)).collect();
    let expected = [0.5 - 0.375, 0.5 + 0.375].map(|x| 46.5 * x);
    assert_eq!(crossings.len(), 2, "two outlines in the row: {crossings:?}");
    for (found, expected) in crossings.iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() < 2.5, "outline at {found}, rim at {expected}");
    }
}

#[test]
fn wires_lie_on_the_edges() {
    let mesh = flat(4);
    let picture = show(&mesh, &LappedTexture::default(), &field(&mesh, 1.0), PreviewStyle::Wireframe);
    let brightness = |x, y| at(&picture, x, y).iter().sum::<i32>();
    for (x, y) in [(0.0, 0.2), (0.5, -0.3), (-0.3, 0.0), (0.25, 0.25)] {
        assert!(brightness(x, y) < 560, "a line at {x} {y}: {}", brightness(x, y));
    }
    for (x, y) in [(0.17, 0.33), (-0.33, -0.17), (0.83, -0.33)] {
        assert!(brightness(x, y) > 620, "no line at {x} {y}: {}", brightness(x, y));
    }
}

#[test]
fn a_style_without_its_data_says_what_is_missing() {
    let mesh = flat(1);
    let texture = plain(&mesh, Vec3::splat(0.5));
    let isotropic = Guide::Isotropic { scale: vec![1.0; mesh.face_count()] };
    let subject = Subject { mesh: &mesh, texture: &texture, lapped: None, guide: Some(&isotropic) };
    let options = SheetOptions { size: [32, 32], samples: 1, ..SheetOptions::default() };
    for style in PreviewStyle::ALL {
        let result = preview(&subject, style, &options);
        let needs = !matches!(style, PreviewStyle::Texture | PreviewStyle::Wireframe);
        assert_eq!(matches!(result, Err(RenderError::Missing { .. })), needs, "{style}");
        assert_eq!(style.name().parse(), Ok(style), "its name reads back");
    }
    assert!("plaid".parse::<PreviewStyle>().unwrap_err().to_string().contains("wireframe"), "the names are listed");
}
