//! The table of a body's own Green's function, which tier `green` reads: computed once per body, kept in the user's cache folder.

use haptor_contact::Tier;
use haptor_contact::green::GreenSpec;

use crate::failure::Failure;
use crate::scene::Scene;

#[cfg(feature = "fem")]
pub use haptor_mesh::green::GreenTable as Table;

/// A build without finite elements has no table.
#[cfg(not(feature = "fem"))]
#[derive(Debug)]
pub enum Table {}

#[cfg(not(feature = "fem"))]
impl Table {
    /// What the core borrows.
    pub fn spec(&self) -> GreenSpec<'_> {
        match *self {}
    }
}

/// The table of the scene's body, when `tier` reads one. A bar on standard error shows what is computed; what the cache folder refuses is said there
/// and does no harm.
///
/// # Errors
/// [`Failure::BadInput`] when the body has no table; `name` is the scene's in messages.
#[cfg(feature = "fem")]
pub fn of(scene: &Scene, tier: Tier, name: &str) -> Result<Option<Table>, Failure> {
    use haptor_mesh::green::{GreenInputs, GreenOptions, cache};
    use haptor_mesh::kept::Keep;

    if tier != Tier::Green {
        return Ok(None);
    }
    let (shape, material) = (scene.object.shape, scene.object.material);
    if scene.object.skin.is_some() {
        return Err(Failure::bad_input(format!("{name}: tier green: a mesh has no table of its own; choose tier influence")));
    }
    let fixed_below = scene.object.fixed_below.unwrap_or(shape.default_fixed_below());
    let inputs = GreenInputs { shape, material, fixed_below, options: GreenOptions::default() };
    let bar = crate::progress::bar(0, "the body's table");
    let mut progress = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
    };
    let fetched = cache::fetch(&inputs, Table::KIND.folder().as_deref(), &mut progress);
    bar.finish_and_clear();
    let fetched = fetched.map_err(|error| Failure::bad_input(format!("{name}: tier green: {error}")))?;
    if let Some(trouble) = fetched.trouble {
        eprintln!("haptor: the body's table was computed, but the cache is of no use: {trouble}");
    }
    Ok(Some(fetched.result))
}

/// A build without finite elements refuses the tier by name.
#[cfg(not(feature = "fem"))]
pub fn of(_: &Scene, tier: Tier, name: &str) -> Result<Option<Table>, Failure> {
    if tier != Tier::Green {
        return Ok(None);
    }
    Err(Failure::bad_input(format!(
        "{name}: tier green: this build has no finite elements; build haptor with its default features"
    )))
}

/// The table as the contents of a section of a baked file (`core/wire/WIRE.md`).
pub fn contents(spec: &GreenSpec<'_>) -> Vec<u8> {
    let chart = &spec.chart;
    let head = [spec.patch_radius, chart.per_edge as f32];
    let places = [chart.centre.to_array(), chart.half_size.to_array()];
    let numbers = places.as_flattened().iter().chain(&head).chain(spec.own).chain(spec.table);
    numbers.flat_map(|number| number.to_le_bytes()).collect()
}
