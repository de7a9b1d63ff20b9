//! Why a baked scene cannot be run.

use haptor_contact::Invalid;
use haptor_wire as wire;

use crate::bodies::MAX_MESHES;
use crate::engine::SAMPLES;

/// Why a baked scene cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The bytes are not a baked scene of this version.
    #[error(transparent)]
    File(#[from] wire::scene_file::SceneFileError),
    /// A value is out of its range.
    #[error(transparent)]
    Value(#[from] Invalid),
    /// A section's contents are not what its kind says.
    #[error("section {kind} of the baked scene: {what}; bake the scene anew")]
    Section {
        /// The section's kind.
        kind: u32,
        /// What is wrong.
        what: &'static str,
    },
    /// A shape names a mesh that the file does not carry.
    #[error("{key}: the file carries {found} meshes, none of number {number}; bake the scene anew")]
    NoMesh {
        /// Whose shape.
        key: &'static str,
        /// What it names, from 0.
        number: u8,
        /// Meshes there are.
        found: usize,
    },
    /// More meshes than bodies.
    #[error("the file carries more than {MAX_MESHES} meshes; bake the scene anew")]
    TooManyMeshes,
    /// The scene wants the body's table, and there is none.
    #[error("model.tier = \"green\": the file carries no table of the body's own Green's function; bake the scene anew")]
    NoTable,
    /// More samples than there is memory for.
    #[error("model.samples is {0}, there is memory for 16 to {SAMPLES} a region")]
    Samples(u16),
}
