//! Frames of lapped textures on a graphics adapter: `single` and `layered` over a plain draw with one texture, the same
//! mesh, camera, light and size; and the memory of records against an atlas of equal sampling density.
//!
//! `cargo bench --bench render` runs tori of about 500 (three draws a face), 5k, 70k and 1M faces at 1080p and 4K. Words after `--` choose the
//! adapter (as `lapped inspect --gpu` names them).

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

use anyhow::Context;
use glam::{DVec3, Vec3};
use lapped::assets::exemplar;
use lapped::format::Model;
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::progress::Silent;
use lapped::render::gpu::{Canvas, Gpu, GpuOptions, Path, Renderer, RendererOptions, shaders};
use lapped::render::{Camera, DrawOptions, Lighting, Projection, Stage, View};
use std::f32::consts::TAU;
use std::time::Instant;
use wgpu::util::DeviceExt;

/// Surface area over exemplar area.
const RATIO: f64 = 60.0;
/// Sides of the tori: 2 n^2 faces each.
const SIDES: [usize; 4] = [16, 50, 187, 707];
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// Frames of which the median is told.
const FRAMES: usize = 7;
/// What an atlas's charts leave unused, commonly.
const ATLAS_FILL: f64 = 0.7;

/// A plain mesh with one texture, lit as ours.
const PLAIN: &str = "
struct PlainCorner { @builtin(position) position: vec4f, @location(0) at: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f }
@group(0) @binding(3) var image: texture_2d<f32>;
@group(0) @binding(4) var smoothly: sampler;
@vertex fn vertex(@location(0) at: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f) -> PlainCorner {
    let off = at - frame.eye;
    let view = vec3f(dot(off, frame.right), dot(off, frame.up), dot(off, frame.forward));
    return PlainCorner(vec4f(view.xy * frame.clip.xy, frame.depth.x * view.z + frame.depth.y, view.z), at, normal, uv);
}
@fragment fn fragment(in: PlainCorner) -> @location(0) vec4f {
    let base = textureSample(image, smoothly, in.uv).xyz;
    let n = normalize(in.normal);
    return vec4f(tone(shade(base, 0.7, 0.0, PLAIN, 1.0, n, n, normalize(frame.eye - in.at))), 1.0);
}
";

fn torus(n: usize) -> Model {
    let point = |i: usize, j: usize| {
        let (a, b) = (TAU * i as f32 / n as f32, TAU * j as f32 / n as f32);
        let r = 0.4 + 0.05 * (3.0 * a).sin() * (2.0 * b).cos() + 0.02 * (9.0 * a + 5.0 * b).sin();
        Vec3::new((1.0 + r * b.cos()) * a.cos(), r * b.sin(), (1.0 + r * b.cos()) * a.sin())
    };
    let positions = (0..n).flat_map(|i| (0..n).map(move |j| point(i, j))).collect();
    let v = |i: usize, j: usize| ((i % n) * n + j % n) as u32;
    let faces = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[v(i, j), v(i, j + 1), v(i + 1, j)], [v(i + 1, j + 1), v(i + 1, j), v(i, j + 1)]])
        .collect();
    Model { name: format!("torus {n}"), positions, faces, ..Model::default() }
}

fn pasted(n: usize) -> anyhow::Result<Pasted> {
    let input = ExemplarInput { exemplar: exemplar("leaves")?, weight: 1.0, patches: Vec::new() };
    let job = PasteJob { scale: Scale::Ratio(RATIO), steer: Steer::Up(DVec3::Y), ..PasteJob::default() };
    Ok(paste_model(&torus(n), vec![input], &job, &Silent)?)
}

/// Milliseconds of the median frame.
fn time(gpu: &Gpu, mut frame: impl FnMut(&mut wgpu::CommandEncoder)) -> anyhow::Result<f64> {
    let mut times = Vec::new();
    for k in 0..=FRAMES {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        frame(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        // The first frame compiles shaders.
        if k > 0 {
            times.push(1e3 * start.elapsed().as_secs_f64());
        }
    }
    times.sort_by(f64::total_cmp);
    Ok(times[FRAMES / 2])
}

/// The plain draw of a mesh: pipeline, bindings, vertices, indices.
struct Plain {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

impl Plain {
    fn new(gpu: &Gpu, stage: &Stage<'_>, camera: &Camera, size: [u32; 2]) -> anyhow::Result<Self> {
        let device = &gpu.device;
        let text = [shaders::FRAME, shaders::SHADE, PLAIN].concat();
        let module = device
            .create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(text.into()) });
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2];
        let layout =
            wgpu::VertexBufferLayout { array_stride: 32, step_mode: wgpu::VertexStepMode::Vertex, attributes: &attributes };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("plain"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[Some(layout)],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba16Float.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let mesh = stage.mesh;
        let normals = mesh.vertex_normals();
        // Any map will do: the texture once over 1/RATIO of the surface, as the exemplar is.
        let repeat = (mesh.total_area() / RATIO).sqrt() as f32;
        let vertices: Vec<f32> = mesh
            .positions
            .iter()
            .zip(&normals)
            .flat_map(|(p, n)| [p.x, p.y, p.z, n.x, n.y, n.z, (p.x + 0.5 * p.z) / repeat, (p.y + 0.5 * p.z) / repeat])
            .collect();
        let buffer =
            |contents: &[u8], usage| device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage });
        let uniform = buffer(bytemuck::cast_slice(&frame_words(camera, size)), wgpu::BufferUsages::UNIFORM);
        let chain = exemplar("leaves")?;
        let [w, h] = chain.size();
        let image = device.create_texture_with_data(
            &gpu.queue,
            &wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: w, height: h, depth_or_array_layers: 1 },
                mip_level_count: w.max(h).ilog2() + 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8UnormSrgb,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::MipMajor,
            // Its pixels do not matter here, their number does.
            &(0..w.max(h).ilog2() + 1)
                .flat_map(|l| vec![120; 4 * ((w >> l).max(1) * (h >> l).max(1)) as usize])
                .collect::<Vec<u8>>(),
        );
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let view = image.create_view(&Default::default());
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 4, resource: wgpu::BindingResource::Sampler(&sampler) },
            ],
        });
        Ok(Self {
            pipeline,
            bindings,
            vertices: buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(&mesh.faces), wgpu::BufferUsages::INDEX),
            count: 3 * mesh.face_count() as u32,
        })
    }
}

/// `Frame` of shaders/frame.wgsl, as far as the plain draw reads it.
fn frame_words(camera: &Camera, [width, height]: [u32; 2]) -> Vec<f32> {
    let Projection::Perspective(tangent) = camera.projection else { return vec![0.0; 84] };
    let mut out = Vec::new();
    let mut row = |v: DVec3, w: f64| out.extend([v.x as f32, v.y as f32, v.z as f32, w as f32]);
    let axes = [camera.right, camera.up, camera.forward];
    axes.iter().for_each(|&axis| row(axis, 1.0));
    row(camera.eye, 0.0);
    row(camera.world_up, 0.0);
    row(DVec3::ZERO, 0.0);
    let (near, far) = (0.1, 100.0);
    row(DVec3::new(f64::from(height) / f64::from(width) / tangent, 1.0 / tangent, 0.0), 0.0);
    row(DVec3::new(far / (far - near), -far * near / (far - near), 0.0), 0.0);
    row(DVec3::ZERO, 0.0);
    let lighting = Lighting::studio();
    for lamp in lighting.lamps {
        let t = lamp.towards.as_dvec3();
        row(axes[0] * t.x + axes[1] * t.y - axes[2] * t.z, 0.0);
        row(lamp.light.as_dvec3(), 0.0);
    }
    row(lighting.sky.as_dvec3(), 0.0);
    row(lighting.ground.as_dvec3(), 0.0);
    out.resize(84, 0.0);
    out
}

fn main() -> anyhow::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let gpu = Gpu::new(&GpuOptions { adapter: words.first().cloned(), limits: None })?;
    println!("{}", gpu.adapter());
    println!("| faces | draws per face | size | plain | single | layered | single / plain | layered / plain |");
    println!("|---|---|---|---|---|---|---|---|");
    let renderer = Renderer::new(gpu.clone(), RendererOptions::default())?;
    let options = DrawOptions { occlusion: false, ..DrawOptions::default() };
    let mut memory = Vec::new();
    for n in SIDES {
        let Pasted { mesh, lapped, .. } = pasted(n)?;
        let stage = Stage::new(&mesh, &options);
        let subject = renderer.load(&stage, &lapped)?;
        let entries: usize = lapped.pastes.iter().map(|p| p.faces.len()).sum();
        let draws = entries as f64 / mesh.face_count() as f64;
        for size in SIZES {
            let camera = View::default().frame(&mesh, f64::from(size[0]) / f64::from(size[1]));
            let seen = renderer.see(&subject, &camera, size, &options, None);
            let canvases = [Path::Single, Path::Layered].map(|path| Canvas::new(&renderer, &subject, size, path));
            let plain = Plain::new(&gpu, &stage, &camera, size)?;
            let color = canvases[0].as_ref().ok().context("a canvas")?.view().clone();
            let depth = depth_view(&gpu, size);
            let base = time(&gpu, |encoder| draw_plain(encoder, &plain, &color, &depth))?;
            let mut ours = [0.0; 2];
            for (time_of, canvas) in ours.iter_mut().zip(canvases) {
                let canvas = canvas?;
                *time_of = time(&gpu, |encoder| renderer.encode(encoder, &subject, &seen, &canvas))?;
            }
            println!(
                "| {} | {draws:.2} | {} x {} | {base:.1} ms | {:.1} ms | {:.1} ms | {:.2} | {:.2} |",
                mesh.face_count(),
                size[0],
                size[1],
                ours[0],
                ours[1],
                ours[0] / base,
                ours[1] / base
            );
        }
        memory.push((mesh.face_count(), subject.bytes(), atlas_bytes(&lapped.exemplars[0])));
    }
    println!("\n| faces | mesh | pastes | textures | atlas of equal density | ratio |\n|---|---|---|---|---|---|");
    for (faces, [mesh, lists, textures], atlas) in memory {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let ratio = atlas as f64 / (lists + textures) as f64;
        println!(
            "| {faces} | {:.2} MiB | {:.2} MiB | {:.2} MiB | {:.1} MiB | {ratio:.1} |",
            mib(mesh),
            mib(lists),
            mib(textures),
            mib(atlas)
        );
    }
    Ok(())
}

/// Bytes of an atlas with the exemplar's pixels over the whole surface, mip levels and all.
fn atlas_bytes(exemplar: &lapped::exemplar::Exemplar) -> u64 {
    let [w, h] = exemplar.size();
    // Base colour; then normal and height; each of four bytes.
    let textures = 1 + u64::from(exemplar.channels().has(lapped::exemplar::Channel::Normal));
    let pixels = f64::from(w) * f64::from(h) * RATIO / ATLAS_FILL;
    (4.0 / 3.0 * 4.0 * pixels) as u64 * textures
}

fn depth_view(gpu: &Gpu, size: [u32; 2]) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

fn draw_plain(encoder: &mut wgpu::CommandEncoder, plain: &Plain, color: &wgpu::TextureView, depth: &wgpu::TextureView) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&plain.pipeline);
    pass.set_bind_group(0, &plain.bindings, &[]);
    pass.set_vertex_buffer(0, plain.vertices.slice(..));
    pass.set_index_buffer(plain.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..plain.count, 0, 0..1);
}
