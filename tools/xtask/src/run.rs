//! Running other programs: said before it is done, and an error when it does not end well.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

/// The folder of the root manifest.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here)
}

/// The folder in which cargo builds, wherever it has been told to: this program lies in it, in the folder of its profile.
///
/// # Errors
/// When the path of this program is unknown.
pub fn target() -> Result<PathBuf> {
    let here = std::env::current_exe().context("the path of this program is unknown")?;
    here.ancestors().nth(2).map(Path::to_owned).context("this program does not lie in a folder of cargo's")
}

/// Cargo, as it was called.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root());
    command
}

/// Builds the host tool and yields its path.
///
/// # Errors
/// When it does not build.
pub fn tool() -> Result<PathBuf> {
    let target = target()?;
    run(cargo().args(["build", "--quiet", "-p", "haptor", "--target-dir"]).arg(&target))?;
    Ok(target.join("debug/haptor"))
}

/// Builds the host tool in release, the one of `cargo xtask demo`, and yields its path.
///
/// # Errors
/// When it does not build.
pub fn release_tool() -> Result<PathBuf> {
    let target = target()?;
    run(cargo().args(["build", "--quiet", "--release", "-p", "haptor", "--target-dir"]).arg(&target))?;
    Ok(target.join("release/haptor"))
}

/// A program that was built, run in the folder of the root manifest.
pub fn program(path: &Path) -> Command {
    let mut command = Command::new(path);
    command.current_dir(root());
    command
}

/// Runs a command to its good end.
///
/// # Errors
/// When it cannot be started or does not end with 0.
pub fn run(command: &mut Command) -> Result<()> {
    let line = line(command);
    eprintln!("$ {line}");
    let status = command.status().with_context(|| format!("`{line}` cannot be started"))?;
    if !status.success() {
        bail!("`{line}` ended with {status}");
    }
    Ok(())
}

/// Runs a command and yields what it prints; `None` when it cannot be started or fails.
pub fn ask(program: impl AsRef<Path>, args: &[&str]) -> Option<String> {
    let output = Command::new(program.as_ref()).args(args).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// The processor's name, as the kernel tells it.
pub fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or("unknown", |(_, name)| name.trim()).to_owned()
}

/// Date, cores, processor, kernel and compiler, as tables name them.
pub fn machine() -> String {
    let line = |program, args: &[&str]| ask(program, args).unwrap_or_default();
    format!(
        "{}, {} cores of {}, Linux {}, {}",
        line("date", &["+%-d %B %Y"]),
        line("nproc", &[]),
        processor(),
        line("uname", &["-r"]),
        line("rustc", &["--version"])
    )
}

/// Installs Debian's packages where that is possible; where it is not, the caller says what to do.
///
/// # Errors
/// When the installation fails.
pub fn install(packages: &[&str]) -> Result<()> {
    if ask("apt-get", &["--version"]).is_none() || ask("id", &["-u"]).as_deref() != Some("0") {
        return Ok(());
    }
    // a list that was never fetched, or long ago, knows other versions
    run(Command::new("apt-get").arg("update"))?;
    run(Command::new("apt-get").args(["install", "-y", "--no-install-recommends"]).args(packages))
}

fn line(command: &Command) -> String {
    let name = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(name).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
