//! One binary for every test that needs more than one crate. One module per promise.

mod acceptance;
#[path = "support/alloc.rs"]
mod alloc;
mod bench_cli;
mod bits;
mod bounds;
mod budget;
mod c_abi;
mod c_device;
#[path = "../support/cli.rs"]
mod cli;
mod closed_forms;
mod corners;
mod counts;
mod demo_drills;
mod determinism;
mod device_demo;
mod docs;
mod edges;
mod eval_cli;
mod extremes;
mod fem;
mod fuzz_cases;
mod green;
mod green_table;
mod histories;
mod host_rig;
mod influence;
mod invariance;
mod link_faults;
mod mesh_files;
mod mesh_scenes;
mod meshes;
mod no_alloc;
mod no_alloc_host;
mod pressing;
mod profiles;
mod rates;
mod recordings;
mod region_limit;
mod replay;
mod scene_errors;
mod scenes;
mod serial;
mod served;
mod session;
mod stability;
mod state_room;
mod steady_loop;
#[path = "../support/mod.rs"]
mod support;
mod surface;
mod timing;
mod trade;
#[path = "../support/viewer.rs"]
mod viewer;
mod viewer_link;
mod viewer_rig;

// the fuzzer's targets name it as their own
use haptor_host::viewer::uploads;
