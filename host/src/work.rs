//! What a unit of work takes on this machine, and the budget of a tick that follows from it.
//!
//! The core counts work in instructions of its x86-64 release build ([`haptor_contact::budget`]). What one takes here is measured: an engine of the scene,
//! without limit, presses, slides and twists for a thousand ticks, and each tick's time is divided by its estimate. What all but one tick in a hundred stay below is
//! taken, so that caches and branches that are not warm are in it and an interrupt is not. The budget is what a share of the period has room for. It is a setting
//! like any other: it goes into the recording with the session's tuning, so that a replay needs no clock to come out to the bit.
//!
//! A session has one **rule**, the host's `--budget` until a viewer says another: every scene that it runs, the first and those that viewers bring, gets its budget by it
//! ([`find`]). The first scene is measured on the real-time thread before its loop begins, later ones on an ordinary thread, while another scene runs.

use std::fmt;

use haptor_contact::{MAX_WORK, MIN_WORK, Pose, Quat, Vec3};
use haptor_engine::{DeviceBase, Handle, Limit, Scene, SceneError};
use haptor_wire::WorkBudget;

use crate::rt::clock::Clock;

/// Share of the period that the core may take: the link, the wake-up and the records of a tick take the rest.
pub const SHARE: f64 = 0.6;

/// Ticks of the motion that is measured.
const TICKS: usize = 1000;

/// Ticks at its beginning that only warm up: the way down to the object.
const FIRST: usize = 100;

/// Share of the ticks that take no longer a unit than what is taken.
const QUANTILE: f64 = 0.99;

/// How deep the motion goes below the place where it starts \[m\]: a scene that was baked starts 5 mm above the object, so 1 mm into it.
const DOWN: f32 = 0.006;

/// A measured budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// What a unit takes \[ns\].
    pub ns_per_unit: f64,
    /// Room in the share of the period \[instructions\].
    pub work: u32,
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ns_per_unit, work } = self;
        write!(f, "work budget: {work} instructions a tick, {:.0} % of the period at {ns_per_unit:.3} ns each", 100.0 * SHARE)
    }
}

/// A budget that was found for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// What a tick may spend.
    pub limit: Limit,
    /// What was measured, where something was.
    pub measured: Option<Measured>,
}

/// The budget of a scene under the rule of its session.
///
/// # Errors
/// [`SceneError`] where the scene does not run, or the budget is out of its range.
pub fn find(rule: WorkBudget, scene: &Scene, rate_hz: u32, clock: &impl Clock) -> Result<Found, SceneError> {
    let measured = if rule == WorkBudget::Auto { Some(measure(scene, rate_hz, clock)?) } else { None };
    let work = match rule {
        WorkBudget::Scene => scene.setup().baked().work,
        WorkBudget::Auto => measured.map(|measured| measured.work),
        WorkBudget::Off => None,
        WorkBudget::Work(work) => Some(work),
    };
    Ok(Found { limit: Limit::new(work)?, measured })
}

/// Runs the motion on an engine of its own.
fn measure(scene: &Scene, rate_hz: u32, clock: &impl Clock) -> Result<Measured, SceneError> {
    let mut engine = scene.engine()?;
    engine.limit(Limit::new(Some(MAX_WORK))?);
    let [w, x, y, z] = engine.get().placed().q_wd;
    let to_device = Quat::from_xyzw(x, y, z, w).conjugate();
    let mut shares = Vec::with_capacity(TICKS);
    for tick in 0..TICKS {
        let pose = pose(tick, to_device);
        let before_ns = clock.now_ns();
        let felt = engine.step(&pose, 1.0 / rate_hz as f32);
        let took_ns = clock.now_ns() - before_ns;
        if tick >= FIRST && felt.work > 0 {
            shares.push(took_ns as f64 / f64::from(felt.work));
        }
    }
    let ns_per_unit = quantile(&mut shares);
    Ok(Measured { ns_per_unit, work: room(ns_per_unit, rate_hz) })
}

/// Handle at a tick: down in the first ticks, then to and fro and turning, by whole rounds, so that patches stick and slip.
fn pose(tick: usize, to_device: Quat) -> Pose<DeviceBase, Handle> {
    let down = DOWN * (tick as f32 / FIRST as f32).min(1.0);
    let angle = std::f32::consts::TAU * tick.saturating_sub(FIRST) as f32 / (TICKS - FIRST) as f32;
    let (slow, fast) = ((4.0 * angle).sin(), (9.0 * angle).sin());
    let along = Vec3::new(1.0e-3 * slow, 5.0e-4 * fast, 3.0e-4 * fast - down);
    Pose::new(to_device * along, (to_device * Quat::from_rotation_z(0.1 * slow) * to_device.conjugate()).normalize())
}

/// The share that [`QUANTILE`] of all stay at or below; of none, an endless one.
fn quantile(shares: &mut [f64]) -> f64 {
    shares.sort_by(f64::total_cmp);
    let index = (shares.len() as f64 * QUANTILE) as usize;
    shares.get(index.min(shares.len().saturating_sub(1))).copied().unwrap_or(f64::INFINITY)
}

/// Instructions that fit into the share of the period, within what a budget may be.
fn room(ns_per_unit: f64, rate_hz: u32) -> u32 {
    let period_ns = 1.0e9 / f64::from(rate_hz);
    // a conversion to an integer keeps to its range
    ((SHARE * period_ns / ns_per_unit.max(f64::MIN_POSITIVE)) as u32).clamp(MIN_WORK, MAX_WORK)
}

#[cfg(test)]
mod tests {
    use haptor_wire::{BakedScene, ObjectShape};

    use super::*;
    use crate::rt::clock::Steady;

    #[test]
    fn room_and_quantile() {
        assert_eq!((room(1.0, 1000), room(0.3, 8000), room(f64::INFINITY, 1000)), (600_000, 250_000, MIN_WORK));
        assert_eq!(quantile(&mut (0..1000).rev().map(f64::from).collect::<Vec<_>>()), 990.0);
    }

    #[test]
    fn every_rule_finds_its_budget() {
        let baked = BakedScene {
            place: haptor_wire::Place { p_wd: [0.0, 0.0, 0.025], q_wd: [1.0, 0.0, 0.0, 0.0] },
            work: Some(30_000),
            ..BakedScene::ball_on(ObjectShape::HalfSpace)
        };
        let scene = Scene::new(&baked).unwrap();
        let clock = Steady::new(50_000);
        let found = |rule| find(rule, &scene, 1000, &clock);
        let Found { limit, measured } = found(WorkBudget::Auto).unwrap();
        let measured = measured.unwrap();
        // 50 us a tick over some 3 to 40 thousand instructions: twelve such ticks fit into 0.6 ms
        assert!((1.0..20.0).contains(&measured.ns_per_unit), "{measured}");
        assert_eq!(limit.work(), Some(measured.work));
        let rules = [(WorkBudget::Scene, Some(30_000)), (WorkBudget::Work(20_000), Some(20_000)), (WorkBudget::Off, None)];
        for (rule, work) in rules {
            assert_eq!(found(rule).unwrap(), Found { limit: Limit::new(work).unwrap(), measured: None }, "{rule}");
        }
        assert!(found(WorkBudget::Work(1)).is_err_and(|error| error.to_string().contains("model.work is 1")));
        let mut engine = scene.engine().unwrap();
        engine.limit(limit);
        assert_eq!(engine.get().tuning().work, limit.work());
    }
}
