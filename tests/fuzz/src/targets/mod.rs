//! The targets: each takes bytes, gives them to a reader and checks what holds of whatever comes out. A panic is a finding.
//!
//! Bytes with a checksum are given twice: as they are, and mended ([`mend`]), because hardly any change survives a checksum and what lies behind it would never be seen.
//! Only wire, engine, firmware, mesh and the server's uploads are needed, so that ordinary tests can include this folder and run the kept inputs.

mod baked_scene;
mod device_link;
mod kept_body;
pub mod mend;
mod mesh_file;
mod push;
mod recording;
mod viewer_link;

/// A reader, and what it is fed with.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, that of its folder of inputs too.
    pub name: &'static str,
    /// Reads and checks.
    pub run: fn(&[u8]),
}

/// All but the reader of scene files, which is part of a program.
pub const ALL: [Target; 8] = [
    Target { name: "device_link", run: device_link::run },
    Target { name: "viewer_link", run: viewer_link::run },
    Target { name: "recording", run: recording::run },
    Target { name: "baked_scene", run: baked_scene::run },
    Target { name: "kept_body", run: kept_body::run },
    Target { name: "mesh_stl", run: mesh_file::stl },
    Target { name: "mesh_obj", run: mesh_file::obj },
    Target { name: "mesh_ply", run: mesh_file::ply },
];

/// Runs the target of this name.
///
/// # Panics
/// When there is none of that name, and where the target finds something.
pub fn run(name: &str, bytes: &[u8]) {
    let target = ALL.iter().find(|target| target.name == name);
    (target.unwrap_or_else(|| panic!("no target {name}")).run)(bytes);
}
