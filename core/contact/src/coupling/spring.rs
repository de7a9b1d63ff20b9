//! Spring and damper of the coupling along one kind of motion (theory.md, equations 10.3 to 10.5).
//!
//! **Why the damper gives way.** A plain damper between a handle that moves in encoder steps and the probe sends B x step / dt to the hand: with 30 um,
//! 1 kHz and 57 N s/m that is 1.7 N a step, and a sampled damper of that size is itself unstable on a light device (Colgate: b > K T/2 + |B|). Here it is in
//! series with a spring of [`GIVE`] x K: a step then costs (1 + GIVE) K x step, 0.12 N, and what the hand sees within a tick is a spring of (1 + GIVE) K
//! at most. Spring and spring-with-damper are passive for any motion.

use glam::Vec3;

use crate::math::{max, min, root};

/// Stiffness in series with the damper, in stiffnesses of the spring. At 4 a probe on a critical damper settles with a damping ratio of 0.37; 2 would leave
/// 0.19, 8 would double what an encoder step costs the hand.
const GIVE: f32 = 4.0;

/// Three equal springs and dampers, for translation \[N/m, N s/m, N\] or for rotation \[N m/rad, N m s/rad, N m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Stiffness K.
    pub stiffness: f32,
    /// Damping B.
    pub damping: f32,
    /// Largest pull of the spring; infinity for none.
    pub most: f32,
}

/// What a spring does in one tick: pull = `now` - dt x `implicit` x speed of the probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Pull if the probe stood still.
    pub now: Vec3,
    /// Of that, the spring's share.
    pub spring: Vec3,
    /// Stiffness against the probe's motion in this tick.
    pub implicit: f32,
    /// Share of the damper's spring that survives the tick.
    kept: f32,
}

impl Spring {
    /// Critical damping of a mass on this stiffness (inertia about an axis for rotation).
    pub fn critical(stiffness: f32, mass: f32) -> f32 {
        2.0 * root(stiffness * mass)
    }

    /// The spring's own pull at a stretch, saturated, direction kept (Barbic and James saturate theirs for the same reasons).
    pub fn pull(&self, stretch: Vec3) -> Vec3 {
        stretch * self.secant(stretch)
    }

    /// Pull over stretch.
    fn secant(&self, stretch: Vec3) -> f32 {
        let length = root(stretch.length_squared());
        if self.stiffness * length > self.most { min(self.most / length, self.stiffness) } else { self.stiffness }
    }

    /// The tick in which the handle moved by `moved` and the stretch would be `stretch` if the probe stood still; the damper held `held`.
    pub fn tick(&self, stretch: Vec3, moved: Vec3, held: Vec3, dt: f32) -> Pull {
        let series = GIVE * self.stiffness;
        // without damping nothing is kept: 1/(1 + infinity)
        let kept = if self.damping > 0.0 { 1.0 / (1.0 + dt * series / self.damping) } else { 0.0 };
        let secant = self.secant(stretch);
        let spring = stretch * secant;
        Pull { now: spring + (held + moved * series) * kept, spring, implicit: secant + kept * series, kept }
    }

    /// What the damper holds after the probe moved by `step` in that tick.
    pub fn held(&self, pull: &Pull, held: Vec3, moved: Vec3, step: Vec3) -> Vec3 {
        (held + (moved - step) * (GIVE * self.stiffness)) * pull.kept
    }

    /// Least stiffness this spring shows at `stretch`: what a pivot of the solve cannot fall below.
    pub fn floor(&self, stretch: Vec3) -> f32 {
        max(self.secant(stretch), f32::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPRING: Spring = Spring { stiffness: 800.0, damping: 50.0, most: f32::INFINITY };

    #[test]
    fn at_a_steady_speed_the_damper_is_a_damper_and_at_rest_it_lets_go() {
        let (dt, speed) = (1.0e-3, Vec3::X * 0.1);
        let mut held = Vec3::ZERO;
        for _ in 0..500 {
            let pull = SPRING.tick(Vec3::ZERO, speed * dt, held, dt);
            held = SPRING.held(&pull, held, speed * dt, Vec3::ZERO);
        }
        assert!((held.x - 5.0).abs() < 1.0e-3, "{held}");
        for _ in 0..500 {
            let pull = SPRING.tick(Vec3::ZERO, Vec3::ZERO, held, dt);
            held = SPRING.held(&pull, held, Vec3::ZERO, Vec3::ZERO);
        }
        assert!(held.length() < 1.0e-6);
    }

    #[test]
    fn a_closed_path_never_gains_energy() {
        // the handle goes to and fro, the probe is held: the sum of pull x motion is what the hand puts in
        for damping in [0.0, 5.0, 50.0, 5.0e3] {
            let spring = Spring { damping, ..SPRING };
            let (mut held, mut x, mut energy) = (Vec3::ZERO, 0.0_f64, 0.0_f64);
            for tick in 0..4000 {
                let next = 1.0e-3 * (f64::from(tick) * 0.01).sin();
                let moved = Vec3::X * (next - x) as f32;
                let pull = spring.tick(Vec3::X * next as f32, moved, held, 1.0e-3);
                held = spring.held(&pull, held, moved, Vec3::ZERO);
                energy += f64::from(spring.pull(Vec3::X * next as f32).x + held.x) * (next - x);
                x = next;
            }
            assert!(energy >= -1.0e-9, "{damping}: {energy} J");
        }
    }

    #[test]
    fn saturation_keeps_the_direction() {
        let spring = Spring { most: 4.0, ..SPRING };
        let pull = spring.pull(Vec3::new(0.03, 0.0, 0.04));
        assert!((pull - Vec3::new(2.4, 0.0, 3.2)).length() < 1.0e-5, "{pull}");
        assert_eq!(spring.pull(Vec3::X * 1.0e-3), Vec3::X * 0.8);
    }
}
