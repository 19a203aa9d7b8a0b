//! A lapped texture in somebody else's frame: a program with its own device, targets and pass loads a record and draws it
//! among its own things.
//!
//! `cargo run --example embed -- bunny.glb frame.png`

use anyhow::Context;
use lapped::format::read_record;
use lapped::job::Bound;
use lapped::render::gpu::{Forward, Gpu, Renderer, RendererOptions, wgpu};
use lapped::render::{DrawOptions, Picture, Stage, View};
use std::path::Path;

const SIZE: [u32; 2] = [1024, 768];
const SAMPLES: u32 = 4;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let (record, out) = args.next().zip(args.next()).context("usage: embed RECORD.glb FRAME.png")?;

    // What the program has anyway: a device, and targets of its own.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(
        adapter.request_device(&wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() }),
    )?;
    let target = |format, samples, usage| {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
            view_formats: &[],
        });
        (texture.create_view(&wgpu::TextureViewDescriptor::default()), texture)
    };
    let color = wgpu::TextureFormat::Rgba8UnormSrgb;
    let (frame, frame_texture) = target(color, 1, wgpu::TextureUsages::COPY_SRC);
    let (samples, _) = target(color, SAMPLES, wgpu::TextureUsages::empty());
    let (depth, _) = target(wgpu::TextureFormat::Depth32Float, SAMPLES, wgpu::TextureUsages::empty());

    // Once: the record on the device.
    let bound = Bound::new(read_record(Path::new(&record))?)?;
    let options = DrawOptions::default();
    let stage = Stage::new(&bound.mesh, &options);
    let renderer = Renderer::new(Gpu::from_device(device.clone(), queue.clone()), RendererOptions::default())?;
    let forward = Forward::new(&renderer, color, wgpu::TextureFormat::Depth32Float, SAMPLES)?;
    let subject = renderer.load(&stage, &bound.lapped)?;

    // Each frame: a camera, and one call in a pass that may draw other things before and after.
    let camera = View::default().frame(&bound.mesh, f64::from(SIZE[0]) / f64::from(SIZE[1]));
    let seen = renderer.see(&subject, &camera, SIZE, &options, None);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let sky = wgpu::Color { r: 0.1, g: 0.2, b: 0.4, a: 1.0 };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &samples,
                depth_slice: None,
                resolve_target: Some(&frame),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(sky), store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        forward.draw(&mut pass, &subject, &seen);
    }
    queue.submit([encoder.finish()]);

    // Instead of a window: the frame in a file.
    let rgba = lapped::render::gpu::read_pixels(renderer.gpu(), &frame_texture)?;
    std::fs::write(out, Picture { width: SIZE[0], height: SIZE[1], rgba }.png()?)?;
    Ok(())
}
