//! Triangles to pixels without a graphics driver: z-buffer, two lights, shadows none, smoothed by averaging a grid of samples in each pixel.

use glam::{DMat3, DVec2, DVec3};

use crate::camera::Camera;
use crate::image::Image;
use crate::picture::{Batch, Colour};

/// Samples along each side of a pixel.
const SAMPLES: u32 = 3;

/// A colour, linear, each part 0 to 1.
type Linear = DVec3;

/// A vertex as it is seen.
#[derive(Clone, Copy, Debug)]
struct Corner {
    pixel: DVec2,
    depth: f64,
    position: DVec3,
    normal: DVec3,
    colour: Linear,
    cover: f64,
}

/// How the triangles of a batch meet what is drawn already.
#[derive(Clone, Copy, Debug)]
struct Pass {
    opacity: f64,
    lit: bool,
    one_sided: bool,
    hides: bool,
    lift: f64,
    /// Draws what lies behind, instead of what lies before.
    behind: bool,
}

/// A picture being drawn.
pub struct Canvas {
    camera: Camera,
    width: u32,
    height: u32,
    colour: Vec<[f32; 3]>,
    depth: Vec<f64>,
}

impl Canvas {
    /// A canvas of `width` x `height` pixels, filled with a shade from `top` to `bottom`.
    pub fn new(camera: impl Fn(u32, u32) -> Camera, (width, height): (u32, u32), [top, bottom]: [Colour; 2]) -> Self {
        let (wide, high) = (width * SAMPLES, height * SAMPLES);
        let [top, bottom] = [top, bottom].map(|colour| linear(colour).0);
        let row = |y: u32| narrow(top.lerp(bottom, f64::from(y) / f64::from(high)));
        let colour = (0..high).flat_map(|y| std::iter::repeat_n(row(y), wide as usize)).collect();
        let depth = vec![f64::INFINITY; (wide * high) as usize];
        Self { camera: camera(wide, high), width: wide, height: high, colour, depth }
    }

    /// Draws triangles; one that reaches behind the camera is left out.
    pub fn draw(&mut self, batch: &Batch, towards: DVec3) {
        if batch.is_empty() {
            return;
        }
        let paint = batch.paint;
        let corners = self.corners(batch);
        let pass = Pass {
            opacity: paint.opacity_from(towards.as_vec3()).into(),
            lit: paint.lit,
            one_sided: paint.one_sided,
            hides: paint.hides,
            lift: paint.lift.into(),
            behind: false,
        };
        if paint.behind > 0.0 {
            let ghost = Pass { opacity: f64::from(paint.behind) * pass.opacity, hides: false, behind: true, ..pass };
            self.draw_pass(batch, &corners, ghost);
        }
        self.draw_pass(batch, &corners, pass);
    }

    fn corners(&self, batch: &Batch) -> Vec<Option<Corner>> {
        let turn = DMat3::from_quat(batch.place.rotation);
        let vertices = batch.positions.iter().zip(&batch.normals).zip(&batch.colours);
        let corner = |((position, normal), &colour): ((&glam::Vec3, &glam::Vec3), &Colour)| {
            let position = batch.place.position + turn * position.as_dvec3();
            let (pixel, depth) = self.camera.project(position)?;
            let (colour, cover) = linear(colour);
            Some(Corner { pixel, depth, position, normal: turn * normal.as_dvec3(), colour, cover })
        };
        vertices.map(corner).collect()
    }

    fn draw_pass(&mut self, batch: &Batch, corners: &[Option<Corner>], pass: Pass) {
        for triangle in &batch.triangles {
            if let [Some(a), Some(b), Some(c)] = triangle.map(|corner| corners[corner as usize]) {
                self.triangle([a, b, c], pass);
            }
        }
    }

    fn triangle(&mut self, corners: [Corner; 3], pass: Pass) {
        let [a, b, c] = corners.map(|corner| corner.pixel);
        let area = (b - a).perp_dot(c - a);
        // pixels count downwards: what faces the camera turns to the left in space, to the right in pixels
        if area == 0.0 || !area.is_finite() || (pass.one_sided && area > 0.0) {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for y in rows(low.y, high.y, self.height) {
            for x in rows(low.x, high.x, self.width) {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let share = [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).perp_dot(q - at) / area);
                if share.iter().all(|&part| part >= 0.0) {
                    self.sample((y * self.width + x) as usize, &corners, share, pass);
                }
            }
        }
    }

    /// One sample, `share` of each corner in the picture's plane, taken back to space by the depths.
    fn sample(&mut self, index: usize, corners: &[Corner; 3], share: [f64; 3], pass: Pass) {
        let near = [0, 1, 2].map(|k| share[k] / corners[k].depth);
        let depth = 1.0 / near.iter().sum::<f64>();
        if (depth - pass.lift >= self.depth[index]) != pass.behind {
            return;
        }
        let weights = near.map(|near| near * depth);
        let mix = |of: fn(&Corner) -> DVec3| (0..3).map(|k| of(&corners[k]) * weights[k]).sum::<DVec3>();
        let colour = mix(|c| c.colour);
        let colour = if pass.lit { self.lit(colour, mix(|c| c.position), mix(|c| c.normal)) } else { colour };
        let mut cover: f64 = (0..3).map(|k| corners[k].cover * weights[k]).sum();
        if pass.lit && pass.opacity < 1.0 {
            cover *= self.rim(mix(|c| c.position), mix(|c| c.normal));
        }
        let behind = DVec3::from_array(self.colour[index].map(f64::from));
        self.colour[index] = narrow(behind.lerp(colour, (pass.opacity * cover).min(1.0)));
        if pass.hides {
            self.depth[index] = depth - pass.lift;
        }
    }

    /// A light from the upper left, a weaker one from the viewer, a gloss; so much from all around that colours stay readable.
    fn lit(&self, colour: Linear, position: DVec3, normal: DVec3) -> Linear {
        let towards = self.camera.towards(position);
        let normal = normal.normalize_or(towards);
        // the side that is seen is the side that is lit
        let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
        let light = DVec3::new(-0.5, -0.25, 0.8).normalize();
        let diffuse = 0.35 + 0.55 * normal.dot(light).max(0.0) + 0.18 * normal.dot(towards).max(0.0);
        let gloss = normal.dot((light + towards).normalize_or(normal)).max(0.0).powi(48);
        colour * diffuse + DVec3::splat(0.08 * gloss)
    }

    /// What is seen through covers more where it turns away, as glass does: its outline shows.
    fn rim(&self, position: DVec3, normal: DVec3) -> f64 {
        let facing = normal.normalize_or_zero().dot(self.camera.towards(position)).abs();
        1.0 + (1.0 - facing) * (1.0 - facing)
    }

    /// The picture, each pixel the mean of its samples.
    pub fn finish(&self) -> Image {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut rgb = Vec::with_capacity((3 * width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                rgb.extend(self.mean(x, y).to_array().map(srgb));
            }
        }
        Image { width, height, rgb }
    }

    fn mean(&self, x: u32, y: u32) -> Linear {
        let samples = (0..SAMPLES * SAMPLES).map(|k| {
            let (i, j) = (x * SAMPLES + k % SAMPLES, y * SAMPLES + k / SAMPLES);
            DVec3::from_array(self.colour[(j * self.width + i) as usize].map(f64::from))
        });
        samples.sum::<DVec3>() / f64::from(SAMPLES * SAMPLES)
    }
}

/// The pixels between two coordinates, inside the picture.
fn rows(low: f64, high: f64, size: u32) -> std::ops::Range<u32> {
    // `as` saturates, so coordinates far outside fall on the edges
    (low.floor() as u32).min(size)..(high.ceil() as u32).saturating_add(1).min(size)
}

fn narrow(colour: Linear) -> [f32; 3] {
    colour.to_array().map(|part| part as f32)
}

/// Linear 0 to 1 to an sRGB byte, in correctly rounded operations only: gamma 2 (a square root) instead of the standard's power
/// keeps the bytes the same on every machine and differs from it by less than one can see.
fn srgb(linear: f64) -> u8 {
    (linear.clamp(0.0, 1.0).sqrt() * 255.0).round() as u8
}

/// Back from sRGB, by the same rule; and the share that covers.
fn linear([r, g, b, cover]: Colour) -> (Linear, f64) {
    let part = |byte: u8| {
        let share = f64::from(byte) / 255.0;
        share * share
    };
    (DVec3::new(part(r), part(g), part(b)), f64::from(cover) / 255.0)
}
