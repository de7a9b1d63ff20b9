//! The fewest inputs that reach what was reached, for the repository.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use super::Folders;
use crate::run;

/// Bytes of an input that is kept at most: larger ones are the good ones, which are made anew.
const MOST_BYTES: u64 = 2048;

/// Bytes of a target's inputs, about, and how many: together the targets keep some hundred kilobytes.
const IN_ALL: u64 = 20_000;
const INPUTS: u64 = 100;

/// Replaces the inputs that are kept of a target.
///
/// # Errors
/// When the target cannot be run, or a file not be copied.
pub fn keep(folders: &Folders, name: &str) -> Result<()> {
    let (fewest, kept) = (folders.work.join("fewest").join(name), Folders::kept(name));
    let again = |folder: &PathBuf| {
        fs::remove_dir_all(folder).ok();
        fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))
    };
    again(&fewest)?;
    let mut command = folders.program(name, &fewest);
    // a set that covers every edge, whatever how often it is passed
    command.args(["-set_cover_merge=1", "-use_counters=0", "-verbosity=0"]).arg(folders.found(name));
    run::run(command.args(kept.is_dir().then_some(&kept)))?;
    let mut inputs = Vec::new();
    for entry in fs::read_dir(&fewest)? {
        let entry = entry?;
        inputs.push((entry.metadata()?.len(), entry.file_name()));
    }
    again(&kept)?;
    for input in spread(inputs) {
        fs::copy(fewest.join(&input), kept.join(&input)).with_context(|| format!("{} cannot be kept", kept.display()))?;
    }
    Ok(())
}

/// Every so many of the inputs, from the small ones to the large: lengths and names.
fn spread<T: Ord>(mut inputs: Vec<(u64, T)>) -> impl Iterator<Item = T> {
    inputs.retain(|&(length, _)| length <= MOST_BYTES);
    inputs.sort();
    let bytes: u64 = inputs.iter().map(|(length, _)| length).sum();
    let every = (inputs.len() as u64).div_ceil(INPUTS).max(bytes.div_ceil(IN_ALL)).max(1) as usize;
    inputs.into_iter().skip(every - 1).step_by(every).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_small_inputs_are_kept_of_all_lengths() {
        let kept = |lengths: &[u64]| spread(lengths.iter().map(|&length| (length, length)).collect()).collect::<Vec<_>>();
        assert_eq!(kept(&[3, 1, MOST_BYTES + 1, 2]), [1, 2, 3]);
        assert!(kept(&[]).is_empty());
        let many: Vec<u64> = (0..400).collect();
        assert_eq!(kept(&many).len(), 100);
        let heavy = kept(&[2000; 40]);
        assert_eq!(heavy.len(), 10);
    }
}
