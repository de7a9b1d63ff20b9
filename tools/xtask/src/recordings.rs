//! Motions recorded by every build: the tool in debug and in release, and the image on the emulated Cortex-M7. They are one motion of a person's, and the dearest inputs of
//! every ready scene in every tier that are known. Every build's recordings must be verified by the others', and the files are the same to the byte.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::run::{self, root};
use crate::worst::{Kept, rows, table_file};

/// The motion that is recorded at length: press, twist, slide.
const SCENE: &str = "tests/scenes/cube-twist";

/// The recordings, one file a build, and the tools that verify them.
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
            let motion = folder.join("motion.haptor");
            record(tool, &root().join(format!("{SCENE}.toml")), &format!("{SCENE}.csv"), &motion)?;
            let mut whole = Vec::new();
            for part in [vec![motion], known_inputs(tool, folder)?].concat() {
                whole.extend(fs::read(&part).with_context(|| format!("{}", part.display()))?);
            }
            fs::write(file, whole).with_context(|| format!("{} cannot be written", file.display()))?;
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
        Ok(format!("{} files of recordings, {} kB each, the same to the byte", self.files.len(), expected.len() / 1024))
    }
}

/// Records every known input in its tier.
///
/// # Errors
/// When there are none, or one cannot be recorded.
pub fn known_inputs(tool: &Path, folder: &Path) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let table = fs::read_to_string(table_file(root())).context("the table of known inputs")?;
    let inputs = rows(&table);
    if inputs.is_empty() {
        bail!("{} has no inputs", table_file(root()).display());
    }
    inputs.iter().map(|input| known_input(tool, folder, input)).collect()
}

fn known_input(tool: &Path, folder: &Path, input: &Kept) -> Result<PathBuf> {
    let name = Path::new(&input.input()).file_stem().context("an input has a name")?.to_owned();
    let (scene, file) = (folder.join(&name).with_extension("toml"), folder.join(&name).with_extension("haptor"));
    let text = fs::read_to_string(root().join(input.scene_file())).with_context(|| input.scene_file())?;
    fs::write(&scene, in_tier(&text, input.tier(), input.samples())?).with_context(|| format!("{}", scene.display()))?;
    record(tool, &scene, &input.input(), &file)?;
    Ok(file)
}

fn record(tool: &Path, scene: &Path, trajectory: &str, file: &Path) -> Result<()> {
    run::run(run::program(tool).arg("record").arg(scene).args(["--trajectory", trajectory, "-o"]).arg(file))
}

/// A scene's text with another tier.
fn in_tier(scene: &str, tier: &str, samples: u16) -> Result<String> {
    let given = |line: &&str| !["tier =", "samples ="].iter().any(|key| line.starts_with(key));
    let (before, after) = scene.split_once("[model]\n").context("the scene has no section [model]")?;
    let rest: String = after.lines().filter(given).flat_map(|line| [line, "\n"]).collect();
    Ok(format!("{before}[model]\ntier = \"{tier}\"\nsamples = {samples}\n{rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_gets_another_tier_and_keeps_the_rest() {
        let scene = "[object]\nshape = \"box\"\n\n[model]\ntier = \"bristle\"\nsamples = 64\nsweeps = 4\n";
        let expected = "[object]\nshape = \"box\"\n\n[model]\ntier = \"point\"\nsamples = 52\nsweeps = 4\n";
        assert_eq!(in_tier(scene, "point", 52).unwrap(), expected);
        assert!(in_tier("[object]\n", "point", 52).is_err());
    }
}
