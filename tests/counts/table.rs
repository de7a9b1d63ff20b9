//! A table for the box of the scenes: small numbers, so that reading it costs what any costs and moves next to nothing.

use haptor_contact::green::{BLOCK, COMPONENTS};
use haptor_contact::{Chart, Green, GreenSpec, Vec3};

/// Nodes along an edge of the chart: what a reading costs does not depend on it.
const PER_EDGE: usize = 3;

/// Every number of the table \[m/N\] and its kin: a thousandth of what the box yields.
const ENTRY: f32 = 1.0e-9;

/// The table. Its memory is the program's until it ends.
pub fn of_a_box() -> Green<'static> {
    let chart = Chart { centre: Vec3::Z * 0.05, half_size: Vec3::new(0.1, 0.1, 0.05), per_edge: PER_EDGE };
    let places = chart.places();
    let side = COMPONENTS * places;
    let (own, table) = (vec![ENTRY; BLOCK * places].leak(), vec![ENTRY; side * side].leak());
    Green::new(&GreenSpec { chart, patch_radius: 0.005, own, table }).expect("a table of the right size")
}
