//! Frames for views that somebody else owns, as a window's are.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use crate::common::{compare, pasted, renderers};
use glam::Vec3;
use lapped::render::gpu::{GpuError, Path, Screen, read_pixels};
use lapped::render::{Background, DrawOptions, Grid, Picture, Stage, View};
use wgpu::TextureFormat::{Rgba8Unorm, Rgba8UnormSrgb};

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn frames_on_any_view_look_like_the_picture_at_every_size() {
    let pasted = pasted("vase", &["bricks"], 30.0, true);
    let colour = Vec3::new(0.1, 0.2, 0.3);
    let options = DrawOptions { occlusion: false, background: Background::Plain(colour), ..DrawOptions::default() };
    let stage = Stage::new(&pasted.mesh, &options);
    for renderer in renderers() {
        let device = &renderer.gpu().device;
        let subject = renderer.load(&stage, &pasted.lapped).unwrap();
        for (format, samples) in [(Rgba8UnormSrgb, 4), (Rgba8Unorm, 4), (Rgba8UnormSrgb, 1)] {
            let mut screen = Screen::new(renderer, format, samples).unwrap();
            let shown = if format.is_srgb() { colour } else { Vec3::from(colour.to_array().map(lapped::exemplar::srgb::encode)) };
            let [r, g, b] = shown.to_array().map(f64::from);
            // A window that is resized, minimised and shown again.
            for size in [[120, 90], [64, 128], [0, 0], [64, 0], [120, 90]] {
                let texture = device.create_texture(&wgpu::TextureDescriptor {
                    label: None,
                    size: wgpu::Extent3d { width: size[0].max(1), height: size[1].max(1), depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                });
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
                let camera = View::default().frame(&pasted.mesh, aspect);
                let seen = renderer.see(&subject, &camera, size, &options, None);
                let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let behind = wgpu::Color { r, g, b, a: 1.0 };
                screen.draw(&mut encoder, &view, size, behind, &[(&subject, &seen)]).unwrap();
                renderer.gpu().queue.submit([encoder.finish()]);
                renderer.gpu().wait().unwrap();
                if size.contains(&0) {
                    continue;
                }
                let rgba = read_pixels(renderer.gpu(), &texture).unwrap();
                let drawn = Picture { width: size[0], height: size[1], rgba };
                let grid = Grid { width: size[0], height: size[1], samples: if samples > 1 { 2 } else { 1 } };
                let expected = renderer.draw(&subject, &stage, &camera, grid, Path::Single).unwrap();
                let found = compare(&pasted.mesh, &camera, grid, &expected, &drawn);
                // Of several samples a pixel only outlines are taken: inside, the texture is shaded once.
                let [inside, outline] = if samples > 1 { [8.0, 16.0] } else { [0.5, 1.0] };
                assert!(
                    found.inside < inside && found.outline < outline && found.outside < 0.5,
                    "{format:?} x{samples}: {found:?}"
                );
            }
        }
        assert!(matches!(Screen::new(renderer, Rgba8Unorm, 3), Err(GpuError::Refused { .. })), "three samples a pixel are refused");
        let mut screen = Screen::new(renderer, Rgba8Unorm, 1).unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let huge = screen.draw(&mut encoder, &view, [1 << 20, 4], wgpu::Color::BLACK, &[]);
        assert!(matches!(huge, Err(GpuError::Limit { .. })), "and a window beyond all limits");
        assert_eq!(renderer.gpu().check(), Ok(()), "nothing else was refused");
    }
}
