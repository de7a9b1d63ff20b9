//! Faults on purpose: what a host must survive.
//!
//! A drill happens at a time counted from when forces are first armed, so that it hits a session at work however long the host took
//! to start.

use std::str::FromStr;

use super::args::seconds;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Random bytes go out in place of frames, 64 a millisecond.
    Garbage,
    /// Nothing goes over the link, either way; the firmware runs on.
    Stall,
    /// The process ends as if the cable were pulled.
    Die,
    /// The firmware starts anew and keeps the link.
    Restart,
    /// Somebody bumps into the hand: the handle flies off at twice its allowed speed.
    Kick,
    /// One bit of every frame is turned.
    Corrupt,
    /// Every frame comes twice.
    Duplicate,
    /// Every other frame comes after the one that follows it.
    Reorder,
    /// Frames come some turns late.
    Delay,
    /// Frames vanish; what the host says arrives.
    Drop,
    /// The position is not a number.
    Nan,
    /// The same report over and over.
    Freeze,
    /// The sensors are read no more: the same pose of the same time under numbers that go on.
    Stuck,
    /// The firmware starts anew as another version.
    Version,
    /// USB: the endpoints halt, again whenever they are cleared.
    Halt,
    /// USB: the cable is out; the firmware runs on.
    Unplug,
    /// USB: the device resets: off the bus, and back with its firmware started anew.
    Reboot,
}

impl Kind {
    /// Every drill by its name; whether it lasts.
    const ALL: [(&str, Self, bool); 17] = [
        ("garbage", Self::Garbage, true),
        ("stall", Self::Stall, true),
        ("die", Self::Die, false),
        ("restart", Self::Restart, false),
        ("kick", Self::Kick, false),
        ("corrupt", Self::Corrupt, true),
        ("duplicate", Self::Duplicate, true),
        ("reorder", Self::Reorder, true),
        ("delay", Self::Delay, true),
        ("drop", Self::Drop, true),
        ("nan", Self::Nan, true),
        ("freeze", Self::Freeze, true),
        ("stuck", Self::Stuck, true),
        ("version", Self::Version, false),
        ("halt", Self::Halt, true),
        ("unplug", Self::Unplug, true),
        ("reboot", Self::Reboot, true),
    ];

    /// Whether it needs a bus: a pseudo terminal and a TCP port have none.
    pub const fn needs_usb(self) -> bool {
        matches!(self, Self::Halt | Self::Unplug | Self::Reboot)
    }
}

/// One planned fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drill {
    /// What goes wrong.
    pub kind: Kind,
    /// When [us since forces were first armed].
    pub at_us: u64,
    /// For how long [us]; 0 for what happens at once.
    pub for_us: u64,
}

/// Length of garbage and stalls when none is given [us].
const USUAL_LENGTH_US: u64 = 50_000;

impl FromStr for Drill {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, when) = text.split_once('@').ok_or("expected KIND@SECONDS, as in stall@2.0:50ms")?;
        let (at, length) = match when.split_once(':') {
            Some((at, length)) => (at, Some(length)),
            None => (when, None),
        };
        let Some(&(_, kind, lasts)) = Kind::ALL.iter().find(|(name, ..)| *name == kind) else {
            let names = Kind::ALL.map(|(name, ..)| name).join(", ");
            return Err(format!("no drill `{kind}`; there are {names}"));
        };
        let for_us = match length {
            None if lasts => USUAL_LENGTH_US,
            None => 0,
            Some(_) if !lasts => return Err("this drill happens at once, without a length".into()),
            Some(length) => parse_length(length)?,
        };
        Ok(Self { kind, at_us: to_us(seconds(at)?), for_us })
    }
}

fn parse_length(text: &str) -> Result<u64, String> {
    let (number, scale) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    Ok(to_us(seconds(number)? * scale))
}

fn to_us(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

/// What the drills ask of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orders {
    /// Send random bytes instead.
    pub garbage: bool,
    /// Neither read nor write.
    pub stall: bool,
    /// End the process.
    pub die: bool,
    /// Start the firmware anew.
    pub restart: bool,
    /// Kick the handle.
    pub kick: bool,
    /// Damage frames.
    pub corrupt: bool,
    /// Send frames twice.
    pub duplicate: bool,
    /// Let frames overtake each other.
    pub reorder: bool,
    /// Send frames late.
    pub delay: bool,
    /// Send no frames.
    pub drop: bool,
    /// Report no position.
    pub nan: bool,
    /// Report the same.
    pub freeze: bool,
    /// Report the same pose under new numbers.
    pub stuck: bool,
    /// Tell another version from now on.
    pub version: bool,
    /// Halt the endpoints.
    pub halt: bool,
    /// Be off the bus.
    pub unplug: bool,
    /// Be off the bus, and begin anew.
    pub reboot: bool,
}

/// Orders for the tick of `tick_us` that begins `now_us` after forces were first armed.
#[must_use]
pub fn orders(drills: &[Drill], now_us: u64, tick_us: u64) -> Orders {
    let mut orders = Orders::default();
    for drill in drills {
        let end = drill.at_us.saturating_add(drill.for_us.max(tick_us));
        if !(drill.at_us..end).contains(&now_us) {
            continue;
        }
        match drill.kind {
            Kind::Garbage => orders.garbage = true,
            Kind::Stall => orders.stall = true,
            Kind::Die => orders.die = true,
            Kind::Restart => orders.restart = true,
            Kind::Kick => orders.kick = true,
            Kind::Corrupt => orders.corrupt = true,
            Kind::Duplicate => orders.duplicate = true,
            Kind::Reorder => orders.reorder = true,
            Kind::Delay => orders.delay = true,
            Kind::Drop => orders.drop = true,
            Kind::Nan => orders.nan = true,
            Kind::Freeze => orders.freeze = true,
            Kind::Stuck => orders.stuck = true,
            Kind::Version => (orders.version, orders.restart) = (true, true),
            Kind::Halt => orders.halt = true,
            Kind::Unplug => orders.unplug = true,
            Kind::Reboot => (orders.unplug, orders.reboot) = (true, true),
        }
    }
    orders
}

/// A stream of random bytes from a seed: SplitMix64 (Steele, Lea & Flood 2014).
#[derive(Clone, Debug)]
pub struct Noise(u64);

impl Noise {
    /// The same seed gives the same bytes.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Fills `bytes`.
    pub fn fill(&mut self, bytes: &mut [u8]) {
        for chunk in bytes.chunks_mut(8) {
            let next = self.next().to_le_bytes();
            chunk.copy_from_slice(&next[..chunk.len()]);
        }
    }

    /// The next number.
    pub const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drills_read_as_they_are_written() {
        let table = [
            ("garbage@2.0", Kind::Garbage, 2_000_000, 50_000),
            ("stall@0.5:20ms", Kind::Stall, 500_000, 20_000),
            ("stall@1:2s", Kind::Stall, 1_000_000, 2_000_000),
            ("die@3", Kind::Die, 3_000_000, 0),
            ("restart@0", Kind::Restart, 0, 0),
            ("unplug@1:300ms", Kind::Unplug, 1_000_000, 300_000),
            ("version@2", Kind::Version, 2_000_000, 0),
        ];
        for (text, kind, at_us, for_us) in table {
            let drill = Drill { kind, at_us, for_us };
            assert_eq!(text.parse(), Ok(drill), "{text}");
        }
        for bad in ["stall", "stall@", "stall@x", "die@1:5ms", "flood@1", "stall@1:-5ms"] {
            assert!(bad.parse::<Drill>().is_err(), "{bad}");
        }
    }

    #[test]
    fn each_drill_has_its_ticks() {
        let drills: Vec<Drill> =
            ["stall@0.010:3ms", "restart@0.012", "kick@0.0125"].iter().map(|text| text.parse().unwrap()).collect();
        let ticks =
            |pick: fn(&Orders) -> bool| -> Vec<u64> { (0..20).filter(|ms| pick(&orders(&drills, ms * 1000, 1000))).collect() };
        assert_eq!(ticks(|o| o.stall), [10, 11, 12]);
        assert_eq!(ticks(|o| o.restart), [12]);
        assert_eq!(ticks(|o| o.kick), [13]);
        assert_eq!(ticks(|o| o.die), []);
    }

    #[test]
    fn noise_is_the_published_sequence() {
        let mut noise = Noise::new(1_234_567);
        assert_eq!(noise.next(), 6_457_827_717_110_365_317);
        assert_eq!(noise.next(), 3_203_168_211_198_807_973);
    }
}
