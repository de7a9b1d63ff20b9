//! The influence of one cell on every other, for a Poisson's ratio: a table over offsets that every patch reads from.

use crate::tier::influence::table::{ALONG, CROSS, REACH};

/// Columns of a row of the kernel: offsets from -(`REACH` - 1) to `REACH` - 1, and one unused.
const COLUMNS: usize = 2 * REACH;

/// Displacement per force between cells of a window `W` wide, times 2 pi G h: row = offset along y (not negative), column = offset along x
/// plus W - 1. The mixed influence is odd in the offset along y, the others even.
#[derive(Clone, Debug)]
pub struct Kernel<const W: usize> {
    xx: [[f32; COLUMNS]; W],
    xy: [[f32; COLUMNS]; W],
    yy: [[f32; COLUMNS]; W],
}

/// One row of the kernel: what the cells of a row of the window feel of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, const W: usize> {
    /// x from x.
    pub xx: &'a [f32; W],
    /// x from y and y from x, up to the sign of the offset along y.
    pub xy: &'a [f32; W],
    /// y from y.
    pub yy: &'a [f32; W],
}

impl<const W: usize> Kernel<W> {
    /// Kernel for Poisson's ratio `nu`: x x = int x^2/r^3 + (1 - nu) int y^2/r^3, x y = nu int x y/r^3.
    pub fn new(nu: f32) -> Self {
        const { assert!(W <= REACH) };
        let mut kernel = Self { xx: [[0.0; COLUMNS]; W], xy: [[0.0; COLUMNS]; W], yy: [[0.0; COLUMNS]; W] };
        for j in 0..W {
            for i in 0..W {
                let (x2, y2) = (ALONG[j][i], ALONG[i][j]);
                let (ahead, behind) = (W - 1 + i, W - 1 - i);
                let (xx, xy, yy) = (x2 + (1.0 - nu) * y2, nu * CROSS[j][i], y2 + (1.0 - nu) * x2);
                (kernel.xx[j][ahead], kernel.xx[j][behind]) = (xx, xx);
                (kernel.yy[j][ahead], kernel.yy[j][behind]) = (yy, yy);
                (kernel.xy[j][ahead], kernel.xy[j][behind]) = (xy, -xy);
            }
        }
        kernel
    }

    /// Influence of a cell on itself, the same in every direction.
    pub fn own(&self) -> f32 {
        self.xx[0][W - 1]
    }

    /// What a row of cells feels of the cell in column `column`, `up` rows away, at most W - 1.
    pub fn rows(&self, up: usize, column: usize) -> Rows<'_, W> {
        let up = up.min(W - 1);
        Rows { xx: window(&self.xx[up], column), xy: window(&self.xy[up], column), yy: window(&self.yy[up], column) }
    }
}

/// Columns of offsets -`column` to W - 1 - `column`.
fn window<const W: usize>(row: &[f32; COLUMNS], column: usize) -> &[f32; W] {
    row.get((W - 1).saturating_sub(column)..).and_then(|rest| rest.first_chunk()).unwrap_or(&[0.0; W])
}
