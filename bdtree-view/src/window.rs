//! The window and its events.

use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bdtree_output::write_whole;
use bdtree_render::one_line;
use bdtree_tools::ToolError;
use wgpu::{Instance, InstanceDescriptor};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::content::Content;
use crate::stage::Stage;

/// Width and height that all controls fit into; smaller windows are only made where they are asked for.
const SMALLEST: [u32; 2] = [320, 480];

/// Frames before a screenshot: controls need some to find their sizes.
const SETTLED: u64 = 6;

/// Shows `content` in a window of `size` pixels until it is closed; with `screenshot` until it is drawn and
/// copied there; the size of that copy.
///
/// # Errors
/// No display, no adapter, a lost device, an asset that the device does not take, a picture that cannot
/// be written.
pub(crate) fn run<C: Content>(
    content: &mut C,
    size: [u32; 2],
    screenshot: Option<&Path>,
) -> Result<Option<[u32; 2]>, ToolError> {
    contained(|| {
        let events = EventLoop::new().map_err(|error| {
            let why = match has_display() {
                true => reason(&error),
                false => NO_DISPLAY.to_string(),
            };
            ToolError::input("no window", why)
        })?;
        events.set_control_flow(ControlFlow::Wait);
        let mut viewer = Viewer {
            content,
            size,
            screenshot: screenshot.map(Path::to_path_buf),
            copied: None,
            stage: None,
            failure: None,
        };
        let result = events.run_app(&mut viewer);
        match viewer.failure {
            Some(failure) => Err(failure),
            None => result
                .map(|()| viewer.copied)
                .map_err(|error| ToolError::input("window", reason(&error))),
        }
    })
}

/// What windows need here. winit's own words are for those who build programs with it.
const NO_DISPLAY: &str =
    "an X11 display (or XWayland) is needed: set DISPLAY, or use `bdtree render`";

/// Whether a display is named, where windows are X11's.
fn has_display() -> bool {
    let is_x11 = cfg!(all(unix, not(target_vendor = "apple")));
    !is_x11 || std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

struct Viewer<'c, C: Content> {
    content: &'c mut C,
    size: [u32; 2],
    screenshot: Option<PathBuf>,
    /// Size of the picture that was written.
    copied: Option<[u32; 2]>,
    stage: Option<Stage<C>>,
    failure: Option<ToolError>,
}

impl<C: Content> Viewer<'_, C> {
    /// Ends with the first failure.
    fn end_if<T>(&mut self, events: &ActiveEventLoop, result: Result<T, ToolError>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(failure) => {
                self.failure.get_or_insert(failure);
                events.exit();
                None
            }
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<Stage<C>, ToolError> {
        let [width, height] = self.size;
        let attributes = Window::default_attributes()
            .with_title(self.content.title())
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(
                width.min(SMALLEST[0]),
                height.min(SMALLEST[1]),
            ));
        let window = events
            .create_window(attributes)
            .map_err(|e| ToolError::input("no window", reason(&e)))?;
        let display = Box::new(events.owned_display_handle());
        let instance = Instance::new(InstanceDescriptor::new_with_display_handle(display));
        let is_read = self.screenshot.is_some();
        let stage = Stage::new(instance, Arc::new(window), self.content, is_read);
        stage.map_err(|error| ToolError::input(self.content.subject(), error))
    }

    fn redraw(&mut self, events: &ActiveEventLoop) -> Result<(), ToolError> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        let copies = self.screenshot.is_some() && stage.frame_count() >= SETTLED;
        let after = stage.frame(self.content, copies);
        let after = after.map_err(|error| ToolError::input(self.content.subject(), error))?;
        if let (Some(copy), Some(path)) = (after.copy, &self.screenshot) {
            write_whole(path, |w| copy.write_png(w))?;
            self.copied = Some(copy.size());
            events.exit();
        } else if after.delay.is_zero() || self.screenshot.is_some() {
            stage.window().request_redraw();
        } else {
            let next = Instant::now().checked_add(after.delay);
            let next = next.filter(|_| after.delay < Duration::MAX);
            events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        }
        Ok(())
    }
}

impl<C: Content> ApplicationHandler for Viewer<'_, C> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.stage.is_none() {
            let stage = self.open(events);
            self.stage = self.end_if(events, stage);
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(stage)) = (cause, &self.stage) {
            stage.window().request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if self.failure.is_some() {
            return;
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Destroyed => {
                let subject = self.content.subject();
                let result = Err(ToolError::input(subject, "the window was destroyed"));
                self.end_if::<()>(events, result);
            }
            WindowEvent::RedrawRequested => {
                let result = self.redraw(events);
                self.end_if(events, result);
            }
            event => {
                let Some(stage) = &mut self.stage else { return };
                let result = stage.event(&event);
                let result = result.map_err(|e| ToolError::input(self.content.subject(), e));
                self.end_if(events, result);
            }
        }
    }
}

/// An error of winit without the place in its source: `os error at /…/mod.rs:765: no display`.
fn reason(error: &impl std::fmt::Display) -> String {
    let text = one_line(&error.to_string());
    let of_os = text.strip_prefix("os error at ");
    let cause = of_os.and_then(|rest| rest.split_once(".rs:")?.1.split_once(": "));
    cause.map_or(text.clone(), |(_, cause)| cause.to_string())
}

/// Runs `f`; panics of the window system's crates (winit where libxkbcommon is missing, say) become errors.
fn contained<T>(f: impl FnOnce() -> Result<T, ToolError>) -> Result<T, ToolError> {
    let heard = Arc::new(Mutex::new(String::new()));
    let note = heard.clone();
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let mut heard = note.lock().unwrap_or_else(PoisonError::into_inner);
        if heard.is_empty() {
            *heard = info.to_string();
        }
    }));
    let result = panic::catch_unwind(AssertUnwindSafe(f));
    panic::set_hook(before);
    result.unwrap_or_else(|_| {
        let heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
        Err(ToolError::input("window", one_line(&heard)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_other_peoples_source_are_left_out() {
        let text = "os error at /x y/winit-0.30.13/src/mod.rs:788: no: display";
        assert_eq!(reason(&text), "no: display");
        assert_eq!(reason(&"os error: other"), "os error: other");
    }

    #[test]
    fn panics_become_one_line() {
        let error = contained::<()>(|| panic!("of\nothers"))
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("window: ") && error.ends_with("of others"),
            "{error}"
        );
        assert!(!error.contains('\n'));
        assert_eq!(contained(|| Ok(7)).unwrap(), 7);
    }
}
