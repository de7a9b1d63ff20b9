//! `cargo xtask pictures`: every picture of the documents that a scene gives, drawn anew into `tests/golden/pictures`.

use std::fs;
use std::process::ExitCode;

use anyhow::{Context, Result};

use crate::run::{self, target};
use crate::scenes::SCENES;

/// Pictures of moments: file, scene, time \[s\].
const SHOTS: [(&str, &str, &str); 5] = [
    ("cube-twist", "cube-twist", "0.9"),
    ("mallet-forth", "mallet", "0.3"),
    ("mallet-back", "mallet", "0.68"),
    ("compass", "compass", "0.3"),
    ("ten-regions", "ten-regions", "0.46"),
];

/// Width and height \[pixels\].
const SIZE: &str = "720x540";

/// Draws all pictures, with the host tool in release: a picture has some million samples.
pub fn run() -> Result<ExitCode> {
    let target = target()?;
    let haptor = run::release_tool()?;
    let tool = || run::program(&haptor);
    let picture = |name: &str| format!("tests/golden/pictures/{name}.png");
    let [scene, poses] = ["toml", "csv"].map(|kind| move |name: &str| format!("tests/scenes/{name}.{kind}"));
    for (file, name, time) in SHOTS {
        let mut shot = tool();
        shot.args(["view", "--shot", &picture(file), "--scene", &scene(name), "--trajectory", &poses(name)]);
        run::run(shot.args(["--at", time, "--size", SIZE]))?;
    }
    let table = target.join("picture.csv");
    for name in SCENES {
        run::run(tool().args(["eval", &scene(name), &poses(name), "-o"]).arg(&table))?;
        run::run(tool().arg("plot").arg(&table).args(["-o", &picture(&format!("{name}-wrench")), "--title", name]))?;
    }
    fs::remove_file(&table).with_context(|| format!("{}", table.display()))?;
    Ok(ExitCode::SUCCESS)
}
