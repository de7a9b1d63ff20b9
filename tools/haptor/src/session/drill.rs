//! A fault on purpose, as `demo --drill` takes it: checked here, acted by the simulated device (its `--fault`).

/// What can go wrong on a device without a bus, and whether it lasts.
const KINDS: [(&str, bool); 14] = [
    ("garbage", true),
    ("stall", true),
    ("die", false),
    ("restart", false),
    ("kick", false),
    ("corrupt", true),
    ("duplicate", true),
    ("reorder", true),
    ("delay", true),
    ("drop", true),
    ("nan", true),
    ("freeze", true),
    ("stuck", true),
    ("version", false),
];

/// A planned fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Drill {
    /// As it was written, for the device.
    pub text: String,
    /// When, counted from the session's begin \[s\].
    pub at_s: f64,
}

/// Reads `KIND@SECONDS[:LENGTH]`.
///
/// # Errors
/// In words, what is wrong and what is allowed.
pub fn parse(text: &str) -> Result<Drill, String> {
    let (kind, when) = text.split_once('@').ok_or("allowed is KIND@SECONDS[:LENGTH], e.g. stall@2:50ms or die@2")?;
    let names = KINDS.map(|(name, _)| name).join(", ");
    let (_, lasts) =
        KINDS.iter().find(|(name, _)| *name == kind).ok_or_else(|| format!("no drill `{kind}`; there are {names}"))?;
    let (at, length) = when.split_once(':').map_or((when, None), |(at, length)| (at, Some(length)));
    let at_s = seconds(at).ok_or_else(|| format!("`{at}` is no time in seconds; e.g. {kind}@2"))?;
    match length {
        Some(_) if !lasts => Err(format!("{kind} happens at once and takes no length; write {kind}@{at}")),
        Some(length) if duration(length).is_none() => Err(format!("`{length}` is no length of time; e.g. {kind}@{at}:50ms")),
        _ => Ok(Drill { text: text.to_owned(), at_s }),
    }
}

fn seconds(text: &str) -> Option<f64> {
    // an hour: the longest demonstration
    text.parse().ok().filter(|value| (0.0..=3600.0).contains(value))
}

fn duration(text: &str) -> Option<f64> {
    match text.strip_suffix("ms") {
        Some(number) => seconds(number).map(|ms| 1e-3 * ms),
        None => seconds(text.strip_suffix('s').unwrap_or(text)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drills_read_as_they_are_written_or_say_what_is_allowed() {
        for (text, at_s) in [("die@2", 2.0), ("stall@0.5:50ms", 0.5), ("garbage@1:2s", 1.0), ("kick@3", 3.0), ("restart@0", 0.0)]
        {
            assert_eq!(parse(text), Ok(Drill { text: text.to_owned(), at_s }));
        }
        let table = [
            ("die", "KIND@SECONDS"),
            ("flood@1", "garbage, stall, die, restart, kick"),
            ("die@soon", "`soon` is no time"),
            ("die@-1", "`-1` is no time"),
            ("die@2:50ms", "write die@2"),
            ("stall@2:long", "`long` is no length"),
            ("stall@nan", "no time"),
        ];
        for (text, part) in table {
            let error = parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
