//! The reference against closed forms, on grids of 8, 16 and 32 cells over the patch. Each row: what the finest grid errs by, and what is left after
//! Richardson's estimate; the committed table in `README.md` is what this test prints.
//!
//! `cargo test -p haptor-reference --test checks -- --nocapture`

use std::f64::consts::PI;

use haptor_reference::contact::{Contact, Ground, Patch};
use haptor_reference::estimate::richardson;
use haptor_reference::kernel::Solid;
use haptor_reference::lattice::Lattice;
use haptor_reference::led::Led;
use haptor_reference::profile::{Profile, cattaneo, lubkin};

/// Cells over the patch, coarse to fine.
const GRIDS: [usize; 3] = [8, 16, 32];

/// A figure on one grid over its exact value.
type Share = fn(usize) -> f64;

/// Name, figure, the largest error of the finest grid and of the extrapolated figure.
const CHECKS: &[(&str, Share, f64, f64)] = &[
    ("Hertz, force", |n| hertz(n).load() / (4.0 / 3.0 * MODULUS * R.sqrt() * DEPTH.powf(1.5)), 0.003, 0.003),
    ("Hertz, radius", |n| hertz(n).radius() / A, 0.004, 0.004),
    ("Hertz, pressure in the middle", |n| middle(&hertz(n)) / (2.0 * MODULUS * A / (PI * R)), 0.004, 0.004),
    ("Hertz, surface sunk at 1.2 a", |n| dent(n, 1.2), 0.005, 0.003),
    ("Hertz, surface sunk at 3 a", |n| dent(n, 3.0), 0.005, 0.003),
    ("cone, force", cone, 0.01, 0.005),
    ("flat punch, force", |n| punch(n, 1e-6) / (2.0 * MODULUS * DEPTH), 0.02, 0.005),
    (
        "bonded punch, nu 0.3, force (Spence)",
        |n| punch(n, 10.0) / (4.0 * DEPTH * (3.0 - 4.0 * NU).ln() / (1.0 - 2.0 * NU)),
        0.02,
        0.006,
    ),
    ("stuck drag, nu 0.5 (Mindlin)", |n| stuck(n, 0.5)[0] / (8.0 / 1.5), 0.02, 0.005),
    ("stuck drag, nu 0.3 (Mindlin)", |n| stuck(n, 0.3)[0] / (8.0 / 1.7), 0.02, 0.005),
    ("stuck twist (Reissner, Sagoci)", |n| stuck(n, 0.3)[2] / (16.0 / 3.0), 0.03, 0.01),
    ("full slip torque", |n| led(n, &[[0.0, 0.0, 50.0]])[0][2], 0.005, 0.003),
    ("twist at 0.5 phi0 (Lubkin)", |n| twist(n, 0.5), 0.01, 0.005),
    ("twist at phi0 (Lubkin)", |n| twist(n, 1.0), 0.01, 0.005),
    ("twist at 2 phi0 (Lubkin)", |n| twist(n, 2.0), 0.005, 0.004),
    ("drag at 0.3 s0 (Cattaneo)", |n| drag(n, 0.3), 0.01, 0.005),
    ("drag at 0.7 s0 (Cattaneo)", |n| drag(n, 0.7), 0.005, 0.004),
    ("twist turned back, from 2 to 0 phi0 (Masing)", |n| turned_back(n, 0.0), 0.01, 0.008),
    ("twist turned back, from 2 to -1 phi0 (Masing)", |n| turned_back(n, -1.0), 0.01, 0.008),
];

const NU: f64 = 0.3;
const SOLID: Solid = Solid { shear_modulus: 1.0, poisson_ratio: NU };
/// E/(1 - nu^2) for G = 1.
const MODULUS: f64 = 2.0 / (1.0 - NU);
/// A paraboloid that makes a contact of radius 1 at this depth.
const R: f64 = 100.0;
const DEPTH: f64 = 0.01;
const A: f64 = 1.0;
/// The lattice of solved contacts reaches beyond the rim by this.
const ROOM: f64 = 1.1;

fn pressed(across: usize, room: f64, friction: f64, gap: impl Fn(f64, f64) -> f64) -> Contact {
    let lattice = Lattice::square(across, 2.0 * room * A / across as f64);
    let patch = Patch::of_gap(SOLID, lattice, gap);
    let mut contact = Contact::new(SOLID, friction, vec![patch], Ground::firm(1));
    contact.advance(&[DEPTH], &[[0.0; 3]]);
    assert_eq!(contact.unconverged, 0, "{across} cells");
    contact
}

fn hertz(across: usize) -> Patch {
    pressed(across, ROOM, 1e-6, |x, y| (x * x + y * y) / (2.0 * R)).patches()[0].clone()
}

/// Mean of the cells next to the middle, taken to the middle along Hertz's profile.
fn middle(patch: &Patch) -> f64 {
    let edge = patch.lattice().edge;
    let most = patch.pressure().iter().copied().fold(0.0, f64::max);
    most / (1.0 - 0.5 * edge * edge - edge * edge / 6.0).sqrt()
}

fn dent(across: usize, r: f64) -> f64 {
    let outside = ((2.0 - r * r) * (1.0 / r).asin() + (r * r - 1.0).sqrt()) / (PI * R);
    hertz(across).displacement(SOLID, [r, 0.0])[2] / outside
}

fn cone(across: usize) -> f64 {
    // a = (2/pi) depth/slope
    let slope = 2.0 / PI * DEPTH;
    pressed(across, ROOM, 1e-6, |x, y| slope * x.hypot(y)).load() / (2.0 / PI * MODULUS * DEPTH * DEPTH / slope)
}

fn punch(across: usize, friction: f64) -> f64 {
    let lattice = Lattice::over_disc(across, 1.0);
    let rim = 0.5 * across as f64 * lattice.edge;
    let patch = Patch::of_gap(SOLID, lattice, |x, y| if x.hypot(y) < rim { 0.0 } else { f64::INFINITY });
    let mut contact = Contact::new(SOLID, friction, vec![patch], Ground::firm(1));
    contact.advance(&[DEPTH], &[[0.0; 3]]);
    assert_eq!(contact.unconverged, 0, "{across} cells");
    contact.load()
}

/// Grip of a disc that cannot slip, per unit of shift and turn.
fn stuck(across: usize, nu: f64) -> [f64; 3] {
    let solid = Solid { poisson_ratio: nu, ..SOLID };
    let lattice = Lattice::over_disc(across, 1.0);
    let mut contact = Contact::new(solid, 1e3, vec![Patch::new(solid, lattice)], Ground::firm(1)).uncoupled();
    contact.set_pressure(0, Profile::Punch.pressures(&lattice, 1.0, 1.0));
    contact.drag(&[[1.0, 0.0, 1.0]]);
    // a step is done to 1e-6 of mu P, far above what the unit motion makes: a few more take the rest out
    (0..20).for_each(|_| contact.drag(&[[0.0; 3]]));
    contact.patches()[0].grip()
}

fn led(across: usize, poses: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut patch = Led::new(across, Profile::Hertz);
    let answers = poses.iter().map(|pose| patch.step(*pose)).collect();
    assert_eq!(patch.unconverged(), 0);
    answers
}

/// Equal steps from the first to the last of `corners`, as twists.
fn twists(corners: &[f64]) -> Vec<[f64; 3]> {
    const STEPS: usize = 8;
    let leg = |pair: &[f64]| (1..=STEPS).map(|i| [0.0, 0.0, pair[0] + (pair[1] - pair[0]) * i as f64 / STEPS as f64]).collect();
    corners.windows(2).flat_map(|pair| -> Vec<_> { leg(pair) }).collect()
}

fn twist(across: usize, x: f64) -> f64 {
    led(across, &twists(&[0.0, x])).last().unwrap()[2] / lubkin(x)
}

fn drag(across: usize, s: f64) -> f64 {
    let poses: Vec<_> = twists(&[0.0, s]).iter().map(|pose| [pose[2], 0.0, 0.0]).collect();
    led(across, &poses).last().unwrap()[0] / cattaneo(s)
}

/// One plus the error in T_max: the torque itself goes through zero.
fn turned_back(across: usize, to: f64) -> f64 {
    let masing = lubkin(2.0) - 2.0 * lubkin(0.5 * (2.0 - to));
    1.0 + led(across, &twists(&[0.0, 2.0, to])).last().unwrap()[2] - masing
}

#[test]
fn closed_forms_are_met() {
    println!("| figure | 8 | 16 | 32 | order | extrapolated |\n|---|---:|---:|---:|---:|---:|");
    let mut failed = Vec::new();
    for (name, share, finest, extrapolated) in CHECKS {
        let shares = GRIDS.map(share);
        let estimate = richardson(shares, 2.0);
        let percent = |share: f64| format!("{:+.2}", 100.0 * (share - 1.0));
        let order = estimate.order.map_or("-".to_owned(), |order| format!("{order:.1}"));
        println!(
            "| {name} | {} | {} | {} | {order} | {} |",
            percent(shares[0]),
            percent(shares[1]),
            percent(shares[2]),
            percent(estimate.value)
        );
        if (shares[2] - 1.0).abs() > *finest || (estimate.value - 1.0).abs() > *extrapolated {
            failed.push(*name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
