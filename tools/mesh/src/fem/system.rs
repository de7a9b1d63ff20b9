//! Assembly and solution: one symmetric sparse matrix, one Cholesky factor, several loads.
//!
//! Unknown 3 n + i is displacement component i of node n. Held unknowns leave the matrix; their values move to the right-hand side.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

use super::FemError;
use super::bricks::Bricks;
use super::element::{Lame, NODES, UNKNOWNS, stiffness};

/// Most unknowns of one run: keeps the factor below some 2 GB and the run below some minutes on one core.
pub(crate) const MAX_UNKNOWNS: usize = 45_000;

/// The stiffness of a body, brick by brick.
pub(crate) struct Stiffness<'m> {
    mesh: &'m Bricks,
    parts: Vec<Vec<f64>>,
}

/// A factored system in which some unknowns are held.
pub(crate) struct Factored<'s, 'm> {
    whole: &'s Stiffness<'m>,
    /// Row of each unknown in the matrix; `None` when held.
    row: Vec<Option<u32>>,
    factor: faer::sparse::linalg::solvers::Llt<usize, f64>,
    free: usize,
}

impl<'m> Stiffness<'m> {
    pub(crate) fn new(mesh: &'m Bricks, lame: Lame) -> Result<Self, FemError> {
        if 3 * mesh.nodes.len() > MAX_UNKNOWNS {
            return Err(FemError::TooFine { unknowns: 3 * mesh.nodes.len(), limit: MAX_UNKNOWNS });
        }
        let part = |brick| stiffness(&mesh.corners(brick), lame).ok_or(FemError::Folded);
        let parts = mesh.bricks.iter().map(part).collect::<Result<_, _>>()?;
        Ok(Self { mesh, parts })
    }

    fn unknowns(brick: &[u32; NODES]) -> impl Iterator<Item = usize> {
        brick.iter().flat_map(|&node| (0..3).map(move |i| 3 * node as usize + i))
    }

    /// K u.
    pub(crate) fn times(&self, u: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; u.len()];
        for (brick, part) in self.mesh.bricks.iter().zip(&self.parts) {
            let local: [f64; UNKNOWNS] = std::array::from_fn(|n| u[3 * brick[n / 3] as usize + n % 3]);
            if local == [0.0; UNKNOWNS] {
                continue;
            }
            for (unknown, row) in Self::unknowns(brick).zip(part.chunks_exact(UNKNOWNS)) {
                force[unknown] += row.iter().zip(&local).map(|(k, u)| k * u).sum::<f64>();
            }
        }
        force
    }

    /// Factors the system with the unknowns of `held` taken out.
    pub(crate) fn factor(&self, held: &[bool]) -> Result<Factored<'_, 'm>, FemError> {
        let mut free = 0_u32;
        let row: Vec<Option<u32>> = held.iter().map(|&held| (!held).then(|| (free, free += 1).0)).collect();
        let free = free as usize;
        let matrix = self.matrix(&row, free)?;
        let factor = matrix.sp_cholesky(Side::Lower).map_err(|_| FemError::Unstable)?;
        Ok(Factored { whole: self, row, factor, free })
    }

    /// Lower triangle, column by column.
    fn matrix(&self, row: &[Option<u32>], free: usize) -> Result<SparseColMat<usize, f64>, FemError> {
        let mut columns: Vec<Vec<u32>> = vec![Vec::new(); free];
        for brick in &self.mesh.bricks {
            let rows: Vec<u32> = Self::unknowns(brick).filter_map(|n| row[n]).collect();
            for &column in &rows {
                columns[column as usize].extend(rows.iter().filter(|&&r| r >= column));
            }
        }
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
        }
        let mut starts = vec![0_usize];
        starts.extend(columns.iter().scan(0, |sum, column| {
            *sum += column.len();
            Some(*sum)
        }));
        let mut values = vec![0.0; starts[free]];
        for (brick, part) in self.mesh.bricks.iter().zip(&self.parts) {
            let rows: Vec<Option<u32>> = Self::unknowns(brick).map(|n| row[n]).collect();
            for (j, column) in rows.iter().enumerate() {
                let Some(column) = column.map(|c| c as usize) else { continue };
                for (i, r) in rows.iter().enumerate() {
                    if let Some(r) = r.filter(|&r| r as usize >= column) {
                        let place = columns[column].partition_point(|&other| other < r);
                        values[starts[column] + place] += part[i * UNKNOWNS + j];
                    }
                }
            }
        }
        let rows = columns.into_iter().flatten().map(|r| r as usize).collect();
        Ok(SparseColMat::new(SymbolicSparseColMat::new_checked(free, free, starts, None, rows), values))
    }
}

impl Factored<'_, '_> {
    /// Displacement under nodal forces `load`, the held unknowns at their values in `u_held` (zero elsewhere).
    pub(crate) fn solve(&self, load: &[f64], u_held: &[f64]) -> Vec<f64> {
        self.solve_many(&[load.to_vec()], &[u_held.to_vec()]).pop().unwrap_or_default()
    }

    /// The same for several loads at once.
    pub(crate) fn solve_many(&self, loads: &[Vec<f64>], u_held: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut right = Mat::<f64>::zeros(self.free, loads.len());
        for (column, (load, held)) in loads.iter().zip(u_held).enumerate() {
            let moved = self.whole.times(held);
            for (unknown, row) in self.row.iter().enumerate() {
                if let Some(row) = row {
                    right[(*row as usize, column)] = load[unknown] - moved[unknown];
                }
            }
        }
        self.factor.solve_in_place(&mut right);
        let one = |(column, held): (usize, &Vec<f64>)| {
            let value = |(unknown, row): (usize, &Option<u32>)| row.map_or(held[unknown], |row| right[(row as usize, column)]);
            self.row.iter().enumerate().map(value).collect()
        };
        u_held.iter().enumerate().map(one).collect()
    }
}
