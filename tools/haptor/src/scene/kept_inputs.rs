//! The fuzzer's inputs that are kept, on the reader of scene files.

use std::fs;
use std::path::Path;

#[path = "../../../../tests/fuzz/src/scene_toml.rs"]
mod scene_toml;

#[test]
fn kept_inputs_find_nothing() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz");
    let kept = ["corpus/scene_toml", "cases/scene_toml"].map(|name| folder.join(name));
    let inputs: Vec<_> = kept.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().collect();
    assert!(inputs.len() > 10, "{} inputs; `cargo xtask fuzz scene_toml --keep` keeps some", inputs.len());
    for input in inputs {
        let path = input.unwrap().path();
        println!("{}", path.display());
        scene_toml::run(&fs::read(&path).unwrap());
    }
}
