//! One binary for every test that needs more than one crate. One module per promise.

#[path = "support/alloc.rs"]
mod alloc;
#[path = "../support/cli.rs"]
mod cli;
mod device_demo;
mod docs;
mod eval_cli;
mod host_rig;
mod link_faults;
mod no_alloc_host;
mod scene_errors;
mod session;
