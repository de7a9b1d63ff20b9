//! One motion recorded by every build: the tool in debug and in release, and the image on the emulated Cortex-M7. Every build's recording must be verified by the
//! others', and the files are the same to the byte.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::run;

/// The motion that is recorded: press, twist, slide.
const SCENE: &str = "tests/scenes/cube-twist";

/// The recordings, and the tools that verify them.
pub struct Recordings {
    tools: [PathBuf; 2],
    /// In debug, in release, on the Cortex-M7.
    files: [PathBuf; 3],
}

impl Recordings {
    /// Builds both tools and records with each.
    ///
    /// # Errors
    /// When one does not build or record.
    pub fn make(folder: &Path) -> Result<Self> {
        fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        let files = ["debug", "release", "cortex-m7"].map(|name| folder.join(format!("{name}.haptor")));
        let tools = [run::tool()?, run::release_tool()?];
        for (tool, file) in tools.iter().zip(&files) {
            let (scene, trajectory) = (format!("{SCENE}.toml"), format!("{SCENE}.csv"));
            let mut command = run::program(tool);
            run::run(command.args(["record", &scene, "--trajectory", &trajectory, "-o"]).arg(file))?;
        }
        Ok(Self { tools, files })
    }

    /// The recording that the image computes again.
    pub fn first(&self) -> &Path {
        &self.files[0]
    }

    /// Keeps what the image wrote, verifies every recording with every tool, and compares the bytes.
    ///
    /// # Errors
    /// When a tick differs; the tool has named it.
    pub fn check(&self, from_image: &[u8]) -> Result<String> {
        let [first, .., of_image] = &self.files;
        fs::write(of_image, from_image).with_context(|| format!("{} cannot be written", of_image.display()))?;
        for file in &self.files {
            for tool in &self.tools {
                run::run(run::program(tool).arg("replay").arg(file).arg("--verify"))?;
            }
        }
        let expected = fs::read(first).with_context(|| format!("{} cannot be read", first.display()))?;
        for file in &self.files {
            if fs::read(file).ok().as_ref() != Some(&expected) {
                bail!("{} and {} are not the same to the byte", first.display(), file.display());
            }
        }
        Ok(format!("{} recordings of {} kB, the same to the byte", self.files.len(), expected.len() / 1024))
    }
}
