//! Trials: short sessions of the real host, started as a program and measured, so that a machine is judged by the loop that will run on it and not by a stand-in.
//!
//! ```text
//!  soak   ours beside cyclictest, on two CPUs and then swapped: nothing else, under load, with a viewer
//!  rates  1, 2, 4, 8 kHz on a scene: the highest that holds, and what limits it
//!  gains  under load, with every right of the real-time policy and without each in turn
//! ```
//! Terms. **Wake-up latency**: from when a tick was due to when the thread ran. **In time**: the command left within its period. The marks are libfranka's
//! (`communication_test`): a share in time of 0.95 is wanted, below 0.90 a machine will not do. Times of the host and of cyclictest are upper edges of bins, 1 % and
//! 1 us wide.

mod cyclictest;
pub mod gains;
mod helper;
mod load;
pub mod rates;
mod session;
pub mod soak;
mod spread;

use crate::failure::Failure;

/// Share of ticks in time below which a machine is doubtful (libfranka's mark).
pub const SHARE_WARN: f64 = 0.95;

/// Share of ticks in time below which it will not do (libfranka's mark).
pub const SHARE_FAIL: f64 = 0.90;

/// Why a trial that somebody ended with Ctrl-C has no result.
fn interrupted() -> Failure {
    Failure::problem("interrupted: a trial that was not run to its end says nothing")
}

/// What the marks say, in a word.
fn verdict(share: f64) -> &'static str {
    match share {
        share if share >= SHARE_WARN => "good",
        share if share >= SHARE_FAIL => "doubtful",
        _ => "not good enough",
    }
}

/// Nanoseconds as the tables print them \[us\].
fn us(ns: u64) -> f64 {
    ns as f64 / 1.0e3
}
