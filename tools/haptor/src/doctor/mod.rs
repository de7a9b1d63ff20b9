//! What makes a machine good or bad at a thousand ticks a second: kernel, processor, interrupts, rights, what it runs in, devices,
//! programs, timer.
//!
//! Each check reads one thing of the system and judges it; nothing is changed. Only what keeps the project from running at all is
//! a fail; what makes late ticks likelier is a warning.

pub mod cpus;
mod interrupts;
mod kernel;
mod place;
mod serial;
pub mod system;
mod timer;
mod usb;

use std::fs;

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

/// Looks at everything; the timer test lasts two seconds.
pub fn examine() -> Vec<Finding> {
    vec![
        kernel::flavour(),
        kernel::clock(),
        kernel::throttling(),
        kernel::isolation(),
        cpus::cores(),
        cpus::governor(),
        cpus::sleep(),
        interrupts::placement(),
        system::rtprio(),
        system::memlock(),
        place::container(),
        place::machine(),
        usb::check(),
        serial::latency(),
        program(programs::HOST),
        program(programs::FIRMWARE_SIM),
        timer::check(),
    ]
}

/// A small text file of the kernel's, without its last newline; empty where there is none.
fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default().trim().to_owned()
}

fn program(name: &'static str) -> Finding {
    match programs::find(name) {
        Ok(path) => Finding::ok(name, path.display().to_string()),
        Err(failure) => Finding::bad(name, Mark::Fail, "not beside this program", &failure.error().to_string()),
    }
}
