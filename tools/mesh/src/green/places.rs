//! The chart's nodes as places that can be loaded: discs on one face each, clear of edges and of the held base.
//!
//! On an edge of a box or the rim of a cylinder a surface has no normal, and half spaces are wrong beside it: such a node stands for the mean of
//! places drawn in on each of the faces that meet there. A node close to the held base stands for a place just above it, its moves and
//! loads reduced in the ratio of the heights; nodes on the base neither move nor load.

use glam::DVec3;
use haptor_contact::green::Chart;

use crate::fem::solid::{Cut, Solid, Spot};

/// Share of the half width that places keep to on a face with edges: clear of the edge by more than [`super::RADIUS`].
const DRAWN_IN: f64 = 0.85;

/// Two shares of a direction this close are the same: the chart counts in f32.
const SAME: f64 = 1.0e-5;

/// A node of the chart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Place {
    /// Where the node lies: displacements are read there, edge or not.
    pub point: DVec3,
    /// Numbers of its discs; none on the held base.
    pub discs: Vec<usize>,
    /// Share of their turns and loads that counts.
    pub share: f64,
}

/// The places of a chart, and the middles of their discs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    pub places: Vec<Place>,
    pub spots: Vec<Spot>,
}

/// Places for discs of `radius`, in units of the body.
pub(crate) fn places(cut: &Cut, chart: &Chart, radius: f64) -> Places {
    let mut found = Places::default();
    for node in 0..chart.places() {
        let direction = chart.direction(node).as_dvec3();
        let (spots, share) = spots(cut, direction, radius);
        let first = found.spots.len();
        found.spots.extend(&spots);
        let point = cut.ray(direction * cut.half_size).point;
        found.places.push(Place { point, discs: (first..first + spots.len()).collect(), share });
    }
    found
}

fn spots(cut: &Cut, direction: DVec3, radius: f64) -> (Vec<Spot>, f64) {
    match cut.solid {
        Solid::Box { .. } => (on_box(cut, direction), 1.0),
        Solid::Cylinder { .. } => on_cylinder(cut, direction, radius),
        Solid::Ellipsoid { .. } => {
            let spot = cut.ray(direction * cut.half_size);
            lifted(cut, spot, radius)
        }
    }
}

/// One spot on each face that meets at the node.
fn on_box(cut: &Cut, direction: DVec3) -> Vec<Spot> {
    if direction.z < SAME - 1.0 {
        return Vec::new();
    }
    let outer = |axis: usize| direction[axis].abs() > 1.0 - SAME;
    let on_face = |axis: usize| {
        let mut at = direction;
        for other in (0..3).filter(|&other| other != axis) {
            at[other] = at[other].clamp(-DRAWN_IN, DRAWN_IN);
        }
        Spot { point: cut.centre + cut.half_size * at, normal: DVec3::AXES[axis] * at[axis].signum() }
    };
    (0..3).filter(|&axis| outer(axis)).map(on_face).collect()
}

fn on_cylinder(cut: &Cut, direction: DVec3, radius: f64) -> (Vec<Spot>, f64) {
    let level = direction.x.hypot(direction.y);
    let (x, y) = (direction.x / level.max(SAME), direction.y / level.max(SAME));
    if direction.z < 0.0 && level <= -direction.z + SAME {
        return (Vec::new(), 0.0);
    }
    let mut spots = Vec::new();
    if direction.z >= level - SAME {
        let out = (level / direction.z).min(DRAWN_IN);
        spots.push(Spot { point: cut.centre + cut.half_size * DVec3::new(x * out, y * out, 1.0), normal: DVec3::Z });
    }
    if level < direction.z - SAME {
        return (spots, 1.0);
    }
    let up = (direction.z / level).min(DRAWN_IN);
    let side = Spot { point: cut.centre + cut.half_size * DVec3::new(x, y, up), normal: DVec3::new(x, y, 0.0) };
    let (side, share) = lifted(cut, side, radius);
    spots.extend(side);
    (spots, share)
}

/// Steps of the search for a place clear of the base.
const STEPS: usize = 64;

/// The spot, or the next one up that keeps a disc off the held base, and the ratio of their heights over it.
fn lifted(cut: &Cut, spot: Spot, radius: f64) -> (Vec<Spot>, f64) {
    let above = |spot: &Spot| spot.point.z - cut.base;
    if above(&spot) <= SAME {
        return (Vec::new(), 0.0);
    }
    // a disc's points lie below its plane where the surface falls away
    let reach = CLEAR * radius;
    let dip = |spot: &Spot| reach * reach * cut.curvature(spot) * spot.normal.z.abs();
    let clear = |spot: &Spot| above(spot) > reach * (1.0 - spot.normal.z * spot.normal.z).sqrt() + dip(spot);
    let towards = |step: usize| {
        let direction = spot.point - cut.centre;
        let share = step as f64 / STEPS as f64;
        match cut.solid {
            Solid::Ellipsoid { .. } => cut.ray(DVec3::new(direction.x, direction.y, direction.z + share * 2.0 * cut.half_size.z)),
            _ => Spot { point: spot.point + DVec3::Z * (share * cut.half_size.z), ..spot },
        }
    };
    let Some(found) = (0..STEPS).map(towards).find(clear) else { return (Vec::new(), 0.0) };
    (vec![found], (above(&spot) / above(&found)).min(1.0))
}

/// Distance that discs keep from the held base, in radii: the circle around them ([`crate::fem::anywhere::NEAR`]) stays above it.
const CLEAR: f64 = 1.5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::anywhere::NEAR;
    use crate::fem::disc::Disc;

    #[test]
    fn every_node_has_a_place_but_those_on_the_base() {
        let bodies = [
            (Cut::new(Solid::Box { size: DVec3::new(1.0, 2.0, 1.4) }, 0.0), 49),
            (Cut::new(Solid::Cylinder { radius: 1.0, height: 1.5 }, 0.0), 29),
            (Cut::new(Solid::Ellipsoid { axes: DVec3::new(1.0, 0.9, 0.8) }, 0.2), 0),
            (Cut::new(Solid::Ellipsoid { axes: DVec3::ONE }, 0.25), 0),
            (Cut::new(Solid::Ellipsoid { axes: DVec3::new(0.3, 0.3, 0.8) }, 0.2), 0),
            (Cut::new(Solid::Cylinder { radius: 1.0, height: 0.4 }, 0.1), 29),
        ];
        for (cut, held) in bodies {
            let half = cut.half_size.as_vec3();
            let chart = Chart { centre: cut.centre.as_vec3(), half_size: half, per_edge: 7 };
            let radius = 0.1 * cut.half_size.min_element();
            let found = places(&cut, &chart, radius);
            assert_eq!(found.places.len(), 218);
            let empty = found.places.iter().filter(|place| place.discs.is_empty()).count();
            assert!(empty >= held && empty <= held.max(25), "{cut:?}: {empty}");
            for &spot in &found.spots {
                let disc = Disc::new(&cut, spot, radius);
                let circle = disc.circle(&cut, NEAR * radius);
                assert!(disc.fine.iter().chain(&circle).all(|point| point.at.z > cut.base), "{cut:?}: {spot:?}");
            }
        }
    }
}
