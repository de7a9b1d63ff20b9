//! `haptor mesh`: what a mesh file holds, whether a scene can use it, mending, reducing and baking it, and meshes to try with.
//!
//! | module | what it does |
//! |---|---|
//! | `file` | the file that a command reads: its path, its unit |
//! | `examine` | `info` and `check` |
//! | `mend` | `repair` and `reduce` |
//! | `bake` | `bake` |
//! | `make` | `make` |

mod bake;
mod examine;
mod file;
mod make;
mod mend;

use crate::failure::Outcome;

/// Looks into mesh files (STL, OBJ, PLY), mends, reduces, bakes and makes them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh check part.stl --unit mm")]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    Info(examine::Info),
    Check(examine::Check),
    Repair(mend::Repair),
    Reduce(mend::Reduce),
    Bake(bake::Args),
    Make(make::Args),
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    match &args.action {
        Action::Info(args) => examine::info(args),
        Action::Check(args) => examine::check(args),
        Action::Repair(args) => mend::repair(args),
        Action::Reduce(args) => mend::reduce(args),
        Action::Bake(args) => bake::run(args),
        Action::Make(args) => make::run(args),
    }
}
