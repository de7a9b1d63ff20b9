//! The host's bits of a tick's flags, as the recording defines them: [`haptor_wire::flags`].

pub use haptor_wire::flags::{CLOSED, HELD, LATE, NO_POSE, NOT_SENT, POSE_REFUSED};
