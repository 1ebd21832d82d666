//! A live window on scenes: a picture that clears up while one moves, looks and edits.
//!
//! Everything that is rendered is rendered by a [`rutilant::Session`]; this
//! crate decides what to ask of it, and shows what comes.

mod flight;
mod frames;
mod history;
mod keys;
mod ladder;
mod live;
mod merge;
mod picture;
mod pose;
mod prefs;
mod source;
mod watch;
mod window;

pub use frames::FrameTimes;
use rutilant::settings::Settings;
pub use source::{BuiltIn, Reading};
pub use window::{Happened, Report};

use eframe::egui;
use std::path::PathBuf;
use std::sync::Arc;
use window::Window;

/// What a window is opened with.
pub struct Options {
    /// The scene to begin with; the built-in one if `None`.
    pub scene: Option<PathBuf>,
    /// How scenes are read.
    pub reading: Reading,
    /// Threads that render.
    pub threads: usize,
    /// What is kept with a picture that is written.
    pub describe: Describe,
    /// Tells what happens in the window.
    pub report: Report,
}

/// Names and values that are kept with a picture of these settings and so many samples per pixel.
pub type Describe = Arc<dyn Fn(&Settings, u64) -> Vec<(String, String)> + Send + Sync>;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[error("there can be no window: {what}; without one, \"rutilant render\" makes pictures")]
pub struct NoWindow {
    what: String,
}

/// Opens a window and stays until it is closed. To be called on the main thread.
///
/// # Errors
/// Where there is no display, or none that can show a window.
pub fn run(options: Options) -> Result<(), NoWindow> {
    #[cfg(all(unix, not(target_os = "macos")))]
    {
        let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        if !["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set) {
            let what = "neither DISPLAY nor WAYLAND_DISPLAY is set, so there is no screen".into();
            return Err(NoWindow { what });
        }
    }
    let viewport = egui::ViewportBuilder::default()
        .with_title("Rutilant")
        .with_app_id("rutilant")
        .with_inner_size([1240.0, 780.0])
        .with_min_inner_size([320.0, 240.0])
        .with_drag_and_drop(true);
    let native = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let Options { scene, reading, threads, describe, report } = options;
    eframe::run_native(
        "rutilant",
        native,
        Box::new(move |creation| {
            let preferences = prefs::Preferences::usual_file();
            let context = &creation.egui_ctx;
            let window =
                Window::new(context, reading, threads, scene, preferences, describe, report);
            Ok(Box::new(App { window, frames: FrameTimes::default() }))
        }),
    )
    .map_err(|error| {
        let what = match error {
            // Their words tell places in their source.
            eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
                "the display that DISPLAY or WAYLAND_DISPLAY names does not answer".into()
            }
            other => other.to_string(),
        };
        NoWindow { what }
    })
}

struct App {
    window: Window,
    frames: FrameTimes,
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        // Of the frame before, its painting included.
        if let Some(seconds) = frame.info().cpu_usage {
            self.frames.add(std::time::Duration::from_secs_f32(seconds.max(0.0)));
        }
        self.window.ui(ui);
    }

    fn on_exit(&mut self, _: Option<&eframe::glow::Context>) {
        self.window.closed(std::mem::take(&mut self.frames));
    }
}
