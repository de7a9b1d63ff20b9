//! The axes of the map, and the runs over them.

use haptor_firmware_sim::plant::{FIRM_GRIP, Hand};
use haptor_firmware_sim::preset::{OMEGA6, PREMIUM15, SIGMA7, TOUCH};

use super::rig::{Case, Machine};

/// Young's moduli \[Pa\]: foam to hard plastic.
pub const MODULI: [f32; 8] = [3.0e4, 1.0e5, 3.0e5, 1.0e6, 3.0e6, 1.0e7, 3.0e7, 1.0e8];

/// Rates \[Hz\].
pub const RATES: [u32; 5] = [500, 1000, 2000, 4000, 8000];

/// Longest delay of the map \[ticks\].
pub const LONGEST: usize = 8;

/// Finger tips on a stylus: a seventh of the firm grip's mass, a thirtieth of its damping.
pub const LIGHT_GRIP: Hand =
    Hand { mass: 0.1, inertia: 1e-4, stiffness: 200.0, damping: 5.0, spin_stiffness: 0.3, spin_damping: 0.01 };

/// The hands.
pub const HANDS: [(&str, Hand); 2] = [("firm", FIRM_GRIP), ("light", LIGHT_GRIP)];

/// The devices. What they close and damp is as CHAI3D's tables have it, which give no rotation for the last two: unused, they render no torque.
pub const MACHINES: [Machine; 4] = [
    Machine { preset: PREMIUM15, closes: (800.0, 0.3), damps: (5.0, 0.004) },
    Machine { preset: SIGMA7, closes: (4000.0, 1.0), damps: (30.0, 0.07) },
    Machine { preset: OMEGA6, closes: (5000.0, 0.3), damps: (30.0, 0.004) },
    Machine { preset: TOUCH, closes: (400.0, 0.1), damps: (4.0, 0.002) },
];

/// Coupling and controller of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name.
    pub name: &'static str,
    /// Virtual coupling.
    pub coupled: bool,
    /// Passivity controller.
    pub passive: bool,
}

/// The four variants.
pub const VARIANTS: [Variant; 4] = [
    Variant { name: "direct", coupled: false, passive: false },
    Variant { name: "direct, damped", coupled: false, passive: true },
    Variant { name: "virtual", coupled: true, passive: false },
    Variant { name: "virtual, damped", coupled: true, passive: true },
];

/// Mass of the probe in the map \[kg\], the paper's.
pub const MASS: f32 = 1.0;

/// How many ticks of delay a loop stands, counted from no delay on: 0 is not even none, 9 all of 0 to 8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stands {
    /// Quiet.
    pub quiet: u8,
    /// Quiet, or toggling within the encoder's own steps.
    pub bounded: u8,
}

impl Stands {
    /// Runs the delays until the loop shakes. `case.delay` does not matter.
    pub fn of(case: Case) -> Self {
        let mut stands = Self::default();
        for delay in 0..=LONGEST {
            let seen = Case { delay, ..case }.run();
            if !seen.is_bounded() {
                break;
            }
            stands.quiet += u8::from(seen.is_quiet() && stands.quiet == stands.bounded);
            stands.bounded += 1;
        }
        stands
    }
}

/// One panel: rows are rates, columns moduli.
pub type Panel = [[Stands; MODULI.len()]; RATES.len()];

/// All panels: device, hand, variant.
pub type Map = [[[Panel; VARIANTS.len()]; HANDS.len()]; MACHINES.len()];

/// Every case of the map in the order of its indices, without delay.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for machine in MACHINES {
        for (_, hand) in HANDS {
            for Variant { coupled, passive, .. } in VARIANTS {
                for rate_hz in RATES {
                    cases.extend(MODULI.map(|young_modulus| Case {
                        machine,
                        hand,
                        young_modulus,
                        rate_hz,
                        delay: 0,
                        coupled,
                        passive,
                        mass: MASS,
                    }));
                }
            }
        }
    }
    cases
}

/// Runs `cases` on two threads; the results are in their order.
pub fn on_two_threads<T: Send + Clone + Default>(cases: &[Case], run: impl Fn(Case) -> T + Sync) -> Vec<T> {
    let mut results = vec![T::default(); cases.len()];
    let (half, run) = (cases.len().div_ceil(2), &run);
    // odd and even indices cost about the same; halves would not
    let work = |first: usize| cases.iter().skip(first).step_by(2).map(|case| run(*case)).collect::<Vec<_>>();
    let (even, odd) = std::thread::scope(|scope| {
        let other = scope.spawn(|| work(1));
        (work(0), other.join().expect("a run does not panic"))
    });
    debug_assert_eq!(even.len(), half);
    for (slot, result) in results.iter_mut().step_by(2).zip(even) {
        *slot = result;
    }
    for (slot, result) in results.iter_mut().skip(1).step_by(2).zip(odd) {
        *slot = result;
    }
    results
}

/// The whole map.
pub fn map() -> Map {
    let mut results = on_two_threads(&cases(), Stands::of).into_iter();
    let mut map = Map::default();
    for cell in map.as_flattened_mut().as_flattened_mut().iter_mut().flatten().flatten() {
        *cell = results.next().expect("one result for each cell");
    }
    map
}
