//! Evaluates a patch's field over a block of points (theory.md, equations 9.1 to 9.5).
//!
//! Beyond `1/FAR` contact radii every radial function is a short series whose coefficients the patch prepared; nearer, all of them share one
//! root and one arc cosine. A block without a near point leaves the near forms out; which form a point gets depends on the point alone.

#![expect(clippy::needless_range_loop, reason = "one index over several arrays is the form that becomes vector instructions")]

use crate::math::PI;

use super::block::{BLOCK, Block, Lane, inverse_root, less, more};
use super::field::{Dent, Drag, Field, Frame, Held, Turn};
use super::local::{FAR, FAR_TURNED, acos_over_root, quadratic};
use super::slip_table::Row;

/// Where the points of a block are as the patch sees them.
struct Placed {
    /// Along the patch's first and second axis, and below its surface \[m\].
    x: Lane,
    y: Lane,
    depth: Lane,
    /// One over the distance from the patch's centre \[1/m\].
    inverse: Lane,
    /// Whether any point is near.
    any_near: bool,
}

/// The radial functions at one point.
#[derive(Clone, Copy)]
struct Radial {
    /// Dent at the surface \[m\].
    dent: f32,
    /// X and Y of equation (9.3) \[m\].
    along: f32,
    across: f32,
    /// Rotation \[rad\].
    turn: f32,
    /// Field of a tilted disc, and what it leaves of 1 over the distance from it: 1 - max(q, 1)^2 turned.
    turned: f32,
    apart: f32,
    /// Share of the load inside the point.
    enclosed: f32,
}

/// Least square of a distance that counts \[m^2\]: its inverse root is an ordinary number.
const LEAST_SQUARE: f32 = 1.0e-30;

impl Field {
    /// Adds the displacement of the block's points.
    pub fn add(&self, block: &mut Block) {
        if self.frame.upright { self.add_by::<true>(block) } else { self.add_by::<false>(block) }
    }

    fn add_by<const UPRIGHT: bool>(&self, block: &mut Block) {
        let placed = self.frame.place::<UPRIGHT>(block);
        if placed.any_near {
            let slipping = if self.turn.slips { self.turn.row.over(&placed, &self.frame) } else { [0.0; BLOCK] };
            self.sum::<UPRIGHT, true>(&placed, &slipping, block);
        } else {
            self.sum::<UPRIGHT, false>(&placed, &[0.0; BLOCK], block);
        }
    }

    #[inline(always)]
    fn sum<const UPRIGHT: bool, const NEAR: bool>(&self, placed: &Placed, slipping: &Lane, block: &mut Block) {
        let Self { frame, dent, drag, turn, held } = self;
        let (e, f, n) = (frame.first, frame.second, frame.normal);
        for i in 0..BLOCK {
            let (x, y, depth, inverse) = (placed.x[i], placed.y[i], placed.depth[i], placed.inverse[i]);
            let s = frame.radius * inverse;
            let mut radial = far(s, dent, drag, turn);
            if NEAR {
                let d2 = x * x + y * y + depth * depth;
                let close = near(s, d2 * inverse * frame.inverse_radius, dent, drag, turn, slipping[i]);
                radial = if s < FAR { radial } else { close };
            }
            let (along, across, up) = combined(x, y, depth, inverse, frame, &radial, dent, drag, held);
            let fade = frame.fade(block.z[i]);
            let (u, v, w) = (along * fade, across * fade, up * fade);
            if UPRIGHT {
                block.ux[i] += u * e.x + v * f.x;
                block.uy[i] += u * e.y + v * f.y;
                block.uz[i] += w;
            } else {
                block.ux[i] += u * e.x + v * f.x + w * n.x;
                block.uy[i] += u * e.y + v * f.y + w * n.y;
                block.uz[i] += u * e.z + v * f.z + w * n.z;
            }
        }
    }
}

impl Frame {
    #[inline(always)]
    fn place<const UPRIGHT: bool>(&self, block: &Block) -> Placed {
        let (c, e, f, n) = (self.centre, self.first, self.second, self.normal);
        let mut placed = Placed { x: [0.0; BLOCK], y: [0.0; BLOCK], depth: [0.0; BLOCK], inverse: [0.0; BLOCK], any_near: false };
        let reach = self.radius / FAR;
        let mut near = 0_u32;
        for i in 0..BLOCK {
            let (dx, dy, dz) = (block.x[i] - c.x, block.y[i] - c.y, block.z[i] - c.z);
            let (x, y, below) = if UPRIGHT {
                (dx * e.x + dy * e.y, dx * f.x + dy * f.y, -dz)
            } else {
                let below = -(dx * n.x + dy * n.y + dz * n.z);
                (dx * e.x + dy * e.y + dz * e.z, dx * f.x + dy * f.y + dz * f.z, below)
            };
            let level = x * x + y * y;
            // depth under the surface as curved at the patch: a convex body falls away without being deep
            let depth = more(below - self.half_curvature * level, 0.0);
            let inverse = inverse_root(more(level + depth * depth, LEAST_SQUARE));
            (placed.x[i], placed.y[i], placed.depth[i], placed.inverse[i]) = (x, y, depth, inverse);
            near |= u32::from(inverse * reach >= 0.999);
        }
        placed.any_near = near != 0;
        placed
    }

    /// 1 at the patch, 0 at the base, level at the patch.
    #[inline(always)]
    fn fade(&self, z: f32) -> f32 {
        let above = z - self.base;
        let missing = if above < self.height { 1.0 - above * self.inverse_height } else { 0.0 };
        1.0 - missing * missing
    }
}

/// The radial functions by their series for small `s` = a/distance.
#[inline(always)]
fn far(s: f32, dent: &Dent, drag: &Drag, turn: &Turn) -> Radial {
    let s2 = s * s;
    let turned = s * quadratic(&FAR_TURNED, s2);
    Radial {
        dent: s * quadratic(&dent.far, s2),
        along: s * quadratic(&drag.far_along, s2),
        across: s * quadratic(&drag.far_across, s2),
        turn: s * s2 * quadratic(&turn.far, s2),
        turned: s2 * turned,
        apart: 1.0 - turned,
        enclosed: 1.0,
    }
}

/// The radial functions by their closed forms, at `s` = a/distance and `q` = distance/a; `slipping` is the turn of the part in partial slip.
#[inline(always)]
fn near(s: f32, q: f32, dent: &Dent, drag: &Drag, turn: &Turn, slipping: f32) -> Radial {
    let q2 = q * q;
    let outside = less(s, 1.0);
    let inside = q2 < 1.0;
    // sqrt(1 - q^2) within, sqrt(1 - s^2) without
    let left = more(1.0 - less(q2, outside * outside), 0.0);
    let both = left * inverse_root(more(left, LEAST_SQUARE));
    let (rim, slope) = if inside { (both, 0.0) } else { (0.0, both) };

    let outer = Shape::new(q2, q, outside, slope);
    let disc = 1.0 - (2.0 / PI) * (slope * acos_over_root(outside));
    let disc_across = (2.0 / PI) * outside * slope;
    let turned = disc - disc_across;

    let (r, t) = (q * drag.stuck_inverse, less(s * drag.stuck, 1.0));
    let rest = more(1.0 - t * t, 0.0);
    let inner = Shape::new(r * r, r, t, rest * inverse_root(more(rest, LEAST_SQUARE)));
    Radial {
        dent: dent.bowl * outer.bowl + dent.disc * disc + dent.rest * more(1.0 - q2, 0.0),
        along: drag.bowl * outer.bowl - drag.inner * inner.bowl + drag.disc * disc,
        across: drag.bowl * outer.across - drag.inner * inner.across + drag.disc * disc_across,
        turn: slipping + turn.disc * turned,
        turned,
        apart: 1.0 - more(q2, 1.0) * turned,
        // (1 - x^3)/(1 - x^2) for x = sqrt(1 - q^2)
        enclosed: (1.0 + rim + rim * rim) / (1.0 + rim),
    }
}

/// Bowl and its part across, equation (9.1).
struct Shape {
    bowl: f32,
    across: f32,
}

impl Shape {
    /// At `q` with `s` = min(1/q, 1) and `slope` = sqrt(1 - s^2).
    #[inline(always)]
    fn new(q2: f32, q: f32, s: f32, slope: f32) -> Self {
        let arc = 0.5 * PI - slope * acos_over_root(s);
        let bowl = ((2.0 - q2) * arc + q * slope) * (1.0 / PI);
        let across = ((2.0 - q2) * (slope * s) + q2 * arc) * (0.5 / PI);
        let inside = q2 < 1.0;
        Self { bowl: if inside { 1.0 - 0.5 * q2 } else { bowl }, across: if inside { 0.25 * q2 } else { across } }
    }
}

/// Displacement along the patch's three axes.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one point's numbers, kept in registers")]
fn combined(
    x: f32,
    y: f32,
    depth: f32,
    inverse: f32,
    frame: &Frame,
    radial: &Radial,
    dent: &Dent,
    drag: &Drag,
    held: &Held,
) -> (f32, f32, f32) {
    let apart = less(inverse, frame.inverse_radius);
    let steep = depth * apart;
    let level = 1.0 / (1.0 + steep);
    let inwards = radial.dent * (1.0 + dent.below * steep * steep);
    let drawn = drag.squeeze * radial.enclosed * level;
    let outwards = dent.force * (steep - drawn) * (apart * apart);
    // Cerruti below the surface; at the surface A - B, 2 B of equation (9.3)
    let squeezed = drag.squeeze * level;
    let (cos, cos_per_length) = (x * inverse, x * inverse * inverse);
    let shift = radial.along * (1.0 + drag.poisson + squeezed) - radial.across * drag.poisson;
    let spread = radial.across * (1.0 - squeezed * level) * cos_per_length;
    let sunk = cos * apart * drag.force * (steep + squeezed * radial.apart);
    let back = (held.rise + held.slope.x * x + held.slope.y * y) * radial.turned;
    let radially = outwards + spread;
    (shift + radially * x - radial.turn * y, radially * y + radial.turn * x, -(inwards + sunk + back))
}

impl Row {
    /// The rotation at the points that are near.
    fn over(&self, placed: &Placed, frame: &Frame) -> Lane {
        let (mut q, mut s) = ([0.0; BLOCK], [0.0; BLOCK]);
        for i in 0..BLOCK {
            let d2 = placed.x[i] * placed.x[i] + placed.y[i] * placed.y[i] + placed.depth[i] * placed.depth[i];
            q[i] = d2 * placed.inverse[i] * frame.inverse_radius;
            s[i] = frame.radius * placed.inverse[i];
        }
        self.at_all(&q, &s)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::footprint::Footprint;
    use crate::model::{Material, Model, ModelSpec, ObjectShape, ProbePart, ProbeShape};
    use crate::params::{Params, ParamsSpec, Tier};
    use crate::patch::{Grip, Patch};
    use crate::profile::{FULLNESS_HERTZ, FULLNESS_PUNCH};
    use crate::surface::local;
    use crate::surface::slip_table::slip_field;
    use crate::tier::Hold;
    use crate::tier::point::curve::Curve;

    const A: f32 = 0.004;

    /// A patch on a half space with the load P, the force `pull` mu P along x and the torque `spin` T_max, and what the block makes of points at
    /// growing distance in the direction (0.8, 0.6).
    fn evaluated(nu: f32, fullness: f32, pull: f32, spin: f32, look: impl Fn(f32, Vec3, &Hold, &Params)) {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: nu, density: 1.0e3 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, &ball)).unwrap();
        let params = Params::new(&ParamsSpec { tier: Tier::Bristle, ..ParamsSpec::default() }).unwrap();
        let mut patch = Patch::born(0, 0, 0, Vec3::ZERO, Vec3::Z);
        patch.tangent = Vec3::X;
        patch.footprint = Footprint { radius: A, load: 20.0, fullness, ..Footprint::NONE };
        let hold = Hold::new(&model, &params, &patch, patch.ground, 0.0);
        patch.grip = Grip {
            force: Vec2::new(pull * params.mu_d * hold.load, 0.0),
            torque: spin * Curve::twist(&hold, params.mu_d).full(),
            stick: 1.0,
        };
        let field = Field::new(&model, &params, &patch).unwrap();
        let places: [f32; BLOCK] = core::array::from_fn(|i| A * 0.02 * (1.0 + i as f32) * (1.0 + 0.02 * (i * i) as f32));
        let mut block = Block::load(&places.map(|r| Vec3::new(0.8 * r, 0.6 * r, 0.0)));
        field.add(&mut block);
        for (i, &r) in places.iter().enumerate() {
            look(r / A, Vec3::new(block.ux[i], block.uy[i], block.uz[i]), &hold, &params);
        }
    }

    #[test]
    fn drag_is_its_closed_form_to_one_in_ten_thousand_of_the_patch_s_shift() {
        for (nu, pull) in [(0.5, 0.2), (0.3, 0.2), (0.3, 0.9), (0.0, 1.0), (0.5, 0.02)] {
            evaluated(nu, FULLNESS_HERTZ, pull, 0.0, |q, u, hold, params| {
                let full = 1.5 * params.mu_d * hold.load / hold.drag_stiffness;
                let stuck = libm::cbrtf(1.0 - pull);
                let form = |f: fn(f32) -> f32| full * (f(q) - if stuck > 0.0 { stuck * stuck * f(q / stuck) } else { 0.0 });
                let (along, across) = (form(local::bowl), nu / (2.0 - nu) * form(local::bowl_across));
                let shift = full * (1.0 - stuck * stuck);
                let expected = Vec2::new(along - across + 2.0 * across * 0.64, 2.0 * across * 0.48);
                // the load draws the surface inwards where nu < 1/2
                let drawn = u - evaluated_without_grip(nu, q);
                assert!((drawn.truncate() - expected).length() < 1.0e-4 * shift, "nu {nu} pull {pull} q {q}: {drawn} {expected}");
            });
        }
    }

    fn evaluated_without_grip(nu: f32, wanted: f32) -> Vec3 {
        let found = core::cell::Cell::new(Vec3::ZERO);
        evaluated(nu, FULLNESS_HERTZ, 0.0, 0.0, |q, u, _, _| {
            if q == wanted {
                found.set(u);
            }
        });
        found.get()
    }

    #[test]
    fn dent_and_punch_are_their_closed_forms() {
        for (fullness, form) in [(FULLNESS_HERTZ, local::bowl as fn(f32) -> f32), (FULLNESS_PUNCH, local::disc)] {
            evaluated(0.5, fullness, 0.0, 0.0, |q, u, hold, _| {
                // the patch is not said to be any deeper: what the probe's shape takes off is the tenth allowed, inside only
                let share = if fullness == FULLNESS_HERTZ { 0.75 } else { 0.5 };
                let depth = share * hold.load / (4.0 * 1.0e6 * A);
                let expected = depth * (form(q) - 0.1 * (1.0 - q * q).max(0.0));
                assert!((u.z + expected).abs() < 1.0e-5 * depth, "{fullness} {q}: {u} {expected}");
            });
        }
    }

    #[test]
    fn twist_is_table_or_disc_near_and_carries_its_torque_far() {
        for spin in [0.01_f32, 0.3, 0.9] {
            evaluated(0.5, FULLNESS_HERTZ, 0.0, spin, |q, u, hold, params| {
                let curve = Curve::twist(hold, params.mu_d);
                let phi = curve.inverse(spin * curve.full());
                let found = (-0.6 * u.x + 0.8 * u.y) / (A * q);
                let z = phi / curve.slope_reach();
                let slipping = (z / 0.02).min(1.0);
                let expected = phi * (slip_field(z, q) * slipping + local::turned_disc(q) * (1.0 - slipping));
                // beyond the near forms the torque counts, which the table's last columns hold to a hundredth
                let allowed = if q < 1.0 / FAR { 1.0e-4 } else { 2.0e-2 / (q * q * q) };
                assert!((found - expected).abs() < allowed * phi, "{spin} {q}: {found} {expected} of {phi}");
            });
        }
    }
}
