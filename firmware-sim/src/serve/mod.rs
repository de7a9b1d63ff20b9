//! The real-time loop: read, step, write, once a millisecond, or as often as the host wants reports.

pub mod args;
mod clock;
mod drill;
mod link;
mod mischief;
mod usbip;

use std::io::{Read, Write, stderr, stdin, stdout};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};
use haptor_firmware_sim::plant::{Encoders, FIRM_GRIP};
use haptor_firmware_sim::script::Reach;
use haptor_firmware_sim::{Device, Preset, Script, TxBuf};
use haptor_wire::{FromDevice, Mode, PACKET_BYTES, StreamDecoder, stream_bound};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use args::{Args, Resolution};
use clock::Clock;
use drill::{Orders, orders};
use link::Link;
use mischief::Mischief;

/// Longest turn of the loop [us]: what USB polls at full speed, and what most hosts ask for.
const TURN_US: u32 = 1_000;

/// The nice value of programs that go before all others of the ordinary kind.
const HIGHEST_PRIORITY: i32 = -20;

/// Random bytes of a turn in the garbage drill: what a full frame, or a packet, would take.
const GARBAGE_BYTES: usize = PACKET_BYTES;

/// Bytes read in a turn at most: a thousand times what a host should send.
const READ_BYTES: usize = 64 * 1024;

/// Serves until the time is up, standard input closes, a signal comes or the drill says so.
pub fn run(args: &Args) -> Result<()> {
    // first: threads inherit it
    be_prompt();
    let mut server = Server::new(args)?;
    let stop = stop_on_signals(args).context("cannot watch for signals")?;
    println!("serving {}", server.link.place()?);
    stdout().flush().context("cannot say where it serves")?;
    if args.until_stdin_closes {
        watch_stdin(Arc::clone(&stop));
    }
    let in_time = |clock: &Clock| args.seconds.is_none_or(|seconds| clock.elapsed_s() < seconds);
    let mut clock = Clock::start();
    while !stop.load(Ordering::Relaxed) && in_time(&clock) {
        clock.wait(server.turn_us()).context("cannot sleep")?;
        if !server.turn()? {
            break;
        }
    }
    server.say_how_it_went(&clock);
    Ok(())
}

/// Asks to run before other programs: this one stands for hardware, which does not wait for a busy computer. Most users are refused;
/// then the device is late when the machine is.
fn be_prompt() {
    let _ = rustix::process::setpriority_process(None, HIGHEST_PRIORITY);
}

/// A flag that ending signals set. The parent that holds our standard input gets the same Ctrl-C and decides what it means.
fn stop_on_signals(args: &Args) -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    let interrupted = if args.until_stdin_closes { Arc::default() } else { Arc::clone(&stop) };
    signal_hook::flag::register(SIGINT, interrupted)?;
    Ok(stop)
}

/// Tells whoever is left to hear it.
fn say(what: std::fmt::Arguments<'_>) {
    let _ = writeln!(stderr(), "haptor-firmware-sim: {what}");
}

fn watch_stdin(stop: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        let mut buffer = [0; 256];
        while matches!(stdin().read(&mut buffer), Ok(n) if n > 0) {}
        stop.store(true, Ordering::Relaxed);
    });
}

struct Server<'a> {
    args: &'a Args,
    preset: Preset,
    link: Link,
    device: Device,
    tx: TxBuf,
    rx: Vec<u8>,
    said: StreamDecoder<{ stream_bound(FromDevice::MAX_ENCODED) }>,
    mischief: Mischief,
    /// The cable is out.
    unplugged: bool,
    /// Time since forces were first armed [us].
    armed_us: Option<u64>,
    /// Frames of the host that a restart cut in two; their rest is rejected, or taken for an idle line.
    cut: u64,
}

impl<'a> Server<'a> {
    fn new(args: &'a Args) -> Result<Self> {
        let mut link = Link::open(args.serve, &args.serial)?;
        if link.usb().is_none() && args.faults.iter().any(|drill| drill.kind.needs_usb()) {
            bail!("the drills halt, unplug and reboot are of USB: --serve usbip or vhci");
        }
        let preset = Preset {
            // 8 ticks of 125 us a millisecond
            watchdog_ticks: args.watchdog_ms * 8,
            ..args.preset
        };
        let reach = Reach::usual(FIRM_GRIP.stiffness, preset.max_force);
        let script = Script::by_name(&args.script, &reach, !args.once).context("no such script")?;
        let encoders = match args.encoders {
            Resolution::Fine => Encoders::FINE,
            Resolution::Sheet => Encoders::of(&preset),
        };
        Ok(Self {
            args,
            preset,
            link,
            device: Device::new(&preset, &args.serial, FIRM_GRIP, encoders, script),
            tx: TxBuf::new(),
            rx: vec![0; READ_BYTES],
            said: StreamDecoder::new(),
            mischief: Mischief::new(args.seed),
            unplugged: false,
            armed_us: None,
            cut: 0,
        })
    }

    /// One turn; false when the drill ends the process.
    fn turn(&mut self) -> Result<bool> {
        let orders = self.orders();
        if orders.die {
            say(format_args!("drill: gone"));
            return Ok(false);
        }
        if orders.restart {
            self.cut += u64::from(self.device.is_amid_a_frame());
            self.device.restart(&self.preset, &self.args.serial);
        }
        if orders.kick {
            self.device.kick([2.0 * self.preset.over_speed, 0.0, 0.0]);
        }
        self.cable(orders)?;
        let come = self.receive(orders)?;
        self.tx.clear();
        self.device.step(self.turn_us(), &self.rx[..come], &mut self.tx);
        self.send(orders);
        Ok(true)
    }

    /// What a drill does to the USB cable.
    fn cable(&mut self, orders: Orders) -> Result<()> {
        let Some(usb) = self.link.usb() else { return Ok(()) };
        if orders.halt {
            usb.halt();
        }
        if orders.unplug && !self.unplugged {
            usb.unplug();
        }
        if !orders.unplug && self.unplugged {
            usb.plug_in()?;
        }
        self.unplugged = orders.unplug;
        if orders.reboot {
            self.device.restart(&self.preset, &self.args.serial);
        }
        Ok(())
    }

    /// Length of a turn [us]: reports that the host wants more often than once a [`TURN_US`] leave one by one.
    fn turn_us(&self) -> u32 {
        TURN_US.min(self.device.period_us())
    }

    fn orders(&mut self) -> Orders {
        let turn_us = u64::from(self.turn_us());
        match &mut self.armed_us {
            None => {
                if self.device.mode() == Mode::Force {
                    self.armed_us = Some(0);
                }
                Orders::default()
            }
            Some(armed_us) => {
                *armed_us += turn_us;
                orders(&self.args.faults, *armed_us, turn_us)
            }
        }
    }

    fn receive(&mut self, orders: Orders) -> Result<usize> {
        if orders.stall {
            return Ok(0);
        }
        if self.link.changed_hands()? {
            self.device.link_opened();
        }
        self.link.read(&mut self.rx)
    }

    fn send(&mut self, orders: Orders) {
        if orders.stall {
            return;
        }
        if orders.garbage {
            let mut bytes = [0; GARBAGE_BYTES];
            self.mischief.garbage(&mut bytes);
            return self.link.write(&bytes);
        }
        let mut frames = self.mischief.arrive(&orders);
        let (link, mischief) = (&self.link, &mut self.mischief);
        self.said.feed(self.tx.as_slice(), |message| {
            let message = mischief.alter(message, &orders);
            frames.extend(mischief.disorder(link.frame(&message), &orders));
        });
        frames.iter().for_each(|frame| self.link.write(frame));
        self.link.flush();
    }

    fn say_how_it_went(&self, clock: &Clock) {
        let counts = self.device.counts();
        say(format_args!(
            "{} turns, {} times stood still; {} messages, {} frames rejected, {} cut by restarts; {} frames sent, {} frames dropped",
            clock.turns(),
            clock.stood_still(),
            counts.accepted,
            u64::from(counts.rejected()) + self.link.bad_packets(),
            self.cut,
            self.link.sent(),
            self.link.dropped()
        ));
    }
}
