//! Coefficients with which cubic B-splines follow values on a grid without overshooting at creases.
//!
//! Splines whose coefficients are the values themselves never leave the range of the values (no bulge beside an edge), but lie
//! h^2/6 times the second derivatives off. The quasi-interpolant c = f - (d_xx + d_yy + d_zz)/6, d the second differences, takes that off and
//! is exact for cubics (P. Sablonniere, 2005). At a crease a second difference is a spike that belongs to no curvature: there each
//! difference is limited to the least of itself and its two neighbours along the axis, and to zero where their signs differ. Smooth
//! surfaces are met to fourth order, flats beside an edge stay flat, the edge itself is rounded over a spacing.

/// Fewest nodes along an axis.
pub const MIN_NODES: usize = 4;

/// Coefficients for values on a grid, x fastest. Axes have at least [`MIN_NODES`] nodes.
pub fn coefficients(values: &[f64], counts: [usize; 3]) -> Vec<f64> {
    let [nx, ny, nz] = counts;
    assert!(
        counts.iter().all(|&n| n >= MIN_NODES) && values.len() == nx * ny * nz,
        "a grid of at least four nodes along each axis"
    );
    let mut found = values.to_vec();
    for (n, stride) in [(nx, 1), (ny, nx), (nz, nx * ny)] {
        for (index, c) in found.iter_mut().enumerate() {
            let i = index / stride % n;
            // the outermost differences are taken from their inner neighbours
            let bend = |i: usize| {
                let middle = index - index / stride % n * stride + i.clamp(1, n - 2) * stride;
                values[middle - stride] - 2.0 * values[middle] + values[middle + stride]
            };
            *c -= limited(bend(i.saturating_sub(1)), bend(i), bend(i + 1)) / 6.0;
        }
    }
    found
}

/// The least of three numbers of one sign, else zero.
fn limited(a: f64, b: f64, c: f64) -> f64 {
    let least = a.abs().min(b.abs()).min(c.abs());
    if a > 0.0 && b > 0.0 && c > 0.0 {
        least
    } else if a < 0.0 && b < 0.0 && c < 0.0 {
        -least
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [usize; 3] = [9, 7, 11];

    /// The splines' value at a node.
    fn at_node(c: &[f64], [i, j, k]: [usize; 3]) -> f64 {
        let weights = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];
        let taps = (0..27).map(|t| {
            let (a, b, d) = (t % 3, t / 3 % 3, t / 9);
            weights[a] * weights[b] * weights[d] * c[((k + d - 1) * COUNTS[1] + j + b - 1) * COUNTS[0] + i + a - 1]
        });
        taps.sum()
    }

    fn grid(value: impl Fn(f64, f64, f64) -> f64) -> Vec<f64> {
        let [nx, ny, nz] = COUNTS;
        let nodes = (0..nx * ny * nz).map(|index| (index % nx, index / nx % ny, index / (nx * ny)));
        nodes.map(|(i, j, k)| value(i as f64 - 4.0, j as f64 - 3.0, k as f64 - 5.0)).collect()
    }

    #[test]
    fn quadratics_are_met_exactly() {
        let value = |x: f64, y: f64, z: f64| 0.3 * x * x + 0.2 * y * y + 0.1 * z * z + x * y - 2.0 * z + 1.0;
        let c = coefficients(&grid(value), COUNTS);
        for (i, j, k) in [(1, 1, 1), (4, 3, 5), (7, 5, 9), (2, 4, 8)] {
            let expected = value(i as f64 - 4.0, j as f64 - 3.0, k as f64 - 5.0);
            assert!((at_node(&c, [i, j, k]) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_crease_does_not_ring() {
        let c = coefficients(&grid(|x, _, z| x.abs().max(z.abs()) - 2.0), COUNTS);
        let flat = |i: usize| at_node(&c, [i, 3, 5]);
        assert!(
            (flat(1) - 1.0).abs() < 1e-12 && (flat(2) - 0.0).abs() < 1e-12 && flat(4) > -2.0,
            "{} {} {}",
            flat(1),
            flat(2),
            flat(4)
        );
    }
}
