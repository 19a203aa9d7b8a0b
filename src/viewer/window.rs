//! A window of the system for [`App`]: its events go to the interface, its surface shows what that draws.
//!
//! Frames are drawn when something asks for one: an event, an animation, a job that has a result. A surface that is lost is made
//! anew; a window without size draws nothing.

use super::app::App;
use super::graphics::Graphics;
use super::{ViewOptions, ViewerError};
use crate::render::gpu::{Gpu, GpuError, GpuOptions, Window as Surface, wgpu};
use egui::mutex::RwLock;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy, OwnedDisplayHandle};
use winit::window::{Window, WindowId};

/// Size of a new window, and the least it can be, points.
const SIZE: [f32; 2] = [1280.0, 800.0];
const LEAST: [f32; 2] = [480.0, 320.0];

/// Opens the window and stays until it is closed.
pub(super) fn run(options: ViewOptions) -> Result<(), ViewerError> {
    let events = EventLoop::<Wake>::with_user_event().build().map_err(|e| ViewerError::Display(e.to_string()))?;
    let mut shell = Shell { proxy: events.create_proxy(), options, open: None, error: None, wake: None };
    events.run_app(&mut shell).map_err(|e| ViewerError::Window(e.to_string()))?;
    if let Some(open) = &mut shell.open {
        open.app.close();
        if let Some(path) = &shell.options.trace {
            let text = open.app.trace().report().to_string();
            let written = crate::format::write_file(path, |file| file.write_all(text.as_bytes()));
            written.map_err(|e| ViewerError::Window(e.to_string()))?;
        }
    }
    shell.error.map_or(Ok(()), Err)
}

/// A frame is wanted after so long.
#[derive(Debug, Clone, Copy)]
struct Wake(Duration);

struct Shell {
    proxy: EventLoopProxy<Wake>,
    options: ViewOptions,
    open: Option<Open>,
    error: Option<ViewerError>,
    /// When the next frame is wanted.
    wake: Option<Instant>,
}

/// The window and everything in it.
struct Open {
    app: App,
    context: egui::Context,
    input: egui_winit::State,
    painter: Arc<RwLock<egui_wgpu::Renderer>>,
    gpu: Gpu,
    instance: wgpu::Instance,
    surface: Surface<'static>,
    window: Arc<Window>,
    title: String,
}

impl ApplicationHandler<Wake> for Shell {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match Open::new(events, &self.options, self.proxy.clone()) {
            Ok(open) => self.open = Some(open),
            Err(error) => {
                self.error = Some(error);
                events.exit();
            }
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, Wake(after): Wake) {
        self.want(after);
    }

    fn new_events(&mut self, events: &ActiveEventLoop, _: StartCause) {
        if self.wake.is_some_and(|at| at <= Instant::now()) {
            self.wake = None;
            if let Some(open) = &self.open {
                open.window.request_redraw();
            }
        }
        events.set_control_flow(self.wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(self.wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        if event == WindowEvent::RedrawRequested {
            let drawn = open.draw();
            if let Err(error) = drawn {
                self.error = Some(error.into());
                events.exit();
            } else if open.app.is_over() {
                events.exit();
            }
            return;
        }
        let response = open.input.on_window_event(&open.window, &event);
        match event {
            WindowEvent::Resized(size) => open.surface.resize(size.into()),
            WindowEvent::CloseRequested => open.app.ask_to_quit(),
            _ => {}
        }
        if response.repaint || matches!(event, WindowEvent::CloseRequested | WindowEvent::Resized(_) | WindowEvent::Occluded(false))
        {
            open.window.request_redraw();
        }
    }
}

impl Shell {
    /// A frame is wanted no later than after so long.
    fn want(&mut self, after: Duration) {
        if after.is_zero() {
            if let Some(open) = &self.open {
                open.window.request_redraw();
            }
            return;
        }
        let Some(at) = Instant::now().checked_add(after) else { return };
        self.wake = Some(self.wake.map_or(at, |before| before.min(at)));
    }
}

impl Open {
    fn new(events: &ActiveEventLoop, options: &ViewOptions, proxy: EventLoopProxy<Wake>) -> Result<Self, ViewerError> {
        let [width, height] = options.size.unwrap_or(SIZE);
        let attributes = Window::default_attributes()
            .with_title("lapped")
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(LEAST[0], LEAST[1]));
        let window = events.create_window(attributes).map_err(|e| ViewerError::Window(e.to_string()))?;
        let window = Arc::new(window);
        let display: OwnedDisplayHandle = events.owned_display_handle();
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display)));
        let target = surface_of(&instance, &window)?;
        let chosen = GpuOptions { adapter: options.adapter.clone(), limits: None };
        let (gpu, adapter) = Gpu::showing(&chosen, &instance, &target)?;
        let size = window.inner_size().into();
        let surface = Surface::new(target, &adapter, &gpu.device, size, false)?;
        let painter = egui_wgpu::Renderer::new(&gpu.device, surface.format(), egui_wgpu::RendererOptions::default());
        let painter = Arc::new(RwLock::new(painter));

        let context = egui::Context::default();
        context.set_request_repaint_callback(move |info| {
            // Nobody waits any more once the window is closed.
            let _ = proxy.send_event(Wake(info.delay));
        });
        let longest = usize::try_from(gpu.limits.max_texture_dimension_2d).ok();
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, &*window, scale, window.theme(), longest);
        let graphics = Graphics::new(gpu.clone(), Arc::clone(&painter))?;
        let mut app = App::new(&context, graphics, options.home.clone());
        app.own_dialogs = options.own_dialogs;
        app.open_all(&options.files);
        window.request_redraw();
        Ok(Self { app, context, input, painter, gpu, instance, surface, window, title: String::new() })
    }

    /// Runs the interface once and shows it.
    fn draw(&mut self) -> Result<(), GpuError> {
        let begin = Instant::now();
        self.app.trace_mut().begin_frame();
        let input = self.input.take_egui_input(&self.window);
        self.app.trace_mut().part("input", begin.elapsed());
        let mut output = self.context.run_ui(input, |ui| self.app.ui(ui));
        let telling = Instant::now();
        self.input.handle_platform_output(&self.window, std::mem::take(&mut output.platform_output));
        let title = self.app.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        self.app.trace_mut().part("system", telling.elapsed());
        let meshing = Instant::now();
        let shapes = self.context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        self.app.trace_mut().part("shapes", meshing.elapsed());
        let uploading = Instant::now();
        let Gpu { device, queue, .. } = &self.gpu;
        let mut painter = self.painter.write();
        for (id, images) in output.textures_delta.set.drain() {
            for image in images {
                painter.update_texture(device, queue, id, &image);
            }
        }
        self.app.trace_mut().part("pictures", uploading.elapsed());
        let size: [u32; 2] = self.window.inner_size().into();
        self.surface.resize(size);
        self.app.trace_mut().frame(begin.elapsed());
        let texture = match self.surface.next(device) {
            Err(GpuError::SurfaceLost) => {
                self.surface.replace(surface_of(&self.instance, &self.window).map_err(lost)?);
                self.window.request_redraw();
                None
            }
            other => other?,
        };
        let shown = texture.is_some();
        if let Some(texture) = texture {
            let screen = egui_wgpu::ScreenDescriptor {
                size_in_pixels: [texture.texture.width(), texture.texture.height()],
                pixels_per_point: output.pixels_per_point,
            };
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let first = painter.update_buffers(device, queue, &mut encoder, &shapes, &screen);
            let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
            let onto = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
            {
                let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("interface"),
                    color_attachments: &[Some(onto)],
                    ..Default::default()
                });
                painter.render(&mut pass.forget_lifetime(), &shapes, &screen);
            }
            queue.submit(first.into_iter().chain([encoder.finish()]));
            self.window.pre_present_notify();
            queue.present(texture);
        }
        for id in output.textures_delta.free.drain() {
            painter.free_texture(&id);
        }
        drop(painter);
        // A surface that drew, if not at its best, must not be drawn without end.
        if !shown && self.surface.is_stale() && !size.contains(&0) {
            self.window.request_redraw();
        }
        match self.gpu.check() {
            Err(error @ GpuError::Refused { .. }) => {
                self.app.tell(error.to_string(), true);
                Ok(())
            }
            other => other,
        }
    }
}

/// A surface of the window.
fn surface_of(instance: &wgpu::Instance, window: &Arc<Window>) -> Result<wgpu::Surface<'static>, ViewerError> {
    instance.create_surface(Arc::clone(window)).map_err(|e| ViewerError::Window(e.to_string()))
}

/// A surface that cannot be made anew is a lost device.
fn lost(error: ViewerError) -> GpuError {
    GpuError::Lost { reason: error.to_string() }
}
