//! Green's tables of the bodies that several proofs share, each computed once in a program: seconds of finite elements.

use std::collections::BTreeMap;
use std::sync::Mutex;

use haptor_contact::{Green, Material, ObjectShape};
use haptor_mesh::green::{GreenInputs, GreenOptions, GreenTable};

/// Tables by the digest of their inputs.
static TABLES: Mutex<BTreeMap<[u8; 32], &'static GreenTable>> = Mutex::new(BTreeMap::new());

/// The table of a body held at its default height.
///
/// # Panics
/// When there is none: the bodies of the proofs have one.
pub fn table(shape: ObjectShape<'static>, material: Material) -> &'static GreenTable {
    let inputs = GreenInputs { shape, material, fixed_below: shape.default_fixed_below(), options: GreenOptions::default() };
    // who asks for a body that is being computed waits for it
    let mut tables = TABLES.lock().expect("nobody panicked");
    tables
        .entry(inputs.key().0)
        .or_insert_with(|| Box::leak(Box::new(GreenTable::compute(&inputs, &mut |_, _| ()).expect("a table"))))
}

/// The same as the core borrows it.
///
/// # Panics
/// As [`table`].
pub fn green(shape: ObjectShape<'static>, material: Material) -> Green<'static> {
    Green::new(&table(shape, material).spec()).expect("a table that the core takes")
}
