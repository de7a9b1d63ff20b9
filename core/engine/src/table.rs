//! The section of the body's own Green's function.

use haptor_contact::green::{BLOCK, Chart, Green, GreenSpec};
use haptor_contact::{Invalid, Vec3};
use haptor_wire::sections;

use crate::error::SceneError;

/// The body's own Green's function as a file carries it: made before the real-time thread starts, and locked in memory with the rest.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    chart: Chart,
    patch_radius: f32,
    /// Own moves, then the table.
    numbers: Vec<f32>,
    /// How many of them are own moves.
    own: usize,
}

/// Numbers of a table's section before the own moves.
const TABLE_HEAD: usize = 8;

impl Table {
    /// Reads and checks the section.
    pub fn new(contents: &[u8]) -> Result<Self, SceneError> {
        let wrong = |what| SceneError::Section { kind: sections::GREEN, what };
        let mut numbers = sections::numbers(contents).ok_or_else(|| wrong("its length is no multiple of four"))?;
        let mut head = [0.0; TABLE_HEAD];
        for slot in &mut head {
            *slot = numbers.next().ok_or_else(|| wrong("it ends within its head"))?;
        }
        let [x, y, z, hx, hy, hz, patch_radius, nodes] = head;
        let per_edge =
            [3_u8, 5, 7, 9].into_iter().find(|&n| f32::from(n) == nodes).ok_or_else(|| wrong("3, 5, 7 or 9 nodes an edge"))?;
        let chart = Chart { centre: Vec3::new(x, y, z), half_size: Vec3::new(hx, hy, hz), per_edge: usize::from(per_edge) };
        let table = Self { chart, patch_radius, own: BLOCK * chart.places(), numbers: numbers.collect() };
        if table.numbers.len() < table.own {
            return Err(wrong("it ends within the own moves"));
        }
        table.green()?;
        Ok(table)
    }

    /// What the core borrows.
    pub fn green(&self) -> Result<Green<'_>, Invalid> {
        let (own, table) = self.numbers.split_at(self.own);
        Green::new(&GreenSpec { chart: self.chart, patch_radius: self.patch_radius, own, table })
    }
}
