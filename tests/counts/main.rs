//! Runs ticks of named scenes, each call that counts in a marked function, for callgrind to count instructions in.
//!
//! Prints the scene's name for each call of a `measured_` function; callgrind writes one dump for each, in the same order. `--sizes` prints
//! the sizes of state and workspace instead.
#![forbid(unsafe_code)]

mod bench;
mod cases;
mod cases_pc;
mod meshes;
mod sizes;
mod table;

use bench::{Count, Room};

fn main() {
    if std::env::args().nth(1).as_deref() == Some("--sizes") {
        sizes::all().iter().for_each(|(what, bytes)| println!("{what}\t{bytes}"));
        return;
    }
    let mut room = Box::new(Room::new());
    let mut lines = String::new();
    for case in cases::all().chain(cases_pc::all()) {
        room.clear();
        let mut calls = Calls(0);
        let regions = bench::run(&case, &mut room, &mut calls).unwrap_or_else(|invalid| panic!("{}: {invalid}", case.name));
        assert_eq!(regions, case.regions, "{}", case.name);
        lines += &format!("{}\n", case.name).repeat(calls.0);
    }
    print!("{lines}");
}

/// Calls that callgrind counts.
struct Calls(usize);

impl Count for Calls {
    fn count(&mut self, call: impl FnOnce()) {
        call();
        self.0 += 1;
    }
}
