//! The scene that sessions run on.

use haptor_firmware_sim::script::CLEARANCE;
use haptor_wire::{BakedScene, ObjectShape, Place};

/// The ball on the rubber cube of the reference scenes; the device stands so that the ball hovers over the middle of the top.
pub fn ball_on_cube() -> BakedScene {
    let place = Place { p_wd: [0.0, 0.0, 0.12 + CLEARANCE], q_wd: [1.0, 0.0, 0.0, 0.0] };
    BakedScene { place, ..BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }) }
}
