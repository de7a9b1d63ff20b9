//! `cargo xtask golden`: are the curves of the ready scenes those that are kept in `tests/golden/curves`? With `--accept` the
//! present ones are kept from now on; the difference to the former belongs into the message of the change.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::thread;

use anyhow::{Context, Result, anyhow, bail};

use crate::run::{root, tool};
use crate::scenes::{self, Tier};

/// Compares, or accepts. What differs is told in either case.
pub fn run(accept: bool) -> Result<ExitCode> {
    let haptor = tool()?;
    let jobs: Vec<_> = scenes::all().collect();
    let found: Vec<Result<String>> = thread::scope(|scope| {
        let one = |&(scene, tier): &(&'static str, Tier)| {
            let haptor = &haptor;
            scope.spawn(move || curve(haptor, scene, tier))
        };
        let threads: Vec<_> = jobs.iter().map(one).collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err(anyhow!("a comparison panicked")))).collect()
    });
    let mut different = 0;
    for (&(scene, tier), found) in jobs.iter().zip(found) {
        different += usize::from(!compare(scene, tier, &found?, accept)?);
    }
    match different {
        0 => println!("{} curves are as expected", jobs.len()),
        _ if accept => println!("{different} of {} curves accepted", jobs.len()),
        _ => bail!("{different} of {} curves differ; accept them with `{}`", jobs.len(), scenes::ACCEPT),
    }
    Ok(ExitCode::SUCCESS)
}

/// True when the curve is the expected one.
fn compare(scene: &str, tier: Tier, found: &str, accept: bool) -> Result<bool> {
    let file = scenes::file(root(), scene, tier);
    let Ok(expected) = fs::read_to_string(&file) else {
        println!("{scene}, tier {}: there is no {}", tier.name, file.display());
        return keep(&file, found, accept);
    };
    let Some(difference) = scenes::difference(scene, tier, &expected, found) else { return Ok(true) };
    println!("{difference}");
    keep(&file, found, accept)
}

fn keep(file: &Path, found: &str, accept: bool) -> Result<bool> {
    if accept {
        let folder = file.parent().context("a curve lies in a folder")?;
        fs::create_dir_all(folder).and_then(|()| fs::write(file, found)).with_context(|| format!("{}", file.display()))?;
    }
    Ok(false)
}

/// The result of a scene in a tier, thinned.
fn curve(haptor: &Path, scene: &str, tier: Tier) -> Result<String> {
    let output = scenes::eval(haptor, root(), scene, tier).output().with_context(|| format!("{}", haptor.display()))?;
    if !output.status.success() {
        bail!("{scene}, tier {}: {}", tier.name, String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(scenes::thinned(&String::from_utf8(output.stdout)?))
}
