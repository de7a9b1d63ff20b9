//! The thread that closes dead links and opens new ones.
//!
//! Opening allocates and may block for seconds, so the real-time thread hands its dead link over and goes on at zero wrench.

use std::thread;
use std::time::Duration;

use crate::link::{Address, open};
use crate::rt::line::Opener;

/// Time between two looks for work and between two attempts: a device that is plugged in again is back within a blink.
const RETRY: Duration = Duration::from_millis(20);

/// Serves until the real-time thread is gone.
pub fn run(mut opener: Opener, device: &Address) {
    while !opener.dead.is_abandoned() {
        if let Ok(dead) = opener.dead.pop() {
            drop(dead);
            reopen(&mut opener, device);
        }
        thread::sleep(RETRY);
    }
}

/// Tries until the device is back or the real-time thread gone. Why an attempt failed says nothing new: the fault is latched.
fn reopen(opener: &mut Opener, device: &Address) {
    while !opener.dead.is_abandoned() {
        if let Ok(link) = open(device) {
            // there is room: the queue holds more links than exist
            let _ = opener.fresh.push(link);
            return;
        }
        thread::sleep(RETRY);
    }
}
