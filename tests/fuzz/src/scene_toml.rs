//! A scene file as people write it: what the tool takes, the host takes too.

use haptor_engine::Scene as Running;
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{ObjectShape, ProbeShape, Tier};

use crate::scene::Scene;

/// Parses a scene, bakes it, and reads it as the host does. Its name in messages has no folder, so that no mesh is found beside it.
pub fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match Scene::parse("scene.toml", text) {
        Ok(scene) => scene,
        Err(error) => {
            // behind a last newline there is a line more
            assert!((1..=text.split('\n').count()).contains(&error.line), "{error}");
            return;
        }
    };
    let baked = scene.bake().expect("a scene that was read can be baked");
    let parts = baked.probe.as_slice();
    let meshes = matches!(baked.object, ObjectShape::Mesh { .. })
        || parts.iter().any(|part| matches!(part.shape, ProbeShape::Mesh { .. }));
    // these need data behind the scene, which is made by finite elements and from files
    if meshes || baked.tier == Tier::Green {
        return;
    }
    let mut file = [0; FILE_MAX];
    let length = encode_file(&baked, &mut file).expect("a scene fits its file");
    let running = Running::read(&file[..length]).unwrap_or_else(|error| panic!("the host refuses what the tool took: {error}"));
    running.engine().unwrap_or_else(|error| panic!("the host refuses what the tool took: {error}"));
}
