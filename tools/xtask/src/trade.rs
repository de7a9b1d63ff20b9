//! `cargo xtask trade`: speed against accuracy of all ready scenes, as `tests/bench/TRADE.md` with a picture for each, and errors and instructions of a first look, which
//! `tests/it/trade.rs` watches, as `tests/bench/trade.json`.

use std::fs;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use crate::run::{self, root};

/// Measures every scene with the host tool in release; `ticks` in place of the tool's own number of timed ticks.
pub fn run(ticks: Option<usize>, quick: bool, kept_only: bool) -> Result<ExitCode> {
    let haptor = run::release_tool()?;
    let folder = root().join("tests/bench");
    let trade = |name: &str, more: &[&str]| {
        let mut command = run::program(&haptor);
        command.args(["trade", &format!("tests/scenes/{name}.toml")]).args(more);
        output(&mut command)
    };
    let scenes = scenes()?;
    let mut first_looks = Vec::new();
    for name in &scenes {
        first_looks.push(trade(name, &["--quick", "--no-time", "--json"])?.trim().to_owned());
    }
    write(&folder.join("trade.json"), &format!("[\n{}\n]\n", first_looks.join(",\n")))?;
    if kept_only {
        return Ok(ExitCode::SUCCESS);
    }
    let again = if quick { "cargo xtask trade --quick" } else { "cargo xtask trade" };
    let mut text = HEAD.replace("{again}", again).replace("{machine}", &run::machine());
    let ticks = ticks.map(|ticks| format!("--ticks={ticks}"));
    for name in &scenes {
        let picture = format!("--picture=tests/bench/trade-{name}.png");
        let options: Vec<&str> =
            ["--markdown", &picture].into_iter().chain(quick.then_some("--quick")).chain(ticks.as_deref()).collect();
        text += &format!("\n{}\n![{name}: error against time](trade-{name}.png)\n", trade(name, &options)?);
        println!("{name}: measured");
    }
    write(&folder.join("TRADE.md"), &text)?;
    Ok(ExitCode::SUCCESS)
}

/// Names of the ready scenes, in order.
fn scenes() -> Result<Vec<String>> {
    let folder = root().join("tests/scenes");
    let files = fs::read_dir(&folder).with_context(|| format!("{}", folder.display()))?;
    let paths = files.map(|file| Ok(file?.path())).collect::<Result<Vec<_>>>()?;
    let scenes = paths.iter().filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let mut names: Vec<String> = scenes.filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    Ok(names)
}

fn output(command: &mut Command) -> Result<String> {
    let output = command.output().context("the tool cannot be started")?;
    if !output.status.success() {
        bail!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8(output.stdout)?)
}

fn write(file: &std::path::Path, text: &str) -> Result<()> {
    fs::write(file, text).with_context(|| format!("{}", file.display()))?;
    println!("{} written", file.display());
    Ok(())
}

const HEAD: &str = "\
# Speed against accuracy

Written by `{again}`: `haptor trade` on the ready scenes, {machine}. Errors and instructions are the same on every run, and `tests/it/trade.rs` watches those of a
first look (`trade.json`); times are this machine's while others used it too.

The probe is pressed by a twentieth of its radius, twisted to four times the turn that a sticking contact would need for full slip, turned back and forth, and led on a circle with twist and along an
aimless path, 0.4 s each. Errors are largest (root mean square): normal force while pressing, of the force at full depth; torque in twist and reversal, of the largest torque of the twist; mixed motion: force
along the surface of mu P, torque as before, the worse; surface: displacement within three contact radii, pressed and after each motion, of the largest there, with the body's motion (`deformation = \"full\"`) and without (`\"local\"`); with
`\"none\"` it is 100 %. Truth: the f64 reference (`tools/reference`) on half spaces with the scene's own shapes, plus the body's compliance from where each section says; where that is the scene's own,
its error does not show.

Where errors stay. `point`: its curves are those of pure motions; what drag and twist take from each other is a fit (theory.md, 6.3a to 6.3c), 10 to 27 % at worst while both change. Mixed motion on
the mallet, likely: its contact is 1.8 times longer than wide, and drag is taken as a disc's, stuck 3 % too stiff along and 7 % too soft across. Organ, meshes, likely: the shape as felt, a spline of distances,
is not quite the mesh that the reference's rays meet. Surface, at worst: inside the contact, after paths that turned, because the field is that of fresh loading to the same force and torque; on the mallet at the
ends of its long contact, because the field is a disc's.

Worst time: the dearest tick, each tick taken at its fastest of all repetitions; max includes interruptions. Instructions: the dearest of 64 ticks, by callgrind. Bytes: state and workspace with room for a probe of 16
parts, without a body's table.
";
