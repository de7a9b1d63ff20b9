//! A scene put together from the chunks of a recording.

use haptor_wire::recording::Chunk;
use haptor_wire::{RecordHeader, scene_file};

use crate::error::SceneError;
use crate::scene::Scene;

/// Why a recording yields no scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoScene {
    /// It has the digest only, as a black box does.
    #[error("it carries only the scene's digest")]
    NotCarried,
    /// A chunk is missing.
    #[error("{found} of {expected} bytes of its scene are whole")]
    Incomplete {
        /// Bytes that came in order.
        found: usize,
        /// Bytes there should be.
        expected: u32,
    },
    /// All chunks are there, but they are of another scene.
    #[error("its scene is not the one that it names")]
    Digest,
    /// This build cannot run it.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Chunks so far.
#[derive(Clone, Debug)]
pub struct Gather {
    header: RecordHeader,
    file: Vec<u8>,
}

impl Gather {
    /// Nothing yet of the scene that a header names.
    #[must_use]
    pub const fn new(header: &RecordHeader) -> Self {
        Self { header: *header, file: Vec::new() }
    }

    /// Takes a chunk. True once, when it was the last; one that is out of order is passed over.
    pub fn push(&mut self, chunk: &Chunk<'_>) -> bool {
        let in_order = chunk.at as usize == self.file.len() && !self.is_whole();
        if in_order {
            self.file.extend_from_slice(chunk.bytes);
        }
        in_order && self.is_whole()
    }

    fn is_whole(&self) -> bool {
        self.file.len() == self.header.scene_bytes as usize
    }

    /// The bytes that came in order.
    #[must_use]
    pub fn file(&self) -> &[u8] {
        &self.file
    }

    /// The scene.
    ///
    /// # Errors
    /// [`NoScene`]: why there is none.
    pub fn scene(&self) -> Result<Scene, NoScene> {
        if self.header.scene_bytes == 0 {
            return Err(NoScene::NotCarried);
        }
        if !self.is_whole() {
            return Err(NoScene::Incomplete { found: self.file.len(), expected: self.header.scene_bytes });
        }
        if scene_file::digest(&self.file) != self.header.scene_digest {
            return Err(NoScene::Digest);
        }
        Ok(Scene::read(&self.file)?)
    }
}
