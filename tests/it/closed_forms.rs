//! Closed forms of contact mechanics that the core must meet: normal force and radius of every probe shape, torsion and drag of flat
//! punch and cone, and the continuum limits of the paper's own equations. Exact values are computed here, in f64, from the integrals.

use std::f64::consts::PI;

use glam::{Quat, Vec3};
use haptor_contact::{Flags, Material, ModelSpec, ObjectShape, ParamsSpec, Patch, ProbePart, ProbeShape, Tier};

use crate::support::drive::{CUBE, Drive, RUBBER};
use crate::support::exact::{ellipse, elliptic, integral, sphere, torsion, zero};

/// G and E* of the rubber [Pa].
const G: f64 = 1.0e6;
const E_STAR: f64 = 4.0e6;
const MU: f64 = 0.75;

/// The reference ends where the straight part does; the round ends add to it as the contact widens.
const SIDE_TOLERANCE: f64 = 0.15;

fn near(found: f64, expected: f64, relative: f64, what: &str) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{what}: {found}, expected {expected}");
}

fn tier(tier: Tier, samples: usize) -> ParamsSpec {
    ParamsSpec { tier, samples, ..ParamsSpec::default() }
}

/// `shape` at `rotation` on `object`, pressed `depth` deep from height `touch` of its origin.
fn pressed(
    object: ObjectShape<'static>,
    shape: ProbeShape<'static>,
    rotation: Quat,
    touch: f32,
    depth: f64,
    params: &ParamsSpec,
) -> Drive {
    let mut drive = Drive::new(object, RUBBER, &[ProbePart::at_origin(shape)], params);
    drive.rotation = rotation;
    drive.press_to(touch, depth as f32);
    drive
}

const PUNCH: ProbeShape<'static> = ProbeShape::Cylinder { radius: 0.01, height: 0.04 };
const CONE: ProbeShape<'static> = ProbeShape::Cone { radius: 0.02, height: 0.02 };

fn punch(depth: f64, params: &ParamsSpec) -> Drive {
    pressed(ObjectShape::HalfSpace, PUNCH, Quat::IDENTITY, 0.02, depth, params)
}

fn cone(depth: f64, params: &ParamsSpec) -> Drive {
    pressed(ObjectShape::HalfSpace, CONE, Quat::IDENTITY, 0.015, depth, params)
}

#[test]
fn flat_punch_force_and_radius() {
    for depth in [1.0e-5, 1.0e-4, 1.0e-3] {
        let drive = punch(depth, &tier(Tier::Bristle, 64));
        near(drive.load(), 2.0 * E_STAR * 0.01 * depth, 0.02, "F = 2 E* a delta");
        near(drive.radius(), 0.01, 0.02, "a");
    }
}

/// F = 2/pi E* tan(half angle) delta^2, a = 2/pi delta tan(half angle) (Sneddon).
#[test]
fn cone_force_and_radius() {
    for (radius, height) in [(0.02_f64, 0.02_f64), (0.04, 0.01), (0.01, 0.04)] {
        for depth in [1.0e-4, 1.0e-3, 3.0e-3] {
            let shape = ProbeShape::Cone { radius: radius as f32, height: height as f32 };
            let touch = 0.75 * height as f32;
            let drive = pressed(ObjectShape::HalfSpace, shape, Quat::IDENTITY, touch, depth, &tier(Tier::Point, 64));
            let tan = radius / height;
            near(drive.load(), 2.0 / PI * E_STAR * tan * depth * depth, 0.02, "cone F");
            near(drive.radius(), 2.0 / PI * depth * tan, 0.02, "cone a");
        }
    }
}

/// T/T_max of the flat punch over x = K phi/T_max: no slip up to x1, then the rim slips inwards (TRUTH, 5.3; fit error 6e-6).
fn punch_torque(x: f64) -> f64 {
    let y = x - 0.8488;
    if y <= 0.0 { x } else { 1.0 - (1.0 - 0.8488) * (-y * (6.618 + 6.137 * y) / (1.0 + 1.162 * y)).exp() }
}

#[test]
fn flat_punch_torque_and_drag() {
    for choice in [Tier::Point, Tier::Bristle] {
        let mut drive = punch(1.0e-3, &tier(choice, 64));
        let (load, a) = (drive.load(), drive.radius());
        let (full, stiffness) = (PI / 4.0 * MU * load * a, 16.0 / 3.0 * G * a * a * a);
        let unit = full / stiffness;
        for step in 1..=60 {
            let x = f64::from(step) * 0.05;
            drive.turn(Vec3::Z, (0.05 * unit) as f32, 4);
            let found = drive.held()[2] / full;
            assert!((found - punch_torque(x)).abs() < 0.02, "{choice:?} x {x}: {found}, expected {}", punch_torque(x));
        }
        let mut drive = punch(1.0e-3, &tier(choice, 64));
        let unit = MU * load / (8.0 * G * a / 1.5);
        for step in 1..=60 {
            let x = f64::from(step) * 0.05;
            drive.shift(Vec3::X * (0.05 * unit) as f32, 4);
            let found = drive.held()[0] / (MU * load);
            assert!((found - x.min(1.0)).abs() < 0.02, "{choice:?} drag {x}: {found}");
        }
    }
}

/// Pressure of the cone over mu P/a^2, p = P/(pi a^2) acosh(a/r), and the twist at which the ring c slips:
/// phi(c) = mu/(2G) int_c^a p dr/sqrt(r^2 - c^2), with r^2 = c^2 + (a^2 - c^2) u^2.
fn cone_limit(m: f64, a: f64, c: f64) -> f64 {
    let span = ((a - c) * (a + c)).sqrt();
    let pressure = |r: f64| m / (PI * a * a) * (a / r).max(1.0).acosh();
    0.5 / G
        * integral(0.0, 1.0, 200, |u| {
            let r = (c * c + span * span * u * u).sqrt();
            pressure(r) * span / r
        })
}

#[test]
fn cone_torque_and_drag() {
    for choice in [Tier::Point, Tier::Bristle] {
        let mut drive = cone(2.0e-3, &tier(choice, 64));
        let (m, a) = (MU * drive.load(), drive.radius());
        let (full, stiffness) = (PI / 6.0 * m * a, 16.0 / 3.0 * G * a * a * a);
        let unit = full / stiffness;
        for step in 1..=20 {
            drive.turn(Vec3::Z, (0.2 * unit) as f32, 4);
            let exact = torsion(G, a, 0.2 * f64::from(step) * unit, |c| cone_limit(m, a, c.max(1.0e-9 * a)));
            let found = drive.held()[2] / full;
            assert!((found - exact / full).abs() < 0.02, "{choice:?} step {step}: {found}, expected {}", exact / full);
        }
        // Cattaneo's principle with the cone's P ~ delta^2: Q = mu P [1 - (1 - s/s0)^2], s0 = 2 mu P/K_t
        let mut drive = cone(2.0e-3, &tier(choice, 64));
        let reach = 2.0 * m / (8.0 * G * a / 1.5);
        for step in 1..=24 {
            drive.shift(Vec3::Y * (0.05 * reach) as f32, 4);
            let s = (0.05 * f64::from(step)).min(1.0);
            let found = drive.held()[1] / m;
            assert!((found - (1.0 - (1.0 - s).powi(2))).abs() < 0.02, "{choice:?} s {s}: {found}");
        }
    }
}

/// Two spheres: Hertz with 1/R = 1/R1 + 1/R2, small strain.
#[test]
fn sphere_on_sphere() {
    for (probe, object) in [(0.02_f64, 0.05_f64), (0.05, 0.02), (0.03, 0.03)] {
        for depth in [1.0e-5_f64, 1.0e-4, 3.0e-4] {
            let shape = ProbeShape::Sphere { radius: probe as f32 };
            let ball = ObjectShape::Sphere { radius: object as f32 };
            let touch = (2.0 * object + probe) as f32;
            let compliance = haptor_contact::Compliance::default();
            let parts: &'static [ProbePart<'static>] = Box::leak(Box::new([ProbePart::at_origin(shape)]));
            let spec = ModelSpec { compliance: Some(compliance), ..ModelSpec::new(ball, RUBBER, parts) };
            let mut drive = Drive::from_spec(&spec, &tier(Tier::Point, 64));
            drive.press_to(touch, depth as f32);
            let r = probe * object / (probe + object);
            near(drive.load(), 4.0 / 3.0 * E_STAR * r.sqrt() * depth.powf(1.5), 0.02, "two spheres, F");
            near(drive.radius(), (r * depth).sqrt(), 0.02, "two spheres, a");
        }
    }
}

/// The true sphere, up to a quarter of its radius (Sneddon).
#[test]
fn true_sphere() {
    for radius in [1.0e-3, 0.02, 1.0] {
        for share in [1.0e-3, 0.01, 0.1, 0.25] {
            let mut drive = Drive::ball(ObjectShape::HalfSpace, radius as f32, 0.5, &tier(Tier::Point, 64));
            drive.press_to(radius as f32, (share * radius) as f32);
            let (load, a) = sphere(radius, share * radius);
            near(drive.load(), E_STAR * load, 0.01, "sphere F");
            near(drive.radius(), a, 0.02, "sphere a");
        }
    }
}

/// Hertz elliptic contact, by elliptic integrals: an ellipsoid on its three sides, and a lying one on a sphere.
#[test]
fn ellipsoid_on_its_sides() {
    let axes = Vec3::new(0.03, 0.02, 0.012);
    let sides = [
        (Quat::IDENTITY, [0.03_f64, 0.02, 0.012]),
        (Quat::from_rotation_x(0.5 * PI as f32), [0.03, 0.012, 0.02]),
        (Quat::from_rotation_y(0.5 * PI as f32), [0.012, 0.02, 0.03]),
    ];
    for (rotation, [x, y, z]) in sides {
        let (kx, ky) = (z / (x * x), z / (y * y));
        for share in [1.0e-4, 1.0e-3, 5.0e-3] {
            let depth = share * z;
            let shape = ProbeShape::Ellipsoid { semi_axes: axes };
            let drive = pressed(ObjectShape::HalfSpace, shape, rotation, z as f32, depth, &tier(Tier::Point, 64));
            let (load, a) = ellipse(kx.max(ky), kx.min(ky), depth);
            near(drive.load(), E_STAR * load, 0.02, "ellipsoid F");
            near(drive.radius(), a, 0.02, "ellipsoid a");
        }
    }
}

/// Thin ellipses: relative curvature 1 : 10 to 1 : 100, where fits of Hertz's integrals part from them.
#[test]
fn slender_ellipsoids() {
    for ratio in [4.0_f64, 10.0, 30.0, 100.0] {
        let (short, long) = (0.01, 0.01 * ratio.sqrt());
        let axes = Vec3::new(long as f32, short as f32, short as f32);
        let depth = 1.0e-5;
        let shape = ProbeShape::Ellipsoid { semi_axes: axes };
        let drive = pressed(ObjectShape::HalfSpace, shape, Quat::IDENTITY, short as f32, depth, &tier(Tier::Point, 64));
        let (load, a) = ellipse(1.0 / short, short / (long * long), depth);
        near(drive.load(), E_STAR * load, 0.02, &format!("ratio {ratio}, F"));
        near(drive.radius(), a, 0.02, &format!("ratio {ratio}, a"));
    }
}

/// Load of a cylinder of radius `r` lying on the half space along its length `l`: depth = x [1 + ln(l^2/(x r))] with
/// x = P/(pi l E*) (Puttock and Thwaite, National Standards Laboratory Technical Paper 25, 1969).
fn lying_cylinder(r: f64, l: f64, depth: f64) -> f64 {
    PI * l * E_STAR * zero(1e-12, depth, |x| x * (1.0 + (l * l / (x * r)).ln()) - depth)
}

/// A capsule's round end is a ball; its side is a line contact.
#[test]
fn capsule_end_and_side() {
    let shape = ProbeShape::Capsule { radius: 0.01, height: 0.06 };
    for depth in [1.0e-4, 5.0e-4] {
        let end = pressed(ObjectShape::HalfSpace, shape, Quat::IDENTITY, 0.04, depth, &tier(Tier::Point, 64));
        let (load, a) = sphere(0.01, depth);
        near(end.load(), E_STAR * load, 0.02, "capsule end F");
        near(end.radius(), a, 0.02, "capsule end a");
        let lying = Quat::from_rotation_x(0.5 * PI as f32);
        let side = pressed(ObjectShape::HalfSpace, shape, lying, 0.01, depth, &tier(Tier::Point, 64));
        let off = side.load() / lying_cylinder(0.01, 0.06, depth) - 1.0;
        println!("capsule side at {depth}: {} N, off by {off:.3}", side.load());
        assert!(off.abs() < SIDE_TOLERANCE, "{depth}: off by {off}");
    }
}

/// A probe of tier `paper`, pressed on an object with the fixed point `l` below.
fn paper(object: ObjectShape<'static>, mu_s: f64, length: f32, depth: f32) -> Drive {
    let ball: &'static [ProbePart<'static>] = Box::leak(Box::new([ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })]));
    let params = ParamsSpec { friction_static: Some(mu_s as f32), ..tier(Tier::Paper, 1024) };
    let mut drive = Drive::from_spec(&ModelSpec { paper_length: length, ..ModelSpec::new(object, RUBBER, ball) }, &params);
    drive.press_to(object.height() + 0.02, depth);
    drive
}

/// Equations (2), (4), (8), (9): stick torque pi G phi a^4/(2 l), with l the depth of the base below the contact.
#[test]
fn paper_stick_torque() {
    for (object, length) in [(CUBE, 0.1 - 2.0e-3), (ObjectShape::HalfSpace, 0.1), (ObjectShape::HalfSpace, 0.03)] {
        let mut drive = paper(object, MU, length, 2.0e-3);
        let a = drive.radius();
        for degrees in [1.0_f64, 10.0, 60.0, 100.0] {
            let so_far = f64::from(drive.rotation.to_axis_angle().1);
            drive.turn(Vec3::Z, (degrees.to_radians() - so_far) as f32, 100);
            let stuck = PI * G * degrees.to_radians() * a.powi(4) / (2.0 * f64::from(length));
            near(drive.held()[2], stuck, 0.01, &format!("{object:?} {degrees} degrees"));
            assert_eq!(drive.report().stick, 1.0);
        }
    }
}

/// Equations (5), (6): beyond r_ms = mu_s P l/(pi a^2 G phi) every small region slips, and torque is 2 pi int tau r^2 dr inside and
/// f_D/(pi a^2) outside; far beyond, (2/3) mu_D F_n a.
#[test]
fn paper_slip_torque_and_stick_radius() {
    for mu_s in [MU, 1.0] {
        let mut drive = paper(ObjectShape::HalfSpace, mu_s, 0.1, 2.0e-3);
        let (load, a) = (drive.load(), drive.radius());
        for turns in [0.9, 1.2, 2.0, 5.0, 40.0] {
            let phi = 2.0 * PI * turns;
            let so_far = f64::from(drive.state().patches()[0].paper.turned.z);
            drive.turn(Vec3::Z, (phi - so_far) as f32, 400);
            let rim = (mu_s * load * 0.1 / (PI * a * a * G * phi)).min(a);
            let inside = 0.5 * PI * G * phi / 0.1 * rim.powi(4);
            let outside = 2.0 / 3.0 * MU * load * (a.powi(3) - rim.powi(3)) / (a * a);
            near(drive.held()[2], inside + outside, 0.01, &format!("mu_s {mu_s}, {turns} turns"));
            let stick = f64::from(drive.report().stick);
            assert!((stick - (rim / a).powi(2)).abs() < 0.01, "mu_s {mu_s}, {turns} turns: stuck {stick}, r_ms/a {}", rim / a);
        }
        near(drive.held()[2], 2.0 / 3.0 * MU * load * a, 0.01, "full slip");
    }
}

/// Before sliding, G s/l per area; then f_D; a slide that stops starts anew.
#[test]
fn paper_translation() {
    let mut drive = paper(ObjectShape::HalfSpace, 1.0, 0.1, 2.0e-3);
    let (load, a) = (drive.load(), drive.radius());
    let per_shift = G * PI * a * a / 0.1;
    let reach = load / per_shift;
    drive.shift(Vec3::X * (0.5 * reach) as f32, 50);
    near(drive.held()[0], 0.5 * load, 0.01, "G s/l per area");
    drive.shift(Vec3::X * (0.45 * reach) as f32, 50);
    near(drive.held()[0], 0.95 * load, 0.01, "up to f_max");
    drive.shift(Vec3::X * (0.2 * reach) as f32, 50);
    near(drive.held()[0], MU * load, 0.01, "then f_D");
    drive.shift(Vec3::X * (-0.1 * reach) as f32, 50);
    near(drive.held()[0], (MU - 0.1) * load, 0.01, "back: stuck again");
}

/// Two balls; the axis through the mass centre pierces neither, the first, or, where they are one region, both stay in stick.
fn two_balls(first: Vec3, second: Vec3, region_distance: f32) -> Drive {
    let ball = |position| ProbePart { position, ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 }) };
    let params = ParamsSpec { region_distance, ..tier(Tier::Paper, 1024) };
    let mut drive = Drive::new(ObjectShape::HalfSpace, RUBBER, &[ball(first), ball(second)], &params);
    drive.press_to(0.02, 2.0e-3);
    drive.press_to(0.02, 2.0e-3);
    drive
}

fn of_part(drive: &Drive, part: u8) -> &Patch {
    drive.state().patches().iter().find(|patch| patch.part == part).expect("the part touches")
}

/// Section V: with a second region, equation (14) makes the pierced one slide everywhere, (2/3) f_D a each; the other adds r x F only.
#[test]
fn paper_with_two_regions() {
    let mut alone = paper(ObjectShape::HalfSpace, MU, 0.1, 2.0e-3);
    alone.turn(Vec3::Z, 0.01, 10);
    let mut drive = two_balls(Vec3::ZERO, Vec3::X * 0.05, 0.004);
    assert_eq!(drive.report().regions, 2);
    drive.turn(Vec3::Z, 0.01, 10);
    let first = of_part(&drive, 0);
    let (load, a) = (f64::from(first.footprint.load), f64::from(first.footprint.radius));
    let torque = -f64::from(first.paper.torque.z);
    near(torque, 2.0 / 3.0 * MU * load * a, 0.01, "equation 14");
    assert!(torque > 10.0 * alone.held()[2], "kinetic, not stuck");
    let second = of_part(&drive, 1);
    assert_eq!(second.paper.torque, Vec3::ZERO, "the axis misses the second region");
    // r x F of the second: G s/l per area with s = 50 mm x 0.01 rad
    let a2 = f64::from(second.footprint.radius);
    near(drive.held()[2] - torque, 0.05 * G * PI * a2 * a2 / 0.1 * 0.05 * 0.01, 0.01, "equation 1");
}

/// Section V: an axis that misses every region gives r x F alone, and one region of two balls stays in stick.
#[test]
fn paper_without_a_pierced_region() {
    let mut drive = two_balls(Vec3::X * -0.025, Vec3::X * 0.025, 0.004);
    drive.turn(Vec3::Z, 0.01, 10);
    let patches = drive.state().patches();
    assert!(patches.iter().all(|patch| patch.paper.torque == Vec3::ZERO));
    let a = f64::from(patches[0].footprint.radius);
    near(drive.held()[2], 2.0 * 0.025 * G * PI * a * a / 0.1 * 0.025 * 0.01, 0.01, "two legs");
    let mut merged = two_balls(Vec3::ZERO, Vec3::X * 0.05, 0.06);
    assert_eq!(merged.report().regions, 1);
    merged.turn(Vec3::Z, 0.01, 10);
    let first = of_part(&merged, 0);
    let (a, torque) = (f64::from(first.footprint.radius), -f64::from(first.paper.torque.z));
    near(torque, PI * G * 0.01 * a.powi(4) / 0.2, 0.01, "one region: equation 9");
}

/// l is floored at the contact radius, and the tick says so: a flat disc 1 mm above its base, pressed by a ball.
#[test]
fn paper_length_is_floored_and_reported() {
    let disc = ObjectShape::Cylinder { radius: 0.05, height: 2.0e-3 };
    let mut drive = paper(disc, MU, 0.1, 0.5e-3);
    drive.turn(Vec3::Z, 1.0e-3, 10);
    assert!(drive.report().flags.contains(Flags::LENGTH_FLOORED), "{}", drive.report().flags);
    let a = drive.radius();
    near(drive.held()[2], PI * G * 1.0e-3 * a.powi(4) / (2.0 * a), 0.01, "l = a");
    let mut tall = paper(CUBE, MU, 0.1, 0.5e-3);
    tall.turn(Vec3::Z, 1.0e-3, 10);
    assert!(!tall.report().flags.contains(Flags::LENGTH_FLOORED), "{}", tall.report().flags);
}

/// The exact forms themselves: K(0.5), E(0.5), a circle as the limit of ellipses, and Lubkin's T_max.
#[test]
fn the_exact_forms_are_exact() {
    let (k, e) = elliptic(0.5);
    near(k, 1.685_750_354_812_596, 1e-12, "K");
    near(e, 1.467_462_209_339_427, 1e-12, "E");
    let (round, nearly) = (ellipse(50.0, 50.0, 1e-4), ellipse(50.01, 49.99, 1e-4));
    near(nearly.0, round.0, 1e-4, "circle");
    near(nearly.1, round.1, 1e-4, "circle");
    let lubkin = |c: f64| crate::support::exact::lubkin_limit(1.0, 1.0, 1.0, c);
    near(torsion(1.0, 1.0, 10.0, lubkin), 3.0 * PI / 16.0, 1e-4, "T_max");
    let material = Material { ..RUBBER };
    near(f64::from(material.contact_modulus()), E_STAR, 1e-6, "E*");
}
