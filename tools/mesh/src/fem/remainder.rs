//! A flat contact: the half space's solution is taken out, and only the smooth remainder is meshed.
//!
//! u = u_h + u_r. The half space's solution u_h of the loaded disc is exact and leaves the plane of the contact free of traction.
//! The remainder u_r carries minus its tractions on the other free faces and minus its displacement on the base, and has no
//! singularity at the contact: a coarse mesh suffices. The compliance beyond the half space is the work of the disc's tractions on u_r.
//!
//! The disc's tractions are those of the bonded rigid disc, proportional to 1/sqrt(a^2 - r^2) (force) and r/sqrt(a^2 - r^2) (torque),
//! summed over 24 points; with r = a sqrt(1 - c^2) the weights are even in c.

use glam::{DMat3, DVec3};

use super::FemError;
use super::bricks::{Bricks, Face, Skin};
use super::element::{GAUSS, Lame, NODES, line, map, shape};
use super::half_space;
use super::system::Stiffness;
use super::{Direction, mirrors};

/// Rays of the disc's quadrature: a multiple of 8, so that no point lies on a mirror.
const RAYS: usize = 8;

/// A contact: its middle, and the axes of its frame: two along the surface, the third into the body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: DVec3,
    pub axes: DMat3,
    pub radius: f64,
}

/// A point of the disc (in the frame) and the force on it.
type Loaded = (DVec3, DVec3);

/// Unit force or unit torque spread over the disc.
fn loads(direction: Direction, radius: f64) -> Vec<Loaded> {
    let mut points = Vec::new();
    for (c, weight) in GAUSS.map(|(g, w)| (0.5 * (1.0 + g), 0.5 * w)) {
        let r = radius * (1.0 - c * c).sqrt();
        for ray in 0..RAYS {
            let angle = (ray as f64 + 0.5) * std::f64::consts::TAU / RAYS as f64;
            let (sin, cos) = angle.sin_cos();
            let share = weight / RAYS as f64;
            let force = match direction {
                Direction::Normal => DVec3::Z * share,
                Direction::DragX => DVec3::X * share,
                Direction::DragY => DVec3::Y * share,
                // sum of share r^2 is 2/3 a^2
                Direction::Twist => DVec3::new(-sin, cos, 0.0) * (share * r * 1.5 / (radius * radius)),
            };
            points.push((DVec3::new(r * cos, r * sin, 0.0), force));
        }
    }
    points
}

/// Compliances beyond the half space, in the order of [`Direction::ALL`]; shear modulus 1.
pub(super) fn compliances(mesh: &Bricks, frame: &Frame, nu: f64, progress: &mut dyn FnMut(u32)) -> Result<[f64; 4], FemError> {
    let stiffness = Stiffness::new(mesh, Lame::of_unit_shear(nu))?;
    let mut found = [0.0; 4];
    let mut factored = None;
    for (slot, direction) in found.iter_mut().zip(Direction::ALL) {
        if factored.is_none() || mesh.quarter {
            factored = Some(stiffness.factor(&held(mesh, direction))?);
        }
        let loaded = loads(direction, frame.radius);
        let u_base = base(mesh, frame, &loaded, nu);
        let u = factored.as_ref().map(|f| f.solve(&tractions(mesh, frame, &loaded, nu), &u_base)).unwrap_or_default();
        *slot = work(mesh, frame, &loaded, &u)?;
        progress(1);
    }
    Ok(found)
}

fn held(mesh: &Bricks, direction: Direction) -> Vec<bool> {
    let mut held = mirrors(mesh, direction);
    for face in mesh.faces.iter().filter(|face| face.skin == Skin::Base) {
        for &node in &face.nodes {
            held[3 * node as usize..3 * node as usize + 3].fill(true);
        }
    }
    held
}

/// Minus the half space's displacement on the base.
fn base(mesh: &Bricks, frame: &Frame, loaded: &[Loaded], nu: f64) -> Vec<f64> {
    let mut u = vec![0.0; 3 * mesh.nodes.len()];
    for face in mesh.faces.iter().filter(|face| face.skin == Skin::Base) {
        for &node in &face.nodes {
            let at = frame.axes.transpose() * (mesh.nodes[node as usize] - frame.origin);
            let sum: DVec3 = loaded.iter().map(|&(point, force)| half_space::displacement(at - point, force, nu)).sum();
            let start = 3 * node as usize;
            u[start..start + 3].copy_from_slice(&(-(frame.axes * sum)).to_array());
        }
    }
    u
}

/// Minus the half space's tractions on the free faces, as nodal forces.
fn tractions(mesh: &Bricks, frame: &Frame, loaded: &[Loaded], nu: f64) -> Vec<f64> {
    let lame = Lame::of_unit_shear(nu);
    let mut load = vec![0.0; 3 * mesh.nodes.len()];
    for face in mesh.faces.iter().filter(|face| face.skin == Skin::Free) {
        for (s, ws) in GAUSS {
            for (t, wt) in GAUSS {
                let (place, area, value) = on_face(mesh, face, s, t);
                let at = frame.axes.transpose() * (place - frame.origin);
                let normal = frame.axes.transpose() * area;
                let pull: DVec3 =
                    loaded.iter().map(|&(point, force)| half_space::stress(at - point, force, nu, lame) * normal).sum();
                let pull = frame.axes * pull * (-ws * wt);
                for (&node, n) in face.nodes.iter().zip(value) {
                    for i in 0..3 {
                        load[3 * node as usize + i] += pull[i] * n;
                    }
                }
            }
        }
    }
    load
}

/// Place, outward area vector and shape functions at (s, t) of a face.
fn on_face(mesh: &Bricks, face: &Face, s: f64, t: f64) -> (DVec3, DVec3, [f64; 9]) {
    let ((a, da), (b, db)) = (line(s), line(t));
    let (mut place, mut along_s, mut along_t, mut value) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, [0.0; 9]);
    for (i, &node) in face.nodes.iter().enumerate() {
        let at = mesh.nodes[node as usize];
        value[i] = a[i % 3] * b[i / 3];
        place += at * value[i];
        along_s += at * (da[i % 3] * b[i / 3]);
        along_t += at * (a[i % 3] * db[i / 3]);
    }
    let area = along_s.cross(along_t);
    let outward = if area.dot(place - face.inside) < 0.0 { -area } else { area };
    (place, outward, value)
}

/// Work of the disc's tractions on the remainder.
fn work(mesh: &Bricks, frame: &Frame, loaded: &[Loaded], u: &[f64]) -> Result<f64, FemError> {
    let mut sum = 0.0;
    for &(point, force) in loaded {
        let place = frame.origin + frame.axes * point;
        if mesh.quarter && (place.x < 0.0 || place.y < 0.0) {
            continue;
        }
        let (brick, at) = locate(mesh, place).ok_or(FemError::Outside)?;
        let value = shape(at).0;
        let force = frame.axes * force;
        for (&node, n) in mesh.bricks[brick].iter().zip(value) {
            let start = 3 * node as usize;
            sum += DVec3::new(u[start], u[start + 1], u[start + 2]).dot(force) * n;
        }
    }
    Ok(if mesh.quarter { 4.0 * sum } else { sum })
}

/// Newton steps to find a place in a brick; more than a brick that holds it ever needs.
const STEPS: usize = 12;
/// How far outside its brick a place may seem to lie, in element coordinates: rounding only.
const SLACK: f64 = 1.0e-6;

/// The brick that holds `place`, and where in it.
fn locate(mesh: &Bricks, place: DVec3) -> Option<(usize, DVec3)> {
    mesh.bricks.iter().enumerate().find_map(|(index, brick)| {
        let corners: [DVec3; NODES] = mesh.corners(brick);
        let reach = corners.iter().map(|c| c.distance(corners[13])).fold(0.0, f64::max);
        if place.distance(corners[13]) > 1.5 * reach {
            return None;
        }
        let mut at = DVec3::ZERO;
        for _ in 0..STEPS {
            let (here, jacobian) = map(&corners, at);
            at = (at + jacobian.inverse() * (place - here)).clamp(DVec3::splat(-2.0), DVec3::splat(2.0));
        }
        let close = (map(&corners, at).0 - place).length() < SLACK * reach;
        (close && at.abs().max_element() <= 1.0 + SLACK).then_some((index, at))
    })
}
