//! The device link: what device and host say to each other, 1,000 times a second and more.
//!
//! Frame of every pose and wrench: handle `h` in device base `d`. A wrench is the one **on the handle**, about the handle's
//! origin, expressed in `d`. Integers and arrays only; the units are in the names and [`crate::units`] converts.
//! A session: the host says [`HostHello`] until the device answers [`DeviceHello`], sets [`Mode::Force`], and from then on
//! answers each [`PoseReport`] with one [`WrenchCommand`]. The device's rules (watchdog, limits, refusals) are in `WIRE.md`.

use serde::{Deserialize, Serialize};

/// Everything a device says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FromDevice {
    /// Who it is and what it can do; answers [`ToDevice::Hello`], whether the versions agree or not.
    Hello(DeviceHello),
    /// Where the handle is; once a period while in session, in every mode.
    Pose(PoseReport),
    /// A fault has latched; once per fault.
    Fault(DeviceFault),
}

impl FromDevice {
    /// Postcard bytes at most, the byte that names the message included.
    pub const MAX_ENCODED: usize = 1 + PoseReport::MAX_ENCODED;
}

/// Everything a host says to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToDevice {
    /// Opens a session; the device answers with its own hello.
    Hello(HostHello),
    /// Asks for a mode; the next report tells whether it was granted.
    SetMode(Mode),
    /// The wrench to render.
    Wrench(WrenchCommand),
}

impl ToDevice {
    /// Postcard bytes at most, the byte that names the message included.
    pub const MAX_ENCODED: usize = 1 + WrenchCommand::MAX_ENCODED;
}

/// What a device is and what it can render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceHello {
    /// [`crate::PROTOCOL_VERSION`] of the firmware.
    pub version: u16,
    /// [`crate::SCHEMA_HASH`] of the firmware.
    pub schema: u32,
    /// Model, ASCII, padded with zeros.
    pub name: [u8; 12],
    /// Serial number, ASCII, padded with zeros.
    pub serial: [u8; 12],
    /// Largest force it renders, of any direction \[uN\].
    pub max_force_un: u32,
    /// Largest torque it renders, about any axis \[uN m\]; 0 = it cannot render torque.
    pub max_torque_unm: u32,
    /// Steps of [`WATCHDOG_STEP_US`] without an accepted wrench in [`Mode::Force`] after which it brakes.
    pub watchdog_ticks: u16,
}

/// Unit of [`DeviceHello::watchdog_ticks`] \[us\]: the micro-frame of high-speed USB.
pub const WATCHDOG_STEP_US: u32 = 125;

impl DeviceHello {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + U32 + 12 + 12 + U32 + U32 + U16;

    /// The model's name as text; bytes that are not ASCII read as `?`, zeros end it.
    pub fn name_chars(&self) -> impl Iterator<Item = char> + use<> {
        ascii_chars(self.name)
    }

    /// The serial number as text; bytes that are not ASCII read as `?`, zeros end it.
    pub fn serial_chars(&self) -> impl Iterator<Item = char> + use<> {
        ascii_chars(self.serial)
    }
}

fn ascii_chars(text: [u8; 12]) -> impl Iterator<Item = char> + use<> {
    text.into_iter().take_while(|&b| b != 0).map(|b| if b.is_ascii_graphic() || b == b' ' { char::from(b) } else { '?' })
}

/// Opens a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostHello {
    /// [`crate::PROTOCOL_VERSION`] of the host.
    pub version: u16,
    /// [`crate::SCHEMA_HASH`] of the host.
    pub schema: u32,
    /// How often the host wants a [`PoseReport`] \[us\]; 0 = 1,000. The device brings it into 125 to 100,000 and up to whole [`WATCHDOG_STEP_US`], and keeps to it:
    /// paced by the device, the host counts time in these periods.
    pub period_us: u32,
}

impl HostHello {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + U32 + U32;
}

/// Where the handle is and how the device fares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PoseReport {
    /// Counts reports from 0 at power-up; wraps.
    pub seq: u32,
    /// The device's clock when the pose was taken \[us\]; wraps after 71.6 minutes.
    pub t_us: u32,
    /// Position `p_dh` of the handle's origin \[nm\].
    pub position_nm: [i32; 3],
    /// Rotation `q_dh` as a unit quaternion (w, x, y, z) \[2^-30\].
    pub rotation_q30: [i32; 4],
    /// Bit k set = button k held.
    pub buttons: u8,
    /// The mode the device is in.
    pub mode: Mode,
    /// What happened to the wrench since the last report: the `FLAG_` bits.
    pub flags: u8,
    /// `seq` of the last [`WrenchCommand`] accepted; 0 before the first (a host counts from 1).
    pub echo: u32,
}

impl PoseReport {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32 + U32 + 3 * U32 + 4 * U32 + 1 + ENUM + 1 + U32;
    /// A torque was asked for that the device cannot render.
    pub const FLAG_TORQUE_NOT_RENDERED: u8 = 1 << 0;
    /// The force was shortened to the device's limit, its direction kept.
    pub const FLAG_FORCE_CLAMPED: u8 = 1 << 1;
    /// The torque was shortened to the device's limit, its axis kept.
    pub const FLAG_TORQUE_CLAMPED: u8 = 1 << 2;
    /// The handle moved faster than the device allows in [`Mode::Force`].
    pub const FLAG_OVER_SPEED: u8 = 1 << 3;
    /// The watchdog ran out.
    pub const FLAG_WATCHDOG: u8 = 1 << 4;
}

/// The wrench to render on the handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WrenchCommand {
    /// Counts commands from 1; wraps. A command not newer than the last accepted one is ignored.
    pub seq: u32,
    /// `seq` of the [`PoseReport`] it answers.
    pub echo: u32,
    /// Force on the handle, in `d` \[uN\]; [`crate::units::NOT_A_NUMBER`] anywhere makes the device refuse and brake.
    pub force_un: [i32; 3],
    /// Torque on the handle about its origin, in `d` \[uN m\]; same rule.
    pub torque_unm: [i32; 3],
    /// How long to render it without a newer command \[us\]; then it fades to zero.
    pub hold_us: u32,
}

impl WrenchCommand {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32 + U32 + 3 * U32 + 3 * U32 + U32;
}

/// What the device does with wrenches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// Motors off; clears the latched fault. The mode after power-up.
    #[default]
    Reset,
    /// In session, motors off.
    Idle,
    /// Renders wrenches.
    Force,
    /// Motors shorted: no commanded wrench, the handle is damped. Left through [`Mode::Reset`] only.
    Brake,
}

impl Mode {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM;

    /// The mode in one lower-case word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reset => "reset",
            Self::Idle => "idle",
            Self::Force => "force",
            Self::Brake => "brake",
        }
    }
}

/// A fault, latched until the host sets [`Mode::Reset`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceFault {
    /// What went wrong.
    pub cause: FaultCause,
    /// `seq` of the last [`PoseReport`] sent before it.
    pub seq: u32,
    /// A number that helps, per cause (see [`FaultCause`]).
    pub detail: i32,
}

impl DeviceFault {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = ENUM + U32 + U32;
}

/// Why a device stopped rendering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaultCause {
    /// No wrench accepted in time. Detail: steps of [`WATCHDOG_STEP_US`] waited.
    Watchdog,
    /// The handle moved too fast. Detail: its speed \[um/s\], or \[urad/s\] negated when it was the rotation.
    OverSpeed,
    /// A command held [`crate::units::NOT_A_NUMBER`]. Detail: its `seq`, as i32.
    NonFinite,
    /// Host and device speak different versions or tables. Detail: the device's version.
    VersionMismatch,
    /// A message that the mode does not allow. Detail: the mode's number.
    Protocol,
    /// The firmware's own encoder, motor or power check failed. Detail: the maker's.
    Hardware,
}

impl FaultCause {
    /// The cause in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Watchdog => "watchdog ran out",
            Self::OverSpeed => "over-speed",
            Self::NonFinite => "non-finite command refused",
            Self::VersionMismatch => "version mismatch",
            Self::Protocol => "message out of turn",
            Self::Hardware => "hardware",
        }
    }
}

/// Postcard bytes at most of a u16.
pub(crate) const U16: usize = 3;
/// Postcard bytes at most of a u32 or i32.
pub(crate) const U32: usize = 5;
/// Postcard bytes at most of a u64.
pub(crate) const U64: usize = 10;
/// Postcard bytes of an f32.
pub(crate) const F32: usize = 4;
/// Postcard bytes of the name of an enum's case, for enums of less than 128 cases.
pub(crate) const ENUM: usize = 1;
