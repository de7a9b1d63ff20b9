//! Where straight lines meet the bodies of a scene, in `f64`: how the gap of the undeformed bodies is measured without the core.

use haptor_contact::{ObjectShape, ProbePart, ProbeShape, Vec3};
use haptor_mesh::{DVec3, Mesh};

use super::boxes::Boxes;

/// A solid about its own origin.
pub enum Solid {
    /// Everything below z = 0.
    HalfSpace,
    /// Box about the origin, half its edges.
    Box(DVec3),
    /// Ellipsoid about the origin.
    Ellipsoid(DVec3),
    /// Cylinder about the origin, axis z: radius, half its height.
    Cylinder(f64, f64),
    /// Cone of this radius and height, tip down, the origin 3/4 of the height above it.
    Cone(f64, f64),
    /// Cylinder with round ends, axis z: radius, half the straight part.
    Capsule(f64, f64),
    /// A closed mesh.
    Mesh(Boxes),
}

/// A solid at its place.
pub struct Placed {
    solid: Solid,
    origin: DVec3,
    /// From the solid's frame to that of its place.
    axes: [DVec3; 3],
}

const UPRIGHT: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

impl Placed {
    /// The elastic body, in world; `skin` where it is a mesh.
    pub fn object(shape: &ObjectShape<'_>, skin: Option<&Mesh>) -> Self {
        let raised = |solid, height: f32| Self { solid, origin: DVec3::Z * f64::from(height) / 2.0, axes: UPRIGHT };
        match (*shape, skin) {
            (_, Some(mesh)) => raised(Solid::Mesh(Boxes::new(mesh)), 0.0),
            (ObjectShape::HalfSpace | ObjectShape::Mesh(_), None) => raised(Solid::HalfSpace, 0.0),
            (ObjectShape::Box { size }, None) => raised(Solid::Box(size.as_dvec3() / 2.0), size.z),
            (ObjectShape::Sphere { radius }, None) => raised(Solid::Ellipsoid(DVec3::splat(radius.into())), 2.0 * radius),
            (ObjectShape::Ellipsoid { semi_axes }, None) => raised(Solid::Ellipsoid(semi_axes.as_dvec3()), 2.0 * semi_axes.z),
            (ObjectShape::Cylinder { radius, height }, None) => {
                raised(Solid::Cylinder(radius.into(), f64::from(height) / 2.0), height)
            }
        }
    }

    /// A part of the probe, in the probe's frame; `skin` where it is a mesh. `None` for a mesh without one.
    pub fn part(part: &ProbePart<'_>, skin: Option<&Mesh>) -> Option<Self> {
        let half = |length: f32| f64::from(length) / 2.0;
        let solid = match (part.shape, skin) {
            (_, Some(mesh)) => Solid::Mesh(Boxes::new(mesh)),
            (ProbeShape::Mesh(_), None) => return None,
            (ProbeShape::Sphere { radius }, None) => Solid::Ellipsoid(DVec3::splat(radius.into())),
            (ProbeShape::Box { size }, None) => Solid::Box(size.as_dvec3() / 2.0),
            (ProbeShape::Cylinder { radius, height }, None) => Solid::Cylinder(radius.into(), half(height)),
            (ProbeShape::Cone { radius, height }, None) => Solid::Cone(radius.into(), height.into()),
            (ProbeShape::Capsule { radius, height }, None) => Solid::Capsule(radius.into(), half(height)),
            (ProbeShape::Ellipsoid { semi_axes }, None) => Solid::Ellipsoid(semi_axes.as_dvec3()),
        };
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| (part.rotation * axis).as_dvec3());
        Some(Self { solid, origin: part.position.as_dvec3(), axes })
    }

    /// Stretch of the line `from` + t `along` that lies in the solid; `None` where the line misses it.
    pub fn stretch(&self, from: DVec3, along: DVec3) -> Option<[f64; 2]> {
        let inside = |v: DVec3| DVec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v));
        self.solid.stretch(inside(from - self.origin), inside(along))
    }
}

impl Solid {
    fn stretch(&self, o: DVec3, d: DVec3) -> Option<[f64; 2]> {
        let found = match self {
            Self::HalfSpace => slab(o.z, d.z, f64::NEG_INFINITY, 0.0),
            Self::Box(half) => {
                common(&[slab(o.x, d.x, -half.x, half.x), slab(o.y, d.y, -half.y, half.y), slab(o.z, d.z, -half.z, half.z)])
            }
            &Self::Ellipsoid(a) => ball(o / a, d / a, 1.0),
            &Self::Cylinder(radius, half) => common(&[tube(o, d, radius), slab(o.z, d.z, -half, half)]),
            &Self::Cone(radius, height) => {
                common(&[cone(o, d, radius / height, -0.75 * height), slab(o.z, d.z, -0.75 * height, 0.25 * height)])
            }
            &Self::Capsule(radius, half) => {
                let end = |z: f64| ball(o - DVec3::Z * z, d, radius);
                either(&[common(&[tube(o, d, radius), slab(o.z, d.z, -half, half)]), end(half), end(-half)])
            }
            Self::Mesh(boxes) => either(&boxes.near(o, d).map(|corners| triangle(corners, o, d)).collect::<Vec<_>>()),
        };
        (found[0] <= found[1]).then_some(found)
    }
}

/// A stretch of nothing.
const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn common(parts: &[[f64; 2]]) -> [f64; 2] {
    parts.iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [from, to]| [low.max(*from), high.min(*to)])
}

fn either(parts: &[[f64; 2]]) -> [f64; 2] {
    parts.iter().filter(|[from, to]| from <= to).fold(NONE, |[low, high], [from, to]| [low.min(*from), high.max(*to)])
}

fn slab(o: f64, d: f64, low: f64, high: f64) -> [f64; 2] {
    if d == 0.0 {
        return if (low..=high).contains(&o) { [f64::NEG_INFINITY, f64::INFINITY] } else { NONE };
    }
    let (a, b) = ((low - o) / d, (high - o) / d);
    [a.min(b), a.max(b)]
}

/// Roots of a t^2 + 2 b t + c = 0, where the left side is not positive between them.
fn between_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let under = b * b - a * c;
    if under < 0.0 || a <= 0.0 {
        return if a <= 0.0 && c <= 0.0 { [f64::NEG_INFINITY, f64::INFINITY] } else { NONE };
    }
    [(-b - under.sqrt()) / a, (-b + under.sqrt()) / a]
}

fn ball(o: DVec3, d: DVec3, radius: f64) -> [f64; 2] {
    between_roots(d.dot(d), o.dot(d), o.dot(o) - radius * radius)
}

fn tube(o: DVec3, d: DVec3, radius: f64) -> [f64; 2] {
    between_roots(d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y, o.x * o.x + o.y * o.y - radius * radius)
}

/// Both nappes of x^2 + y^2 <= (slope (z - tip))^2; the slab that goes with it keeps the upper one.
fn cone(o: DVec3, d: DVec3, slope: f64, tip: f64) -> [f64; 2] {
    let (z, s) = (o.z - tip, slope * slope);
    let (a, b, c) =
        (d.x * d.x + d.y * d.y - s * d.z * d.z, o.x * d.x + o.y * d.y - s * z * d.z, o.x * o.x + o.y * o.y - s * z * z);
    if a > 0.0 {
        return between_roots(a, b, c);
    }
    // steeper than the side: inside from where the line meets the upper nappe on
    let root = (b * b - a * c).max(0.0).sqrt();
    let roots = if a == 0.0 { [-c / (2.0 * b); 2] } else { [(-b - root) / a, (-b + root) / a] };
    let Some(meets) = roots.into_iter().find(|t| z + t * d.z >= 0.0) else { return NONE };
    if d.z > 0.0 { [meets, f64::INFINITY] } else { [f64::NEG_INFINITY, meets] }
}

/// A point where the line goes through a triangle.
fn triangle([a, b, c]: [DVec3; 3], o: DVec3, d: DVec3) -> [f64; 2] {
    let (u, v) = (b - a, c - a);
    let (p, s) = (d.cross(v), o - a);
    let volume = u.dot(p);
    if volume == 0.0 {
        return NONE;
    }
    let q = s.cross(u);
    let (x, y) = (s.dot(p) / volume, d.dot(q) / volume);
    let at = v.dot(q) / volume;
    if x >= 0.0 && y >= 0.0 && x + y <= 1.0 { [at, at] } else { NONE }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: DVec3 = DVec3::Z;

    fn lowest(solid: &Solid, x: f64) -> Option<f64> {
        solid.stretch(DVec3::new(x, 0.0, -10.0), UP).map(|[from, _]| from - 10.0)
    }

    #[test]
    fn lines_meet_the_undersides() {
        let near = |found: Option<f64>, want: f64| assert!((found.unwrap() - want).abs() < 1e-12, "{found:?} {want}");
        near(lowest(&Solid::Ellipsoid(DVec3::new(2.0, 1.0, 3.0)), 1.0), -3.0 * 0.75_f64.sqrt());
        near(lowest(&Solid::Box(DVec3::new(2.0, 1.0, 3.0)), 1.0), -3.0);
        near(lowest(&Solid::Cylinder(2.0, 3.0), 1.9), -3.0);
        near(lowest(&Solid::Capsule(1.0, 3.0), 0.6), -3.8);
        // a cone of radius 1 and height 4: the side rises 4 to 1
        near(lowest(&Solid::Cone(1.0, 4.0), 0.5), -3.0 + 2.0);
        assert_eq!(lowest(&Solid::Cone(1.0, 4.0), 1.5), None);
        assert_eq!(lowest(&Solid::Ellipsoid(DVec3::ONE), 1.5), None);
    }

    #[test]
    fn a_mesh_is_met_like_the_box_it_is() {
        let mesh = haptor_mesh::tessellate::cuboid(DVec3::new(2.0, 4.0, 6.0));
        let found = Solid::Mesh(Boxes::new(&mesh)).stretch(DVec3::new(0.3, 0.2, -9.0), UP).unwrap();
        assert!((found[0] - 6.0).abs() < 1e-12 && (found[1] - 12.0).abs() < 1e-12, "{found:?}");
    }
}
