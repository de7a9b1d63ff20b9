//! The body above its held plane: where its surface lies, which way it faces, how it curves.
//!
//! Frame: world axes, lengths in units of the body's largest half extent, origin where the scene has it. **Flat** faces are told apart from
//! **round** ones, because on them the half space's solution is exact.

use glam::DVec3;
use haptor_contact::ObjectShape;

/// A convex body, in units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Solid {
    /// Middle of the bottom at the origin.
    Box { size: DVec3 },
    /// Upright, middle of the bottom at the origin.
    Cylinder { radius: f64, height: f64 },
    /// Lowest point at the origin.
    Ellipsoid { axes: DVec3 },
}

/// A point of the surface and the outward unit normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    pub point: DVec3,
    pub normal: DVec3,
}

/// A body cut at the held plane z = `base`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    pub solid: Solid,
    pub base: f64,
    /// Middle of the bounds above the plane.
    pub centre: DVec3,
    /// Half of those bounds.
    pub half_size: DVec3,
}

impl Solid {
    /// The scene's shape divided by `unit` \[m\]; none for the half space, which has no body.
    pub(crate) fn new(shape: &ObjectShape<'_>, unit: f64) -> Option<Self> {
        Some(match *shape {
            ObjectShape::HalfSpace => return None,
            ObjectShape::Mesh(mesh) => return Self::new(&mesh.stand_in(), unit),
            ObjectShape::Box { size } => Self::Box { size: size.as_dvec3() / unit },
            ObjectShape::Cylinder { radius, height } => {
                Self::Cylinder { radius: f64::from(radius) / unit, height: f64::from(height) / unit }
            }
            ObjectShape::Sphere { radius } => Self::Ellipsoid { axes: DVec3::splat(f64::from(radius) / unit) },
            ObjectShape::Ellipsoid { semi_axes } => Self::Ellipsoid { axes: semi_axes.as_dvec3() / unit },
        })
    }

    /// Height of the highest point.
    pub(crate) fn height(&self) -> f64 {
        match *self {
            Self::Box { size } => size.z,
            Self::Cylinder { height, .. } => height,
            Self::Ellipsoid { axes } => 2.0 * axes.z,
        }
    }

    /// Half extents of the section at height `z`.
    pub(crate) fn section(&self, z: f64) -> DVec3 {
        match *self {
            Self::Box { size } => DVec3::new(0.5 * size.x, 0.5 * size.y, 0.0),
            Self::Cylinder { radius, .. } => DVec3::new(radius, radius, 0.0),
            Self::Ellipsoid { axes } => {
                let up = z / axes.z - 1.0;
                let share = (1.0 - up * up).max(0.0).sqrt();
                DVec3::new(axes.x * share, axes.y * share, 0.0)
            }
        }
    }
}

impl Cut {
    /// The body above z = `base`.
    pub(crate) fn new(solid: Solid, base: f64) -> Self {
        let top = solid.height();
        let widest = match solid {
            Solid::Ellipsoid { axes } => solid.section(base.max(axes.z)),
            _ => solid.section(base),
        };
        let half_size = DVec3::new(widest.x, widest.y, 0.5 * (top - base));
        Self { solid, base, centre: DVec3::Z * (0.5 * (top + base)), half_size }
    }

    /// Where the ray from the centre along `direction` leaves the body, held plane left out: rays that meet the plane first go on below it.
    pub(crate) fn ray(&self, direction: DVec3) -> Spot {
        let point = match self.solid {
            Solid::Box { .. } => {
                let reach = (direction / self.half_size).abs().max_element();
                self.centre + direction / reach
            }
            Solid::Cylinder { radius, .. } => {
                let reach = (direction.x.hypot(direction.y) / radius).max(direction.z.abs() / self.half_size.z);
                self.centre + direction / reach
            }
            Solid::Ellipsoid { axes } => {
                let from = (self.centre - DVec3::Z * axes.z) / axes;
                self.centre + direction * beyond(from, direction / axes)
            }
        };
        Spot { point, normal: self.normal(point, direction) }
    }

    /// Outward normal at a surface point; on the edge of a cylinder or a box the face that `outward` looks through.
    pub(crate) fn normal(&self, point: DVec3, outward: DVec3) -> DVec3 {
        match self.solid {
            Solid::Box { .. } => {
                let share = outward / self.half_size;
                let axis = share.abs().max_position();
                DVec3::AXES[axis] * share[axis].signum()
            }
            Solid::Cylinder { radius, .. } => {
                if outward.z / self.half_size.z > outward.x.hypot(outward.y) / radius {
                    DVec3::Z
                } else {
                    DVec3::new(point.x, point.y, 0.0).normalize_or_zero()
                }
            }
            Solid::Ellipsoid { axes } => ((point - DVec3::Z * axes.z) / (axes * axes)).normalize_or_zero(),
        }
    }

    /// The surface point over `point`, which lies near the surface, along `normal`, that of the face it belongs to.
    pub(crate) fn along(&self, point: DVec3, normal: DVec3) -> Spot {
        match self.solid {
            Solid::Cylinder { radius, .. } if normal.z.abs() < 0.5 => {
                let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0) / radius;
                let point = point + normal * beyond(flat(point), flat(normal));
                Spot { point, normal: DVec3::new(point.x, point.y, 0.0).normalize_or_zero() }
            }
            Solid::Ellipsoid { axes } => {
                let point = point + normal * beyond((point - DVec3::Z * axes.z) / axes, normal / axes);
                Spot { point, normal: self.normal(point, normal) }
            }
            _ => Spot { point, normal },
        }
    }

    /// True where the surface is a plane.
    pub(crate) fn is_flat(&self, normal: DVec3) -> bool {
        match self.solid {
            Solid::Box { .. } => true,
            Solid::Cylinder { .. } => normal.z.abs() > 0.5,
            Solid::Ellipsoid { .. } => false,
        }
    }

    /// Mean curvature of the surface at a spot, 0 on planes.
    pub(crate) fn curvature(&self, spot: &Spot) -> f64 {
        match self.solid {
            Solid::Cylinder { radius, .. } if !self.is_flat(spot.normal) => 0.5 / radius,
            Solid::Ellipsoid { axes } => {
                let (n, squares) = (spot.normal, axes * axes);
                let width = (squares * n * n).element_sum().sqrt();
                0.5 * width * ((1.0 / squares).element_sum() - (n * n / squares).element_sum())
            }
            _ => 0.0,
        }
    }
}

/// Distance along `direction` at which the line from `from` leaves the unit ball; the nearest approach if it misses.
fn beyond(from: DVec3, direction: DVec3) -> f64 {
    let (a, b, c) = (direction.length_squared(), from.dot(direction), from.length_squared() - 1.0);
    (-b + (b * b - a * c).max(0.0).sqrt()) / a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuts() -> [Cut; 3] {
        [
            Cut::new(Solid::Box { size: DVec3::new(1.0, 2.0, 1.5) }, 0.2),
            Cut::new(Solid::Cylinder { radius: 0.7, height: 2.0 }, 0.0),
            Cut::new(Solid::Ellipsoid { axes: DVec3::new(1.2, 1.0, 0.8) }, 0.2),
        ]
    }

    #[test]
    fn rays_end_on_the_surface_and_normals_point_out() {
        for cut in cuts() {
            for direction in [DVec3::Z, DVec3::new(1.0, 0.3, 0.2), DVec3::new(-0.4, 0.9, -0.3), DVec3::new(0.2, -0.1, 1.0)] {
                let spot = cut.ray(direction);
                assert!((spot.normal.length() - 1.0).abs() < 1.0e-12 && spot.normal.dot(direction) > 0.0, "{cut:?} {spot:?}");
                // a little off along the normal comes back
                let back = cut.along(spot.point - spot.normal * 0.01, spot.normal);
                if !cut.is_flat(spot.normal) {
                    assert!(back.point.distance(spot.point) < 1.0e-9, "{cut:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn curvature_is_that_of_the_poles() {
        let [_, cylinder, ellipsoid] = cuts();
        let top = ellipsoid.ray(DVec3::Z);
        assert!((ellipsoid.curvature(&top) - 0.5 * (0.8 / 1.44 + 0.8)).abs() < 1.0e-12);
        assert!((cylinder.curvature(&cylinder.ray(DVec3::X)) - 0.5 / 0.7).abs() < 1.0e-12);
        assert_eq!(cylinder.curvature(&cylinder.ray(DVec3::Z)), 0.0);
    }
}
