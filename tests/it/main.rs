//! One binary for every test that needs more than one crate. One module per promise.

mod device_demo;
