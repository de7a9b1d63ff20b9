//! A recording in words: what is in the file, line by line, and the same for programs.

use std::fmt::Write;

use haptor_wire::{BakedScene, ObjectShape, SessionHello, TickRecord, flags};
use serde_json::{Value, json};

use super::recording::{Happening, Recording};

/// Seconds of a tick's number.
fn seconds(recording: &Recording, ticks: u64) -> f64 {
    recording.header.map_or(0.0, |header| ticks as f64 / f64::from(header.rate_hz.max(1)))
}

/// The recording, one line per thing.
pub fn table(recording: &Recording) -> String {
    let rows = [
        ("recorded", begun(recording)),
        ("scene", scene(recording)),
        ("device", recording.device.map_or("none, or not in the file".to_owned(), |device| told_device(&device))),
        ("length", length(recording)),
        ("peak contact", peaks(&recording.ticks)),
        ("rests", count(recording, |what| matches!(what, Happening::Rested)).to_string()),
        ("tunings", count(recording, |what| matches!(what, Happening::Tuned(_))).to_string()),
        (
            "end",
            if recording.summary.is_some() { "in order" } else { "not in order: cut off, or still being written" }.to_owned(),
        ),
        ("lost", format!("{} records while it was written", recording.lost())),
        ("damage", damage(recording)),
    ];
    let mut table = String::new();
    for (name, value) in &rows {
        // writing to a string cannot fail
        let _ = writeln!(table, "{name:<14}{value}");
    }
    for (at, what) in happenings(recording) {
        let _ = writeln!(table, "{:<14}{what}", format!("tick {at}"));
    }
    table
}

/// The same for programs.
pub fn value(recording: &Recording) -> Value {
    let header = recording.header.map(|header| {
        json!({ "version": header.version, "schema": format!("{:08x}", header.schema), "rate_hz": header.rate_hz,
                "start_unix_s": header.start_unix_s, "scene_digest": format!("{:016x}", header.scene_digest) })
    });
    let device = recording.device.map(|device| {
        json!({ "name": text(&device.device_name), "serial": text(&device.device_serial),
                "max_force_n": f64::from(device.max_force_un) * 1.0e-6, "max_torque_nm": f64::from(device.max_torque_unm) * 1.0e-6 })
    });
    let happened: Vec<Value> = happenings(recording).map(|(tick, what)| json!({ "tick": tick, "what": what })).collect();
    json!({
        "header": header, "device": device, "ticks": recording.ticks.len(), "scene_carried": recording.scene().is_some(),
        "rests": count(recording, |what| matches!(what, Happening::Rested)), "ended_in_order": recording.summary.is_some(),
        "lost": recording.lost(), "damaged_places": recording.damaged, "happened": happened,
    })
}

/// What happened that people care about, with the number of the tick before which it did.
pub fn happenings(recording: &Recording) -> impl Iterator<Item = (u64, String)> {
    recording.happened.iter().filter_map(|(index, what)| {
        let ticks = &recording.ticks;
        // behind the last tick: the one that would have followed
        let at = ticks.get(*index).map(|tick| tick.tick).or_else(|| ticks.last().map(|tick| tick.tick + 1)).unwrap_or(0);
        Some((at, words(what)?))
    })
}

/// What happened, in words; `None` for what every session begins with.
pub fn words(what: &Happening) -> Option<String> {
    Some(match what {
        Happening::Scene(_) | Happening::Device(_) | Happening::Placed(_) | Happening::Rested => return None,
        Happening::Tuned(tuning) => format!(
            "tuned: tier {}, {} samples, friction {} static, {} dynamic",
            tuning.tier.name(),
            tuning.samples,
            tuning.friction_static,
            tuning.friction_dynamic
        ),
        Happening::Done(done) => done.name().to_owned(),
        Happening::Fault(fault) => format!("fault: {}, wrench zero after {} ticks", fault.cause.name(), fault.after_ticks),
        Happening::Lost(count) => format!("lost: {count} records were never written"),
        Happening::Damaged(damage) => format!("damage: {damage}"),
    })
}

fn count(recording: &Recording, of: impl Fn(&Happening) -> bool) -> usize {
    recording.happened.iter().filter(|(_, what)| of(what)).count()
}

fn begun(recording: &Recording) -> String {
    match recording.header {
        None => "unknown, the header is damaged".to_owned(),
        Some(header) if header.start_unix_s == 0 => format!("offline, version {} (table {:08x})", header.version, header.schema),
        Some(header) => {
            let at = date(header.start_unix_s);
            format!("{at}, version {} (table {:08x})", header.version, header.schema)
        }
    }
}

fn scene(recording: &Recording) -> String {
    let digest = recording.header.map_or(String::new(), |header| format!(" (digest {:016x})", header.scene_digest));
    match recording.scenes.last() {
        None => "unknown, the header is damaged".to_owned(),
        Some((_, Err(why))) => format!("not in the file: {why}{digest}"),
        Some((_, Ok(scene))) => format!("{}{digest}", told_scene(scene.setup().baked())),
    }
}

fn told_scene(scene: &BakedScene) -> String {
    let object = match scene.object {
        ObjectShape::HalfSpace => "half space",
        ObjectShape::Box { .. } => "box",
        ObjectShape::Sphere { .. } => "sphere",
        ObjectShape::Ellipsoid { .. } => "ellipsoid",
        ObjectShape::Cylinder { .. } => "cylinder",
        ObjectShape::Mesh { .. } => "mesh",
    };
    let parts = scene.probe.count;
    format!("{object} of {} Pa, probe of {parts} parts, tier {}", scene.young_modulus, scene.tier.name())
}

fn told_device(device: &SessionHello) -> String {
    let (name, serial) = (text(&device.device_name), text(&device.device_serial));
    let (force, torque) = (f64::from(device.max_force_un) * 1.0e-6, f64::from(device.max_torque_unm) * 1.0e-6);
    format!("{name} {serial}, {force} N, {torque} N m")
}

/// The text in a field that zeros fill up.
fn text(field: &[u8]) -> String {
    String::from_utf8_lossy(field).trim_end_matches('\0').to_owned()
}

fn length(recording: &Recording) -> String {
    let ticks = &recording.ticks;
    let (Some(header), Some(first), Some(last)) = (recording.header, ticks.first(), ticks.last()) else {
        return format!("{} ticks", ticks.len());
    };
    let span = seconds(recording, (last.tick + 1).saturating_sub(first.tick));
    let idle = ticks.iter().filter(|tick| tick.flags & flags::NO_POSE != 0).count();
    format!("{span:.3} s, {} ticks at {} Hz, {idle} without a pose", ticks.len(), header.rate_hz)
}

fn peaks(ticks: &[TickRecord]) -> String {
    let magnitude = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
    let felt = || ticks.iter().filter(|tick| tick.was_felt());
    let force = felt().map(|tick| magnitude(tick.contact_force)).fold(0.0, f32::max);
    let torque = felt().map(|tick| magnitude(tick.contact_torque)).fold(0.0, f32::max);
    let regions = felt().map(|tick| tick.regions).max().unwrap_or(0);
    format!("{force:.3} N, {torque:.5} N m, {regions} regions")
}

fn damage(recording: &Recording) -> String {
    match recording.damaged {
        0 => "none".to_owned(),
        places => format!("{places} places; what lies between them was read"),
    }
}

/// Date and time in UTC. The calendar is Howard Hinnant's `civil_from_days` (howardhinnant.github.io/date_algorithms.html).
fn date(unix_s: u32) -> String {
    let (days, second) = (i64::from(unix_s / 86_400), unix_s % 86_400);
    let z = days + 719_468;
    let (era, of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02}:{:02} UTC", second / 3600, second / 60 % 60, second % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (unix_s, told) in [
            (0, "1970-01-01 00:00:00 UTC"),
            (951_782_400, "2000-02-29 00:00:00 UTC"),
            (1_763_804_130, "2025-11-22 09:35:30 UTC"),
            (u32::MAX, "2106-02-07 06:28:15 UTC"),
        ] {
            assert_eq!(date(unix_s), told);
        }
    }
}
