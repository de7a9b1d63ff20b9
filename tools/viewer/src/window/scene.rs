//! The middle of the window: the picture, the hand that turns it, and the legend over it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use eframe::egui::{self, Color32, PointerButton, Pos2, Rect, Shape, pos2};
use eframe::{egui_glow, glow};
use glam::DVec3;

use super::gl::Renderer;
use super::legend;
use crate::camera::Orbit;
use crate::feed::{Frame, Stage};
use crate::picture::{Builder, Settings};
use crate::shot::SKY;

/// Degrees a point of drag.
const TURN: f64 = 0.4;

/// Change of distance a point of wheel.
const APPROACH: f64 = 0.0025;

/// How near and how far the eye goes, in scene radii.
const REACH: (f64, f64) = (0.02, 60.0);

/// A region is looked at with this much around it, in its radii.
const AROUND: f64 = 5.0;

/// What to look at, and from where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// The whole scene from the usual side.
    Usual,
    /// The whole scene from the front.
    Front,
    /// From the right.
    Side,
    /// From above.
    Top,
    /// The contact, from where the eye is.
    Contact,
}

/// What the driver draws: shared with egui's callback, which runs after the panels.
#[derive(Default)]
struct Drawn {
    builder: Option<Builder>,
    renderer: Option<Renderer>,
    /// Why the driver does not draw.
    failure: Option<String>,
}

/// The scene in the window.
#[derive(Default)]
pub struct Scene {
    drawn: Arc<Mutex<Drawn>>,
    orbit: Option<Orbit>,
    /// To be done when the size of the picture is known.
    aim: Option<Aim>,
}

impl Scene {
    fn drawn(&self) -> MutexGuard<'_, Drawn> {
        // a panic elsewhere leaves nothing half done here
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Another stage is active.
    pub fn set_stage(&mut self, stage: Arc<Stage>) {
        let mut drawn = self.drawn();
        drawn.builder = Some(Builder::new(stage));
        if let Some(renderer) = &mut drawn.renderer {
            renderer.forget();
        }
        drop(drawn);
        (self.orbit, self.aim) = (None, Some(Aim::Usual));
    }

    /// The stage that is active.
    pub fn stage(&self) -> Option<Arc<Stage>> {
        self.drawn().builder.as_ref().map(|builder| Arc::clone(builder.stage()))
    }

    /// Builds the picture of a moment.
    pub fn build(&self, frame: &Frame, settings: &Settings) {
        if let Some(builder) = &mut self.drawn().builder {
            builder.build(frame, settings);
        }
    }

    /// Upper end of the colour scale as last built \[m or Pa\].
    pub fn colour_end(&self) -> Option<f64> {
        self.drawn().builder.as_ref().and_then(|builder| builder.picture().legend.bar.as_ref().map(|bar| bar.end))
    }

    /// Scales choose themselves anew.
    pub fn forget_peaks(&self) {
        if let Some(builder) = &mut self.drawn().builder {
            builder.forget_peaks();
        }
    }

    /// Looks at something in the next picture.
    pub fn aim(&mut self, aim: Aim) {
        self.aim = Some(aim);
    }

    /// Gives the driver's memory back.
    pub fn destroy(&self, gl: &glow::Context) {
        if let Some(renderer) = self.drawn().renderer.take() {
            renderer.destroy(gl);
        }
    }

    /// Shows picture and legend and follows the hand.
    pub fn show(&mut self, ui: &mut egui::Ui, frame: Option<&Frame>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::click_and_drag());
        ui.painter().add(sky(rect));
        let Some(frame) = frame else {
            let words = "waiting for the first picture of the session";
            ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, words, egui::FontId::proportional(16.0), legend::INK);
            return;
        };
        if response.double_clicked() {
            self.aim = Some(Aim::Usual);
        }
        self.follow_aim(frame, rect);
        self.follow_hand(ui, &response, rect);
        let Some(orbit) = self.orbit else { return };
        ui.painter().add(self.callback(orbit, rect));
        let drawn = self.drawn();
        if let Some(builder) = &drawn.builder {
            let picture = builder.picture();
            legend::show(ui.painter(), rect, &picture.legend, orbit.axes());
            legend::show_trouble(ui.painter(), rect, picture.refused, drawn.failure.as_deref());
        }
    }

    fn follow_aim(&mut self, frame: &Frame, rect: Rect) {
        let Some(aim) = self.aim.take() else { return };
        let drawn = self.drawn();
        let Some(builder) = &drawn.builder else { return };
        let regions = frame.regions.iter().filter(|region| region.is_finite());
        let near: Vec<DVec3> = regions
            .flat_map(|region| {
                let reach = AROUND * region.radius;
                [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| [region.centre + reach * axis, region.centre - reach * axis])
            })
            .flatten()
            .collect();
        let points = if aim == Aim::Contact && !near.is_empty() { near } else { builder.outline(frame) };
        drop(drawn);
        let now = self.orbit.map_or((Orbit::AZIMUTH, Orbit::ELEVATION), |orbit| (orbit.azimuth, orbit.elevation));
        let (azimuth, elevation) = match aim {
            Aim::Usual => (Orbit::AZIMUTH, Orbit::ELEVATION),
            Aim::Front => (0.0, 0.0),
            Aim::Side => (90.0, 0.0),
            Aim::Top => (0.0, 90.0),
            Aim::Contact => now,
        };
        let size = (rect.width().max(1.0) as u32, rect.height().max(1.0) as u32);
        self.orbit = Some(Orbit::framing(&points, azimuth, elevation, size));
    }

    /// Turns, moves and zooms.
    fn follow_hand(&mut self, ui: &egui::Ui, response: &egui::Response, rect: Rect) {
        let radius = self.drawn().builder.as_ref().map_or(1.0, Builder::radius);
        let Some(orbit) = &mut self.orbit else { return };
        let drag = response.drag_delta();
        let (right, down) = (f64::from(drag.x), f64::from(drag.y));
        let shift = ui.input(|input| input.modifiers.shift);
        if response.dragged_by(PointerButton::Primary) && !shift {
            orbit.turn(-TURN * right, TURN * down);
        } else if response.dragged() {
            let height = f64::from(rect.height().max(1.0));
            orbit.shift(right / height, down / height);
        }
        if response.contains_pointer() {
            let (wheel, pinch) = ui.input(|input| (f64::from(input.smooth_scroll_delta().y), f64::from(input.zoom_delta())));
            orbit.approach((-APPROACH * wheel).exp() / pinch.max(0.1), REACH.0 * radius..=REACH.1 * radius);
        }
    }

    /// What egui calls when it is the picture's turn.
    fn callback(&self, orbit: Orbit, rect: Rect) -> egui::PaintCallback {
        let drawn = Arc::clone(&self.drawn);
        let draw = move |info: egui::PaintCallbackInfo, painter: &egui_glow::Painter| {
            let mut drawn = drawn.lock().unwrap_or_else(PoisonError::into_inner);
            let Drawn { builder: Some(builder), renderer, failure } = &mut *drawn else { return };
            if renderer.is_none() && failure.is_none() {
                match Renderer::new(painter.gl()) {
                    Ok(new) => *renderer = Some(new),
                    Err(words) => *failure = Some(words),
                }
            }
            if let Some(renderer) = renderer {
                let aspect = f64::from(info.viewport.width() / info.viewport.height().max(1.0));
                renderer.draw(painter.gl(), builder.picture(), &orbit, aspect);
            }
        };
        egui::PaintCallback { rect, callback: Arc::new(egui_glow::CallbackFn::new(draw)) }
    }
}

/// What is behind the scene: lighter above.
fn sky(rect: Rect) -> Shape {
    let [top, bottom] = SKY.map(|[r, g, b, _]| Color32::from_rgb(r, g, b));
    let mut mesh = egui::Mesh::default();
    let corners: [(Pos2, Color32); 4] = [
        (rect.left_top(), top),
        (rect.right_top(), top),
        (rect.right_bottom(), bottom),
        (pos2(rect.left(), rect.bottom()), bottom),
    ];
    for (corner, colour) in corners {
        mesh.colored_vertex(corner, colour);
    }
    mesh.add_triangle(0, 1, 2);
    mesh.add_triangle(0, 2, 3);
    Shape::mesh(mesh)
}
