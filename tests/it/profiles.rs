//! The core's profile tables, recomputed in f64 from their integrals.
//!
//! Units: a = 1, mu P = 1, and K_t = 1 for drag, G = 1 (K_theta = 16/3) for twist. Let x be the radius that truly sticks. The exact theory
//! gives shift and load over x: drag s(x) = (1 - x^n)/rho, Q(x) = 1 - x^(n+1) (Cattaneo's principle for f = A r^n); twist
//! phi(x) = (mu/2G) int_x^1 p dr/sqrt(r^2 - x^2), T(x) = 16/3 x^3 phi(x) + 16 int_x^1 s^2 phi(s) ds.
//!
//! Bristles that share the part alpha of the compliance 1/K feel only s~(x) = s(x) - alpha Q(x)/K. While those beyond q slip and the rest,
//! each with the stiffness cap/s~, sticks, the load is the capacity beyond q plus the slope times s~: so q and x belong together where
//! Q - s~ dQ/ds~ = capacity beyond q, with dQ/ds~ = K x/(1 - alpha x) (twist: x^3). At that x a bristle at q slips at s~(x).

use std::f64::consts::PI;

use haptor_contact::profile::table::{CONE, HERTZ, INTERVALS, PUNCH, Table};
use haptor_contact::profile::{COMMON_DRAG, COMMON_TWIST};

use crate::support::exact::{elliptic, integral, zero};

/// Pieces of every quadrature: its error is below 1e-8.
const PIECES: usize = 32;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Cone,
    Hertz,
    Punch,
}

impl Kind {
    /// Pressure at r, total load 1.
    fn pressure(self, r: f64) -> f64 {
        match self {
            Self::Cone => (1.0 / r).max(1.0).acosh() / PI,
            Self::Hertz => 1.5 / PI * (1.0 - r * r).max(0.0).sqrt(),
            Self::Punch => 0.5 / (PI * (1.0 - r * r).sqrt()),
        }
    }

    /// Integral of 2 pi r^(1 + power) p from q to 1, with r = sin t: load beyond q, or torque capacity there.
    fn beyond(self, q: f64, power: i32) -> f64 {
        integral(q.min(1.0).asin(), 0.5 * PI, PIECES, |t| {
            let (r, c) = t.sin_cos();
            // the punch's pressure times cos t is finite up to the rim
            let weighted = if self == Self::Punch { 0.5 / PI } else { self.pressure(r) * c };
            2.0 * PI * r.powi(1 + power) * weighted
        })
    }

    /// Largest torque, in mu P a.
    fn full_torque(self) -> f64 {
        match self {
            Self::Cone => PI / 6.0,
            Self::Hertz => 3.0 * PI / 16.0,
            Self::Punch => PI / 4.0,
        }
    }

    /// Twist at which the ring x slips.
    fn limit(self, x: f64) -> f64 {
        let k = (1.0 - x * x).max(0.0).sqrt();
        match self {
            Self::Hertz => {
                let (first, second) = elliptic(k);
                0.75 / PI * (first - second)
            }
            Self::Punch => 0.25 / PI * elliptic(k).0,
            // r^2 = x^2 + k^2 sin^2 t
            Self::Cone => {
                0.5 * integral(0.0, 0.5 * PI, 4 * PIECES, |t| {
                    let r = (x * x + k * k * t.sin().powi(2)).sqrt();
                    self.pressure(r) * k * t.cos() / r
                })
            }
        }
    }

    /// Fullness rho.
    fn fullness(self) -> f64 {
        match self {
            Self::Cone => 0.5,
            Self::Hertz => 2.0 / 3.0,
            Self::Punch => 1.0,
        }
    }
}

/// Shift less the common share, and the radius that sticks, when bristles beyond `q` slip in drag.
fn drag(kind: Kind, q: f64) -> (f64, f64) {
    let alpha = f64::from(COMMON_DRAG);
    let capacity = kind.beyond(q, 0);
    if kind == Kind::Punch {
        // all of a flat punch slips at once, at s = 1
        return (1.0 - alpha, 1.0 - capacity);
    }
    let n = kind.fullness() / (1.0 - kind.fullness());
    let load = |x: f64| 1.0 - x.powf(n + 1.0);
    let felt = |x: f64| (1.0 - x.powf(n)) / kind.fullness() - alpha * load(x);
    let slipped = |x: f64| load(x) - felt(x) * x / (1.0 - alpha * x);
    let stuck = zero(0.0, 1.0, |x| capacity - slipped(x));
    (felt(stuck), stuck)
}

/// The same in twist.
fn twist(kind: Kind, q: f64) -> (f64, f64) {
    const K: f64 = 16.0 / 3.0;
    let alpha = f64::from(COMMON_TWIST);
    let capacity = kind.beyond(q, 1);
    // s = sin t takes out the square root that `limit` has at the rim
    let torque = |x: f64, phi: f64| {
        let slipped = integral(x.min(1.0).asin(), 0.5 * PI, PIECES, |t| {
            let (s, c) = t.sin_cos();
            s * s * kind.limit(s.min(1.0 - 1e-15)) * c
        });
        K * x.powi(3) * phi + 16.0 * slipped
    };
    let state = |x: f64| {
        let phi = kind.limit(x);
        let torque = torque(x, phi);
        (torque, (phi - alpha / K * torque) * K)
    };
    let stuck = zero_in(STEPS, 1.0e-7, 1.0 - 1.0e-12, |x| {
        let (torque, felt) = state(x);
        capacity - (torque - felt * x.powi(3) / (1.0 - alpha * x.powi(3)))
    });
    (state(stuck).1, stuck)
}

/// Halvings that place the stuck radius: 2^-36 of it.
const STEPS: usize = 36;

/// As `zero`, with fewer halvings: each costs nested quadratures.
fn zero_in(steps: usize, mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Every fifth row: all of them come from the same code.
const STRIDE: usize = 5;

fn check(kind: Kind, table: &Table) {
    let mut worst = [0.0_f64; 6];
    for row in (STRIDE..INTERVALS).step_by(STRIDE) {
        let depth = row as f64 / INTERVALS as f64;
        let q = (1.0 - depth * depth).sqrt();
        let ((drag_softness, drag_stuck), (twist_softness, twist_stuck)) = (drag(kind, q), twist(kind, q));
        let inside = (1.0 - kind.beyond(q, 0), kind.full_torque() - kind.beyond(q, 1));
        let exact = [drag_softness, twist_softness, inside.0, inside.1, drag_stuck, twist_stuck];
        for column in 0..6 {
            let off = (f64::from(table[row][column]) - exact[column]).abs();
            worst[column] = worst[column].max(off);
            assert!(off < 1.0e-6, "{kind:?} row {row} column {column}: {} expected {}", table[row][column], exact[column]);
        }
    }
    println!("{kind:?}: largest differences {worst:?}");
}

#[test]
fn cone_table() {
    check(Kind::Cone, &CONE);
}

#[test]
fn hertz_table() {
    check(Kind::Hertz, &HERTZ);
}

#[test]
fn punch_table() {
    check(Kind::Punch, &PUNCH);
}

/// Rim and centre: nothing inside, everything inside; the rim of a smooth profile slips at once, that of a punch where it begins to slip.
#[test]
fn first_and_last_rows() {
    for (kind, table) in [(Kind::Cone, &CONE), (Kind::Hertz, &HERTZ), (Kind::Punch, &PUNCH)] {
        let (rim, centre) = (table[0].map(f64::from), table[INTERVALS].map(f64::from));
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1.0e-6, "{kind:?}: {a} {b}");
        near(kind.beyond(0.0, 1), kind.full_torque());
        assert!((kind.beyond(0.0, 0) - 1.0).abs() < 1.0e-5, "the cone's tip is logarithmic");
        [(2, 1.0), (3, kind.full_torque()), (4, 1.0), (5, 1.0)].into_iter().for_each(|(column, value)| near(rim[column], value));
        (2..6).for_each(|column| near(centre[column], 0.0));
        near(centre[0], 1.0 / kind.fullness() - f64::from(COMMON_DRAG));
        if kind == Kind::Punch {
            near(rim[0], 1.0 - f64::from(COMMON_DRAG));
            // phi(1) = 1/8, T(1) = 16/3 phi(1)
            near(rim[1], (1.0 - f64::from(COMMON_TWIST)) * 16.0 / 3.0 / 8.0);
        } else {
            near(rim[0], 0.0);
            near(rim[1], 0.0);
        }
        // the twist softness of the centre has no finite value for Hertz and punch; the table goes on in a straight line
        near(centre[1], 2.0 * f64::from(table[INTERVALS - 1][1]) - f64::from(table[INTERVALS - 2][1]));
    }
    assert!((zero(0.0, 2.0, |x| x * x - 2.0) - 2.0_f64.sqrt()).abs() < 1e-12);
}
