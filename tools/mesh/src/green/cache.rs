//! Tables kept in a folder, one file per key: computed once per body, found again ever after.

use std::path::{Path, PathBuf};

use super::file::GreenFileError;
use super::{GreenError, GreenInputs, GreenTable};

/// The user's cache folder for tables: `$XDG_CACHE_HOME/haptor/green`, or `~/.cache/haptor/green`; none without a home.
pub fn folder() -> Option<PathBuf> {
    use etcetera::BaseStrategy;
    let base = etcetera::choose_base_strategy().ok()?;
    Some(base.cache_dir().join("haptor").join("green"))
}

/// A table, and where it is from.
#[derive(Debug)]
pub struct Fetched {
    /// The table.
    pub table: GreenTable,
    /// True when it was computed now.
    pub computed: bool,
    /// Why it could not be kept or why a kept one was not used; the table is good all the same.
    pub trouble: Option<GreenFileError>,
}

/// The file of these inputs in `folder`.
pub fn path(folder: &Path, inputs: &GreenInputs) -> PathBuf {
    folder.join(format!("{}.green", inputs.key()))
}

/// The table of `inputs` from `folder`, computed and kept there if it is missing or damaged; `None` keeps nothing.
///
/// # Errors
/// [`GreenError`] names what cannot be computed.
pub fn fetch(inputs: &GreenInputs, folder: Option<&Path>, progress: &mut dyn FnMut(usize, usize)) -> Result<Fetched, GreenError> {
    let path = folder.map(|folder| path(folder, inputs));
    let mut trouble = None;
    if let Some(path) = path.as_deref().filter(|path| path.exists()) {
        match GreenTable::read(path, inputs) {
            Ok(table) => return Ok(Fetched { table, computed: false, trouble }),
            Err(error) => trouble = Some(error),
        }
    }
    let table = GreenTable::compute(inputs, progress)?;
    if let Some(path) = path
        && let Err(error) = keep(&path, inputs, &table)
    {
        trouble = Some(error);
    }
    Ok(Fetched { table, computed: true, trouble })
}

fn keep(path: &Path, inputs: &GreenInputs, table: &GreenTable) -> Result<(), GreenFileError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| GreenFileError::Io { path: folder.to_path_buf(), error })?;
    }
    table.write(path, inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::green::GreenOptions;
    use haptor_contact::{Material, ObjectShape};

    #[test]
    fn a_table_is_computed_once_and_again_when_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.3, density: 1100.0 };
        let shape = ObjectShape::Box { size: glam::Vec3::splat(0.1) };
        let inputs = GreenInputs { shape, material, fixed_below: 0.0, options: GreenOptions { per_edge: 3, fineness: 3 } };
        let fetch = || fetch(&inputs, Some(folder.path()), &mut |_, _| ()).unwrap();
        let first = fetch();
        assert!(first.computed && first.trouble.is_none());
        let second = fetch();
        assert!(!second.computed && second.table == first.table);
        std::fs::write(path(folder.path(), &inputs), b"haptgrn").unwrap();
        let third = fetch();
        assert!(third.computed && third.trouble.is_some() && third.table == first.table);
        assert!(!fetch().computed);
    }
}
