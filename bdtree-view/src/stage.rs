//! All that a window needs on the device, and one frame of it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bdtree_render::{Gpu, Image, RenderError};
use egui::{TextureId, ViewportId};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use wgpu::{FilterMode, Instance};
use winit::event::WindowEvent;
use winit::window::Window;

use crate::content::Content;
use crate::panel::{self, Status};
use crate::surface::Screen;

/// A window with all that draws in it.
pub(crate) struct Stage<C: Content> {
    window: Arc<Window>,
    gpu: Gpu,
    screen: Screen,
    egui: egui_winit::State,
    painter: egui_wgpu::Renderer,
    picture: C::Picture,
    picture_id: TextureId,
    status: Status,
    last_frame: Instant,
    frame_count: u64,
}

/// What comes after a frame.
pub(crate) struct After {
    /// When the next one is due, if nothing else happens.
    pub(crate) delay: Duration,
    /// What the window shows, if it was asked for.
    pub(crate) copy: Option<Image>,
}

impl<C: Content> Stage<C> {
    /// On a window.
    ///
    /// # Errors
    /// No adapter for it, an asset that the device does not take.
    pub(crate) fn new(
        instance: Instance,
        window: Arc<Window>,
        content: &C,
        is_read: bool,
    ) -> Result<Self, RenderError> {
        let surface = instance.create_surface(window.clone());
        let surface = surface.map_err(|error| RenderError::NoAdapter(error.to_string()))?;
        let gpu = Gpu::for_surface(instance, Some(&surface))?;
        let screen = Screen::new(&gpu, window.clone(), surface, is_read)?;
        let context = egui::Context::default();
        panel::dress(&context);
        let egui = egui_winit::State::new(
            context,
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        let options = RendererOptions::default();
        let mut painter = egui_wgpu::Renderer::new(&gpu.device, screen.format(), options);
        let picture = content.picture(&gpu)?;
        let view = C::texture(&picture).create_view(&Default::default());
        let picture_id = painter.register_native_texture(&gpu.device, &view, FilterMode::Nearest);
        gpu.check()?;
        let status = Status {
            adapter: gpu.adapter.get_info().name,
            ..Status::default()
        };
        Ok(Self {
            window,
            gpu,
            screen,
            egui,
            painter,
            picture,
            picture_id,
            status,
            last_frame: Instant::now(),
            frame_count: 0,
        })
    }

    /// Follows an event; whether that needs another frame is known to the window.
    ///
    /// # Errors
    /// A size that the device does not take.
    pub(crate) fn event(&mut self, event: &WindowEvent) -> Result<(), RenderError> {
        if let WindowEvent::Resized(size) = event {
            self.screen.resize(&self.gpu, [size.width, size.height])?;
        }
        if self.egui.on_window_event(&self.window, event).repaint {
            self.window.request_redraw();
        }
        Ok(())
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// More than the device takes, a lost device or surface.
    pub(crate) fn frame(&mut self, content: &mut C, copies: bool) -> Result<After, RenderError> {
        let later = After {
            delay: Duration::MAX,
            copy: None,
        };
        let Some(target) = self.screen.next(&self.gpu)? else {
            return Ok(later);
        };
        let begin = Instant::now();
        content.advance((begin - self.last_frame).as_secs_f64());
        self.last_frame = begin;
        self.status.problem = content.problem(&self.picture);

        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut size = [0; 2];
        let (status, picture_id) = (&self.status, self.picture_id);
        let mut failure = None;
        let mut output =
            context.run_ui(input, |ui| match content.lay_out(ui, status, picture_id) {
                Ok(of_picture) => size = of_picture,
                Err(problem) => failure = Some(problem),
            });
        // Out of there at once: egui panics where they are dropped unused, as errors would have it.
        let textures = std::mem::take(&mut output.textures_delta.set);
        let free_textures = std::mem::take(&mut output.textures_delta.free);
        if let Some(problem) = failure {
            self.status.problem = Some(problem);
        }
        let found_news = content.refresh();
        self.egui
            .handle_platform_output(&self.window, output.platform_output);

        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut encoder = device.create_command_encoder(&Default::default());
        if content.draw(&mut self.picture, &self.gpu, &mut encoder, size)? {
            let view = C::texture(&self.picture).create_view(&Default::default());
            let filter = FilterMode::Nearest;
            let id = self.picture_id;
            self.painter
                .update_egui_texture_from_wgpu_texture(device, &view, filter, id);
        }
        for (id, deltas) in &textures {
            for delta in deltas {
                self.painter.update_texture(device, queue, *id, delta);
            }
        }
        let triangles = context.tessellate(output.shapes, output.pixels_per_point);
        let descriptor = ScreenDescriptor {
            size_in_pixels: self.screen.size(),
            pixels_per_point: output.pixels_per_point,
        };
        let mut commands =
            self.painter
                .update_buffers(device, queue, &mut encoder, &triangles, &descriptor);
        let view = target.texture.create_view(&Default::default());
        self.paint(&mut encoder, &view, &triangles, &descriptor);
        commands.push(encoder.finish());
        self.gpu.queue.submit(commands);
        for id in &free_textures {
            self.painter.free_texture(id);
        }
        let copy = match copies {
            true => Some(self.gpu.read_back(&target.texture)?),
            false => None,
        };
        self.window.pre_present_notify();
        self.gpu.queue.present(target);
        self.gpu.check()?;
        self.frame_count += 1;
        self.status.frame_ms = Some(1e3 * begin.elapsed().as_secs_f64());
        let delay = output.viewport_output.get(&ViewportId::ROOT);
        let delay = delay.map_or(Duration::MAX, |viewport| viewport.repaint_delay);
        let is_moving = content.is_moving() || found_news;
        Ok(After {
            delay: if is_moving { Duration::ZERO } else { delay },
            copy,
        })
    }

    /// How many frames there have been.
    pub(crate) fn frame_count(&self) -> u64 {
        self.frame_count
    }

    /// The window.
    pub(crate) fn window(&self) -> &Window {
        &self.window
    }

    fn paint(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        triangles: &[egui::ClippedPrimitive],
        descriptor: &ScreenDescriptor,
    ) {
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("window"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        self.painter
            .render(&mut pass.forget_lifetime(), triangles, descriptor);
    }
}
