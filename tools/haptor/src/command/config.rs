//! `haptor config`: where the configuration lies, what holds, and a file to begin with.

use std::fs;

use serde_json::json;

use crate::config::{self, Config};
use crate::failure::{Failure, Outcome};
use crate::output::{self, say};

/// Shows the configuration: where its file lies and what holds where the command line says nothing.
///
/// The file is $XDG_CONFIG_HOME/haptor/config.toml, by default ~/.config/haptor/config.toml; the variable HAPTOR_CONFIG names
/// another. The command line goes before the file, the file before the built-in defaults.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor config --init")]
pub struct Args {
    /// Write a file to begin with, every key commented out with its default; one that is there is left alone
    #[arg(long)]
    init: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (path, _) = config::path();
    let path = path.ok_or_else(|| Failure::problem(format!("there is no home folder; name a file with {}", config::VARIABLE)))?;
    if args.init {
        return init(&path);
    }
    let config = Config::load()?;
    let rows = [
        ("device", config.device.clone(), None),
        ("rate", config.rate.map(|rate| rate.to_string()), Some(config::RATE.to_string())),
        ("rt", config.rt.clone(), Some(config::RT.to_owned())),
        ("preset", config.preset.clone(), Some(config::PRESET.to_owned())),
    ];
    if args.json {
        let keys: serde_json::Map<_, _> = rows
            .into_iter()
            .map(|(key, own, default)| (key.to_owned(), json!({ "from_file": own.is_some(), "value": own.or(default) })))
            .collect();
        say(format_args!("{:#}", json!({ "file": path, "exists": path.is_file(), "keys": keys })));
        return Ok(());
    }
    say(format_args!("{}{}", path.display(), if path.is_file() { "" } else { " (not there; haptor config --init writes one)" }));
    for (key, own, default) in rows {
        let from = if own.is_some() { "file" } else { "default" };
        let value = own.or(default).unwrap_or_else(|| "none: give --device".to_owned());
        say(format_args!("  {key:<9}{value:<24}{from}"));
    }
    Ok(())
}

fn init(path: &std::path::Path) -> Outcome {
    if path.exists() {
        return Err(Failure::problem(format!("{} is there already; it was left alone", path.display())));
    }
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder).map_err(|error| Failure::bad_input(format!("{}: cannot be made: {error}", folder.display())))?;
    output::write_file(path, config::TEMPLATE.as_bytes())?;
    say(format_args!("{} written", path.display()));
    Ok(())
}
