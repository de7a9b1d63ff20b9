//! An engine pushed into its object: whatever scene it runs, what it sends is finite.

use haptor_contact::{Pose, Quat, Vec3};
use haptor_engine::{Felt, OwnedEngine};

/// How far below the start a pose is \[m\] and how far it is turned about z: the start is 5 mm above the object where a tool has baked the scene.
const POSES: [(f32, f32); 6] = [(0.0, 0.0), (0.004, 0.0), (0.0055, 0.0), (0.006, 0.1), (0.2, -0.3), (0.0, 0.0)];

/// Length of a tick \[s\].
const DT: f32 = 1.0e-3;

/// Steps an engine through a push, and leaves it at rest.
///
/// # Panics
/// When a wrench is not finite, or a contact is not and nothing says so.
pub fn push(engine: &mut OwnedEngine) {
    for (depth, turn) in POSES {
        let turned = Quat::from_xyzw(0.0, 0.0, turn, 1.0).normalize();
        check(&engine.step(&Pose::new(Vec3::new(0.0, 0.0, -depth), turned), DT));
    }
    engine.rest();
}

/// Checks what came out of a tick.
///
/// # Panics
/// As [`push`].
pub fn check(felt: &Felt) {
    assert!(felt.wrench.force.is_finite() && felt.wrench.torque.is_finite(), "{felt:?}");
    let contact = felt.contact_force.iter().chain(&felt.contact_torque).all(|value| value.is_finite());
    assert!(contact || felt.non_finite, "{felt:?}");
}
