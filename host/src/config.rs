//! What a run is told on the command line, checked before anything is opened.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};

use crate::error::HostError;
use crate::link::Address;
use crate::rt::pace::Follow;
use crate::rt::policy::{Right, RtPolicy};
use crate::rt::scale::ticks_at;
use crate::rt::stale::StaleRule;
use crate::viewer::listen::ViewerAddress;
use haptor_engine::work::budget;
use haptor_wire::WorkBudget;
use haptor_wire::viewer::DEFAULT_ADDRESS;

/// Slowest rate \[Hz\]: below it a hand feels steps, and a stale pose is held for longer than a hand takes to react.
pub const RATE_MIN_HZ: u32 = 100;

/// Fastest rate \[Hz\]: the micro-frames of high-speed USB.
pub const RATE_MAX_HZ: u32 = 8000;

/// Longest hold and fade \[ticks\] at the default rate ([`crate::rt::scale`]): a tenth of a second, after which a hand feels a wall that is not there.
pub const STALE_MAX_TICKS: u32 = 100;

/// Longest session \[s\]: a month.
pub const SECONDS_MAX: f64 = 2.7e6;

/// The arguments of `haptor-host`.
#[derive(Parser, Clone, Debug)]
#[command(name = "haptor-host", version, about = "Closes the loop between a haptic device and the contact core", after_help = HELP_END)]
pub struct Args {
    /// The baked scene (`haptor bake SCENE -o MODEL`)
    pub model: PathBuf,
    /// The device: serial:PATH, serial:NUMBER (of its USB device), tcp:HOST:PORT, usb, usb:SERIAL, or by its bulk endpoints usb-bulk,
    /// usb-bulk:SERIAL
    #[arg(long, value_name = "DEVICE")]
    pub device: Address,
    /// Ticks a second
    #[arg(long, value_name = "HZ", default_value_t = 1000)]
    pub rate: u32,
    /// Whether to start without real-time rights
    #[arg(long, value_enum, default_value_t = Rt::Enforce)]
    pub rt: Rt,
    /// CPU for the real-time thread; default: the last one it may use, if it is granted the real-time class
    #[arg(long, value_name = "N")]
    pub cpu: Option<usize>,
    /// Do not ask for this right, to measure what it buys; may be repeated
    #[arg(long, value_enum, value_name = "RIGHT")]
    pub without: Vec<RightArg>,
    /// Length of the session; default: until Ctrl-C
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Where to record the session
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Where to write the last second before a fault, 1000 ticks at least; default: the recording's name with .blackbox
    #[arg(long, value_name = "FILE")]
    pub blackbox: Option<PathBuf>,
    /// Where to write every duration of the session when it ends: wake-up, step and round trip as histograms (CSV: what,upto_ns,count)
    #[arg(long, value_name = "FILE")]
    pub times: Option<PathBuf>,
    /// What goes to standard output: one table at the end, or frames for a program
    #[arg(long, value_enum, default_value_t = StatusFormat::Text)]
    pub status: StatusFormat,
    /// Ticks without a pose through which the last wrench is held; default: 4, above 1 kHz as many as make 4 ms
    #[arg(long, value_name = "TICKS")]
    pub hold: Option<u32>,
    /// Ticks over which it then fades to zero and a fault latches; default: 16, above 1 kHz as many as make 16 ms
    #[arg(long, value_name = "TICKS")]
    pub fade: Option<u32>,
    /// End when standard input is closed, as after Ctrl-C: for a program that starts this one and may die
    #[arg(long)]
    pub until_stdin_closes: bool,
    /// Let viewers in at HOST:PORT or unix:PATH; without an address at 127.0.0.1:21278, port 0 = a free one. They may steer the session, so nobody gets in
    /// unless asked to; from beyond this machine only with a token
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    pub viewer: Option<ViewerAddress>,
    /// The token that viewers must know, 64 hexadecimal digits; default: HAPTOR_TOKEN of the environment
    #[arg(long, value_name = "FILE", requires = "viewer")]
    pub token_file: Option<PathBuf>,
    /// What ticks follow; default: the clock, with USB the device
    #[arg(long, value_enum)]
    pub pace: Option<PaceArg>,
    /// Work a tick may spend before tier and samples are lowered, in this scene and in those that viewers bring: auto measures this machine for each, off sets no
    /// limit, scene leaves it to each, or instructions
    #[arg(long, value_name = "scene|auto|off|N", value_parser = budget, default_value_t = WorkBudget::Scene)]
    pub budget: WorkBudget,
}

const HELP_END: &str = "\
Example:
  haptor-host cube-twist.model --device serial:/dev/ttyACM0 --rt enforce --seconds 10 --record session.rec

Exit: 0 no fault and at least 90 % of the ticks in time; 1 a fault, a device or a machine that does not do; 2 bad usage or input.";

/// `--rt`.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rt {
    /// Refuse to start without the rights, and say what to do
    Enforce,
    /// Run with what there is, and say so
    Ignore,
}

/// `--without`.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightArg {
    /// The real-time class
    Fifo,
    /// Locked memory
    Lock,
    /// A CPU of its own
    Pin,
    /// No deep CPU sleep
    Awake,
}

impl From<RightArg> for Right {
    fn from(right: RightArg) -> Self {
        match right {
            RightArg::Fifo => Self::Fifo,
            RightArg::Lock => Self::Lock,
            RightArg::Pin => Self::Pin,
            RightArg::Awake => Self::Awake,
        }
    }
}

/// `--status`.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusFormat {
    /// One table at the end
    Text,
    /// Frames of the tool link, as they happen
    Frames,
}

/// `--pace`.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaceArg {
    /// The host's clock
    Clock,
    /// The device's reports
    Device,
}

/// A checked run.
#[derive(Clone, Debug)]
pub struct Config {
    /// The baked scene.
    pub model: PathBuf,
    /// The device.
    pub device: Address,
    /// Ticks a second.
    pub rate_hz: u32,
    /// What to do without real-time rights.
    pub rt: RtPolicy,
    /// CPU asked for.
    pub cpu: Option<usize>,
    /// What is not asked for.
    pub without: Vec<Right>,
    /// Ticks of the session; `None` = until stopped.
    pub ticks: Option<u64>,
    /// Recording.
    pub record: Option<PathBuf>,
    /// Black box, when there is anywhere to write it.
    pub black_box: Option<PathBuf>,
    /// Histograms.
    pub times: Option<PathBuf>,
    /// Standard output.
    pub status: StatusFormat,
    /// What ticks follow.
    pub follow: Follow,
    /// What says how much a tick may spend.
    pub budget: WorkBudget,
    /// How long a wrench outlives its pose.
    pub stale: StaleRule,
    /// The session ends with standard input.
    pub until_stdin_closes: bool,
    /// Where viewers come in.
    pub viewer: Option<ViewerAddress>,
    /// What holds their token.
    pub token_file: Option<PathBuf>,
}

impl Config {
    /// Checks the arguments.
    ///
    /// # Errors
    /// [`HostError::Argument`] names the first that is out of range.
    pub fn new(args: Args) -> Result<Self, HostError> {
        check(&args)?;
        let beside = |record: &PathBuf| {
            let mut name = record.clone().into_os_string();
            name.push(".blackbox");
            PathBuf::from(name)
        };
        let usual = StaleRule::at(args.rate);
        let default_pace = if matches!(args.device, Address::Usb(_)) { PaceArg::Device } else { PaceArg::Clock };
        Ok(Self {
            black_box: args.blackbox.or_else(|| args.record.as_ref().map(beside)),
            rt: match args.rt {
                Rt::Enforce => RtPolicy::Enforce,
                Rt::Ignore => RtPolicy::Ignore,
            },
            budget: args.budget,
            follow: match args.pace.unwrap_or(default_pace) {
                PaceArg::Clock => Follow::Clock,
                PaceArg::Device => Follow::Device,
            },
            ticks: args.seconds.map(|seconds| (seconds * f64::from(args.rate)).ceil() as u64),
            stale: StaleRule { hold: args.hold.unwrap_or(usual.hold), fade: args.fade.unwrap_or(usual.fade), ..usual },
            until_stdin_closes: args.until_stdin_closes,
            model: args.model,
            device: args.device,
            rate_hz: args.rate,
            cpu: args.cpu,
            without: args.without.into_iter().map(Right::from).collect(),
            times: args.times,
            record: args.record,
            status: args.status,
            viewer: args.viewer,
            token_file: args.token_file,
        })
    }
}

fn check(args: &Args) -> Result<(), HostError> {
    let out_of_range = |name, value: String, allowed| HostError::Argument { name, value, allowed };
    if !(RATE_MIN_HZ..=RATE_MAX_HZ).contains(&args.rate) {
        return Err(out_of_range("--rate", args.rate.to_string(), "100 to 8000 Hz"));
    }
    if let Some(seconds) = args.seconds
        && !(seconds > 0.0 && seconds <= SECONDS_MAX)
    {
        return Err(out_of_range("--seconds", seconds.to_string(), "above 0 to 2.7e6 s"));
    }
    for (name, ticks) in [("--hold", args.hold), ("--fade", args.fade)] {
        if ticks.is_some_and(|ticks| !(1..=ticks_at(args.rate, STALE_MAX_TICKS)).contains(&ticks)) {
            return Err(out_of_range(name, ticks.unwrap_or(0).to_string(), "1 to 100 ticks, above 1 kHz as many as make 100 ms"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn config(extra: &[&str]) -> Result<Config, HostError> {
        let args = ["haptor-host", "m", "--device", "tcp:127.0.0.1:4000"];
        Config::new(Args::try_parse_from(args.iter().chain(extra)).unwrap())
    }

    #[test]
    fn defaults() {
        Args::command().debug_assert();
        let c = config(&[]).unwrap();
        assert_eq!((c.rate_hz, c.rt, c.ticks, c.follow), (1000, RtPolicy::Enforce, None, Follow::Clock));
        assert_eq!(c.black_box, None);
    }

    #[test]
    fn seconds_become_ticks_and_the_black_box_lies_beside_the_recording() {
        let c = config(&["--rate", "2000", "--seconds", "1.5", "--record", "a/b.rec"]).unwrap();
        assert_eq!((c.ticks, c.black_box), (Some(3000), Some("a/b.rec.blackbox".into())));
    }

    #[test]
    fn what_is_out_of_range_is_named() {
        for (extra, named) in [
            (["--rate", "99"], "--rate is 99"),
            (["--seconds", "0"], "above 0"),
            (["--seconds", "nan"], "--seconds is NaN"),
            (["--fade", "0"], "1 to 100 ticks"),
        ] {
            let text = config(&extra).unwrap_err().to_string();
            assert!(text.contains(named), "{text}");
        }
    }
}
