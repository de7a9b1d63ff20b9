//! The element: a brick of 27 nodes with quadratic displacement and a linear pressure of its own.
//!
//! Stiffness: K = int G (grad N_a . grad N_b I + grad N_a (x) grad N_b) + lambda Q M^-1 Q^T. The volumetric part is projected on the four
//! functions {1, xi, eta, zeta} of the element (Q2/P-1), so that the brick does not lock as Poisson's ratio nears one half
//! (Hughes, "The Finite Element Method", 4.4; Brezzi and Fortin on Q2/P-1). Nodes run x first, then y, then z, three each.

use glam::{DMat3, DVec3};

/// Nodes of a brick.
pub(crate) const NODES: usize = 27;
/// Displacement unknowns of a brick.
pub(crate) const UNKNOWNS: usize = 3 * NODES;
/// Pressure functions of a brick.
const PRESSURES: usize = 4;

/// Three-point Gauss rule on [-1, 1]: place and weight.
pub(crate) const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Lame's two constants \[Pa\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lame {
    pub lambda: f64,
    pub shear: f64,
}

impl Lame {
    /// Of shear modulus 1 and this Poisson's ratio, which must be below one half.
    pub(crate) fn of_unit_shear(nu: f64) -> Self {
        Self { lambda: 2.0 * nu / (1.0 - 2.0 * nu), shear: 1.0 }
    }
}

/// Quadratic line functions and their slopes at `s` in [-1, 1].
pub(crate) fn line(s: f64) -> ([f64; 3], [f64; 3]) {
    ([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)], [s - 0.5, -2.0 * s, s + 0.5])
}

/// The 27 shape functions at `at` and their slopes in element coordinates.
pub(crate) fn shape(at: DVec3) -> ([f64; NODES], [DVec3; NODES]) {
    let ((x, dx), (y, dy), (z, dz)) = (line(at.x), line(at.y), line(at.z));
    let (mut value, mut slope) = ([0.0; NODES], [DVec3::ZERO; NODES]);
    for node in 0..NODES {
        let (i, j, k) = (node % 3, node / 3 % 3, node / 9);
        value[node] = x[i] * y[j] * z[k];
        slope[node] = DVec3::new(dx[i] * y[j] * z[k], x[i] * dy[j] * z[k], x[i] * y[j] * dz[k]);
    }
    (value, slope)
}

/// Place and Jacobian at element coordinates `at`.
pub(crate) fn map(corners: &[DVec3; NODES], at: DVec3) -> (DVec3, DMat3) {
    let (value, slope) = shape(at);
    let (mut place, mut jacobian) = (DVec3::ZERO, DMat3::ZERO);
    for (node, &corner) in corners.iter().enumerate() {
        place += corner * value[node];
        jacobian.x_axis += corner * slope[node].x;
        jacobian.y_axis += corner * slope[node].y;
        jacobian.z_axis += corner * slope[node].z;
    }
    (place, jacobian)
}

/// Stiffness of one brick, row by row; `None` when the brick is turned inside out at a Gauss point.
pub(crate) fn stiffness(corners: &[DVec3; NODES], lame: Lame) -> Option<Vec<f64>> {
    let mut k = vec![0.0; UNKNOWNS * UNKNOWNS];
    let mut q = [[0.0; PRESSURES]; UNKNOWNS];
    let mut mass = glam::DMat4::ZERO;
    for (zeta, wz) in GAUSS {
        for (eta, wy) in GAUSS {
            for (xi, wx) in GAUSS {
                let at = DVec3::new(xi, eta, zeta);
                let (_, jacobian) = map(corners, at);
                let volume = jacobian.determinant();
                if volume <= 0.0 {
                    return None;
                }
                let weight = volume * wx * wy * wz;
                let to_place = jacobian.inverse().transpose();
                let gradients = shape(at).1.map(|slope| to_place * slope);
                add_shear(&mut k, &gradients, lame.shear * weight);
                let pressure = [1.0, xi, eta, zeta];
                mass += outer(pressure, weight);
                for (unknown, row) in q.iter_mut().enumerate() {
                    let divergence = gradients[unknown / 3][unknown % 3] * weight;
                    for (sum, p) in row.iter_mut().zip(pressure) {
                        *sum += divergence * p;
                    }
                }
            }
        }
    }
    add_volumetric(&mut k, &q, &mass.inverse(), lame.lambda);
    Some(k)
}

fn outer(p: [f64; PRESSURES], weight: f64) -> glam::DMat4 {
    let column = |j: usize| glam::DVec4::from_array(p) * (p[j] * weight);
    glam::DMat4::from_cols(column(0), column(1), column(2), column(3))
}

fn add_shear(k: &mut [f64], gradients: &[DVec3; NODES], factor: f64) {
    for (a, ga) in gradients.iter().enumerate() {
        for (b, gb) in gradients.iter().enumerate() {
            let dot = ga.dot(*gb) * factor;
            for i in 0..3 {
                for j in 0..3 {
                    let same = if i == j { dot } else { 0.0 };
                    k[(3 * a + i) * UNKNOWNS + 3 * b + j] += same + ga[j] * gb[i] * factor;
                }
            }
        }
    }
}

fn add_volumetric(k: &mut [f64], q: &[[f64; PRESSURES]; UNKNOWNS], mass_inverse: &glam::DMat4, lambda: f64) {
    for (row, qr) in q.iter().enumerate() {
        let weighted = *mass_inverse * glam::DVec4::from_array(*qr) * lambda;
        for (column, qc) in q.iter().enumerate() {
            k[row * UNKNOWNS + column] += weighted.dot(glam::DVec4::from_array(*qc));
        }
    }
}
