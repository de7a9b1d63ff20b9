//! Instructions by source file, inlined or not: what a feature costs a scene that does not use it. Only the test asks for them.

use std::collections::BTreeMap;

use super::callgrind::cost;
use super::stages::Names;

/// Instructions by source file; the core's by their path in its `src`, others under `libraries`.
pub type ByFile = BTreeMap<String, u64>;

/// Instructions in files whose path starts with one of these.
pub fn within(files: &ByFile, starts: &[&str]) -> u64 {
    files.iter().filter(|(file, _)| starts.iter().any(|start| file.starts_with(start))).map(|(_, count)| count).sum()
}

/// Adds a dump's instructions to `into`; yields their sum. `names` keeps what the dumps of one run have named.
pub fn by_file(dump: &str, names: &mut Names, into: &mut ByFile) -> u64 {
    names.learn(dump);
    let (mut file, mut total, mut is_call) = (String::new(), 0, false);
    for line in dump.lines() {
        match line.split_once('=') {
            Some(("fl" | "fi" | "fe", name)) => file = names.file(name),
            Some(("calls", _)) => is_call = true,
            Some(_) => {}
            None => {
                // what a callee cost is counted in its own lines
                let own = cost(line).filter(|_| !std::mem::take(&mut is_call));
                total += own.inspect(|cost| *into.entry(file.clone()).or_default() += cost).unwrap_or(0);
            }
        }
    }
    into.retain(|_, cost| *cost > 0);
    total
}
