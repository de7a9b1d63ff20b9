//! Serves the simulated device in real time over a pseudo terminal, a TCP port or a USB cable.
//!
//! One line on standard output says where (`serving pty /dev/pts/3`, `serving tcp 127.0.0.1:40001`, `serving usbip 127.0.0.1:3240`);
//! everything else goes to standard error. Hosts may come and go; the device goes on. SIGTERM and SIGHUP end it in order, exit 0, and
//! so does Ctrl-C, unless it was told to live as long as its standard input: then the keyboard is its parent's.
#![forbid(unsafe_code)]

mod serve;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let args = serve::args::Args::parse();
    match serve::run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("haptor-firmware-sim: {error:#}");
            ExitCode::from(2)
        }
    }
}
