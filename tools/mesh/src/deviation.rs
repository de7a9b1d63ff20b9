//! How far two surfaces are from each other, both ways: each is asked at its vertices and at points spread over it for the nearest point of the other.

use glam::DVec3;

use crate::distance::Distance;
use crate::mesh::Mesh;
use crate::samples::places_by_area;

/// Points spread by area on each surface.
const SPREAD: usize = 65_536;

/// Most vertices asked on each, evenly thinned where there are more.
const VERTICES: usize = 131_072;

/// Distance between two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest, of both ways \[m\].
    pub max: f64,
    /// Root of the mean square over the points of both \[m\].
    pub rms: f64,
}

/// Measures both ways; `None` where one of the two has no triangle.
pub fn deviation(one: &Mesh, other: &Mesh) -> Option<Deviation> {
    let (to_one, to_other) = (Distance::new(one)?, Distance::new(other)?);
    let offs = points(one).map(|p| to_other.nearest(p).distance).chain(points(other).map(|p| to_one.nearest(p).distance));
    let (mut max, mut squares, mut count) = (0.0_f64, 0.0, 0_u32);
    for off in offs {
        (max, squares, count) = (max.max(off.abs()), squares + off * off, count + 1);
    }
    Some(Deviation { max, rms: (squares / f64::from(count.max(1))).sqrt() })
}

fn points(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    let stride = mesh.vertices.len().div_ceil(VERTICES).max(1);
    mesh.vertices.iter().copied().step_by(stride).chain(places_by_area(mesh, SPREAD))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    #[test]
    fn a_shifted_cube_deviates_by_the_shift_and_an_added_spike_by_its_height() {
        let cube = tessellate::cuboid(DVec3::ONE);
        let off = deviation(&cube, &cube.mapped(|v| v + 0.01 * DVec3::X)).unwrap();
        assert!((off.max - 0.01).abs() < 1e-9 && off.rms < 0.01 && off.rms > 0.005, "{off:?}");
        let mut spiked = cube.clone();
        let [a, b, c] = spiked.triangles[0];
        let tip = spiked.corners([a, b, c]).iter().sum::<DVec3>() / 3.0 * 1.2;
        spiked.vertices.push(tip);
        spiked.triangles[0] = [a, b, 8];
        spiked.triangles.extend([[b, c, 8], [c, a, 8]]);
        for (one, other) in [(&cube, &spiked), (&spiked, &cube)] {
            let off = deviation(one, other).unwrap();
            assert!((off.max - 0.1).abs() < 1e-9 && off.rms < 0.05, "{off:?}");
        }
        assert_eq!(deviation(&cube, &Mesh::default()), None);
    }
}
