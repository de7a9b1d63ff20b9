//! Tables kept in the user's cache folder: computed once per body, found again ever after.

use std::path::Path;

use super::{GreenError, GreenInputs, GreenTable};
use crate::kept::{self, Fetched};

/// The table of `inputs` from `folder`, computed and kept there if it is missing or damaged; `None` keeps nothing.
///
/// # Errors
/// [`GreenError`] names what cannot be computed.
pub fn fetch(
    inputs: &GreenInputs,
    folder: Option<&Path>,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Fetched<GreenTable>, GreenError> {
    kept::fetch(&inputs.key(), folder, || GreenTable::compute(inputs, progress))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::green::GreenOptions;
    use crate::kept::Keep;
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
        assert!(!second.computed && second.result == first.result);
        std::fs::write(GreenTable::KIND.path(folder.path(), &inputs.key()), b"haptgrn").unwrap();
        let third = fetch();
        assert!(third.computed && third.trouble.is_some() && third.result == first.result);
        assert!(!fetch().computed);
    }
}
