//! The thread that closes dead links and opens new ones.
//!
//! Opening allocates and may block for seconds, so the real-time thread hands its dead link over and goes on at zero wrench. A device
//! that was given as a bare pseudo-terminal is not opened again: see [`Address::comes_back`].

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
            // the device that was lost, and not another that fits the address
            let same = dead.name().parse().unwrap_or_else(|_| device.clone());
            drop(dead);
            if same.comes_back() {
                reopen(&mut opener, &same);
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rt::clock::{Clock, Monotonic};
    use crate::rt::line::{Arrivals, Line, exchange};
    use std::net::TcpListener;

    /// Looks until `done`; a device on loopback is there at once, so the limit only ends a test that fails.
    fn until(line: &mut Line, done: impl Fn(&Arrivals) -> bool) -> bool {
        (0..2_000).any(|_| done(&line.gather(&Monotonic, Monotonic.now_ns() + 5_000_000)))
    }

    #[test]
    fn a_device_that_goes_and_comes_back_is_found_again_and_the_thread_ends_with_the_loop() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let device = Address::Tcp(listener.local_addr().unwrap());
        let (links, opener) = exchange();
        let mut line = Line::new(open(&device).unwrap(), links);
        thread::scope(|scope| {
            scope.spawn(|| run(opener, &device));
            for _ in 0..3 {
                drop(listener.accept().unwrap());
                assert!(until(&mut line, |got| got.lost));
                assert!(until(&mut line, |got| got.reopened));
            }
            drop(line);
        });
    }
}
