//! The window in a picture without a display: the same panels, the same driver calls, through EGL.

use std::time::Duration;

use eframe::egui_glow::Painter;
use eframe::{egui, egui::Rect, egui::pos2};

use super::app::App;
use super::gl::Screenless;
use super::keys::Action;
use super::{WindowError, style};
use crate::feed::Source;
use crate::image::Image;

/// Times the panels are laid out before the picture: their sizes settle within two.
const SETTLE: u32 = 3;

/// What is looked at.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Time since the window opened, as the source is told.
    pub at: Duration,
    /// Asked for at that time, one after the other.
    pub actions: Vec<Action>,
}

/// Draws the window on a source, `size` pixels, after the given moments.
///
/// # Errors
/// [`WindowError::Driver`] when there is no EGL or it does not draw, in words that name the packages to install.
pub fn window_shot(source: Box<dyn Source>, moments: &[Moment], size: [u32; 2]) -> Result<Image, WindowError> {
    let screen = Screenless::open(size).map_err(WindowError::Driver)?;
    let painter = Painter::new(std::sync::Arc::clone(screen.gl()), "", None, false);
    let mut painter = painter.map_err(|error| WindowError::Driver(error.to_string()))?;
    let context = egui::Context::default();
    style::apply(&context);
    let mut app = App::new(source);
    for moment in moments {
        draw(&screen, &mut painter, &context, &mut app, moment.at, size);
        moment.actions.iter().for_each(|&action| app.act(action));
        for _ in 0..SETTLE {
            draw(&screen, &mut painter, &context, &mut app, moment.at, size);
        }
    }
    let rgb = screen.read();
    app.scene.destroy(screen.gl());
    painter.destroy();
    Ok(Image { width: size[0], height: size[1], rgb })
}

fn draw(screen: &Screenless, painter: &mut Painter, context: &egui::Context, app: &mut App, now: Duration, size: [u32; 2]) {
    let [width, height] = size.map(|side| side as f32);
    let input = egui::RawInput {
        screen_rect: Some(Rect::from_min_max(pos2(0.0, 0.0), pos2(width, height))),
        // the source's time: the same picture at any speed of this machine
        time: Some(now.as_secs_f64()),
        ..egui::RawInput::default()
    };
    let mut output = context.run_ui(input, |ui| app.show(ui, now));
    let shapes = context.tessellate(output.shapes, output.pixels_per_point);
    screen.begin();
    painter.paint_and_update_textures(size, output.pixels_per_point, &shapes, &mut output.textures_delta);
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use haptor_mesh::tessellate;

    use super::*;
    use crate::feed::{Displacement, Frame, Mode, Pose, Region, Sample, Script, Stage, Wrench};
    use crate::picture::MAKO;

    const SIZE: [u32; 2] = [1280, 720];

    fn stage() -> Stage {
        let object = tessellate::ellipsoid(DVec3::splat(0.05), 64).mapped(|v| v + 0.05 * DVec3::Z);
        let probe = vec![tessellate::ellipsoid(DVec3::splat(0.02), 32)];
        Stage { name: "ball on ball".to_owned(), object, probe, period: 0.01, step_budget_us: 300.0, ..Stage::default() }
    }

    /// A press that grows deeper.
    fn frames() -> Vec<Frame> {
        let vertices = stage().object.vertices;
        let moved = |depth: f64| vertices.iter().map(|v| Vec3::new(0.0, 0.0, (-depth * v.z / 0.1) as f32)).collect();
        let frame = |k: u32| {
            let depth = 1.0e-5 * f64::from(k);
            let radius = (0.02 * depth).sqrt();
            let force = DVec3::Z * (1.0e6 * depth);
            Frame {
                tick: k.into(),
                time: f64::from(k) * 0.01,
                probe: Pose { position: DVec3::new(0.0, 0.0, 0.12 - depth), ..Pose::default() },
                contact: Wrench { force, torque: DVec3::ZERO },
                regions: vec![Region {
                    centre: DVec3::new(0.0, 0.0, 0.1 - depth),
                    normal: DVec3::Z,
                    radius,
                    stick_radius: 0.6 * radius,
                    force,
                    torque: DVec3::ZERO,
                    pressure: None,
                }],
                displacement: Some(Displacement { tick: k.into(), moved: moved(depth) }),
                depth,
                tier: "bristle".to_owned(),
                mode: Mode::Running,
                ..Frame::default()
            }
        };
        (1..100).map(frame).collect()
    }

    fn moment(at_ms: u64, actions: &[Action]) -> Moment {
        Moment { at: Duration::from_millis(at_ms), actions: actions.to_vec() }
    }

    fn shoot(source: Script, moments: &[Moment]) -> Image {
        window_shot(Box::new(source), moments, SIZE).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Pixels of the picture in the middle that are within `reach` of a colour in each part.
    fn pixels_like(image: &Image, colour: [u8; 3], reach: u8) -> usize {
        let width = image.width as usize;
        let rows = image.rgb.chunks_exact(3 * width);
        let middle = rows.flat_map(|row| row[3 * 250..3 * 900].chunks_exact(3));
        middle.filter(|pixel| pixel.iter().zip(colour).all(|(&part, of)| part.abs_diff(of) <= reach)).count()
    }

    #[test]
    fn the_window_shows_the_object_in_its_colours_panels_and_plots() {
        let rest = [moment(0, &[]), moment(900, &[])];
        let image = shoot(Script::session(stage(), frames()), &rest);
        assert_eq!((image.width, image.height), (SIZE[0], SIZE[1]));
        // the middle of the scale, lit from above
        assert!(pixels_like(&image, MAKO[128], 60) > 5_000, "the object");
        assert!(pixels_like(&image, [214, 39, 40], 60) > 100, "the arrow of the force");
        let stop = &image.rgb[3 * (70 * SIZE[0] as usize + 30)..][..3];
        assert!(stop[0] > 150 && stop[1] < 60, "the e-stop is red, not {stop:?}");
        let plain =
            shoot(Script::session(stage(), frames()), &[moment(0, &[]), moment(900, &[Action::Colours, Action::Colours])]);
        assert!(pixels_like(&plain, MAKO[128], 30) < pixels_like(&image, MAKO[128], 30), "without a scale");
        assert_eq!(image, shoot(Script::session(stage(), frames()), &rest), "the same twice");
    }

    #[test]
    fn every_action_can_be_asked_for_with_a_session_and_with_a_recording() {
        let asked = super::super::BINDINGS.iter().map(|binding| moment(500, &[binding.action]));
        let moments: Vec<Moment> = asked.chain([moment(500, &[Action::Help])]).collect();
        for source in [Script::session(stage(), frames()), Script::recording(stage(), frames())] {
            let image = shoot(source, &moments);
            // seen from above at last, each region's arrow end on, the probe solid
            assert!(pixels_like(&image, [240, 242, 245], 14) > 5_000, "the sky is there");
            assert!(pixels_like(&image, [222, 199, 160], 60) + pixels_like(&image, MAKO[0], 60) > 1_000, "the object is there");
        }
    }

    #[test]
    fn a_source_without_news_waits() {
        struct Silent;
        impl Source for Silent {
            fn poll(&mut self, _: Duration) -> crate::feed::News {
                crate::feed::News {
                    samples: vec![Sample { time: f64::NAN, ..Sample::default() }],
                    ..crate::feed::News::default()
                }
            }
            fn send(&mut self, _: crate::feed::Command) {}
        }
        let all: Vec<Action> = super::super::BINDINGS.iter().map(|binding| binding.action).collect();
        let image = window_shot(Box::new(Silent), &[moment(0, &all)], SIZE).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(image.rgb.len(), 3 * 1280 * 720);
    }
}
