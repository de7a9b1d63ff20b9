//! `wrench.csv`: a session's ticks. The first thirteen columns are those of `haptor eval`; then what was sent to the device (after
//! the guard, in the device's frame) and the times of the tick.

use std::io::{self, Write};

use haptor_wire::TickRecord;

use super::describe::words;
use super::recording::Recording;
use crate::command::EVAL_HEADER;

/// Columns beyond those of `haptor eval`.
const MORE: &str = "sent_fx,sent_fy,sent_fz,sent_tx,sent_ty,sent_tz,wake_us,step_us,round_trip_us";

/// Columns of a whole recording beyond those.
const POSE: &str = "handle_px,handle_py,handle_pz,handle_qw,handle_qx,handle_qy,handle_qz,event";

/// Writes the ticks as CSV.
pub fn write(ticks: &[TickRecord], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{EVAL_HEADER},{MORE}")?;
    ticks.iter().try_for_each(|tick| write_tick(tick, out))
}

fn write_tick(tick: &TickRecord, out: &mut impl Write) -> io::Result<()> {
    write_columns(tick, out)?;
    writeln!(out)
}

/// Writes everything of a recording as CSV: the columns of [`write`], the handle's pose in the device's frame as it was received, and what happened before the tick.
pub fn write_recording(recording: &Recording, out: &mut impl Write, mut at: impl FnMut(usize)) -> io::Result<()> {
    writeln!(out, "{EVAL_HEADER},{MORE},{POSE}")?;
    let mut happened = recording.happened.iter().peekable();
    for (index, tick) in recording.ticks.iter().enumerate() {
        write_columns(tick, out)?;
        write_all(out, &[tick.position])?;
        tick.rotation.iter().try_for_each(|value| write!(out, ",{value}"))?;
        let mut told = Vec::new();
        while let Some((_, what)) = happened.next_if(|(before, _)| *before <= index) {
            told.extend(words(what));
        }
        // words hold no quotation mark
        writeln!(out, ",\"{}\"", told.join("; "))?;
        at(index);
    }
    Ok(())
}

fn write_columns(tick: &TickRecord, out: &mut impl Write) -> io::Result<()> {
    write!(out, "{}", micro(tick.t_us))?;
    write_all(out, &[tick.contact_force, tick.contact_torque])?;
    write!(out, ",{},{},{},{},{},", tick.regions, tick.depth, tick.radius, tick.stick, tick.tier.name())?;
    match tick.flags {
        0 => write!(out, "0")?,
        bits => write!(out, "{bits:#x}")?,
    }
    write_all(out, &[tick.force, tick.torque])?;
    let [wake, step, round_trip] = [tick.wake_ns, tick.step_ns, tick.round_trip_ns].map(|ns| f64::from(ns) / 1.0e3);
    write!(out, ",{wake},{step},{round_trip}")
}

fn write_all(out: &mut impl Write, vectors: &[[f32; 3]]) -> io::Result<()> {
    vectors.iter().flatten().try_for_each(|value| write!(out, ",{value}"))
}

/// Seconds of a count of microseconds, exactly.
fn micro(us: u64) -> String {
    format!("{}.{:06}", us / 1_000_000, us % 1_000_000)
}
