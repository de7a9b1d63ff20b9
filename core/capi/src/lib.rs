//! The core behind a C interface: what `include/haptor.h` declares, and nothing else.
//!
//! The header is written by hand and says what each function does; a test compares its sizes, offsets and values with the types here.
//! Every pointer is looked at before it is used: null and misaligned ones are refused, the rest (that it points to as much memory as its
//! type says, that nobody else uses it at the same time, that a handle was not closed) is the caller's promise, as always in C.
//!
//! No panic leaves this crate: what makes or frees things is wrapped in [`catch_unwind`], and a step has no panic path (the core proves it
//! by its image for the Cortex-M7); were there one, a function declared `extern "C"` ends the process and does not unwind.
#![deny(missing_docs)]

use std::ffi::{c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use haptor_contact::{Flags, Pose, Quat, Vec3};
use haptor_engine::{Felt, OwnedEngine, Scene, SceneError};
use haptor_wire::{DeviceHello, Place, Tier};

/// `HAPTOR_ABI`.
pub const ABI: u32 = 1;

/// `HAPTOR_OK`.
pub const OK: i32 = 0;
/// `HAPTOR_BAD_POINTER`.
pub const BAD_POINTER: i32 = 1;
/// `HAPTOR_BAD_VALUE`.
pub const BAD_VALUE: i32 = 2;
/// `HAPTOR_REFUSED`.
pub const REFUSED: i32 = 3;
/// `HAPTOR_NOT_FINITE`.
pub const NOT_FINITE: i32 = 4;

/// The version in words, ended by the zero that C wants.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");

/// `haptor`: a core at work.
#[derive(Debug)]
pub struct Core {
    engine: OwnedEngine,
    place: Place,
}

/// One handle may go from thread to thread.
const _: fn() = || {
    fn moves_between_threads<T: Send>() {}
    moves_between_threads::<Core>();
};

/// `haptor_pose`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CPose {
    /// Position \[m\].
    pub position: [f32; 3],
    /// Unit quaternion (w, x, y, z).
    pub rotation: [f32; 4],
}

/// `haptor_wrench`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CWrench {
    /// Force \[N\].
    pub force: [f32; 3],
    /// Torque \[N m\].
    pub torque: [f32; 3],
}

/// `haptor_report`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CReport {
    /// Contact force on the probe, in world \[N\].
    pub contact_force: [f32; 3],
    /// Contact torque on the probe about its mass centre, in world \[N m\].
    pub contact_torque: [f32; 3],
    /// Largest depth \[m\].
    pub depth: f32,
    /// Contact radius of the deepest region \[m\].
    pub radius: f32,
    /// Stuck share of the deepest region's area, 0 to 1.
    pub stick: f32,
    /// [`Flags`].
    pub flags: u32,
    /// Regions in contact.
    pub regions: u32,
    /// [`tier_number`] of the tier used.
    pub tier: u32,
}

/// `HAPTOR_TIER_` of a tier.
#[must_use]
pub const fn tier_number(tier: Tier) -> u32 {
    match tier {
        Tier::Point => 0,
        Tier::Paper => 1,
        Tier::Bristle => 2,
        Tier::Influence => 3,
        Tier::Green => 4,
    }
}

/// See `haptor.h`.
#[unsafe(no_mangle)]
pub extern "C" fn haptor_abi() -> u32 {
    ABI
}

/// See `haptor.h`.
#[unsafe(no_mangle)]
pub extern "C" fn haptor_version() -> *const c_char {
    VERSION.as_ptr().cast()
}

/// See `haptor.h`.
///
/// # Safety
/// `model` points to `length` bytes that nobody writes meanwhile; `error`, when not null, to `error_size` that are the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_open(model: *const c_void, length: usize, error: *mut c_char, error_size: usize) -> *mut Core {
    let opened = if model.is_null() || isize::try_from(length).is_err() {
        Err("no bytes of a baked scene were given".to_owned())
    } else {
        // SAFETY: not null, of a length that memory can have, aligned as every byte is; that so many are there is the caller's promise
        let file = unsafe { std::slice::from_raw_parts(model.cast::<u8>(), length) };
        catch_unwind(|| open(file)).unwrap_or_else(|_| Err("the scene made the library fail; please report it".to_owned()))
    };
    opened.unwrap_or_else(|text| {
        // SAFETY: the caller's promise, passed on
        unsafe { write_text(&text, error, error_size) };
        ptr::null_mut()
    })
}

fn open(file: &[u8]) -> Result<*mut Core, String> {
    let said = |error: SceneError| error.to_string();
    let scene = Scene::read(file).map_err(said)?;
    let core = Core { place: scene.setup().baked().place, engine: scene.engine().map_err(said)? };
    Ok(Box::into_raw(Box::new(core)))
}

/// Writes as much of `text` as there is room for, and a zero.
///
/// # Safety
/// `to`, when not null, points to `size` bytes that are the caller's.
unsafe fn write_text(text: &str, to: *mut c_char, size: usize) {
    let Some(room) = size.checked_sub(1).filter(|_| !to.is_null()) else { return };
    let length = text.floor_char_boundary(room);
    // SAFETY: at most size - 1 bytes of text and one zero go to size bytes, which are the caller's and no part of the text
    unsafe {
        ptr::copy_nonoverlapping(text.as_ptr(), to.cast::<u8>(), length);
        *to.add(length) = 0;
    }
}

/// The thing behind a pointer that C gave, when it can be one.
///
/// # Safety
/// A pointer that is not null and aligned points to a `T` that nobody else uses until the caller is done.
unsafe fn behind<'a, T>(pointer: *mut T) -> Option<&'a mut T> {
    if !pointer.is_aligned() {
        return None;
    }
    // SAFETY: aligned; null becomes None; the rest is the caller's promise
    unsafe { pointer.as_mut() }
}

/// The same, only to be read.
///
/// # Safety
/// A pointer that is not null and aligned points to a `T` that nobody writes until the caller is done.
unsafe fn at<'a, T>(pointer: *const T) -> Option<&'a T> {
    if !pointer.is_aligned() {
        return None;
    }
    // SAFETY: aligned; null becomes None; the rest is the caller's promise
    unsafe { pointer.as_ref() }
}

/// See `haptor.h`.
///
/// # Safety
/// `core` came from [`haptor_open`], was not closed and is used by no other thread meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_fit(core: *mut Core, max_force: f32, max_torque: f32) -> i32 {
    // SAFETY: the caller's promise, passed on
    let Some(core) = (unsafe { behind(core) }) else { return BAD_POINTER };
    let (Some(force), Some(torque)) = (micro(max_force), micro(max_torque)) else { return BAD_VALUE };
    let device = DeviceHello {
        version: haptor_wire::PROTOCOL_VERSION,
        schema: haptor_wire::SCHEMA_HASH,
        name: [0; 12],
        serial: [0; 12],
        max_force_un: force,
        max_torque_unm: torque,
        watchdog_ticks: 0,
    };
    match catch_unwind(AssertUnwindSafe(|| core.engine.fit(&device))) {
        Ok(Ok(())) => OK,
        Ok(Err(_)) | Err(_) => BAD_VALUE,
    }
}

/// Millionths; `None` when it is no amount.
fn micro(value: f32) -> Option<u32> {
    // a float converts saturating: two kilonewtons are as good as more
    (value >= 0.0 && value.is_finite()).then_some((f64::from(value) * 1.0e6).round() as u32)
}

/// See `haptor.h`.
///
/// # Safety
/// As [`haptor_fit`]; `x_wd` points to a pose that is the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_place(core: *const Core, x_wd: *mut CPose) -> i32 {
    // SAFETY: the caller's promise, passed on
    let (core, to) = unsafe { (at(core), behind(x_wd)) };
    let (Some(core), Some(to)) = (core, to) else { return BAD_POINTER };
    *to = CPose { position: core.place.p_wd, rotation: core.place.q_wd };
    OK
}

/// See `haptor.h`.
///
/// # Safety
/// As [`haptor_fit`]; the other pointers, where not null, point to things of their types that are the caller's and do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_step(
    core: *mut Core,
    x_dh: *const CPose,
    dt: f32,
    wrench: *mut CWrench,
    report: *mut CReport,
) -> i32 {
    // SAFETY: the caller's promise, passed on
    let (core, pose, wrench) = unsafe { (behind(core), at(x_dh), behind(wrench)) };
    let Some(wrench) = wrench else { return BAD_POINTER };
    *wrench = CWrench::default();
    let (Some(core), Some(pose)) = (core, pose) else { return BAD_POINTER };
    if !report.is_null() && !report.is_aligned() {
        return BAD_POINTER;
    }
    let [w, x, y, z] = pose.rotation;
    let felt = core.engine.step(&Pose::new(Vec3::from_array(pose.position), Quat::from_xyzw(x, y, z, w)), dt);
    *wrench = CWrench { force: felt.wrench.force.to_array(), torque: felt.wrench.torque.to_array() };
    // SAFETY: the caller's promise, passed on
    if let Some(report) = unsafe { behind(report) } {
        *report = report_of(&felt);
    }
    if felt.non_finite {
        NOT_FINITE
    } else if felt.flags & (Flags::POSE_REFUSED.0 | Flags::POSE_JUMP.0) != 0 {
        REFUSED
    } else {
        OK
    }
}

fn report_of(felt: &Felt) -> CReport {
    CReport {
        contact_force: felt.contact_force,
        contact_torque: felt.contact_torque,
        depth: felt.depth,
        radius: felt.radius,
        stick: felt.stick,
        flags: felt.flags,
        regions: felt.regions.into(),
        tier: tier_number(felt.tier),
    }
}

/// See `haptor.h`.
///
/// # Safety
/// As [`haptor_fit`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_rest(core: *mut Core) -> i32 {
    // SAFETY: the caller's promise, passed on
    let Some(core) = (unsafe { behind(core) }) else { return BAD_POINTER };
    core.engine.rest();
    OK
}

/// See `haptor.h`.
///
/// # Safety
/// `core` is null, or came from [`haptor_open`], was not closed, and nobody uses it any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn haptor_close(core: *mut Core) {
    if core.is_null() || !core.is_aligned() {
        return;
    }
    // SAFETY: it came from Box::into_raw in haptor_open and is given back once, by the caller's promise
    let core = unsafe { Box::from_raw(core) };
    // memory that cannot be freed in order is lost, the program goes on
    let _ = catch_unwind(AssertUnwindSafe(|| drop(core)));
}
