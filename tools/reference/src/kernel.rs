//! Displacement of an elastic half space under squares of uniform pressure and traction.
//!
//! Boussinesq and Cerruti for a point force on the surface, shear modulus G, Poisson's ratio nu, (x, y) from the force to the point, z into
//! the body:
//!
//! ```text
//! u_x = [(1 - nu)/r + nu x^2/r^3] Q_x / (2 pi G) + nu x y/r^3 Q_y / (2 pi G) - (1 - 2 nu) x/r^2 P / (4 pi G)
//! u_z = (1 - nu)/r P / (2 pi G) + (1 - 2 nu) (x Q_x + y Q_y)/r^2 / (4 pi G)
//! ```
//!
//! Each term has a closed integral over a rectangle, so that the influence of a cell on itself is exact too.

use std::f64::consts::PI;

use crate::lattice::{LANES, Lattice};

/// Elastic constants of the half space; the probe is rigid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Shear modulus G, in the unit of pressure in use.
    pub shear_modulus: f64,
    /// Poisson's ratio nu, 0 to 0.5.
    pub poisson_ratio: f64,
}

impl Solid {
    /// E/(1 - nu^2) = 2 G/(1 - nu), the modulus against a rigid probe.
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        2.0 * self.shear_modulus / (1.0 - self.poisson_ratio)
    }
}

/// Influence of one cell on one point: displacement per unit traction or pressure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Influence {
    /// Along x per traction along x.
    pub xx: f64,
    /// Along x per traction along y, and along y per x.
    pub xy: f64,
    /// Along y per traction along y.
    pub yy: f64,
    /// Into the body per pressure.
    pub zz: f64,
    /// Along x per pressure; the opposite is what a traction along x sinks the point by.
    pub xz: f64,
    /// Along y per pressure, likewise.
    pub yz: f64,
}

/// Influence at a point `offset` away from the centre of a square cell of edge `edge`.
#[must_use]
pub fn influence(solid: Solid, offset: [f64; 2], edge: f64) -> Influence {
    let mut sum = [0.0; 5];
    for (sign_x, x) in [(-1.0, offset[0] - 0.5 * edge), (1.0, offset[0] + 0.5 * edge)] {
        for (sign_y, y) in [(-1.0, offset[1] - 0.5 * edge), (1.0, offset[1] + 0.5 * edge)] {
            for (total, term) in sum.iter_mut().zip(corner_terms(x, y)) {
                *total += sign_x * sign_y * term;
            }
        }
    }
    let [along_x, along_y, cross, out_x, out_y] = sum;
    let nu = solid.poisson_ratio;
    let scale = 1.0 / (2.0 * PI * solid.shear_modulus);
    Influence {
        xx: scale * (along_x + (1.0 - nu) * along_y),
        xy: scale * nu * cross,
        yy: scale * (along_y + (1.0 - nu) * along_x),
        zz: scale * (1.0 - nu) * (along_x + along_y),
        xz: -0.5 * scale * (1.0 - 2.0 * nu) * out_x,
        yz: -0.5 * scale * (1.0 - 2.0 * nu) * out_y,
    }
}

/// Corner values of the integrals of x^2/r^3, y^2/r^3, x y/r^3, x/r^2 and y/r^2; their mixed derivative is the integrand.
fn corner_terms(x: f64, y: f64) -> [f64; 5] {
    let grown = |s: f64, c: f64| if s == 0.0 { 0.0 } else { s * (c / s.abs()).asinh() };
    let turned = |s: f64, c: f64| {
        let log = if s == 0.0 { 0.0 } else { 0.5 * s * (s * s + c * c).ln() };
        if c == 0.0 { log } else { log + c * (s / c).atan() }
    };
    [grown(y, x), grown(x, y), -x.hypot(y), turned(y, x), turned(x, y)]
}

/// The influences between all cells of a lattice, by their offset in cells: every offset once, since the half space is the same everywhere.
///
/// A row holds the offsets of one dy, dx falling, so that the sum over a row of cells runs through table and field in the same direction.
#[derive(Debug, Clone)]
pub struct Kernels {
    lattice: Lattice,
    xx: Vec<f64>,
    xy: Vec<f64>,
    yy: Vec<f64>,
    zz: Vec<f64>,
    xz: Vec<f64>,
    yz: Vec<f64>,
    own: Influence,
}

impl Kernels {
    /// Fills the tables.
    #[must_use]
    pub fn new(solid: Solid, lattice: Lattice) -> Self {
        let (columns, rows, width) = (lattice.columns, lattice.rows, 2 * lattice.stride());
        let blank = vec![0.0; width * (2 * rows - 1)];
        let [mut xx, mut xy, mut yy, mut zz, mut xz, mut yz] = std::array::from_fn(|_| blank.clone());
        for row in 0..2 * rows - 1 {
            for k in 0..2 * columns - 1 {
                let offset = [columns as f64 - 1.0 - k as f64, row as f64 - (rows as f64 - 1.0)];
                let found = influence(solid, offset.map(|c| c * lattice.edge), lattice.edge);
                let at = row * width + k;
                (xx[at], xy[at], yy[at]) = (found.xx, found.xy, found.yy);
                (zz[at], xz[at], yz[at]) = (found.zz, found.xz, found.yz);
            }
        }
        Self { lattice, xx, xy, yy, zz, xz, yz, own: influence(solid, [0.0; 2], lattice.edge) }
    }

    /// Influence of a cell on itself.
    #[must_use]
    pub fn own(&self) -> Influence {
        self.own
    }

    /// Level displacement of cell `index` under tractions.
    #[must_use]
    pub fn level(&self, index: usize, [qx, qy]: [&[f64]; 2]) -> [f64; 2] {
        let [x, xy] = self.sum(index, [&self.xx, &self.xy], [qx, qy]);
        let [yx, y] = self.sum(index, [&self.xy, &self.yy], [qx, qy]);
        [x + xy, yx + y]
    }

    /// Level displacement of cell `index` under pressure.
    #[must_use]
    pub fn level_of_pressure(&self, index: usize, p: &[f64]) -> [f64; 2] {
        self.sum(index, [&self.xz, &self.yz], [p, p])
    }

    /// How far cell `index` sinks under pressure.
    #[must_use]
    pub fn sunk(&self, index: usize, p: &[f64]) -> f64 {
        self.sum(index, [&self.zz, &self.zz], [p, &[]])[0]
    }

    /// How far cell `index` sinks under tractions.
    #[must_use]
    pub fn sunk_by_tractions(&self, index: usize, q: [&[f64]; 2]) -> f64 {
        let [x, y] = self.sum(index, [&self.xz, &self.yz], q);
        -(x + y)
    }

    /// The sum of table times field over all cells, for two tables at once; an empty field counts as zero.
    fn sum(&self, index: usize, tables: [&[f64]; 2], fields: [&[f64]; 2]) -> [f64; 2] {
        let (stride, rows) = (self.lattice.stride(), self.lattice.rows);
        let (column, row) = (index % stride, index / stride);
        let one = |table: &[f64], field: &[f64]| {
            let mut sums = [0.0; LANES];
            for (acting, values) in field.chunks_exact(stride).enumerate() {
                let start = (row + rows - 1 - acting) * 2 * stride + self.lattice.columns - 1 - column;
                let weights = &table[start..start + stride];
                for (w, v) in weights.chunks_exact(LANES).zip(values.chunks_exact(LANES)) {
                    for lane in 0..LANES {
                        sums[lane] += w[lane] * v[lane];
                    }
                }
            }
            sums.iter().sum::<f64>()
        };
        [one(tables[0], fields[0]), one(tables[1], fields[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOLID: Solid = Solid { shear_modulus: 1.0, poisson_ratio: 0.3 };

    #[test]
    fn a_far_cell_acts_as_a_point_force() {
        let (x, y, edge) = (30.0, 40.0, 1.0);
        let got = influence(SOLID, [x, y], edge);
        let (r, nu) = (f64::hypot(x, y), SOLID.poisson_ratio);
        let want = Influence {
            xx: ((1.0 - nu) / r + nu * x * x / r.powi(3)) / (2.0 * PI),
            xy: nu * x * y / r.powi(3) / (2.0 * PI),
            yy: ((1.0 - nu) / r + nu * y * y / r.powi(3)) / (2.0 * PI),
            zz: (1.0 - nu) / r / (2.0 * PI),
            xz: -(1.0 - 2.0 * nu) * x / (r * r) / (4.0 * PI),
            yz: -(1.0 - 2.0 * nu) * y / (r * r) / (4.0 * PI),
        };
        let pairs =
            [(got.xx, want.xx), (got.xy, want.xy), (got.yy, want.yy), (got.zz, want.zz), (got.xz, want.xz), (got.yz, want.yz)];
        for (found, expected) in pairs {
            assert!((found / expected - 1.0).abs() < 1e-3, "{got:?} {want:?}");
        }
    }

    #[test]
    fn own_influence_is_the_integral_of_one_over_r() {
        // a square of edge e has integral of 1/r over itself = 4 e asinh(1)
        let own = influence(SOLID, [0.0, 0.0], 0.1);
        let integral = 4.0 * 0.1 * 1.0_f64.asinh() / (2.0 * PI);
        let want = (1.0 - 0.5 * SOLID.poisson_ratio) * integral;
        assert!((own.xx - want).abs() < 1e-12 && (own.yy - want).abs() < 1e-12);
        assert!((own.zz - (1.0 - SOLID.poisson_ratio) * integral).abs() < 1e-12);
        assert!(own.xy.abs() + own.xz.abs() + own.yz.abs() < 1e-15);
    }

    #[test]
    fn tables_give_the_plain_double_sum() {
        let lattice = Lattice::new(6, 5, 0.2);
        let kernels = Kernels::new(SOLID, lattice);
        let mut fields: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; lattice.len()]);
        for (index, [x, y]) in lattice.cells() {
            fields[0][index] = 1.0 + x;
            fields[1][index] = x * y - 0.3;
            fields[2][index] = 2.0 - y;
        }
        let [qx, qy, p] = &fields;
        for (index, [x, y]) in lattice.cells() {
            let mut want = [0.0; 3];
            for (from, [ax, ay]) in lattice.cells() {
                let k = influence(SOLID, [x - ax, y - ay], lattice.edge);
                want[0] += k.xx * qx[from] + k.xy * qy[from] + k.xz * p[from];
                want[1] += k.xy * qx[from] + k.yy * qy[from] + k.yz * p[from];
                want[2] += k.zz * p[from] - k.xz * qx[from] - k.yz * qy[from];
            }
            let (level, pressed) = (kernels.level(index, [qx, qy]), kernels.level_of_pressure(index, p));
            let sunk = kernels.sunk(index, p) + kernels.sunk_by_tractions(index, [qx, qy]);
            let got = [level[0] + pressed[0], level[1] + pressed[1], sunk];
            assert!((0..3).all(|k| (got[k] - want[k]).abs() < 1e-12), "{got:?} {want:?}");
        }
    }
}
