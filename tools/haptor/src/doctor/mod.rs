//! What makes a machine good or bad at a thousand ticks a second: kernel, rights, cores, sleep states, devices,
//! programs, timer.
//!
//! Each check reads one thing of the system and judges it; nothing is changed. Only what keeps the project from running at all is
//! a fail; what makes late ticks likelier is a warning.

mod serial;
mod system;
mod timer;
mod usb;

use crate::programs;

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// As it should be.
    Ok,
    /// Late ticks are likelier.
    Warn,
    /// It will not do.
    Fail,
}

impl Mark {
    /// The word in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Fail => "FAIL",
        }
    }
}

/// One line of the examination.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What was looked at.
    pub what: &'static str,
    /// How it is.
    pub mark: Mark,
    /// What was found.
    pub found: String,
    /// What to do about it, when it is not ok.
    pub advice: Option<String>,
}

impl Finding {
    /// As it should be.
    pub fn ok(what: &'static str, found: impl Into<String>) -> Self {
        Self { what, mark: Mark::Ok, found: found.into(), advice: None }
    }

    /// Not as it should be, with what to do.
    pub fn bad(what: &'static str, mark: Mark, found: impl Into<String>, advice: &str) -> Self {
        Self { what, mark, found: found.into(), advice: Some(advice.to_owned()) }
    }
}

/// Looks at everything; the timer test lasts `soak` minutes, or two seconds.
pub fn examine(soak: Option<u32>) -> Vec<Finding> {
    vec![
        system::kernel(),
        system::cores(),
        system::rtprio(),
        system::memlock(),
        system::governor(),
        system::dma_latency(),
        usb::check(),
        serial::latency(),
        program(programs::HOST),
        program(programs::FIRMWARE_SIM),
        timer::check(soak),
    ]
}

fn program(name: &'static str) -> Finding {
    match programs::find(name) {
        Ok(path) => Finding::ok(name, path.display().to_string()),
        Err(failure) => Finding::bad(name, Mark::Fail, "not beside this program", &failure.error().to_string()),
    }
}
