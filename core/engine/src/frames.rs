//! The two frames that only the host knows; world and probe are the core's.
//!
//! | letter | frame | marker |
//! |---|---|---|
//! | `w` | world: the object's base centre, +z up | [`haptor_contact::World`] |
//! | `d` | device base | [`DeviceBase`] |
//! | `h` | handle, the moving end of the device | [`Handle`] |
//! | `p` | probe, origin at its mass centre | [`haptor_contact::ProbeFrame`] |
//!
//! `x_wp = x_wd * x_dh * x_hp`. With a direct coupling `x_hp` is the identity, so a wrench on the probe about its mass centre is
//! the wrench on the handle about its origin. With a virtual one the core moves the probe, and what it returns is the spring's and
//! damper's wrench on the handle about the handle's origin.

/// Marker of the device's base frame `d`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceBase;

/// Marker of the handle's frame `h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handle;
