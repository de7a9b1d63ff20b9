//! Displacement and stress below a point force on the surface of the half space z >= 0 (z into the body).
//!
//! Boussinesq (force along z) and Cerruti (along x or y), Johnson, "Contact Mechanics", 3.2 and 3.6. Shear modulus 1, force 1;
//! rho = |r|. Displacement \[m\] is per unit of force over shear modulus \[m^2\], stress per unit of force.
//!
//! Two forms of the same solution: one force at a time, stress by differences of the displacement; and all three unit forces at once in closed
//! form, for runs that ask often. A test holds them together.

use glam::{DMat3, DVec3};

use super::element::Lame;

/// Displacement at `r` from the loaded point, for the force `f`.
pub(crate) fn displacement(r: DVec3, f: DVec3, nu: f64) -> DVec3 {
    let (rho, z) = (r.length(), r.z);
    let (m, below) = (1.0 - 2.0 * nu, rho + z);
    let flat = DVec3::new(r.x, r.y, 0.0);
    let f_flat = DVec3::new(f.x, f.y, 0.0);
    let along = r.dot(f_flat);
    // Cerruti, both directions at once
    let mut u = f_flat / rho + r * (along / rho.powi(3));
    u += (f_flat / below - flat * (along / (rho * below * below))) * m;
    u.z += m * along / (rho * below);
    // Boussinesq
    let mut w = flat * (z / rho.powi(3) - m / (rho * below));
    w.z = z * z / rho.powi(3) + 2.0 * (1.0 - nu) / rho;
    (u + w * f.z) / (4.0 * std::f64::consts::PI)
}

/// Share of the distance to the load over which slopes are taken: fourth-order differences then err by some 1e-12.
const STEP: f64 = 1.0e-3;

/// Stress at `r` from the loaded point, for the force `f`; symmetric.
pub(crate) fn stress(r: DVec3, f: DVec3, nu: f64, lame: Lame) -> DMat3 {
    let h = STEP * r.length();
    let slope = |axis: DVec3| {
        let u = |steps: f64| displacement(r + axis * (h * steps), f, nu);
        ((u(1.0) - u(-1.0)) * 8.0 - (u(2.0) - u(-2.0))) / (12.0 * h)
    };
    let gradient = DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
    let trace = gradient.x_axis.x + gradient.y_axis.y + gradient.z_axis.z;
    (gradient + gradient.transpose()) * lame.shear + DMat3::from_diagonal(DVec3::splat(lame.lambda * trace))
}

/// Displacement at `r` from the loaded point: column j belongs to the unit force along axis j.
pub(crate) fn displacements(r: DVec3, nu: f64) -> DMat3 {
    let (rho, z, m) = (r.length(), r.z, 1.0 - 2.0 * nu);
    let (inverse, below) = (1.0 / rho, 1.0 / (rho + z));
    let cube = inverse * inverse * inverse;
    let flat = DVec3::new(r.x, r.y, 0.0);
    let along = |axis: DVec3, r_axis: f64| {
        let plane = (axis - flat * (r_axis * inverse * below)) * below * m;
        axis * inverse + r * (r_axis * cube) + plane + DVec3::Z * (m * r_axis * inverse * below)
    };
    let down = flat * (z * cube - m * inverse * below) + DVec3::Z * (z * z * cube + 2.0 * (1.0 - nu) * inverse);
    DMat3::from_cols(along(DVec3::X, r.x), along(DVec3::Y, r.y), down) * (0.25 / std::f64::consts::PI)
}

/// Traction at `r` from the loaded point on a surface with the area vector `n`: column j belongs to the unit force along axis j.
pub(crate) fn tractions(r: DVec3, n: DVec3, nu: f64) -> DMat3 {
    let (rho, z, m) = (r.length(), r.z, 1.0 - 2.0 * nu);
    let (inverse, below) = (1.0 / rho, 1.0 / (rho + z));
    let cube = inverse * inverse * inverse;
    let (flat, n_flat) = (DVec3::new(r.x, r.y, 0.0), DVec3::new(n.x, n.y, 0.0));
    // all of it where nu = 1/2: pulls along the ray from the load
    let ray = r * (-3.0 * r.dot(n) * cube * inverse * inverse);
    let radial = |r_axis: f64| ray * r_axis;
    // the rest lies in planes of the surface
    let across = flat.dot(n_flat);
    let square = inverse * below * below;
    let along = |axis: DVec3, r_axis: f64| {
        let even =
            n_flat * (r_axis * cube) + flat * (across * r_axis * (square * inverse * inverse + 2.0 * square * inverse * below));
        let edge = n_flat * r_axis + flat * axis.dot(n_flat) + axis * across;
        radial(r_axis) + (even - edge * square) * m
    };
    let sunk = n_flat * (z * cube - inverse * below) + flat * (across * (2.0 * rho + z) * cube * below * below);
    DMat3::from_cols(along(DVec3::X, r.x), along(DVec3::Y, r.y), radial(z) + sunk * m) * (0.5 / std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_forms_meet_the_differences() {
        for nu in [0.0, 0.3, 0.4999] {
            let lame = Lame::of_unit_shear(nu);
            for r in [DVec3::new(0.3, -0.4, 0.2), DVec3::new(1.0e-3, 2.0e-3, 0.5), DVec3::new(-0.7, 0.1, 1.0e-4)] {
                let n = DVec3::new(0.2, -0.5, 0.7);
                let (moved, pulled) = (displacements(r, nu), tractions(r, n, nu));
                for (axis, f) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                    let (u, t) = (displacement(r, f, nu), stress(r, f, nu, lame) * n);
                    assert!((moved.col(axis) - u).length() < 1.0e-12 * u.length(), "nu {nu}, {r}, {f}");
                    // the differences lose digits to the bulk modulus
                    assert!(
                        (pulled.col(axis) - t).length() < 1.0e-5 * t.length().max(1.0),
                        "nu {nu}, {r}, {f}: {t} {}",
                        pulled.col(axis)
                    );
                }
            }
        }
    }

    #[test]
    fn a_plane_below_the_load_carries_it_and_the_surface_carries_nothing() {
        let nu = 0.3;
        let lame = Lame::of_unit_shear(nu);
        for f in [DVec3::X, DVec3::Y, DVec3::Z] {
            let surface = stress(DVec3::new(0.3, 0.4, 0.0), f, nu, lame) * DVec3::Z;
            assert!(surface.length() < 1.0e-9, "{f}: {surface}");
            // rings on z = 1 out to radius tan(t), substitution r = tan t
            let (mut sum, n) = (DVec3::ZERO, 400);
            for i in 0..n {
                let t = (f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::FRAC_PI_2;
                let r = t.tan();
                for j in 0..16 {
                    let angle = (f64::from(j) + 0.5) * std::f64::consts::PI / 8.0;
                    let at = DVec3::new(r * angle.cos(), r * angle.sin(), 1.0);
                    let area = r * (1.0 + r * r) * std::f64::consts::FRAC_PI_2 / f64::from(n) * std::f64::consts::PI / 8.0;
                    sum += stress(at, f, nu, lame) * DVec3::Z * area;
                }
            }
            assert!((sum + f).length() < 2.0e-3, "{f}: {sum}");
        }
    }
}
