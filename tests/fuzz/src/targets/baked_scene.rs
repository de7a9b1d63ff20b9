//! A baked scene with the data behind it: what is taken, runs.

use haptor_engine::Scene;

use super::{mend, push};

/// Bytes as they are, and mended.
pub fn run(bytes: &[u8]) {
    for file in [bytes.to_vec(), mend::baked_scene(bytes)] {
        let Ok(scene) = Scene::read(&file) else { continue };
        let mut engine = scene.engine().expect("a scene that was read has an engine");
        push::push(&mut engine);
    }
}
