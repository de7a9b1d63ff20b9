//! # haptor-host: the real-time thread that closes the loop
//!
//! One thread owns the link to the device and the contact core: pose in, wrench out, a thousand times a second and more. All
//! else serves it from a distance.
//!
//! | file | what it is |
//! |---|---|
//! | [`rt`] | the real-time thread: what it promises; its parts, one a file |
//! | [`link`] | what carries bytes: serial, TCP, USB, memory; addresses; faults on purpose |
//! | [`config`] | arguments, checked |
//! | [`session`] | the threads of a run and the queues between them |
//! | [`reopen`], [`recorder`], [`status`] | the ordinary threads: links, files, what people and tools are told |
//! | [`viewer`] | programs that look on and may steer: the server of the viewer link |
//! | [`work`] | what a tick may spend on this machine |
//! | [`measure`] | what a tick costs on this machine: recorded ticks in a loop under the policy of the real-time thread |
//! | [`error`] | what can go wrong outside the tick |
//!
//! The binaries `haptor-host` (sessions) and `haptor-measure` (what a tick costs) are arguments in, exit code out. Other programs of this project start it and listen to its status; they do
//! not link this crate, tests do.

pub mod config;
pub mod error;
pub mod link;
pub mod measure;
pub mod recorder;
pub mod reopen;
pub mod rt;
pub mod session;
pub mod status;
pub mod viewer;
pub mod work;
