//! The signs over a moment: discs for regions, arrows for forces, an arc for the torque; and how long they are.

use glam::Vec3;

use super::batch::{Batch, Colour};
use super::mako::MAKO;
use super::pressure::Profile;
use super::quantity::round_rung;
use super::shapes;
use crate::feed::Region;

/// Where a region sticks: blue of Okabe and Ito.
pub const STICKS: Colour = [0, 114, 178, 255];
/// Where a region slips: orange of Okabe and Ito.
pub const SLIPS: Colour = [230, 159, 0, 255];
/// Edge of a region.
const EDGE: Colour = [24, 26, 32, 255];
/// Force on the probe.
pub const FORCE: Colour = [214, 39, 40, 255];
/// Torque on the probe.
pub const TORQUE: Colour = [148, 72, 190, 255];

/// Width of a region's edge per its radius.
const EDGE_WIDTH: f32 = 0.04;

/// Width of the lines of core and ring within a pressure, likewise.
const LINE_WIDTH: f32 = 0.06;

/// Steps of the colours from a region's centre to its edge.
const PROFILE_STEPS: u16 = 12;

/// Arrows are cut at this multiple of the scene's radius: beyond it they leave every picture.
const LONGEST: f64 = 4.0;

/// The largest arc, of a full turn: the gap shows where it begins.
const LARGEST_ARC: f64 = 0.92;

/// Forces and torques smaller than this share of their scale are not drawn.
const VISIBLE: f64 = 2.0e-3;

/// Full length of an arrow as a share of the scene's radius.
pub const ARROW: f64 = 0.7;

/// How long arrows and arcs are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Force of an arrow as long as a tile of the ground \[N\].
    pub force_of_tile: f64,
    /// Torque of a full turn \[N m\].
    pub torque_of_turn: f64,
}

impl Scales {
    /// Round scales for the largest force \[N\] and torque \[N m\] in a scene of `radius` with tiles of edge `tile` \[m\].
    pub fn of(force: f64, torque: f64, radius: f64, tile: f64, longer: i32) -> Self {
        Self {
            force_of_tile: round_rung(force * tile / (ARROW * radius), -longer),
            torque_of_turn: round_rung(torque / LARGEST_ARC, -longer),
        }
    }
}

/// The colour of a share of the scale, 0 to 1.
pub fn scale_colour(share: f32) -> Colour {
    // `as` saturates; a NaN is zero
    let [r, g, b] = MAKO[usize::from((255.0 * share.min(1.0)) as u8)];
    [r, g, b, 255]
}

/// A region as its stuck core within its slipping ring.
pub fn draw_disc(batch: &mut Batch, region: &Region) {
    let edge = (1.0 - EDGE_WIDTH) * region.radius as f32;
    let core = (region.stick_radius as f32).min(edge);
    let rings = [(0.0, STICKS), (core, STICKS), (core, SLIPS), (edge, SLIPS), (edge, EDGE), (region.radius as f32, EDGE)];
    // a core of no size has no colour
    let rings = if core > 0.0 { &rings[..] } else { &rings[2..] };
    draw_rings(batch, region, rings);
}

/// A region as its pressure, the edges of core and ring as lines within it: nothing lies on anything else, which a driver would mix up.
pub fn draw_profile(batch: &mut Batch, region: &Region, end: f64) {
    let profile = Profile::of(region);
    let a = region.radius as f32;
    let width = LINE_WIDTH * a;
    let slips = region.stick_radius < region.radius;
    let core = if slips { (region.stick_radius as f32).min(a - width) } else { a };
    let at = |r: f32| (r, scale_colour(profile.at_share(r / a) / end as f32));
    let filled =
        |from: f32, to: f32| (0..=PROFILE_STEPS).map(move |k| at(from + (to - from) * f32::from(k) / f32::from(PROFILE_STEPS)));
    let inner = (core - width).max(0.0);
    let mut rings: Vec<(f32, Colour)> = filled(0.0, inner).collect();
    if core > 0.0 {
        rings.extend([(inner, STICKS), (core, STICKS)]);
    }
    if slips {
        rings.extend(filled(core, a - width));
        rings.extend([(a - width, SLIPS), (a, SLIPS)]);
    }
    draw_rings(batch, region, &rings);
}

fn draw_rings(batch: &mut Batch, region: &Region, rings: &[(f32, Colour)]) {
    shapes::rings(batch, region.centre.as_vec3(), region.normal.as_vec3(), rings.iter().copied());
}

/// Where arrows and arcs are put, and how thick.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Their origin in world \[m\].
    pub origin: Vec3,
    /// Radius of the scene \[m\].
    pub radius: f64,
    /// Edge of a tile \[m\].
    pub tile: f64,
    /// Distance of the arc from its axis \[m\].
    pub ring: f64,
}

/// Thickness of arrows as a share of the scene's radius.
const THICK: f64 = 0.012;

/// An arrow for a force \[N\].
pub fn draw_force(batch: &mut Batch, room: &Room, force: Vec3, scales: &Scales, thin: f32) {
    let length = f64::from(force.length()) * room.tile / scales.force_of_tile;
    if length > VISIBLE * room.radius {
        let reach = force.normalize_or(Vec3::Z) * length.min(LONGEST * room.radius) as f32;
        shapes::arrow(batch, room.origin, reach, thin * (THICK * room.radius) as f32, FORCE);
    }
}

/// An arc for a torque \[N m\].
pub fn draw_torque(batch: &mut Batch, room: &Room, torque: Vec3, scales: &Scales) {
    let share = f64::from(torque.length()) / scales.torque_of_turn;
    if share > VISIBLE {
        let angle = std::f64::consts::TAU * share.min(LARGEST_ARC);
        let thick = 0.8 * THICK * room.radius;
        shapes::arc(batch, room.origin, torque, room.ring as f32, angle as f32, thick as f32, TORQUE);
    }
}
