//! Displacement of an elastic half space under squares of uniform tangential traction.
//!
//! Cerruti's kernel for a tangential point force on the surface, shear modulus G, Poisson's ratio nu:
//! u_x = [(1 - nu)/r + nu x^2/r^3] q_x / (2 pi G) + [nu x y / r^3] q_y / (2 pi G). Each term has a closed integral over a
//! rectangle, so that the influence of a cell on itself is exact too. Lengths in contact radii, G = 1.

use std::f64::consts::PI;

/// Poisson's ratio of the reference: at 0.5 normal and tangential problems do not disturb each other.
pub const POISSON: f64 = 0.5;

/// The square cells whose centre lies on the unit disc.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Edge of a cell, in contact radii.
    pub edge: f64,
    /// Cell centres (x, y), in contact radii.
    pub centres: Vec<[f64; 2]>,
}

impl Grid {
    /// Cuts the disc's bounding square into `across` x `across` cells, keeps those centred on the disc, and scales
    /// them until they cover the disc's area, so that the stepped rim neither adds nor loses contact.
    ///
    /// # Panics
    /// If `across` is below 4: coarser grids have no rim.
    #[must_use]
    pub fn new(across: usize) -> Self {
        assert!(across >= 4, "across = {across}, allowed 4 or more");
        let at = |i: usize| i as f64 + 0.5 - 0.5 * across as f64;
        let kept =
            (0..across * across).map(|k| [at(k % across), at(k / across)]).filter(|[x, y]| x.hypot(*y) < 0.5 * across as f64);
        let cells: Vec<[f64; 2]> = kept.collect();
        let edge = (PI / cells.len() as f64).sqrt();
        let centres = cells.iter().map(|c| c.map(|x| x * edge)).collect();
        Self { edge, centres }
    }
}

/// Influence of one cell on one point: displacement per unit traction, symmetric 2 x 2 [a/G].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Influence {
    /// x displacement per x traction.
    pub xx: f64,
    /// x displacement per y traction, and y per x.
    pub xy: f64,
    /// y displacement per y traction.
    pub yy: f64,
}

/// Influence at a point `offset` away from the centre of a cell of edge `edge`.
///
/// The point must not share a coordinate with a cell edge (cell centres never do).
#[must_use]
pub fn influence(offset: [f64; 2], edge: f64) -> Influence {
    let mut sum = [0.0; 3];
    for (sign_x, x) in [(-1.0, offset[0] - 0.5 * edge), (1.0, offset[0] + 0.5 * edge)] {
        for (sign_y, y) in [(-1.0, offset[1] - 0.5 * edge), (1.0, offset[1] + 0.5 * edge)] {
            let corner = corner_terms(x, y);
            for (total, term) in sum.iter_mut().zip(corner) {
                *total += sign_x * sign_y * term;
            }
        }
    }
    let [along_x, along_y, cross] = sum;
    let scale = 1.0 / (2.0 * PI);
    Influence {
        xx: scale * (along_x + (1.0 - POISSON) * along_y),
        xy: scale * POISSON * cross,
        yy: scale * (along_y + (1.0 - POISSON) * along_x),
    }
}

/// Corner values of the integrals of x^2/r^3, y^2/r^3 and x y/r^3; their mixed derivative is the integrand.
fn corner_terms(x: f64, y: f64) -> [f64; 3] {
    [y * (x / y.abs()).asinh(), x * (y / x.abs()).asinh(), -x.hypot(y)]
}

/// The whole patch's influence matrix, stored as three dense blocks, row = feeling cell.
#[derive(Debug, Clone)]
pub struct Matrix {
    /// Number of cells.
    pub cells: usize,
    /// x from x, row by row.
    pub xx: Vec<f64>,
    /// x from y and y from x, row by row.
    pub xy: Vec<f64>,
    /// y from y, row by row.
    pub yy: Vec<f64>,
}

impl Matrix {
    /// Fills the matrix for every pair of cells of `grid`.
    #[must_use]
    pub fn new(grid: &Grid) -> Self {
        let cells = grid.centres.len();
        let mut out = Self { cells, xx: Vec::new(), xy: Vec::new(), yy: Vec::new() };
        for feels in &grid.centres {
            for acts in &grid.centres {
                let pair = influence([feels[0] - acts[0], feels[1] - acts[1]], grid.edge);
                out.xx.push(pair.xx);
                out.xy.push(pair.xy);
                out.yy.push(pair.yy);
            }
        }
        out
    }

    /// Displacement of cell `row` under the tractions `qx`, `qy` of all cells.
    #[must_use]
    pub fn displacement(&self, row: usize, qx: &[f64], qy: &[f64]) -> [f64; 2] {
        let span = row * self.cells..(row + 1) * self.cells;
        let (xx, xy, yy) = (&self.xx[span.clone()], &self.xy[span.clone()], &self.yy[span]);
        // four running sums let the compiler keep the additions in vector registers
        let mut ux = [0.0; 4];
        let mut uy = [0.0; 4];
        let whole = self.cells / 4 * 4;
        for base in (0..whole).step_by(4) {
            for lane in 0..4 {
                let j = base + lane;
                ux[lane] += xx[j] * qx[j] + xy[j] * qy[j];
                uy[lane] += xy[j] * qx[j] + yy[j] * qy[j];
            }
        }
        for j in whole..self.cells {
            ux[0] += xx[j] * qx[j] + xy[j] * qy[j];
            uy[0] += xy[j] * qx[j] + yy[j] * qy[j];
        }
        [ux.iter().sum(), uy.iter().sum()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_cell_acts_as_a_point_force() {
        let (x, y, edge) = (30.0, 40.0, 1.0);
        let got = influence([x, y], edge);
        let r = f64::hypot(x, y);
        let scale = edge * edge / (2.0 * PI);
        let want = scale * ((1.0 - POISSON) / r + POISSON * x * x / r.powi(3));
        assert!((got.xx / want - 1.0).abs() < 1e-3);
        assert!((got.xy / (scale * POISSON * x * y / r.powi(3)) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn own_influence_matches_the_integral_of_one_over_r() {
        // a square of edge e has integral of 1/r over itself = 4 e asinh(1)
        let own = influence([0.0, 0.0], 0.1);
        let want = (1.0 - 0.5 * POISSON) * 4.0 * 0.1 * 1.0_f64.asinh() / (2.0 * PI);
        assert!((own.xx - want).abs() < 1e-12 && (own.yy - want).abs() < 1e-12);
        assert!(own.xy.abs() < 1e-15);
    }

    #[test]
    fn matrix_is_symmetric() {
        let matrix = Matrix::new(&Grid::new(6));
        for i in 0..matrix.cells {
            for j in 0..matrix.cells {
                let (a, b) = (i * matrix.cells + j, j * matrix.cells + i);
                assert!((matrix.xx[a] - matrix.xx[b]).abs() < 1e-14);
                assert!((matrix.xy[a] - matrix.xy[b]).abs() < 1e-14);
            }
        }
    }
}
