//! The one error of this crate: a value that construction refuses.

use core::fmt;

/// A parameter out of its range: what it is called, what was given, what is allowed.
///
/// Only construction ([`Model::new`](crate::Model::new), [`Params::new`](crate::Params::new)) returns it; a tick
/// cannot fail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invalid {
    /// Name of the parameter, as in the scene file, e.g. `object.young_modulus`.
    pub name: &'static str,
    /// The value that was given, in the parameter's SI unit.
    pub value: f32,
    /// The allowed range in words, with the unit.
    pub allowed: &'static str,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, allowed is {}", self.name, self.value, self.allowed)
    }
}

impl core::error::Error for Invalid {}

/// Accepts `value` if it is finite and `ok`, else says what is allowed.
pub(crate) fn require(ok: bool, name: &'static str, value: f32, allowed: &'static str) -> Result<(), Invalid> {
    if ok && value.is_finite() { Ok(()) } else { Err(Invalid { name, value, allowed }) }
}
