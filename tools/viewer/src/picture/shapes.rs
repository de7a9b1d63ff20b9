//! The signs of a picture as triangles: arrows, arcs, discs, ground.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{Mat3, Quat, Vec2, Vec3};

use super::batch::{Batch, Colour};

/// Points on a ring: round at any size of window.
const SIDES: usize = 48;

/// Points around the bar of an arc.
const BAR_SIDES: usize = 16;

/// Pieces of an arc.
const ARC_STEPS: usize = 48;

/// Width of an arrow's head per its shaft.
const HEAD: f32 = 2.6;

/// Length of a head per the shaft's radius.
const HEAD_LENGTH: f32 = 6.5;

static RING: LazyLock<[Vec2; SIDES]> = LazyLock::new(circle);
static BAR: LazyLock<[Vec2; BAR_SIDES]> = LazyLock::new(circle);

/// Cosine and sine of even steps around a circle.
fn circle<const N: usize>() -> [Vec2; N] {
    std::array::from_fn(|k| {
        let (sin, cos) = (TAU * k as f64 / N as f64).sin_cos();
        Vec2::new(cos as f32, sin as f32)
    })
}

/// Axes of which the third is `axis`; a zero vector counts as z.
fn about(axis: Vec3) -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, axis.normalize_or(Vec3::Z)))
}

/// A band of a turned body: two rings (radius, height) and the normal (outward, upward) between them.
type Band = ([f32; 2], [f32; 2], [f32; 2]);

/// Turns bands about the third of `axes` through `origin`; the rings of a band go up or, on a flat face, as the normal demands.
fn turn(batch: &mut Batch, origin: Vec3, axes: Mat3, bands: &[Band], colour: Colour) {
    for &(low, high, normal) in bands {
        let first = batch.positions.len() as u32;
        for side in RING.iter() {
            let out = side.extend(0.0);
            let direction = axes * (normal[0] * out + normal[1] * Vec3::Z);
            for [radius, height] in [low, high] {
                batch.push(origin + axes * (radius * out + height * Vec3::Z), direction, colour);
            }
        }
        for k in 0..SIDES as u32 {
            let next = (k + 1) % SIDES as u32;
            let [a, b, c, d] = [2 * k, 2 * next, 2 * next + 1, 2 * k + 1].map(|corner| first + corner);
            batch.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// The head of an arrow: from its base at height `from` to its tip at `to`.
fn head(radius: f32, from: f32, to: f32) -> [Band; 2] {
    let slant = Vec2::new(to - from, HEAD * radius).normalize_or(Vec2::X).to_array();
    [([0.0, from], [HEAD * radius, from], [0.0, -1.0]), ([HEAD * radius, from], [0.0, to], slant)]
}

/// An arrow from `tail` along `reach`, its shaft as thick as `radius` \[m\].
pub fn arrow(batch: &mut Batch, tail: Vec3, reach: Vec3, radius: f32, colour: Colour) {
    let length = reach.length();
    // a short arrow keeps its form
    let radius = radius.min(length / (1.5 * HEAD_LENGTH));
    let neck = length - HEAD_LENGTH * radius;
    let shaft = [([0.0, 0.0], [radius, 0.0], [0.0, -1.0]), ([radius, 0.0], [radius, neck], [1.0, 0.0])];
    turn(batch, tail, about(reach), &[&shaft[..], &head(radius, neck, length)].concat(), colour);
}

/// A bent arrow about `axis` through `centre`, from angle 0 to `angle` \[rad\] at the distance `ring` \[m\]: a torque.
pub fn arc(batch: &mut Batch, centre: Vec3, axis: Vec3, ring: f32, angle: f32, radius: f32, colour: Colour) {
    let axes = about(axis);
    // the head takes the end of the arc
    let bend = (angle - HEAD_LENGTH * radius / ring).max(0.0);
    let out = |angle: f32| axes * Vec3::new(angle.cos(), angle.sin(), 0.0);
    let first = batch.positions.len() as u32;
    for step in 0..=ARC_STEPS {
        let out = out(bend * step as f32 / ARC_STEPS as f32);
        for side in BAR.iter() {
            let normal = side.x * out + side.y * axes.z_axis;
            batch.push(centre + ring * out + radius * normal, normal, colour);
        }
    }
    let count = BAR_SIDES as u32;
    for (step, side) in (0..ARC_STEPS as u32).flat_map(|step| (0..count).map(move |side| (step, side))) {
        let next = (side + 1) % count;
        let [a, b, c, d] = [step * count + side, (step + 1) * count + side, (step + 1) * count + next, step * count + next];
        batch.triangles.extend([[a, b, c], [a, c, d]].map(|corners| corners.map(|corner| first + corner)));
    }
    let along = |angle: f32| axes * Vec3::new(-angle.sin(), angle.cos(), 0.0);
    turn(batch, centre + ring * out(0.0), about(along(0.0)), &[([0.0, 0.0], [radius, 0.0], [0.0, -1.0])], colour);
    // a straight head on a bent bar: turned inward by half of what it spans
    let length = (HEAD_LENGTH * radius).min(angle * ring);
    let tangent = along(bend + length / ring / 2.0);
    turn(batch, centre + ring * out(bend), about(tangent), &head(radius, 0.0, length), colour);
}

/// A flat ring about `normal`: radii \[m\] from the centre outward with the colour at each; the first may be 0.
pub fn rings(batch: &mut Batch, centre: Vec3, normal: Vec3, radii: impl IntoIterator<Item = (f32, Colour)>) {
    let axes = about(normal);
    let mut inner: Option<u32> = None;
    for (radius, colour) in radii {
        let first = batch.positions.len() as u32;
        for side in RING.iter() {
            batch.push(centre + axes * (radius * side.extend(0.0)), axes.z_axis, colour);
        }
        let count = SIDES as u32;
        for (inner, side) in inner.into_iter().flat_map(|inner| (0..count).map(move |side| (inner, side))) {
            let next = (side + 1) % count;
            let [a, b, c, d] = [inner + side, first + side, first + next, inner + next];
            batch.triangles.extend([[a, b, c], [a, c, d]]);
        }
        inner = Some(first);
    }
}

/// Tiles of edge `step` at the given height about `centre`, in two colours by turns, fading out from `near` to `far` \[m\].
pub fn ground(batch: &mut Batch, centre: Vec3, step: f32, near: f32, far: f32, colours: [Colour; 2]) {
    let count = (far / step).ceil() as i32;
    // tiles lie on whole steps of the world
    let [i0, j0] = [centre.x, centre.y].map(|x| (x / step).round() as i32);
    for (i, j) in (-count..count).flat_map(|i| (-count..count).map(move |j| (i0 + i, j0 + j))) {
        let colour = colours[(i + j).rem_euclid(2) as usize];
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
            let corner = Vec3::new((i + a) as f32 * step, (j + b) as f32 * step, centre.z);
            let cover = ((far - corner.distance(centre)) / (far - near)).clamp(0.0, 1.0);
            (corner, [colour[0], colour[1], colour[2], (255.0 * cover) as u8])
        });
        if corners.iter().any(|(_, colour)| colour[3] > 0) {
            let [a, b, c, d] = corners.map(|(corner, colour)| batch.push(corner, Vec3::Z, colour));
            batch.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Colour = [1, 2, 3, 255];

    /// Every triangle is numbered within the vertices and turns as its normals say.
    fn check(batch: &Batch, name: &str) {
        assert!(!batch.triangles.is_empty(), "{name}");
        assert_eq!((batch.normals.len(), batch.colours.len()), (batch.positions.len(), batch.positions.len()), "{name}");
        for &triangle in &batch.triangles {
            let [a, b, c] = triangle.map(|corner| batch.positions[corner as usize]);
            let face = (b - a).cross(c - a);
            let normal: Vec3 = triangle.iter().map(|&corner| batch.normals[corner as usize]).sum();
            assert!(face.length() < 1.0e-12 || face.dot(normal) > 0.0, "{name}: {triangle:?} is inside out");
        }
    }

    #[test]
    fn signs_are_outside_out_whichever_way_they_point() {
        for axis in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.3, -0.8, 0.1)] {
            let mut batch = Batch::default();
            arrow(&mut batch, Vec3::ONE, 0.05 * axis, 0.001, INK);
            let reach = batch.positions.iter().map(|p| (*p - Vec3::ONE).dot(axis)).fold(0.0, f32::max);
            assert!((reach / (0.05 * axis.length_squared()) - 1.0).abs() < 1.0e-3, "{axis}: {reach}");
            check(&batch, "arrow");
            let mut batch = Batch::default();
            arc(&mut batch, Vec3::ZERO, axis, 0.03, 4.0, 0.001, INK);
            check(&batch, "arc");
            let mut batch = Batch::default();
            rings(&mut batch, Vec3::ZERO, axis, [(0.0, INK), (0.002, INK), (0.003, INK)]);
            check(&batch, "rings");
            assert_eq!(batch.triangles.len(), 4 * SIDES);
        }
    }

    #[test]
    fn an_arc_turns_to_the_right_about_its_axis() {
        let mut batch = Batch::default();
        arc(&mut batch, Vec3::ZERO, Vec3::Z, 0.03, 1.5, 0.001, INK);
        // the quarter turn from x ends at y, where the head is the widest part
        let widest = batch.positions.iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        assert!(widest.y > widest.x && widest.x > 0.0, "{widest}");
    }

    #[test]
    fn the_ground_fades_and_lies_on_whole_steps() {
        let mut batch = Batch::default();
        ground(&mut batch, Vec3::new(0.013, 0.0, -0.001), 0.01, 0.05, 0.1, [INK; 2]);
        check(&batch, "ground");
        assert!(batch.colours.iter().any(|c| c[3] == 255) && batch.colours.iter().any(|c| c[3] == 0));
        assert!(batch.positions.iter().all(|p| (p.x / 0.01 - (p.x / 0.01).round()).abs() < 1.0e-3));
    }
}
