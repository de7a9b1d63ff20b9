//! Host and simulated device on one virtual clock in one thread: real bytes both ways, no waiting, the same every time.
//!
//! The device hangs on the far end of a [`Link`] that lets its time pass when the host looks: waiting for a pose moves the clock in
//! the device's own ticks until bytes come. Drills change what the link does, as the same things happen to cables.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use haptor_engine::Scene;
use haptor_firmware_sim::plant::{Encoders, FIRM_GRIP};
use haptor_firmware_sim::preset::PREMIUM15;
use haptor_firmware_sim::script::{Reach, Script};
use haptor_firmware_sim::{Device, TxBuf};
use haptor_host::link::{AnyLink, Link, LinkError};
use haptor_host::rt::account::{Account, Readers};
use haptor_host::rt::blackbox::{BlackBoxReader, black_box};
use haptor_host::rt::clock::{Clock, Virtual};
use haptor_host::rt::control::Control;
use haptor_host::rt::desk::{Counter, desk};
use haptor_host::rt::line::{Line, Opener, exchange};
use haptor_host::rt::pace::Follow;
use haptor_host::rt::parts::Settings;
use haptor_host::rt::stale::StaleRule;
use haptor_wire::{BakedScene, FaultRecord, FromHost, Record, RtReport, SessionHello, Summary, TickRecord};
use rtrb::Producer;

pub use crate::support::ball::ball_on_cube;

/// Ticks a second of every rig.
pub const RATE_HZ: u32 = 1000;

/// The device's own tick [us].
const DEVICE_TICK_US: u64 = 125;

/// Room for what waits on the cable [bytes]: a second of reports.
const CABLE_BYTES: usize = 64 * 1024;

/// The device and its cable.
pub struct Far {
    pub clock: Virtual,
    pub device: Device,
    tx: TxBuf,
    to_host: VecDeque<u8>,
    passed_us: u64,
    /// The cable is pulled: both ends get an error.
    pub cut: bool,
    /// The device stands still until then [us].
    still_until_us: u64,
    /// Noise drowns what the device says until then [us].
    noise_until_us: u64,
    noise: u64,
}

impl Far {
    fn now_us(&self) -> u64 {
        self.clock.now_ns() / 1000
    }

    /// Lets the device's time pass up to the clock's.
    fn catch_up(&mut self) {
        let now_us = self.now_us();
        let elapsed_us = now_us - self.passed_us;
        self.passed_us = now_us;
        if now_us > self.still_until_us {
            self.device.step(elapsed_us as u32, &[], &mut self.tx);
        }
        self.carry();
    }

    fn carry(&mut self) {
        let noisy = self.now_us() < self.noise_until_us;
        for &byte in self.tx.as_slice() {
            // a linear congruential generator, Numerical Recipes' constants; its high byte is noise enough
            self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            self.to_host.push_back(if noisy { (self.noise >> 24) as u8 } else { byte });
        }
        self.tx.clear();
    }

    /// The device stands still for so long [us].
    pub fn stall(&mut self, for_us: u64) {
        self.still_until_us = self.now_us() + for_us;
    }

    /// Noise drowns what the device says for so long [us].
    pub fn drown(&mut self, for_us: u64) {
        self.noise_until_us = self.now_us() + for_us;
    }

    /// Power off and on.
    pub fn restart(&mut self) {
        self.device.restart(&PREMIUM15, "RIG");
    }

    /// Plugs the cable in again; what was on it is gone.
    pub fn plug_in(&mut self) {
        self.cut = false;
        self.to_host.clear();
        self.device.link_opened();
    }
}

/// The host's end of the cable.
pub struct Cable(pub Arc<Mutex<Far>>);

impl Cable {
    fn far(&self) -> Result<MutexGuard<'_, Far>, LinkError> {
        let mut far = self.0.lock().expect("one thread");
        if far.cut {
            return Err(LinkError::Closed);
        }
        far.catch_up();
        Ok(far)
    }
}

impl Link for Cable {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut far = self.far()?;
        let Far { device, tx, .. } = &mut *far;
        device.step(0, bytes, tx);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        let mut far = self.far()?;
        let until_us = far.now_us() + wait.as_micros() as u64;
        while far.to_host.is_empty() && far.now_us() + DEVICE_TICK_US <= until_us {
            far.clock.advance_ns(DEVICE_TICK_US * 1000);
            far.catch_up();
        }
        let n = into.len().min(far.to_host.len());
        for (slot, byte) in into.iter_mut().zip(far.to_host.drain(..n)) {
            *slot = byte;
        }
        Ok(n)
    }

    fn name(&self) -> &str {
        "rig"
    }
}

/// A session under test.
pub struct Rig {
    pub control: Control<Virtual>,
    pub far: Arc<Mutex<Far>>,
    /// The other side of the loop's desk, until somebody takes it.
    pub counter: Option<Counter>,
    /// Everything recorded so far.
    pub records: Vec<Record<'static>>,
    /// Where everything recorded goes too.
    pub copies: Option<Producer<Record<'static>>>,
    opener: Opener,
    readers: Readers,
    pub dumps: BlackBoxReader,
    /// Every tick recorded so far.
    pub ticks: Vec<TickRecord>,
    /// The device recorded.
    pub device: Option<SessionHello>,
    /// Every fault recorded so far.
    pub faults: Vec<FaultRecord>,
    /// Everything told to tools so far.
    pub told: Vec<FromHost>,
}

impl Rig {
    /// The hand plays `script` over and over on the ball and cube; the session lasts `ticks`.
    pub fn new(script: &str, ticks: Option<u64>) -> Self {
        Self::with_link(script, ticks, |cable| Box::new(cable))
    }

    /// The same with something between host and cable.
    pub fn with_link(script: &str, ticks: Option<u64>, wrap: impl FnOnce(Cable) -> AnyLink) -> Self {
        Self::on(&ball_on_cube(), script, ticks, wrap)
    }

    /// The same on another scene.
    pub fn on(scene: &BakedScene, script: &str, ticks: Option<u64>, wrap: impl FnOnce(Cable) -> AnyLink) -> Self {
        let clock = Virtual::default();
        let reach = Reach::usual(FIRM_GRIP.stiffness, PREMIUM15.max_force);
        let script = Script::by_name(script, &reach, true).expect("a script of that name");
        let far = Arc::new(Mutex::new(Far {
            clock: clock.clone(),
            device: Device::new(&PREMIUM15, "RIG", FIRM_GRIP, Encoders::FINE, script),
            tx: TxBuf::new(),
            to_host: VecDeque::with_capacity(CABLE_BYTES),
            passed_us: 0,
            cut: false,
            still_until_us: 0,
            noise_until_us: 0,
            noise: 1,
        }));
        let (links, opener) = exchange();
        let (writer, dumps) = black_box(RATE_HZ);
        let (account, readers) = Account::new(writer, RATE_HZ);
        let engine = Scene::new(scene).and_then(|scene| scene.engine()).expect("a good scene");
        let settings = settings(ticks);
        let line = Line::new(wrap(Cable(Arc::clone(&far))), links);
        let (desk, counter) = desk();
        let control = Control::new(settings, clock, line, engine, account, desk);
        Self {
            control,
            far,
            counter: Some(counter),
            copies: None,
            records: Vec::new(),
            opener,
            readers,
            dumps,
            ticks: Vec::new(),
            device: None,
            faults: Vec::new(),
            told: Vec::new(),
        }
    }

    pub fn far(&self) -> MutexGuard<'_, Far> {
        self.far.lock().expect("one thread")
    }

    /// One tick of the host; what it left behind is collected.
    pub fn tick(&mut self) {
        self.control.tick();
        self.collect();
    }

    /// Takes what the queues hold.
    pub fn collect(&mut self) {
        while let Ok(record) = self.readers.records.pop() {
            if let Some(copies) = &mut self.copies {
                copies.push(record).expect("the recorder keeps up");
            }
            self.records.push(record);
            match record {
                Record::Tick(tick) => self.ticks.push(tick),
                Record::Fault(fault) => self.faults.push(fault),
                Record::Device(device) => self.device = Some(device),
                _ => {}
            }
        }
        while let Ok(message) = self.readers.news.pop() {
            self.told.push(message);
        }
    }

    /// Ticks until `done`, at most `limit` times; whether it was.
    pub fn until(&mut self, limit: u32, mut done: impl FnMut(&Self) -> bool) -> bool {
        (0..limit).any(|_| {
            self.tick();
            done(self)
        })
    }

    /// Plugs the cable in again and hands the host a new link on it, as the reopening thread does.
    pub fn reopen(&mut self) {
        self.opener.dead.pop().expect("the host gave up its link");
        self.far().plug_in();
        let link: AnyLink = Box::new(Cable(Arc::clone(&self.far)));
        self.opener.fresh.push(link).expect("room for a link");
    }

    /// The flag by which a recorder asks for a rest.
    pub fn rest_wanted(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.readers.rest_wanted)
    }

    pub fn summary(&self) -> Summary {
        self.control.summary(RtReport::default())
    }

    /// The last tick recorded.
    pub fn last(&self) -> &TickRecord {
        self.ticks.last().expect("the session has begun")
    }
}

/// What every rig's host is told.
pub fn settings(ticks: Option<u64>) -> Settings {
    Settings { rate_hz: RATE_HZ, follow: Follow::Clock, ticks, stale: StaleRule::at(RATE_HZ), rt: RtReport::default() }
}

/// Length of a vector.
pub fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}
