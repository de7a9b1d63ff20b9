//! The books of device, cable and host, row against row.

use haptor_wire::Summary;

use crate::programs::DeviceBooks;
use crate::relay::Relay;
use crate::watch::Verdict;

/// One thing counted on two sides.
#[derive(Clone, Debug)]
pub struct Row {
    what: &'static str,
    one: (&'static str, u64),
    other: (&'static str, u64),
    /// How far they may differ, and why.
    slack: (u64, &'static str),
}

impl Row {
    const fn new(what: &'static str, one: (&'static str, u64), other: (&'static str, u64)) -> Self {
        Self { what, one, other, slack: (0, "") }
    }

    fn adds_up(&self) -> bool {
        self.one.1.abs_diff(self.other.1) <= self.slack.0
    }
}

/// Everything that must add up.
pub fn rows(relay: &Relay, host: &Summary, device: &DeviceBooks) -> Vec<Row> {
    let (down, up) = relay.ledgers();
    // the beginning of a frame that a restart cut is forgotten, its rest rejected or, when it is the zero alone, taken for an idle line
    let cut = (device.cut, "frames cut by restarts");
    vec![
        Row::new("frames of the device", ("device sent", device.sent), ("cable took", down.came)),
        Row::new("frames to the host", ("cable took, less its own", taken(&down)), ("cable delivered", down.good + down.bad)),
        Row::new("damaged, to the host", ("cable damaged", down.bad), ("host rejected", host.rejected)),
        Row::new("reports lost", ("gaps in what was delivered", relay.reports.lost), ("host lost", host.lost)),
        Row::new("reports out of order", ("in what was delivered", relay.reports.out_of_order), ("host", host.out_of_order)),
        Row::new("commands of the host", ("the last one's number", relay.commands.last), ("cable took", relay.commands.came)),
        Row::new("frames to the device", ("cable took, less its own", taken(&up)), ("cable delivered", up.good + up.bad)),
        Row {
            slack: cut,
            ..Row::new("whole, to the device", ("cable delivered", up.good), ("device understood", device.messages))
        },
        Row { slack: cut, ..Row::new("damaged, to the device", ("cable damaged", up.bad), ("device rejected", device.rejected)) },
        Row::new("left on the cable [bytes]", ("at the end", relay.on_the_way() as u64), ("expected", 0)),
        Row::new("ticks unrecorded", ("host", host.recorder_dropped), ("expected", 0)),
    ]
}

/// Deliveries that must follow from what came.
const fn taken(ledger: &crate::relay::Ledger) -> u64 {
    ledger.came - ledger.dropped - ledger.withheld + ledger.doubled
}

/// Prints the table; true when all of it is good.
pub fn print(rows: &[Row], watches: &[Verdict], host: &Summary, device: &DeviceBooks, relay: &Relay, planned: u64) -> bool {
    let (down, up) = relay.ledgers();
    println!("{:<26} {:<26} {:>10}   {:<26} {:>10}", "what", "one side", "", "other side", "");
    for row in rows {
        let (one, other) = (row.one, row.other);
        let verdict = match (row.adds_up(), one.1 == other.1) {
            (true, true) => String::new(),
            (true, false) => format!("  ({} {})", row.slack.0, row.slack.1),
            (false, _) => "  DOES NOT ADD UP".to_owned(),
        };
        println!("{:<26} {:<26} {:>10}   {:<26} {:>10}{verdict}", row.what, one.0, one.1, other.0, other.1);
    }
    for (way, l) in [("device to host", down), ("host to device", up)] {
        let faults = [(l.dropped, "dropped"), (l.damaged, "damaged"), (l.doubled, "doubled"), (l.delayed, "delayed")];
        let faults = faults.map(|(n, what)| format!("{n} {what}")).join(", ");
        println!("{way}: {faults}, {} withheld at the end", l.withheld);
    }
    println!(
        "both ways: {} stalls; {planned} restarts of the device planned, {} seen in its count",
        relay.stalls, relay.reports.restarts
    );
    let share = 100.0 * host.in_time as f64 / host.ticks.max(1) as f64;
    let fault = host.fault.map_or("none", haptor_wire::HostFault::name);
    println!("host: {} ticks, {share:.2} % in time; first fault: {fault}; peak {:.2} N", host.ticks, host.peak_force);
    println!("device: {} times stood still, {} frames that nobody took", device.stood_still, device.dropped);
    watches.iter().for_each(|watch| println!("{}{}", watch.told, if watch.flat { "" } else { "  GREW" }));
    let good = rows.iter().all(Row::adds_up) && watches.iter().all(|watch| watch.flat);
    println!("{}", if good { "everything adds up" } else { "NOT everything adds up" });
    good
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_too_few_does_not_add_up() {
        let row = |one, other, slack| Row { slack: (slack, "why"), ..Row::new("frames", ("here", one), ("there", other)) };
        for (one, other, slack, good) in [(7, 7, 0, true), (7, 6, 0, false), (6, 7, 0, false), (7, 6, 1, true), (8, 6, 1, false)]
        {
            assert_eq!(row(one, other, slack).adds_up(), good, "{one} {other} {slack}");
        }
    }
}
