//! The window: the picture of a [`Source`] on OpenGL, plots, what the session is doing, and the keys and buttons to steer it.
//!
//! ```text
//! Source -> [app] news, commands -> [scene] picture, camera -> [gl]
//!                                -> [state] [controls] [plots] [playback] [help] panels
//! ```
//! [`open`] shows it on a display, [`window_shot`] draws the same into a picture without one. Keys, buttons and help come from one table, [`BINDINGS`].

mod app;
mod controls;
mod gl;
mod help;
mod keys;
mod legend;
mod playback;
mod plots;
mod scene;
mod shot;
mod state;
mod style;

use eframe::{NativeOptions, Renderer, egui};

use crate::feed::Source;
use app::App;

pub use keys::{Action, BINDINGS, Binding, When};
pub use shot::{Moment, window_shot};

/// How a window opens.
#[derive(Clone, Debug)]
pub struct Options {
    /// Its title.
    pub title: String,
    /// Width and height \[points\]; usable from 1280 x 720.
    pub size: [f32; 2],
    /// Samples a pixel, against jagged edges: 0, 2, 4 or 8. Without a graphics card fewer are faster.
    pub samples: u16,
}

impl Default for Options {
    fn default() -> Self {
        Self { title: "haptor".to_owned(), size: [1280.0, 720.0], samples: 4 }
    }
}

/// Smallest window in which nothing is cut off \[points\].
const LEAST_SIZE: [f32; 2] = [960.0, 600.0];

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No display, or one without OpenGL.
    #[error(
        "no window: {0}. Is there a display (DISPLAY or WAYLAND_DISPLAY set) with OpenGL 3.3? Without one, `haptor view --shot FILE.png` draws pictures"
    )]
    Open(String),
    /// No driver to draw with, or it refused.
    #[error("{0}")]
    Driver(String),
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// [`WindowError::Open`] when there is no display or no OpenGL.
pub fn open(source: Box<dyn Source>, options: &Options) -> Result<(), WindowError> {
    let native = NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size(options.size).with_min_inner_size(LEAST_SIZE),
        multisampling: options.samples,
        depth_buffer: 24,
        renderer: Renderer::Glow,
        ..NativeOptions::default()
    };
    let app = App::new(source);
    let started =
        eframe::run_native(&options.title, native, Box::new(move |creation| Ok(Box::new(app::Host::new(app, creation)))));
    started.map_err(|error| WindowError::Open(error.to_string()))
}
