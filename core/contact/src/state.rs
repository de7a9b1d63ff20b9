//! What survives a tick.
