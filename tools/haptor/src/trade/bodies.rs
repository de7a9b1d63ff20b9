//! Figures of whole bodies from finite elements, shipped with the tool: what a cube and the ellipsoid 60:50:40 add to a half space.
//!
//! `bodies.csv`, everything without dimension, b the cube's edge, c the ellipsoid's semi-axis upright, G the shear modulus, a the contact radius:
//!
//! - cube, twist: C_theta G b^3 over a/b;  drag: C_t G b over a/b;  press: force of a sphere over that on the half space, over depth/radius, for a sphere of b/5
//! - ellipsoid, twist: stiffness of a bonded disc at the pole over that of the half space, over a/c;  couple: C G c^3 of two discs a/c = 0.15 that are turned about
//!   the axis between them, over their distance from it/c: compliance beyond that of two half spaces

use haptor_contact::{ObjectShape, Vec3};

const TABLE: &str = include_str!("bodies.csv");

/// Proportions count as those of a tabulated body within this.
const LIKE: f64 = 0.01;

/// Ratio of the tabulated sphere's radius to the cube's edge.
const SPHERE: f64 = 0.2;

/// A tabulated body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Its edge \[m\].
    Cube(f64),
    /// Its upright semi-axis \[m\].
    Ellipsoid(f64),
}

impl Known {
    /// The body of the tables that has the proportions of `shape`.
    pub fn of(shape: &ObjectShape<'_>) -> Option<Self> {
        let like = |v: Vec3, want: [f64; 3]| {
            v.to_array().iter().zip(want).all(|(x, w)| (f64::from(*x) / f64::from(v.z) / (w / want[2]) - 1.0).abs() < LIKE)
        };
        match *shape {
            ObjectShape::Box { size } if like(size, [1.0; 3]) => Some(Self::Cube(size.z.into())),
            ObjectShape::Ellipsoid { semi_axes } if like(semi_axes, [60.0, 50.0, 40.0]) => {
                Some(Self::Ellipsoid(semi_axes.z.into()))
            }
            _ => None,
        }
    }

    /// Turn of the body per torque on a patch of radius `a` on its top, beyond the half space's \[rad/(N m)\], for the shear modulus `g` \[Pa\].
    pub fn twist(self, nu: f64, g: f64, a: f64) -> f64 {
        match self {
            Self::Cube(b) => read("cube", "twist", nu, a / b) / (g * b.powi(3)),
            // stiffness over the half space's falls from 1 with a: 1/k - 1 over a is what is even
            Self::Ellipsoid(c) => {
                let local = 3.0 / (16.0 * g * a.powi(3));
                let rows = rows("ellipsoid", "twist", nu);
                let slopes: Vec<_> = rows.iter().map(|&(ratio, k)| (ratio, (1.0 / k - 1.0) / ratio)).collect();
                local * between(&slopes, a / c) * a / c
            }
        }
    }

    /// Shift of the body per drag on a patch of radius `a` on its top, beyond the half space's \[m/N\]; `None` where the tables have none.
    pub fn drag(self, nu: f64, g: f64, a: f64) -> Option<f64> {
        match self {
            Self::Cube(b) => Some(read("cube", "drag", nu, a / b) / (g * b)),
            Self::Ellipsoid(_) => None,
        }
    }

    /// Turn of the body per torque of opposed forces at `offset` from the axis, beyond two half spaces' \[rad/(N m)\].
    pub fn couple(self, nu: f64, g: f64, offset: f64) -> Option<f64> {
        match self {
            Self::Cube(_) => None,
            Self::Ellipsoid(c) => Some(read("ellipsoid", "couple", nu, offset / c) / (g * c.powi(3))),
        }
    }

    /// Force of a ball of `radius` over that on the half space; `None` where the tables have none.
    pub fn press(self, nu: f64, radius: f64, depth: f64) -> Option<f64> {
        match self {
            Self::Cube(b) if (radius / b / SPHERE - 1.0).abs() < LIKE => Some(read("cube", "press", nu, depth / radius)),
            _ => None,
        }
    }
}

/// Rows (ratio, value) of a quantity, by ratio, mixed between the Poisson's ratios of the table.
fn rows(body: &str, quantity: &str, nu: f64) -> Vec<(f64, f64)> {
    let all: Vec<(f64, f64, f64)> = TABLE
        .lines()
        .skip(1)
        .filter_map(|line| {
            let [its_body, its_quantity, nu, ratio, value] = line.split(',').collect::<Vec<_>>().try_into().ok()?;
            let number = |text: &str| text.parse::<f64>().ok();
            ((its_body, its_quantity) == (body, quantity)).then(|| Some((number(nu)?, number(ratio)?, number(value)?)))?
        })
        .collect();
    let mut ratios: Vec<f64> = all.iter().map(|row| row.1).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    let at = |ratio: f64| {
        let mut by_nu: Vec<_> = all.iter().filter(|row| row.1 == ratio).map(|row| (row.0, row.2)).collect();
        by_nu.sort_by(|a, b| a.0.total_cmp(&b.0));
        (ratio, between(&by_nu, nu))
    };
    ratios.into_iter().map(at).collect()
}

fn read(body: &str, quantity: &str, nu: f64, ratio: f64) -> f64 {
    between(&rows(body, quantity, nu), ratio)
}

/// Linear between points, level beyond the ends.
fn between(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.iter().position(|point| point.0 >= x);
    match after {
        None => points.last().map_or(0.0, |point| point.1),
        Some(0) => points[0].1,
        Some(i) => {
            let ((x0, y0), (x1, y1)) = (points[i - 1], points[i]);
            y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of the finite elements come back, and what the theory's constants say lies near.
    #[test]
    fn the_table_reads_back() {
        let cube = Known::of(&ObjectShape::Box { size: Vec3::splat(0.1) }).unwrap();
        assert!((cube.twist(0.5, 1.0e6, 0.01) / (4.552 / (1.0e6 * 1.0e-3)) - 1.0).abs() < 1e-6);
        assert!((cube.drag(0.3, 1.0e6, 0.02).unwrap() / (1.895 / 1.0e5) - 1.0).abs() < 1e-6);
        assert!((cube.press(0.5, 0.02, 0.001).unwrap() - 0.9974).abs() < 1e-9);
        let ellipsoid = Known::of(&ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }).unwrap();
        let (a, g) = (0.008, 1.0e6_f64);
        let stiffness = 1.0 / (3.0 / (16.0 * g * a * a * a) + ellipsoid.twist(0.5, g, a));
        assert!((stiffness / (16.0 / 3.0 * g * a * a * a) - 0.9107).abs() < 1e-4, "{stiffness}");
        assert!((ellipsoid.couple(0.5, g, 0.02).unwrap() * g - 0.6558 / 6.4e-5).abs() < 1.0);
        assert_eq!(Known::of(&ObjectShape::Box { size: Vec3::new(0.1, 0.1, 0.05) }), None);
    }
}
