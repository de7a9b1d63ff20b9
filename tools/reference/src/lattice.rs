//! Where the cells of a patch are: a rectangle of equal squares about the patch's middle.
//!
//! Every field of a patch (pressure, tractions) is a vector over the whole rectangle, row by row along y, zero where nothing touches. Rows are
//! padded to whole groups of [`LANES`] so that sums over a row need no remainder.

use std::f64::consts::PI;

/// Numbers that are summed side by side: what the widest registers in common use hold.
pub const LANES: usize = 4;

/// Equal squares in rows and columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Columns, along x.
    pub columns: usize,
    /// Rows, along y.
    pub rows: usize,
    /// Edge of a cell, in the unit of length in use.
    pub edge: f64,
}

impl Lattice {
    /// `across` x `across` cells of edge `edge`.
    ///
    /// # Panics
    /// If `across` is below 4, which has no rim, or `edge` is not above zero.
    #[must_use]
    pub fn square(across: usize, edge: f64) -> Self {
        Self::new(across, across, edge)
    }

    /// `columns` x `rows` cells of edge `edge`.
    ///
    /// # Panics
    /// As [`Self::square`].
    #[must_use]
    pub fn new(columns: usize, rows: usize, edge: f64) -> Self {
        assert!(columns >= 4 && rows >= 4, "columns = {columns}, rows = {rows}, allowed 4 or more");
        assert!(edge > 0.0, "edge = {edge}, allowed above 0");
        Self { columns, rows, edge }
    }

    /// `across` x `across` cells over a disc of `radius`, scaled until the cells whose centre lies on the disc cover its area, so that the
    /// stepped rim neither adds nor loses contact.
    ///
    /// # Panics
    /// As [`Self::square`].
    #[must_use]
    pub fn over_disc(across: usize, radius: f64) -> Self {
        let unit = Self::square(across, 1.0);
        let kept = unit.cells().filter(|&(_, [x, y])| x.hypot(y) < 0.5 * across as f64).count();
        Self { edge: radius * (PI / kept as f64).sqrt(), ..unit }
    }

    /// Length of a padded row.
    #[must_use]
    pub fn stride(&self) -> usize {
        self.columns.next_multiple_of(LANES)
    }

    /// Length of a field over the lattice.
    #[must_use]
    pub fn len(&self) -> usize {
        self.stride() * self.rows
    }

    /// Never: a lattice has at least sixteen cells.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Area of a cell.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.edge * self.edge
    }

    /// Every cell: its index in a field and its centre (x, y) from the patch's middle.
    pub fn cells(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        (0..self.rows)
            .flat_map(move |row| (0..self.columns).map(move |column| (row * self.stride() + column, self.centre(column, row))))
    }

    /// Centre of one cell.
    fn centre(&self, column: usize, row: usize) -> [f64; 2] {
        [
            (column as f64 - 0.5 * (self.columns as f64 - 1.0)) * self.edge,
            (row as f64 - 0.5 * (self.rows as f64 - 1.0)) * self.edge,
        ]
    }
}
