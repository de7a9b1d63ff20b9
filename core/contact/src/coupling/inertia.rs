//! Inertia of the probe from its shape (theory.md, equations 10.1 and 10.2).
//!
//! The probe's mass is spread evenly over the volume of its parts; where parts overlap the common volume counts for each. Everything is about the
//! probe's origin, which is its mass centre by definition, in the probe's frame p.

use glam::Vec3;

use super::sym::Sym3;
use crate::error::{Invalid, require};
use crate::math::PI;
use crate::model::{ObjectShape, ProbePart, ProbeShape};

/// Inertia tensor about the mass centre, in the probe's frame \[kg m^2\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Moments about x, y, z: integrals of y^2 + z^2, z^2 + x^2, x^2 + y^2 over the mass.
    pub moments: Vec3,
    /// Products xy, xz, yz: **minus** the integrals of x y, x z, y z, as they stand in the tensor.
    pub products: Vec3,
}

impl Inertia {
    pub(crate) fn tensor(&self) -> Sym3 {
        Sym3 { diagonal: self.moments, off: self.products }
    }

    /// Refuses what no body has: a negative moment, one above the sum of the other two, a product above the mean of its moments.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let (m, p) = (self.moments, self.products);
        for (own, others) in [(m.x, m.y + m.z), (m.y, m.x + m.z), (m.z, m.x + m.y)] {
            require((0.0..=LARGEST).contains(&own), "probe.inertia.moments", own, "0 to 1e8 kg m^2")?;
            require(own <= others * SLACK, "probe.inertia.moments", own, "at most the sum of the other two")?;
        }
        for (product, pair) in [(p.x, m.x * m.y), (p.y, m.x * m.z), (p.z, m.y * m.z)] {
            require(
                product * product <= pair,
                "probe.inertia.products",
                product,
                "in size at most the root of the product of its two moments",
            )?;
        }
        Ok(())
    }
}

/// Inertia of the largest mass (1e4 kg) at the largest length (1e2 m).
const LARGEST: f32 = 1.0e8;

/// A thin plate meets the triangle rule with equality; its given digits may miss it by rounding.
const SLACK: f32 = 1.0001;

/// Volume, and squared radii of gyration about the shape's own origin: what an even body needs to be known by.
///
/// This is where a shape without closed forms comes in: give its volume and its second moments over the volume, about its mass centre.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Solid {
    /// \[m^3\]
    volume: f32,
    /// Inertia tensor over the mass, in the part's frame \[m^2\].
    gyration: Sym3,
}

impl Solid {
    /// Body whose axes are principal ones: means of x^2, y^2 and z^2 over its volume.
    fn from_means(volume: f32, mean_squares: Vec3) -> Self {
        let Vec3 { x, y, z } = mean_squares;
        Self { volume, gyration: Sym3 { diagonal: Vec3::new(y + z, z + x, x + y), off: Vec3::ZERO } }
    }

    /// Closed forms of the primitives. A mesh has its own volume and the gyration of its stand-in; a tool that knows better gives the inertia.
    fn of(shape: &ProbeShape<'_>) -> Self {
        match *shape {
            ProbeShape::Sphere { radius } => Self::of_ellipsoid(Vec3::splat(radius)),
            ProbeShape::Ellipsoid { semi_axes } => Self::of_ellipsoid(semi_axes),
            ProbeShape::Box { size } => Self::from_means(size.x * size.y * size.z, size * size / 12.0),
            ProbeShape::Cylinder { radius, height } => {
                let (r2, h2) = (radius * radius, height * height);
                Self::from_means(PI * r2 * height, Vec3::new(0.25 * r2, 0.25 * r2, h2 / 12.0))
            }
            ProbeShape::Cone { radius, height } => {
                let (r2, h2) = (radius * radius, height * height);
                Self::from_means(PI / 3.0 * r2 * height, Vec3::new(0.15 * r2, 0.15 * r2, 0.0375 * h2))
            }
            ProbeShape::Capsule { radius, height } => Self::of_capsule(radius, height),
            ProbeShape::Mesh(mesh) => Self { volume: mesh.volume(), ..Self::of_stand_in(&mesh.stand_in()) },
        }
    }

    fn of_stand_in(shape: &ObjectShape<'_>) -> Self {
        match *shape {
            ObjectShape::Box { size } => Self::of(&ProbeShape::Box { size }),
            ObjectShape::Cylinder { radius, height } => Self::of(&ProbeShape::Cylinder { radius, height }),
            ObjectShape::Sphere { radius } => Self::of_ellipsoid(Vec3::splat(radius)),
            ObjectShape::Ellipsoid { semi_axes } => Self::of_ellipsoid(semi_axes),
            ObjectShape::HalfSpace | ObjectShape::Mesh(_) => Self::of_ellipsoid(Vec3::splat(0.5 * shape.height())),
        }
    }

    fn of_ellipsoid(semi_axes: Vec3) -> Self {
        Self::from_means(4.0 / 3.0 * PI * semi_axes.x * semi_axes.y * semi_axes.z, semi_axes * semi_axes / 5.0)
    }

    /// Cylinder and two half balls whose flats are h/2 from the middle.
    fn of_capsule(radius: f32, height: f32) -> Self {
        let (r2, h2) = (radius * radius, height * height);
        let (tube, ball) = (PI * r2 * height, 4.0 / 3.0 * PI * r2 * radius);
        let volume = tube + ball;
        let (of_tube, of_ball) = (tube / volume, ball / volume);
        let across = of_tube * 0.25 * r2 + of_ball * 0.2 * r2;
        let along = of_tube * h2 / 12.0 + of_ball * (0.2 * r2 + 0.25 * h2 + 0.375 * height * radius);
        Self::from_means(volume, Vec3::new(across, across, along))
    }
}

/// Inertia of `parts` that share `mass` by volume.
pub(crate) fn of_parts(parts: &[ProbePart<'_>], mass: f32) -> Inertia {
    let total = parts.iter().fold(0.0, |sum, part| sum + Solid::of(&part.shape).volume);
    let tensor = parts.iter().fold(Sym3::ZERO, |sum, part| {
        let solid = Solid::of(&part.shape);
        let arm = part.position;
        // Steiner: the part as a point at its place
        let placed = Sym3::splat(arm.length_squared()) + Sym3::dyad(arm) * -1.0;
        sum + (solid.gyration.rotated(part.rotation) + placed) * (mass * (solid.volume / total))
    });
    Inertia { moments: tensor.diagonal, products: tensor.off }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    /// Inertia over the mass by counting points of a grid, in f64.
    fn counted(inside: impl Fn(f64, f64, f64) -> bool, half: [f64; 3]) -> [f64; 4] {
        let n = 60;
        let at = |i: i32, half: f64| (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0) * half;
        let (mut count, mut xx, mut yy, mut zz) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                for k in 0..n {
                    let (x, y, z) = (at(i, half[0]), at(j, half[1]), at(k, half[2]));
                    if inside(x, y, z) {
                        (count, xx, yy, zz) = (count + 1.0, xx + x * x, yy + y * y, zz + z * z);
                    }
                }
            }
        }
        let cell = half.iter().product::<f64>() * 8.0 / f64::from(n).powi(3);
        [count * cell, (yy + zz) / count, (zz + xx) / count, (xx + yy) / count]
    }

    #[test]
    fn every_shape_meets_its_integral() {
        let cases: [(ProbeShape<'_>, [f64; 4]); 6] = [
            (ProbeShape::Sphere { radius: 0.02 }, counted(|x, y, z| x * x + y * y + z * z < 4e-4, [0.02; 3])),
            (ProbeShape::Box { size: Vec3::new(0.02, 0.04, 0.06) }, counted(|_, _, _| true, [0.01, 0.02, 0.03])),
            (ProbeShape::Cylinder { radius: 0.01, height: 0.05 }, counted(|x, y, _| x * x + y * y < 1e-4, [0.01, 0.01, 0.025])),
            (
                // tip at -3/4 of the height
                ProbeShape::Cone { radius: 0.02, height: 0.04 },
                counted(|x, y, z| z < 0.01 && (x * x + y * y).sqrt() < 0.5 * (z + 0.03), [0.02, 0.02, 0.03]),
            ),
            (
                ProbeShape::Capsule { radius: 0.01, height: 0.03 },
                counted(
                    |x, y, z| {
                        let beyond = (z.abs() - 0.015).max(0.0);
                        x * x + y * y + beyond * beyond < 1e-4
                    },
                    [0.01, 0.01, 0.025],
                ),
            ),
            (
                ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.01, 0.02, 0.03) },
                counted(|x, y, z| x * x / 1e-4 + y * y / 4e-4 + z * z / 9e-4 < 1.0, [0.01, 0.02, 0.03]),
            ),
        ];
        for (shape, [volume, x, y, z]) in cases {
            let found = Solid::of(&shape);
            let d = found.gyration.diagonal;
            for (found, expected) in [(found.volume, volume), (d.x, x), (d.y, y), (d.z, z)] {
                assert!((f64::from(found) / expected - 1.0).abs() < 0.01, "{shape:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn two_balls_are_a_dumbbell_and_turn_with_their_frame() {
        let ball = ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 });
        let legs = [-0.05, 0.05].map(|x| ProbePart { position: Vec3::new(x, 0.0, 0.0), ..ball });
        let Inertia { moments, products } = of_parts(&legs, 2.0);
        let own = 2.0 * 0.4 * 1.0e-4;
        assert!((moments.x - own).abs() < 1e-9 && (moments.y - own - 2.0 * 0.0025).abs() < 1e-8, "{moments}");
        assert_eq!(products, Vec3::ZERO);

        let tilted = ProbePart {
            rotation: Quat::from_rotation_z(0.25 * PI),
            ..ProbePart::at_origin(ProbeShape::Box { size: Vec3::new(0.1, 0.02, 0.02) })
        };
        let turned = of_parts(&[tilted], 1.0);
        assert!((turned.moments.x - turned.moments.y).abs() < 1e-9);
        assert!(turned.products.x < 0.0, "mass along x = y has a negative product in the tensor: {turned:?}");
        assert_eq!(turned.check(), Ok(()));
    }

    #[test]
    fn what_no_body_has_is_refused() {
        let good = Inertia { moments: Vec3::new(1.0, 1.0, 1.0), products: Vec3::ZERO };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(Inertia::default().check(), Ok(()));
        assert!(Inertia { moments: Vec3::new(-1.0, 1.0, 1.0), ..good }.check().is_err());
        assert!(Inertia { moments: Vec3::new(3.0, 1.0, 1.0), ..good }.check().is_err());
        assert!(Inertia { products: Vec3::new(1.5, 0.0, 0.0), ..good }.check().is_err());
        assert!(Inertia { moments: Vec3::splat(f32::NAN), ..good }.check().is_err());
    }
}
