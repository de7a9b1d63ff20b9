//! What runs inside the guest of `cargo xtask guest`: sessions of the real host with the simulated device on the kernel's own USB, then the
//! drills.
//!
//! `haptor-guest SECONDS [drills|latency]`, as root, the programs in `/bin`. It prints lines that begin with `@` for `xtask` to read:
//! `@session|...`, `@drill|...`, `@latency|...`, `@calls|...`, each with the columns of the tables in `DRILLS.md` and `LATENCY.md`, `@failed|WHAT` for everything that is not as it
//! should be, and `@end`. All times are the guest's own.

mod drills;
mod judge;
mod latency;
mod openings;
mod programs;
mod recording;
#[path = "../../tools/haptor/src/trial/spread.rs"]
#[allow(dead_code, reason = "the tool asks for more")]
mod spread;

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result, ensure};
use haptor_firmware_sim::script::CLEARANCE;
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{BakedScene, ObjectShape, Place, Quantiles};

use programs::{Host, Options, Sim, instructions};
use recording::Recording;

/// Share of a session after which the real-time thread's account is opened; its end is a second before the session's.
const SETTLED_S: f64 = 0.5;

/// What libusb allocates in a tick: the kernel's description of each of two transfers. A whole session's rest is spread over the ticks, hence the
/// little more.
const ALLOCATIONS_MAX: f64 = 2.05;

/// The counter of allocations, see `malloc_count.c`.
const COUNTER: &str = "/lib/malloc_count.so";

fn main() -> Result<()> {
    let mut args = env::args().skip(1);
    let seconds: f64 = args.next().context("seconds")?.parse().context("seconds")?;
    let what = args.next();
    let folder = env::temp_dir();
    let model = folder.join("ball-on-cube.model");
    fs::write(&model, baked()?)?;
    if what.as_deref() == Some("latency") {
        latency::run(&model, seconds);
    } else {
        sessions(&model, seconds, what.is_some());
    }
    println!("@end");
    Ok(())
}

/// Sessions without a fault, and the drills.
fn sessions(model: &Path, seconds: f64, drills: bool) {
    for (device, seconds) in [("usb:G1", seconds), ("usb-bulk:G1", seconds.min(10.0)), ("usb:G1 --pace clock", seconds.min(10.0))]
    {
        if let Err(error) = session(model, device, seconds) {
            println!("@failed|{device}: {error:#}");
        }
    }
    match allocations(model) {
        Ok(per_tick) if per_tick <= ALLOCATIONS_MAX => println!("@allocations|{per_tick:.2}"),
        Ok(per_tick) => println!("@failed|{per_tick} allocations a tick in C, {ALLOCATIONS_MAX} are known of libusb"),
        Err(error) => println!("@failed|counting allocations: {error:#}"),
    }
    if drills {
        drills::run(model);
        openings::run(model);
    }
}

/// A session without a fault, told in figures.
fn session(model: &Path, device: &str, seconds: f64) -> Result<()> {
    let _sim = Sim::start(&["--script", "press-twist-slide"])?;
    let file = PathBuf::from("/tmp/session.haptor");
    let mut host = Host::start(model, device, seconds, &file)?;
    host.run_for(SETTLED_S)?;
    let begin = host.account()?;
    host.run_for(seconds - SETTLED_S - 0.2)?;
    let end = host.account()?;
    let code = host.end()?;
    let recording = Recording::read(&file)?;
    let summary = recording.summary.context("the recording has no end")?;
    let per_tick = instructions(end.ran_ns - begin.ran_ns) as f64 / (1000.0 * (end.uptime_s - begin.uptime_s));
    let us = |q: Quantiles| {
        format!("{:.0} / {:.0} / {:.0}", f64::from(q.p50) * 1e-3, f64::from(q.p99) * 1e-3, f64::from(q.max) * 1e-3)
    };
    println!(
        "@session|{device}|{}|{}|{}|{}|{}|{}|{:.0}|{:.1}",
        summary.ticks,
        summary.late,
        summary.lost,
        us(summary.round_trip_ns),
        us(summary.wake_ns),
        us(summary.step_ns),
        per_tick / 1000.0,
        summary.peak_force,
    );
    ensure!(summary.fault.is_none() && code == 0, "ended with {code}, {:?}", summary.fault);
    ensure!(summary.rt.fifo && summary.rt.locked && summary.rt.pinned, "not in real time: {:?}", summary.rt);
    ensure!((end.files, end.memory_kb) == (begin.files, begin.memory_kb), "it grows: {begin:?}, {end:?}");
    Ok(())
}

/// Allocations in C by the real-time thread in a tick: what a longer session has more of than a shorter one.
fn allocations(model: &Path) -> Result<f64> {
    let _sim = Sim::start(&["--script", "press"])?;
    let file = PathBuf::from("/tmp/counted.haptor");
    let counted = Options { preload: Some(COUNTER), ..Options::default() };
    let count = |seconds: f64| -> Result<f64> {
        let code = Host::start_with(model, "usb:G1", seconds, &file, counted)?.end()?;
        let said = programs::said(&file);
        let count = said.lines().find_map(|line| line.strip_prefix("allocations real-time "));
        ensure!(code == 0, "ended with {code}: {said}");
        Ok(count.with_context(|| format!("no count in {said}"))?.parse()?)
    };
    Ok((count(2.0)? - count(1.0)?) / 1000.0)
}

/// The ball on the rubber cube, the device so that the ball hovers over the middle of the top.
fn baked() -> Result<Vec<u8>> {
    let place = Place { p_wd: [0.0, 0.0, 0.12 + CLEARANCE], q_wd: [1.0, 0.0, 0.0, 0.0] };
    let scene = BakedScene { place, ..BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }) };
    let mut file = vec![0; FILE_MAX];
    let length = encode_file(&scene, &mut file).map_err(|error| anyhow::anyhow!("{error:?}"))?;
    file.truncate(length);
    Ok(file)
}
