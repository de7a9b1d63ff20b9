//! `haptor completions`: what a shell needs to complete commands and options.

use std::io;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::failure::Outcome;

/// Prints the completions for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor completions bash > ~/.local/share/bash-completion/completions/haptor\n\
                        zsh: into a folder of $fpath as _haptor; fish: ~/.config/fish/completions/haptor.fish")]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut crate::Cli::command(), "haptor", &mut text);
    // a reader that has left is no failure
    let _ = io::Write::write_all(&mut io::stdout(), &text);
    Ok(())
}
