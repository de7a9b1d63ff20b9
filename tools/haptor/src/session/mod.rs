//! A session of the three programs: simulated device, real-time host, and this one looking on.
//!
//! ```text
//! haptor-firmware-sim ── pty, the device link ── haptor-host ── pipe, the tool link ── haptor
//!                                                     └── recording (file)
//! ```

pub mod describe;
pub mod device;
pub mod drill;
pub mod host;
pub mod mcap;
pub mod offline;
pub mod recording;
pub mod replay;
pub mod report;
pub mod table;
