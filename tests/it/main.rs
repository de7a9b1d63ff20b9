//! One binary for every test that needs more than one crate. One module per promise.

#[path = "../support/cli.rs"]
mod cli;
mod device_demo;
mod docs;
mod eval_cli;
mod scene_errors;
