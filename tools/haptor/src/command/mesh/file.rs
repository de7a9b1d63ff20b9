//! The file that a command reads and the one that it writes.

use std::path::{Path, PathBuf};

use haptor_mesh::load::{extension, read_bytes};
use haptor_mesh::{Mesh, load_mesh, save_as};

use crate::failure::{Failure, Outcome};
use crate::output;

/// A mesh file and its unit.
#[derive(Debug, clap::Args)]
pub struct File {
    /// Mesh file (STL, OBJ or PLY; told apart by its contents)
    file: PathBuf,
    /// Takes the file's unit to metres: 0.001 for millimetres
    #[arg(long, conflicts_with = "unit")]
    scale: Option<f64>,
    /// The file's unit
    #[arg(long, value_enum)]
    unit: Option<Unit>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Unit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
}

impl Unit {
    fn metres(self) -> f64 {
        match self {
            Self::Mm => 1.0e-3,
            Self::Cm => 1.0e-2,
            Self::M => 1.0,
            Self::In => 25.4e-3,
        }
    }
}

impl File {
    /// Its path in messages.
    pub fn name(&self) -> String {
        self.file.display().to_string()
    }

    /// What takes its unit to metres.
    pub fn scale(&self) -> f64 {
        self.scale.or(self.unit.map(Unit::metres)).unwrap_or(1.0)
    }

    /// The end of its name, in small letters.
    pub fn extension(&self) -> Option<String> {
        extension(&self.file)
    }

    /// A failure about it.
    pub fn bad(&self, what: impl std::fmt::Display) -> Failure {
        Failure::bad_input(format!("{}: {what}", self.name()))
    }

    /// The mesh, as it is in the file.
    ///
    /// # Errors
    /// [`Failure::BadInput`] with the reason.
    pub fn load(&self) -> Result<Mesh, Failure> {
        load_mesh(&self.file, self.scale()).map_err(|error| self.bad(error))
    }

    /// Its bytes.
    ///
    /// # Errors
    /// As [`File::load`].
    pub fn bytes(&self) -> Result<Vec<u8>, Failure> {
        read_bytes(&self.file).map_err(|error| self.bad(error))
    }
}

/// Writes a mesh, in metres, in the format that the file's name asks for.
///
/// # Errors
/// [`Failure::BadInput`] for other names; those of the output.
pub fn write(mesh: &Mesh, path: &Path) -> Outcome {
    let Some(bytes) = save_as(mesh, extension(path).as_deref()) else {
        let what = "its name must end with .stl, .ply or .obj, which says the format";
        return Err(Failure::bad_input(format!("{}: {what}", path.display())));
    };
    output::write_file(path, &bytes)
}

/// Refuses a name that [`write`] would refuse, before any work is done.
///
/// # Errors
/// As [`write`].
pub fn check_name(path: &Path) -> Outcome {
    match save_as(&Mesh::default(), extension(path).as_deref()) {
        Some(_) => Ok(()),
        None => write(&Mesh::default(), path),
    }
}
