//! A signed distance on a regular grid, read by cubic B-splines: value, gradient and second derivatives at any point.
//!
//! Terms: a **node** is a point of the grid, x running fastest; a **coefficient** belongs to a node. The distance is
//! phi(q) = sum c_ijk B(x - i) B(y - j) B(z - k) with (x, y, z) = (q - origin)/spacing and B the cubic B-spline, twice continuously
//! differentiable (theory.md, equation 2.4). The baking step solves for coefficients with which phi passes through the distances at the
//! nodes. A point costs 64 taps, never more. Lengths \[m\], frame of the mesh.

use glam::{Mat3, Vec3};

use crate::error::{Invalid, require};
use crate::geometry::field::Field;
use crate::limits::MAX_DISTANCE;
use crate::math::{direction, max, min, root};

/// Fewest nodes along an axis: three layers outside the solid on either side, and two for the solid.
pub const MIN_NODES: usize = 8;

/// Most nodes along an axis: 128 cubed are 8 MB, which a host's cache shares between cores and which is read once per session.
pub const MAX_NODES: usize = 128;

/// Layers of nodes on every side whose coefficients must lie outside the solid: the ones that the spline on the border reads.
pub const BORDER: usize = 3;

/// A borrowed, validated grid.
#[derive(Clone, Copy, PartialEq)]
pub struct DistanceGrid<'a> {
    origin: Vec3,
    spacing: f32,
    counts: [usize; 3],
    coefficients: &'a [f32],
    least: f32,
}

impl core::fmt::Debug for DistanceGrid<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { origin, spacing, counts, .. } = self;
        f.debug_struct("DistanceGrid")
            .field("origin", origin)
            .field("spacing", spacing)
            .field("counts", counts)
            .finish_non_exhaustive()
    }
}

/// Spacings a grid may have \[m\]: the range of a scene's lengths over the most nodes.
const SPACING_RANGE: core::ops::RangeInclusive<f32> = 1.0e-7..=1.0e1;

impl<'a> DistanceGrid<'a> {
    /// Validates a grid whose first node stands at `origin` \[m\], with `counts` nodes along x, y, z.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(origin: Vec3, spacing: f32, counts: [usize; 3], coefficients: &'a [f32]) -> Result<Self, Invalid> {
        for count in counts {
            require((MIN_NODES..=MAX_NODES).contains(&count), "mesh.grid (nodes along an axis)", count as f32, "8 to 128")?;
        }
        require(SPACING_RANGE.contains(&spacing), "mesh.grid (spacing)", spacing, "1e-7 to 10 m")?;
        let farthest = origin.length();
        require(farthest <= MAX_DISTANCE, "mesh.grid (origin)", farthest, "within 1e3 m")?;
        let [nx, ny, nz] = counts;
        let length = coefficients.len();
        require(length == nx * ny * nz, "mesh.grid (coefficients)", length as f32, "one for each node")?;
        let mut grid = Self { origin, spacing, counts, coefficients, least: 0.0 };
        grid.least = grid.checked_least()?;
        Ok(grid)
    }

    /// Least coefficient \[m\], after a look at every one.
    fn checked_least(&self) -> Result<f32, Invalid> {
        let [nx, ny, nz] = self.counts;
        let inner = |i: usize, n: usize| (BORDER..n - BORDER).contains(&i);
        let mut least = f32::MAX;
        for (index, &c) in self.coefficients.iter().enumerate() {
            require(c.abs() <= MAX_DISTANCE, "mesh.grid (coefficient)", c, "a finite distance within 1e3 m")?;
            let (x, y, z) = (index % nx, index / nx % ny, index / (nx * ny));
            let outside = !(inner(x, nx) && inner(y, ny) && inner(z, nz));
            require(
                !outside || c > 0.0,
                "mesh.grid (coefficient in the outer three layers)",
                c,
                "above 0: the solid keeps clear of the border",
            )?;
            least = min(least, c);
        }
        require(least < 0.0, "mesh.grid (least coefficient)", least, "below 0: the grid holds a solid")?;
        Ok(least)
    }

    /// Distance between neighbouring nodes \[m\].
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    /// Depth of the solid's inmost node \[m\], to a spacing.
    pub fn inmost(&self) -> f32 {
        -self.least
    }

    /// Signed distance and its derivatives at `q` \[m\].
    pub fn field(&self, q: Vec3) -> Field {
        let (cell, t, off) = self.place(q);
        let (value, gradient, hessian) = self.taps::<true>(cell, t);
        let (value, gradient) = beyond(value, gradient, off);
        Field { value, gradient, hessian }
    }

    /// Signed distance \[m\] and gradient at `q` \[m\]: the field at half the cost.
    pub fn slope(&self, q: Vec3) -> (f32, Vec3) {
        let (cell, t, off) = self.place(q);
        let (value, gradient, _) = self.taps::<false>(cell, t);
        beyond(value, gradient, off)
    }

    /// Cell, place in it (0 to 1), and the way \[m\] to `q` from the nearest point that the splines reach: zero within.
    fn place(&self, q: Vec3) -> ([usize; 3], Vec3, Vec3) {
        let u = (q - self.origin) / self.spacing;
        let [nx, ny, nz] = self.counts.map(|n| n as f32);
        // a coordinate that is not a number fails every comparison and is taken as the last node's
        let held = |u: f32, n: f32| max(min(u, n - 2.0), 1.0);
        let held = Vec3::new(held(u.x, nx), held(u.y, ny), held(u.z, nz));
        let floor = |u: f32, n: f32| min(u, n - 3.0) as usize;
        let cell = [floor(held.x, nx), floor(held.y, ny), floor(held.z, nz)];
        let [i, j, k] = cell.map(|i| i as f32);
        (cell, held - Vec3::new(i, j, k), (u - held) * self.spacing)
    }

    /// The 64 taps about a cell: sums over z and y first, four columns along x side by side, then along x.
    fn taps<const SECOND: bool>(&self, [i, j, k]: [usize; 3], t: Vec3) -> (f32, Vec3, Mat3) {
        let (x, y, z) = (Weights::at(t.x), Weights::at(t.y), Weights::at(t.z));
        let mut all = Columns::default();
        for c in 0..4 {
            let (mut value, mut slope, mut bend) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            for b in 0..4 {
                let row = self.row(i - 1, j + b - 1, k + c - 1);
                add(&mut value, y.value[b], row);
                add(&mut slope, y.slope[b], row);
                if SECOND {
                    add(&mut bend, y.bend[b], row);
                }
            }
            add(&mut all.value, z.value[c], value);
            add(&mut all.y, z.value[c], slope);
            add(&mut all.z, z.slope[c], value);
            if SECOND {
                add(&mut all.yy, z.value[c], bend);
                add(&mut all.yz, z.slope[c], slope);
                add(&mut all.zz, z.bend[c], value);
            }
        }
        let per_length = 1.0 / self.spacing;
        let gradient = Vec3::new(dot(x.slope, all.value), dot(x.value, all.y), dot(x.value, all.z)) * per_length;
        let hessian = if SECOND { all.second(&x) * (per_length * per_length) } else { Mat3::ZERO };
        (dot(x.value, all.value), gradient, hessian)
    }

    fn row(&self, i: usize, j: usize, k: usize) -> [f32; 4] {
        let [nx, ny, _] = self.counts;
        let start = (k * ny + j) * nx + i;
        self.coefficients.get(start..).and_then(<[f32]>::first_chunk).copied().unwrap_or_default()
    }
}

/// Sums over y and z in the four columns along x: of values and of derivatives.
#[derive(Clone, Copy, Default)]
struct Columns {
    value: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    yy: [f32; 4],
    yz: [f32; 4],
    zz: [f32; 4],
}

impl Columns {
    /// Second derivatives, per spacing squared.
    fn second(&self, x: &Weights) -> Mat3 {
        let (xx, xy, xz) = (dot(x.bend, self.value), dot(x.slope, self.y), dot(x.slope, self.z));
        let (yy, yz, zz) = (dot(x.value, self.yy), dot(x.value, self.yz), dot(x.value, self.zz));
        Mat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz))
    }
}

fn add(sum: &mut [f32; 4], weight: f32, row: [f32; 4]) {
    for (sum, c) in sum.iter_mut().zip(row) {
        *sum += weight * c;
    }
}

/// The four B-splines that reach a place in a cell, and their derivatives.
struct Weights {
    value: [f32; 4],
    slope: [f32; 4],
    bend: [f32; 4],
}

impl Weights {
    fn at(t: f32) -> Self {
        const SIXTH: f32 = 1.0 / 6.0;
        let s = 1.0 - t;
        let near = |t: f32| SIXTH * (t * t * (3.0 * t - 6.0) + 4.0);
        Self {
            value: [SIXTH * s * s * s, near(t), near(s), SIXTH * t * t * t],
            slope: [-0.5 * s * s, t * (1.5 * t - 2.0), -s * (1.5 * s - 2.0), 0.5 * t * t],
            bend: [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
        }
    }
}

fn dot(w: [f32; 4], c: [f32; 4]) -> f32 {
    w[0] * c[0] + w[1] * c[1] + w[2] * c[2] + w[3] * c[3]
}

/// Continues a distance beyond the grid by its tangent plane, which lies below a convex distance, and not below the way from the grid,
/// which holds the solid: a lower bound, equal to the distance on the border.
fn beyond(value: f32, gradient: Vec3, off: Vec3) -> (f32, Vec3) {
    if off == Vec3::ZERO {
        return (value, gradient);
    }
    let (tangent, way) = (value + gradient.dot(off), root(off.length_squared()));
    if tangent >= way { (tangent, gradient) } else { (way, direction(off, gradient)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [usize; 3] = [20, 22, 24];
    const SPACING: f32 = 0.1;
    const SIZE: usize = 20 * 22 * 24;

    /// Coefficients of the paraboloid-like ball |q|^2 - 0.25 about the middle. Splines of values c at the nodes give q^2 + h^2/3 per axis,
    /// so that the coefficients take that off.
    fn quadratic() -> ([f32; SIZE], Vec3) {
        let origin = Vec3::new(-0.95, -1.05, -1.15);
        let mut c = [0.0; SIZE];
        for (index, c) in c.iter_mut().enumerate() {
            let node = Vec3::new((index % 20) as f32, (index / 20 % 22) as f32, (index / 440) as f32);
            *c = (origin + node * SPACING).length_squared() - 0.25 - SPACING * SPACING;
        }
        (c, origin)
    }

    #[test]
    fn a_quadratic_is_reproduced_with_its_derivatives() {
        let (c, origin) = quadratic();
        let grid = DistanceGrid::new(origin, SPACING, COUNTS, &c).unwrap();
        for i in 0..200 {
            let f = i as f32;
            let q = Vec3::new(0.8 * libm::sinf(f * 0.7), 0.8 * libm::sinf(f * 1.3), 0.8 * libm::sinf(f * 2.1));
            let found = grid.field(q);
            assert!((found.value - (q.length_squared() - 0.25)).abs() < 1.0e-6, "{q} {found:?}");
            assert!((found.gradient - 2.0 * q).length() < 1.0e-5, "{q} {found:?}");
            assert!((found.hessian.x_axis - 2.0 * Vec3::X).length() < 2.0e-4, "{q} {found:?}");
            assert!((found.hessian.y_axis - 2.0 * Vec3::Y).length() < 2.0e-4, "{q} {found:?}");
            assert_eq!(grid.slope(q), (found.value, found.gradient));
        }
    }

    #[test]
    fn beyond_the_grid_it_goes_on_without_a_step_and_stays_finite() {
        let (c, origin) = quadratic();
        let grid = DistanceGrid::new(origin, SPACING, COUNTS, &c).unwrap();
        let mut last = grid.slope(Vec3::ZERO).0;
        for i in 0..2000 {
            let (value, gradient) = grid.slope(Vec3::new(0.6, 0.7, 1.0) * (i as f32 * 1.0e-3));
            assert!(value.is_finite() && gradient.is_finite() && (value - last).abs() < 1.0e-2, "{i}: {last} {value}");
            last = value;
        }
        for q in [Vec3::splat(1.0e30), Vec3::splat(-1.0e30), Vec3::splat(f32::INFINITY), Vec3::NAN, origin, -origin] {
            let _ = grid.field(q);
        }
        assert!(grid.slope(Vec3::new(0.0, -900.0, 0.0)).0 > 898.0);
    }

    #[test]
    fn what_is_no_grid_is_refused_by_name() {
        let (c, origin) = quadratic();
        let flaw = |index: usize, value: f32| {
            let mut bad = c;
            bad[index] = value;
            DistanceGrid::new(origin, SPACING, COUNTS, &bad).unwrap_err().name
        };
        assert!(flaw(5000, f32::NAN).contains("coefficient"));
        assert!(flaw(0, -0.1).contains("outer three layers"));
        assert!(DistanceGrid::new(origin, SPACING, COUNTS, &c[1..]).unwrap_err().name.contains("coefficients"));
        assert!(DistanceGrid::new(origin, SPACING, [4, 22, 24], &c).unwrap_err().name.contains("nodes"));
        assert!(DistanceGrid::new(origin, 0.0, COUNTS, &c).unwrap_err().name.contains("spacing"));
        assert!(DistanceGrid::new(Vec3::NAN, SPACING, COUNTS, &c).unwrap_err().name.contains("origin"));
        assert!(DistanceGrid::new(origin, SPACING, COUNTS, &[1.0; SIZE]).unwrap_err().name.contains("least"));
    }
}
