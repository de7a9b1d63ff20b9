//! A haptic device that is not there: firmware logic, a handle, and a hand that moves it.
//!
//! ```text
//!            bytes in                                    bytes out
//!               │                                            ▲
//!  StreamDecoder▼                                            │ encode_stream
//!            Logic: modes, watchdog, limits, refusals, reports        integers only, as on a microcontroller
//!               │ rendered wrench                            ▲ sensed pose, speed
//!               ▼                                            │
//!            Plant: handle (mass, damper) + hand (spring, damper)     f32, semi-implicit Euler at 8 kHz
//!                                 ▲ target pose
//!                              Script: what the hand wants, smooth in time
//! ```
//! [`device::Device::step`] is a function of its state, elapsed time and bytes: it reads no clock, draws no random number and
//! allocates nothing, so the same calls give the same bytes on a PC and on a microcontroller. Frames: `d` device base, `h`
//! handle; the handle's pose is `x_dh`. At the start of every script the handle is at the origin of `d`, unrotated, and the host
//! places `d` so that the probe then hovers [`script::CLEARANCE`] above the object. The binary `haptor-firmware-sim` (feature
//! `serve`) runs it in real time behind a pseudo terminal, a TCP port or a USB cable.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod device;
pub mod limits;
pub mod logic;
pub mod plant;
pub mod preset;
pub mod script;

#[cfg(test)]
mod closed_loop_tests;
#[cfg(test)]
mod logic_tests;

pub use device::{Device, TxBuf};
pub use preset::Preset;
pub use script::Script;
