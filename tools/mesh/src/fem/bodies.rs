//! Which mesh and which method a body and a place take, and the way back to SI units.

use glam::{DMat3, DVec3};

use super::bricks::{Bricks, RoundCut, Skin, bent_quarter, cuboid, even, round_quarter};
use super::remainder::Frame;
use super::{Body, BodyConstants, Direction, Elastic, FemError, Fineness, Found, MAX_POISSON, Place, patch, remainder};

/// Compliances in the order of [`Direction::ALL`], and the unknowns of the largest mesh.
type Run = ([f64; 4], usize);

/// Mesh density: index 0 is only used for the error of the coarsest answer.
#[derive(Clone, Copy, Debug)]
struct Density {
    /// Bricks along the longest edge of a box, over the radius and the height of a cylinder.
    cells: usize,
    /// Distance of the first ring of bricks from the edge of a bonded patch, as a share of its radius.
    edge: f64,
    /// Growth of the rings and layers from there on.
    growth: f64,
    /// Bricks over a right angle.
    turns: usize,
}

const DENSITIES: [Density; 4] = [
    Density { cells: 3, edge: 0.16, growth: 3.2, turns: 2 },
    Density { cells: 4, edge: 0.08, growth: 2.6, turns: 4 },
    Density { cells: 6, edge: 0.04, growth: 2.1, turns: 4 },
    Density { cells: 9, edge: 0.02, growth: 1.75, turns: 6 },
];

/// Compliance constants of `body` at `place`, with the distance to a coarser mesh as error.
///
/// `progress` is called with the number of solved load cases and how many there will be.
///
/// # Errors
/// Names a parameter out of range, or a place that is not supported (tops at their middle and all of a box but its base are), or
/// a mesh that cannot be made or solved.
pub fn body_constants(
    body: &Body,
    material: &Elastic,
    place: &Place,
    fineness: Fineness,
    progress: &mut dyn FnMut(u32, u32),
) -> Result<Found, FemError> {
    let unit = check(body, material, place)?;
    let nu = material.poisson_ratio.min(MAX_POISSON);
    let fine = 1 + fineness as usize;
    let total = 2 * if matches!(body, Body::Ellipsoid { .. }) { 12 } else { 4 };
    let mut done = 0;
    let mut count = |n| {
        done += n;
        progress(done, total);
    };
    let mut at = |density| run(body, place, unit, nu, DENSITIES[density], &mut count);
    let (coarse, _) = at(fine - 1)?;
    let (values, unknowns) = at(fine)?;
    let difference = std::array::from_fn(|i| (values[i] - coarse[i]).abs());
    let si = |c| in_si(c, unit, material.shear_modulus);
    Ok(Found { constants: si(values), error: si(difference), unknowns })
}

fn in_si(c: [f64; 4], unit: f64, shear_modulus: f64) -> BodyConstants {
    let force = 1.0 / (shear_modulus * unit);
    BodyConstants { normal: c[0] * force, drag: [c[1] * force, c[2] * force], twist: c[3] * force / (unit * unit) }
}

fn run(body: &Body, place: &Place, unit: f64, nu: f64, density: Density, count: &mut dyn FnMut(u32)) -> Result<Run, FemError> {
    let frame = frame(place, unit);
    match *body {
        Body::Box { size } => flat(&box_mesh(size / unit, place.normal, density), &frame, nu, count),
        Body::Cylinder { radius, height } => {
            let height = height / unit;
            let layers = ((density.cells as f64 * height / (radius / unit)).round() as usize).clamp(3, 3 * density.cells);
            let mut rings = even(density.cells);
            rings.remove(0);
            let cut = RoundCut { rings, layers: even(layers), turns: density.turns };
            let mesh = cylinder(&cut, radius / unit, height);
            flat(&mesh, &Frame { origin: DVec3::Z * height, ..frame }, nu, count)
        }
        Body::Ellipsoid { semi_axes, held_below } => {
            curved(semi_axes / unit, held_below / unit, frame.radius, nu, density, count)
        }
    }
}

fn flat(mesh: &Bricks, frame: &Frame, nu: f64, count: &mut dyn FnMut(u32)) -> Result<Run, FemError> {
    Ok((remainder::compliances(mesh, frame, nu, count)?, 3 * mesh.nodes.len()))
}

/// Bricks nearly as long as wide, at least three along each edge.
fn box_mesh(size: DVec3, contact: DVec3, density: Density) -> Bricks {
    let step = (size.x * size.y * size.z).cbrt() / density.cells as f64;
    let cells = size.to_array().map(|edge| ((edge / step).round() as usize).max(3));
    cuboid(size, contact, cells)
}

fn cylinder(cut: &RoundCut, radius: f64, height: f64) -> Bricks {
    round_quarter(cut, Skin::Contact, |s, w| (radius * s, height * w))
}

/// Angle from the pole up to which the top of the mesh reaches; beyond it lies the side.
const SHOULDER: f64 = std::f64::consts::FRAC_PI_3;

/// A bonded patch on the pole, minus the same on a flat body cut in the same way, plus that body's remainder.
fn curved(axes: DVec3, held: f64, a: f64, nu: f64, density: Density, count: &mut dyn FnMut(u32)) -> Result<Run, FemError> {
    // the flat body has the mesh of the round one near the patch
    let mean = (axes.x * axes.y).sqrt();
    let (radius, height) = (mean * SHOULDER.sin(), 2.0 * axes.z);
    let cut = graded(a / radius, a / height, density);
    let stretched = ellipsoid(&cut, axes, held, a / radius);
    let rigid = patch::stiffnesses(&stretched, a, nu, &Direction::ALL, count)?;
    let reference = patch::stiffnesses(&cylinder(&cut, radius, height), a, nu, &Direction::ALL, count)?;
    let cells = density.cells;
    let mut rings = even(cells);
    rings.remove(0);
    let smooth = RoundCut { rings, layers: even((cells as f64 * height / radius).round() as usize), turns: density.turns };
    let frame = Frame { origin: DVec3::Z * height, axes: DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), radius: a };
    let rest = remainder::compliances(&cylinder(&smooth, radius, height), &frame, nu, count)?;
    Ok((std::array::from_fn(|i| 1.0 / rigid[i] - 1.0 / reference[i] + rest[i]), 3 * stretched.nodes.len()))
}

/// Distances from a graded edge, growing by the density's factor, none further than `longest` from the next, up to `reach`.
fn steps(density: Density, longest: f64, reach: f64) -> Vec<f64> {
    let mut at = density.edge;
    let mut list = Vec::new();
    while at < reach {
        list.push(at);
        at += (at * (density.growth - 1.0)).min(longest);
    }
    list
}

/// Distance of the second break from a held edge, as a share of the height or the radius, in units of the density's edge: the
/// stress at the rim of the held surface grows without bound and wants its own grading.
const RIM: f64 = 0.5;
/// No step of the rings or layers is longer than this share of the radius or the height.
const LONGEST: f64 = 0.25;

/// Rings graded to both sides of the patch's edge at `ring` and layers graded from the top, in shares of the radius and height;
/// both are graded once more towards the held rim.
fn graded(ring: f64, patch_over_height: f64, density: Density) -> RoundCut {
    let rim: Vec<f64> = steps(Density { edge: RIM * density.edge, ..density }, LONGEST, LONGEST);
    let last = rim.last().copied().unwrap_or(0.0);
    let mut rings: Vec<f64> = steps(density, 1.0, 0.55).into_iter().rev().map(|d| ring * (1.0 - d)).collect();
    rings.push(ring);
    let (end, gap) = (1.0 - last, 0.5 * last);
    rings.extend(steps(density, LONGEST / ring, (end - gap) / ring - 1.0).into_iter().map(|d| ring * (1.0 + d)));
    // a break nearer to the edge of the patch than to the rim is left to the patch's grading
    let outermost = rings.last().copied().unwrap_or(ring);
    rings.extend(rim.iter().rev().map(|d| 1.0 - d).filter(|at| *at > outermost + 0.3 * (1.0 - at)));
    rings.push(1.0);
    let mut layers = vec![0.0];
    layers.extend(&rim);
    let long = LONGEST / patch_over_height;
    layers.extend(steps(density, long, (end - gap) / patch_over_height).into_iter().rev().map(|d| 1.0 - d * patch_over_height));
    layers.push(1.0);
    RoundCut { rings, layers, turns: density.turns.min(4) }
}

/// The ellipsoid's quarter, lowest point at z = 0. Inside `ring` the section's rings are circles, outside they go over to the section's ellipses.
fn ellipsoid(cut: &RoundCut, axes: DVec3, held: f64, ring: f64) -> Bricks {
    let bottom = (held / axes.z - 1.0).acos();
    let polar = |angle: f64| (angle.sin(), angle.cos());
    let meridian = move |s: f64, w: f64| {
        let top = {
            let r = s * SHOULDER.sin();
            (r, (1.0 - r * r).sqrt())
        };
        let base = (s * bottom.sin(), bottom.cos());
        let side = polar(bottom + (SHOULDER - bottom) * w);
        let (corner_low, corner_high) = (polar(bottom), polar(SHOULDER));
        let blend = |t: f64, b: f64, axis: f64, side: f64, low: [f64; 2], high: [f64; 2]| {
            let ends = (1.0 - s) * ((1.0 - w) * low[0] + w * high[0]) + s * ((1.0 - w) * low[1] + w * high[1]);
            (1.0 - w) * b + w * t + (1.0 - s) * axis + s * side - ends
        };
        (
            blend(top.0, base.0, 0.0, side.0, [0.0, corner_low.0], [0.0, corner_high.0]),
            blend(
                top.1,
                base.1,
                bottom.cos() + (1.0 - bottom.cos()) * w,
                side.1,
                [bottom.cos(), corner_low.1],
                [1.0, corner_high.1],
            ),
        )
    };
    bent_quarter(cut, Skin::Contact, meridian, going_over(axes, ring), move |unit: DVec3| (unit + DVec3::Z) * axes)
}

/// Takes a unit section whose rings are circles to one where those outside `ring` go over to the ellipses of the body.
fn going_over(axes: DVec3, ring: f64) -> impl Fn(f64, f64) -> (f64, f64) {
    let mean = (axes.x * axes.y).sqrt();
    move |x, y| {
        let outside = ((x.hypot(y) - ring) / (1.0 - ring)).clamp(0.0, 1.0);
        let bend = |axis: f64| {
            let inner = mean / axis;
            inner + (1.0 - inner) * outside
        };
        (x * bend(axes.x), y * bend(axes.y))
    }
}

/// The frame of the contact, in units of the body.
fn frame(place: &Place, unit: f64) -> Frame {
    let n = place.normal;
    let side = if n.z.abs() > 0.5 { DVec3::X } else { DVec3::Z.cross(n).normalize() };
    let other = if n.z.abs() > 0.5 { DVec3::Y } else { DVec3::Z };
    Frame { origin: place.point / unit, axes: DMat3::from_cols(side, other, -n), radius: place.radius / unit }
}

/// Largest patch, as a share of the distance to the nearest edge of its face.
const MAX_PATCH: f64 = 0.8;

/// Checks every parameter and returns the body's unit of length.
fn check(body: &Body, material: &Elastic, place: &Place) -> Result<f64, FemError> {
    let range = |name, value: f64, good: bool, expected| {
        if good && value.is_finite() { Ok(()) } else { Err(FemError::Range { name, value, expected }) }
    };
    let (g, nu) = (material.shear_modulus, material.poisson_ratio);
    range("shear_modulus", g, g > 0.0, "above 0 Pa")?;
    range("poisson_ratio", nu, (0.0..=0.5).contains(&nu), "0 to 0.5")?;
    let size = match *body {
        Body::Box { size } => size,
        Body::Cylinder { radius, height } => DVec3::new(2.0 * radius, 2.0 * radius, height),
        Body::Ellipsoid { semi_axes, .. } => 2.0 * semi_axes,
    };
    range("size", size.min_element(), size.min_element() > 0.0, "above 0 m")?;
    let slender = size.max_element() / size.min_element();
    range("longest over shortest edge", slender, slender <= MAX_SLENDER, "at most 10")?;
    if let Body::Ellipsoid { semi_axes, held_below } = *body {
        let share = held_below / semi_axes.z;
        range("held_below", held_below, (0.02..=1.0).contains(&share), "0.02 to 1 times the height semi-axis, m")?;
    }
    let reach = reach(body, place, size)?;
    range(
        "radius",
        place.radius,
        place.radius > 0.0 && place.radius <= MAX_PATCH * reach,
        "above 0 m, below 0.8 times the distance to the edge",
    )?;
    Ok(size.max_element())
}

/// Beyond this the bricks or the mesh degenerate.
const MAX_SLENDER: f64 = 10.0;

/// Distance from the place to the nearest edge of its face.
fn reach(body: &Body, place: &Place, size: DVec3) -> Result<f64, FemError> {
    let refuse = |expected| Err(FemError::NoPlace { point: place.point, normal: place.normal, expected });
    let axis = place.normal.abs().max_position();
    let straight = (place.normal.abs()[axis] - 1.0).abs() < 1.0e-9 && place.normal.is_normalized();
    let near = 1.0e-6 * size.max_element();
    let top = DVec3::Z * size.z;
    let at_top = straight && place.normal.z > 0.5 && place.point.distance(top) < near;
    match *body {
        Body::Box { .. } => {
            let middle = DVec3::Z * (0.5 * size.z);
            let from_middle = place.point - middle;
            let on_face = straight && (from_middle.dot(place.normal) - 0.5 * size[axis]).abs() < near;
            if !on_face || place.normal.z < -0.5 {
                return refuse("a point on the top or a side of the box");
            }
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            let inner = (0.5 * size[j] - from_middle[j].abs()).min(0.5 * size[k] - from_middle[k].abs());
            if inner <= 0.0 { refuse("a point within its face") } else { Ok(inner) }
        }
        Body::Cylinder { radius, .. } if at_top => Ok(radius),
        // the mesh's top must reach well beyond the patch
        Body::Ellipsoid { semi_axes, .. } if at_top => Ok(0.6 * semi_axes.x.min(semi_axes.y)),
        _ => refuse("the middle of the top"),
    }
}
