//! The body's own Green's function: what a load at one place of the surface moves at another, beyond the closed forms of [`kernel`].
//!
//! A tool computes it by finite elements, once per body, on the places of a [`Chart`]; ticks read it. Displacement under a load =
//! `kernel` + table, for the same place, the same outward normal and a disc of `patch_radius` (theory.md, section 11).
//!
//! Loads and moves at a place are four numbers: force along world x, y, z \[N\] and torque about the place's outward normal \[N m\]; displacement along
//! world x, y, z \[m\] and turn about the outward normal \[rad\].

pub mod chart;
pub mod drawn;
pub mod kernel;

use glam::Vec3;

use crate::error::{Invalid, require};
pub use chart::Chart;
use chart::{CELL, Cell};
pub use kernel::{Disc, Load, Move};

/// Numbers of a load, and of a move.
pub const COMPONENTS: usize = 4;

/// Numbers of the move at one place per load at one place.
pub const BLOCK: usize = COMPONENTS * COMPONENTS;

/// Moves per loads, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block(pub [f32; BLOCK]);

impl Block {
    /// Adds `more` to the shift along `t` per force along `u`.
    pub(crate) fn plus(mut self, t: Vec3, u: Vec3, more: f32) -> Self {
        for (i, t) in t.to_array().into_iter().enumerate() {
            for (j, u) in u.to_array().into_iter().enumerate() {
                if let Some(entry) = self.0.get_mut(COMPONENTS * i + j) {
                    *entry += more * t * u;
                }
            }
        }
        self
    }

    /// The move under a load.
    pub fn times(&self, load: &Load) -> Move {
        let row = |[x, y, z, t]: [f32; COMPONENTS]| x * load.force.x + y * load.force.y + z * load.force.z + t * load.torque;
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = self.0;
        Move { shift: Vec3::new(row([a, b, c, d]), row([e, f, g, h]), row([i, j, k, l])), turn: row([m, n, o, p]) }
    }
}

/// A body's table, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Green<'a> {
    chart: Chart,
    patch_radius: f32,
    own: &'a [f32],
    table: &'a [f32],
}

/// Everything a [`Green`] is made from.
#[derive(Clone, Copy, Debug)]
pub struct GreenSpec<'a> {
    /// The places.
    pub chart: Chart,
    /// Radius of the loaded discs the table was computed with \[m\].
    pub patch_radius: f32,
    /// Mean move of each loaded disc itself beyond the stiffnesses of the half space: 16 numbers per place, row = move, column = load.
    pub own: &'a [f32],
    /// Moves of all places: a square of 4 x places rows (moves) and as many columns (loads), row by row.
    pub table: &'a [f32],
}

impl<'a> Green<'a> {
    /// Validates the spec.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(spec: &GreenSpec<'a>) -> Result<Self, Invalid> {
        spec.chart.check()?;
        let side = COMPONENTS * spec.chart.places();
        require(spec.patch_radius > 0.0 && spec.patch_radius.is_finite(), "green.patch_radius", spec.patch_radius, "above 0 m")?;
        let wrong = |length: usize| length as f32;
        require(
            spec.own.len() == BLOCK * spec.chart.places(),
            "green.own (length)",
            wrong(spec.own.len()),
            "16 numbers per place",
        )?;
        require(spec.table.len() == side * side, "green.table (length)", wrong(spec.table.len()), "(4 x places)^2 numbers")?;
        let odd = spec.own.iter().chain(spec.table).find(|number| !number.is_finite());
        require(odd.is_none(), "green.table", odd.copied().unwrap_or(0.0), "finite numbers")?;
        Ok(Self { chart: spec.chart, patch_radius: spec.patch_radius, own: spec.own, table: spec.table })
    }

    /// The chart.
    pub fn chart(&self) -> &Chart {
        &self.chart
    }

    /// Radius of the discs the table was computed with \[m\].
    pub fn patch_radius(&self) -> f32 {
        self.patch_radius
    }

    /// Move of the loaded disc at the surface place `p_w` itself, row by row.
    pub fn own(&self, p_w: Vec3) -> Block {
        let cell = self.chart.cell(p_w);
        let mut sum = [0.0; BLOCK];
        for (place, weight) in cell.place.into_iter().zip(cell.weight) {
            let block = self.own.get(BLOCK * place..BLOCK * (place + 1)).unwrap_or(&[]);
            sum.iter_mut().zip(block).for_each(|(sum, value)| *sum += weight * value);
        }
        Block(sum)
    }

    /// What the table adds at the nodes of `at` when the nodes of `loaded` share `load` by their weights.
    pub fn respond(&self, at: &Cell, loaded: &Cell, load: &Load) -> Move {
        let mut sum = [0.0; COMPONENTS];
        for (row, weight) in at.place.into_iter().zip(at.weight) {
            let found = self.at_node(row, loaded, load);
            sum.iter_mut().zip(found).for_each(|(sum, value)| *sum += weight * value);
        }
        let [x, y, z, turn] = sum;
        Move { shift: Vec3::new(x, y, z), turn }
    }

    /// What the table adds at one node.
    pub fn at_node(&self, node: usize, loaded: &Cell, load: &Load) -> [f32; COMPONENTS] {
        let side = COMPONENTS * self.chart.places();
        let load = [load.force.x, load.force.y, load.force.z, load.torque];
        let mut rows = self.table.chunks_exact(side.max(1)).skip(COMPONENTS * node);
        let mut found = [0.0; COMPONENTS];
        for (value, row) in found.iter_mut().zip(&mut rows) {
            for k in 0..CELL {
                let start = COMPONENTS * loaded.place[k];
                let entries = row.get(start..start + COMPONENTS).unwrap_or(&[]);
                let part = entries.iter().zip(load).fold(0.0, |sum, (entry, load)| sum + entry * load);
                *value += loaded.weight[k] * part;
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_the_wrong_length_is_refused() {
        let chart = Chart { centre: Vec3::ZERO, half_size: Vec3::ONE, per_edge: 3 };
        let own = [0.0; BLOCK * 26];
        let refused = Green::new(&GreenSpec { chart, patch_radius: 0.01, own: &own, table: &own });
        assert_eq!(refused.unwrap_err().name, "green.table (length)");
    }
}
