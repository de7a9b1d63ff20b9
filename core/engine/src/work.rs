//! The work budget of a session: read from what people write, and checked for an engine that takes it over between two ticks.

use haptor_contact::{Invalid, MAX_WORK, MIN_WORK, check_work};
use haptor_wire::WorkBudget;

/// What a tick may spend, checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit(pub(crate) Option<u32>);

impl Limit {
    /// Checks a work budget \[instructions\]; `None` is no limit.
    ///
    /// # Errors
    /// [`Invalid`] when it is not within [`MIN_WORK`] and [`MAX_WORK`].
    pub fn new(work: Option<u32>) -> Result<Self, Invalid> {
        check_work(work).map(|()| Self(work))
    }

    /// What was checked.
    #[must_use]
    pub const fn work(self) -> Option<u32> {
        self.0
    }
}

/// Reads a budget as people write it: `scene`, `auto`, `off`, or instructions a tick.
///
/// # Errors
/// [`NoBudget`] for anything else.
pub fn budget(text: &str) -> Result<WorkBudget, NoBudget> {
    match (text, text.parse()) {
        ("scene", _) => Ok(WorkBudget::Scene),
        ("auto", _) => Ok(WorkBudget::Auto),
        ("off", _) => Ok(WorkBudget::Off),
        (_, Ok(work)) if (MIN_WORK..=MAX_WORK).contains(&work) => Ok(WorkBudget::Work(work)),
        _ => Err(NoBudget),
    }
}

/// What was written is no budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("allowed is scene, auto, off, or instructions a tick, {MIN_WORK} to {MAX_WORK}")]
pub struct NoBudget;

#[cfg(all(test, feature = "std"))]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn words_and_ranges() {
        let cases = [
            ("scene", Ok(WorkBudget::Scene)),
            ("auto", Ok(WorkBudget::Auto)),
            ("off", Ok(WorkBudget::Off)),
            ("300000", Ok(WorkBudget::Work(300_000))),
            ("9999", Err(NoBudget)),
            ("1e6", Err(NoBudget)),
            ("", Err(NoBudget)),
        ];
        for (text, expected) in cases {
            assert_eq!(budget(text), expected, "{text}");
            // what is written reads again
            assert!(expected.is_err() || expected.is_ok_and(|budget| budget.to_string() == text), "{text}");
        }
        assert!(NoBudget.to_string().contains("10000 to 1000000000"));
        assert_eq!(Limit::new(None).map(Limit::work), Ok(None));
        assert!(Limit::new(Some(MIN_WORK - 1)).is_err_and(|error| error.name == "model.work"));
    }
}
