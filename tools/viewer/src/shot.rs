//! One picture of a moment, without a display.

use std::sync::Arc;

use crate::camera::Orbit;
use crate::caption;
use crate::feed::{Frame, Stage};
use crate::image::Image;
use crate::picture::{Builder, Colour, Settings};
use crate::raster::Canvas;

/// A picture to be drawn.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The scene.
    pub stage: Arc<Stage>,
    /// The moment.
    pub frame: Frame,
    /// What colours and arrows say.
    pub settings: Settings,
    /// From where.
    pub view: View,
    /// Pixels across and down, each [`crate::MIN_SIDE`] to [`crate::MAX_SIDE`].
    pub size: (u32, u32),
}

/// From where a picture is taken, as in [`Orbit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// To the right of the front \[degrees\].
    pub azimuth: f64,
    /// Above the level \[degrees\].
    pub elevation: f64,
    /// From the middle of the scene to the eye \[m\]; `None` = so that the scene fills the picture.
    pub distance: Option<f64>,
}

impl Default for View {
    fn default() -> Self {
        Self { azimuth: Orbit::AZIMUTH, elevation: Orbit::ELEVATION, distance: None }
    }
}

/// What is behind the scene, from the top to the bottom of a picture.
pub const SKY: [Colour; 2] = [[250, 251, 253, 255], [228, 232, 238, 255]];

/// Draws a shot.
pub fn draw(shot: &Shot) -> Image {
    let mut builder = Builder::new(Arc::clone(&shot.stage));
    let View { azimuth, elevation, distance } = shot.view;
    let framed = Orbit::framing(&builder.outline(&shot.frame), azimuth, elevation, shot.size);
    let orbit = Orbit { distance: distance.unwrap_or(framed.distance), ..framed };
    let picture = builder.build(&shot.frame, &shot.settings);
    let mut canvas = Canvas::new(|width, height| orbit.camera(width, height), shot.size, SKY);
    picture.batches.iter().for_each(|batch| canvas.draw(batch, orbit.back()));
    let mut image = canvas.finish();
    caption::draw(&mut image, &picture.legend, orbit.axes());
    image
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use haptor_mesh::tessellate;

    use super::*;
    use crate::feed::{Pose, Region, Wrench};
    use crate::picture::ColourBy;

    fn shot(object: haptor_mesh::Mesh) -> Shot {
        let region = Region {
            centre: DVec3::new(0.0, 0.0, 0.1),
            normal: DVec3::Z,
            radius: 0.0044,
            stick_radius: 0.002,
            force: DVec3::new(0.0, 0.0, 20.0),
            torque: DVec3::ZERO,
            pressure: None,
        };
        Shot {
            stage: Arc::new(Stage { object, probe: vec![tessellate::ellipsoid(DVec3::splat(0.02), 32)], ..Stage::default() }),
            frame: Frame {
                probe: Pose { position: DVec3::new(0.0, 0.0, 0.119), rotation: DQuat::IDENTITY },
                contact: Wrench { force: DVec3::new(0.0, 0.0, 20.0), torque: DVec3::new(0.0, 0.0, -0.02) },
                regions: vec![region],
                ..Frame::default()
            },
            settings: Settings::default(),
            view: View::default(),
            size: (64, 48),
        }
    }

    #[test]
    fn every_view_is_a_picture_of_its_own_and_the_same_twice() {
        let cube = tessellate::cuboid(DVec3::splat(0.1)).mapped(|v| v + 0.05 * DVec3::Z);
        let ball = tessellate::ellipsoid(DVec3::splat(0.05), 32).mapped(|v| v + 0.05 * DVec3::Z);
        let base = shot(cube);
        let table = [
            ("cube", base.clone()),
            ("ball", shot(ball)),
            ("top", Shot { view: View { azimuth: 0.0, elevation: 90.0, distance: None }, ..base.clone() }),
            ("near", Shot { view: View { distance: Some(0.3), ..View::default() }, ..base.clone() }),
            ("pressure", Shot { settings: Settings { colour_by: ColourBy::Pressure, ..Settings::default() }, ..base.clone() }),
            ("forces", Shot { settings: Settings { region_forces: true, ..Settings::default() }, ..base }),
        ];
        let mut pictures = Vec::new();
        for (name, shot) in table {
            let picture = draw(&shot);
            assert_eq!(picture, draw(&shot), "{name}");
            assert_eq!(picture.rgb.len(), 64 * 48 * 3, "{name}");
            let middle = picture.rgb[3 * (24 * 64 + 32)..][..3].to_vec();
            assert_ne!(middle, picture.rgb[..3], "{name}: nothing in the middle");
            pictures.push(picture.rgb);
        }
        let count = pictures.len();
        pictures.sort();
        pictures.dedup();
        assert_eq!(pictures.len(), count);
    }

    #[test]
    fn a_picture_is_a_png_with_its_legend() {
        let large = Shot { size: (480, 360), ..shot(tessellate::cuboid(DVec3::splat(0.1))) };
        let image = draw(&large);
        assert_eq!(&image.png().unwrap()[..8], b"\x89PNG\r\n\x1a\n");
        let [r, g, b, _] = image_colour(&image, 13, 14);
        assert!(r > 180 && g < 90 && b < 90, "the sign of the force is red, not {r} {g} {b}");
    }

    fn image_colour(image: &Image, x: usize, y: usize) -> Colour {
        let at = 3 * (y * image.width as usize + x);
        [image.rgb[at], image.rgb[at + 1], image.rgb[at + 2], 255]
    }
}
