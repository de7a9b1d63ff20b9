//! Meshes of whole bodies, loaded anywhere: a box, a round column, and a **dome** over a held base.
//!
//! The dome is a square block on the base inside five shells: four around it, which stand on the base as well, and one on top. The rim of the base
//! is an edge of the shells; round surfaces have no edge where bricks would be flat. It works in half extents of the body, base at -1.

use glam::DVec3;

use super::bricks::{Bricks, Skin, even};
use super::solid::{Cut, Solid};

/// Half width of the inner block, as a share of the body's.
const INNER: f64 = 0.5;

/// How much the inner block's corners are drawn in, so that they stay off the round surface.
const DRAWN_IN: f64 = 0.12;

/// Bricks across the inner block and up, and through the shells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cells {
    across: usize,
    up: usize,
    shells: usize,
}

/// A mesh of the body with about `fineness` bricks along the mean of its edges; the held base is [`Skin::Base`], all else [`Skin::Free`].
pub(crate) fn mesh(cut: &Cut, fineness: usize) -> Bricks {
    let half = cut.half_size;
    let step = (half.x * half.y * half.z).cbrt() / fineness as f64;
    let along = |half: f64, least: usize| ((half / step).round() as usize).max(least);
    match cut.solid {
        Solid::Box { .. } => cuboid(cut, [half.x, half.y, half.z].map(|half| along(half, LEAST))),
        Solid::Cylinder { .. } | Solid::Ellipsoid { .. } => {
            let across = along((half.x * half.y).sqrt(), LEAST);
            let up = along(half.z, LEAST) + RIM;
            let cells = Cells { across, up, shells: fineness.div_ceil(2) + 1 };
            if matches!(cut.solid, Solid::Cylinder { .. }) { column(cut, cells) } else { dome(cut, cells) }
        }
    }
}

/// Bricks along an edge at least.
const LEAST: usize = 3;

/// Bricks more over the height than the body's proportions ask for, gathered at the rim of the base: without them a sphere dragged at its top comes
/// out 6 % too stiff.
const RIM: usize = 2;

fn cuboid(cut: &Cut, cells: [usize; 3]) -> Bricks {
    let mut mesh = Bricks::default();
    let [x, y, z] = cells.map(even);
    let free = Some(Skin::Free);
    mesh.block([&x, &y, &z], [free, free, free, free, Some(Skin::Base), free], |u, v, w| {
        cut.centre + cut.half_size * (DVec3::new(u, v, w) * 2.0 - 1.0)
    });
    mesh
}

/// (u, v) of the inner square, -1 to 1, turned by `quarter` right angles.
fn turned(quarter: usize, u: f64, v: f64) -> (f64, f64) {
    match quarter {
        0 => (u, v),
        1 => (-v, u),
        2 => (-u, -v),
        _ => (v, -u),
    }
}

/// Equal angles instead of equal lengths along an edge of the square.
fn equal_angle(u: f64) -> f64 {
    (u * std::f64::consts::FRAC_PI_4).tan()
}

/// The inner square: corners drawn in.
fn square(u: f64, v: f64) -> (f64, f64) {
    (INNER * equal_angle(u) * (1.0 - DRAWN_IN * v * v), INNER * equal_angle(v) * (1.0 - DRAWN_IN * u * u))
}

/// Direction of a point of the square's edge from the axis.
fn azimuth(u: f64, v: f64) -> (f64, f64) {
    let (x, y) = (equal_angle(u), equal_angle(v));
    let reach = x.hypot(y);
    (x / reach, y / reach)
}

fn signed(parameter: f64) -> f64 {
    2.0 * parameter - 1.0
}

/// Breaks that gather at 0, as the square root's slope does at the rim of the base.
fn gathered(n: usize) -> Vec<f64> {
    even(n).into_iter().map(|at| at * at).collect()
}

/// The same that gather at 1.
fn gathered_out(n: usize) -> Vec<f64> {
    gathered(n).into_iter().rev().map(|at| 1.0 - at).collect()
}

fn column(cut: &Cut, cells: Cells) -> Bricks {
    let place = |x: f64, y: f64, w: f64| cut.centre + cut.half_size * DVec3::new(x, y, signed(w));
    let (across, up, shells) = (even(cells.across), even(cells.up), even(cells.shells));
    let ends = [Some(Skin::Base), Some(Skin::Free)];
    let mut mesh = Bricks::default();
    mesh.block([&across, &across, &up], [None, None, None, None, ends[0], ends[1]], |u, v, w| {
        let (x, y) = square(signed(u), signed(v));
        place(x, y, w)
    });
    for quarter in 0..4 {
        mesh.block([&shells, &across, &up], [None, Some(Skin::Free), None, None, ends[0], ends[1]], |t, v, w| {
            let (u, v) = turned(quarter, 1.0, signed(v));
            let ((x, y), (ox, oy)) = (square(u, v), azimuth(u, v));
            place(x + (ox - x) * t, y + (oy - y) * t, w)
        });
    }
    mesh
}

fn dome(cut: &Cut, cells: Cells) -> Bricks {
    let base = cut.solid.section(cut.base) / cut.half_size;
    let base = DVec3::new(base.x, base.y, 1.0);
    // inner block: as wide as its share of the section, from the base to the same share of the height
    let inner = |u: f64, v: f64, w: f64| {
        let (x, y) = square(u, v);
        let width = base + (DVec3::ONE - base) * w;
        let top = INNER * (1.0 - DRAWN_IN * (u * u + v * v));
        cut.centre + cut.half_size * DVec3::new(x * width.x, y * width.y, -1.0 + (1.0 + top) * w)
    };
    let ray = |direction: DVec3| cut.ray(direction * cut.half_size).point;
    let side = |u: f64, v: f64, w: f64| {
        let (x, y) = azimuth(u, v);
        let rim = 1.0 / (x / base.x).hypot(y / base.y);
        let low = (-1.0_f64).atan2(rim);
        let high = 1.0_f64.atan2(equal_angle(u).hypot(equal_angle(v)));
        let (up, level) = (low + (high - low) * w).sin_cos();
        ray(DVec3::new(x * level, y * level, up))
    };
    let (across, up, shells) = (even(cells.across), gathered(cells.up), gathered_out(cells.shells));
    let mut mesh = Bricks::default();
    let held = Some(Skin::Base);
    mesh.block([&across, &across, &up], [None, None, None, None, held, None], |u, v, w| inner(signed(u), signed(v), w));
    for quarter in 0..4 {
        mesh.block([&shells, &across, &up], [None, Some(Skin::Free), None, None, held, None], |t, v, w| {
            let (u, v) = turned(quarter, 1.0, signed(v));
            inner(u, v, w).lerp(side(u, v, w), t)
        });
    }
    mesh.block([&across, &across, &shells], [None, None, None, None, None, Some(Skin::Free)], |u, v, t| {
        let (u, v) = (signed(u), signed(v));
        inner(u, v, 1.0).lerp(ray(DVec3::new(equal_angle(u), equal_angle(v), 1.0)), t)
    });
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::element::Lame;
    use crate::fem::system::Stiffness;

    #[test]
    fn no_brick_is_folded_and_every_surface_closes() {
        let bodies = [
            Cut::new(Solid::Box { size: DVec3::new(2.0, 1.0, 0.5) }, 0.1),
            Cut::new(Solid::Cylinder { radius: 0.3, height: 2.0 }, 0.0),
            Cut::new(Solid::Cylinder { radius: 1.0, height: 0.4 }, 0.0),
            Cut::new(Solid::Ellipsoid { axes: DVec3::ONE }, 0.02),
            Cut::new(Solid::Ellipsoid { axes: DVec3::ONE }, 1.0),
            Cut::new(Solid::Ellipsoid { axes: DVec3::new(1.0, 0.2, 0.4) }, 0.1),
        ];
        for cut in bodies {
            let mesh = mesh(&cut, 4);
            assert!(Stiffness::new(&mesh, Lame::of_unit_shear(0.3)).is_ok(), "{cut:?}");
            // each edge of an outer face belongs to two of them
            let mut edges = std::collections::HashMap::new();
            for face in &mesh.faces {
                for [a, b] in [[0, 2], [2, 8], [8, 6], [6, 0]] {
                    let (a, b) = (face.nodes[a], face.nodes[b]);
                    *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            assert!(edges.values().all(|&count| count == 2), "{cut:?}");
        }
    }
}
