//! What a file carries behind its scene: one section of bytes after the other.

use haptor_contact::green::Green;
use haptor_contact::{Invalid, MeshShape};
use haptor_wire::scene_file;
use haptor_wire::sections;

use crate::bodies::{MAX_MESHES, Meshes};
use crate::error::SceneError;
use crate::grid::Grid;
use crate::table::Table;

/// What a file carries behind its scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Data {
    /// The body's table.
    pub table: Option<Table>,
    /// The meshes, as shapes number them.
    pub grids: Vec<Grid>,
}

impl Data {
    /// Reads every section that this build knows; others are left to builds that do.
    pub fn read(file: &[u8]) -> Result<Self, SceneError> {
        let mut data = Self::default();
        for section in scene_file::sections(file)? {
            let section = section?;
            match section.kind {
                sections::GREEN => data.table = Some(Table::new(section.contents)?),
                sections::GRID if data.grids.len() == MAX_MESHES => return Err(SceneError::TooManyMeshes),
                sections::GRID => data.grids.push(Grid::new(section.contents)?),
                _ => {}
            }
        }
        Ok(data)
    }

    /// The body's table as the core borrows it.
    pub fn green(&self) -> Result<Option<Green<'_>>, Invalid> {
        self.table.as_ref().map(Table::green).transpose()
    }
}

impl<'a> Meshes<'a> for &'a Data {
    fn mesh(&self, key: &'static str, number: u8) -> Result<MeshShape<'a>, SceneError> {
        let found = self.grids.len();
        let grid = self.grids.get(usize::from(number)).ok_or(SceneError::NoMesh { key, number, found })?;
        Ok(grid.shape()?)
    }
}
