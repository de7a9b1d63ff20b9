//! The arguments of `haptor-measure`.

use std::num::NonZeroU16;
use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use haptor_contact::{MAX_WORK, MIN_WORK};
use haptor_wire::Tier;

use crate::config::Rt;
use crate::rt::policy::RtPolicy;

const HELP_END: &str = "\
Example:
  haptor record -o twist.haptor tests/scenes/cube-twist.toml --trajectory tests/scenes/cube-twist.csv
  haptor-measure twist.haptor time --ticks 1000000

Lines of JSON on standard output; `haptor timing` reads them. Exit: 0 done; 1 a right or a thread was refused; 2 bad usage or input.";

/// Runs the ticks of a recording again and says what they cost.
#[derive(Parser, Clone, Debug)]
#[command(name = "haptor-measure", version, after_help = HELP_END)]
pub struct Args {
    /// The recording, with its scene
    pub file: PathBuf,
    /// Tier in place of the recording's
    #[arg(long, value_enum)]
    pub tier: Option<TierArg>,
    /// Samples per region in place of the recording's
    #[arg(long)]
    pub samples: Option<u16>,
    /// Sweeps in place of the recording's
    #[arg(long)]
    pub sweeps: Option<u8>,
    /// Work that a tick may spend, in instructions, in place of the recording's
    #[arg(long, value_parser = clap::value_parser!(u32).range(i64::from(MIN_WORK)..=i64::from(MAX_WORK)))]
    pub work: Option<u32>,
    /// What is measured
    #[command(subcommand)]
    pub how: How,
}

/// What is measured.
#[derive(Subcommand, Clone, Copy, Debug)]
pub enum How {
    /// The time of every tick under the real-time policy, the recording over and over
    Time {
        /// Ticks
        #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..))]
        ticks: u64,
        /// Whether to measure without real-time rights
        #[arg(long, value_enum, default_value_t = Rt::Ignore)]
        rt: Rt,
        /// CPU to run on; default: the last one it may use, if it is granted the real-time class
        #[arg(long, value_name = "N")]
        cpu: Option<usize>,
        /// Longest run in seconds: then fewer ticks are timed
        #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..))]
        seconds: Option<u32>,
    },
    /// The least time of each tick over some rounds
    Fastest {
        /// Rounds
        #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
        rounds: u32,
    },
    /// Nothing: every tick once, for an instruction counter to watch
    Count {
        /// Then the surface of so many points once, as a viewer watches it: a square of 0.1 m around the deepest contact
        #[arg(long, value_name = "POINTS")]
        surface: Option<NonZeroU16>,
    },
}

impl From<Rt> for RtPolicy {
    fn from(rt: Rt) -> Self {
        match rt {
            Rt::Enforce => Self::Enforce,
            Rt::Ignore => Self::Ignore,
        }
    }
}

/// A tier on the command line.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum TierArg {
    /// Closed-form curves
    Point,
    /// The paper's equations
    Paper,
    /// Calibrated bristles
    Bristle,
    /// Cells on the elastic surface
    Influence,
    /// The same with the body's own table
    Green,
}

impl From<TierArg> for Tier {
    fn from(tier: TierArg) -> Self {
        match tier {
            TierArg::Point => Self::Point,
            TierArg::Paper => Self::Paper,
            TierArg::Bristle => Self::Bristle,
            TierArg::Influence => Self::Influence,
            TierArg::Green => Self::Green,
        }
    }
}
