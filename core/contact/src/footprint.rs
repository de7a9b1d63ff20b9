//! The footprint of one patch: radius, load and profile from depth and shape (PHYSICS 3.1; theory.md, section 3).

use glam::{Quat, Vec3};

use crate::World;
use crate::frames::Pose;
use crate::geometry::curvature::{self, Curvature};
use crate::geometry::deepest::{Deepest, PartFrame};
use crate::geometry::edges::Edges;
use crate::geometry::gap::deepest_meaningful;
use crate::geometry::outline::{LEVELS, Levels, Stand};
use crate::geometry::support;
use crate::math::{GAUSS_4, PI, cbrt, clamp, exp, ln, max, min, perpendicular, pow, pow_3_2, root, sqrt};
use crate::mesh_shape::MeshShape;
use crate::model::{Model, ObjectShape, ProbePart, ProbeShape};
use crate::overlap::{Growth, Standing};
use crate::params::{FORCE_TABLE_LEN, ForceLaw};
use crate::profile::FULLNESS_HERTZ;

/// What the normal direction says about a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Contact radius a (of equal area where the patch is not round) \[m\].
    pub radius: f32,
    /// Normal force P \[N\].
    pub load: f32,
    /// Fullness of the pressure profile.
    pub fullness: f32,
    /// How many times longer than wide the patch is, 1 where it is round.
    pub aspect: f32,
    /// Small strain does not hold here.
    pub large_strain: bool,
}

impl Footprint {
    /// No contact.
    pub const NONE: Self = Self { radius: 0.0, load: 0.0, fullness: FULLNESS_HERTZ, aspect: 1.0, large_strain: false };
}

/// A normal force, and how it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Normal force P \[N\].
    pub load: f32,
    /// dP/d(depth) \[N/m\].
    pub slope: f32,
}

/// What a footprint is read from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// Hertz's closed forms.
    Smooth(Hertz),
    /// The overlap at every depth, and the centre of the patch in the part's frame.
    Cut(Growth, Vec3),
}

/// The constant geometry of a patch in one tick: what a footprint needs besides the depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    form: Form,
    /// Slices of the part that edges of the object cut.
    cuts: u8,
    /// Mean curvature of the object \[1/m\].
    object_mean: f32,
    /// Radius of the largest disc the object's face can offer \[m\].
    widest: f32,
    /// Depth beyond which figures mean nothing \[m\].
    deepest_meaningful: f32,
}

impl Seat {
    /// Geometry at the deepest point of `part`.
    pub fn new(model: &Model<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, at: &Deepest) -> Self {
        let n = at.gap.normal;
        let e1 = perpendicular(n);
        let place = Place {
            object: &model.object,
            at,
            to_part: x_wa.rotation.conjugate(),
            origin: x_wa.position,
            frame: [n, e1, n.cross(e1)],
        };
        let bent = curvature::of_object(&model.object, at.point, n, e1, n.cross(e1));
        let widest = min(widest_disc(&model.object, n), support::widest_disc(&part.shape));
        let deepest_meaningful = min(deepest_meaningful(&model.object), support::half_thickness(&part.shape));
        let (form, cuts) = place.form(&part.shape, bent, widest, deepest_meaningful);
        Self { form, cuts, object_mean: bent.mean(), widest, deepest_meaningful }
    }

    /// The same for a contact that has gone deeper since it was seen, to `depth` \[m\].
    pub fn stretched(&self, depth: f32) -> Self {
        let used = min(depth, self.deepest_meaningful);
        match &self.form {
            Form::Smooth(_) => *self,
            Form::Cut(growth, middle) => Self { form: Form::Cut(growth.stretched(used), *middle), ..*self },
        }
    }

    /// How many slices of the part the edges of the object cut, to see what they leave of the patch.
    pub const fn cuts(&self) -> u8 {
        self.cuts
    }

    /// Mean radius of curvature of the object \[m\]; infinite on flat faces.
    pub fn object_radius(&self) -> f32 {
        if self.object_mean > 0.0 { 1.0 / self.object_mean } else { f32::INFINITY }
    }

    /// Centre of the patch in the part's frame, `None` where it is the deepest point itself.
    pub fn centroid(&self) -> Option<Vec3> {
        match self.form {
            Form::Smooth(_) => None,
            Form::Cut(_, middle) => Some(middle),
        }
    }

    /// Footprint at `depth` > 0 \[m\].
    pub fn footprint(&self, contact_modulus: f32, depth: f32) -> Footprint {
        let depth_used = min(depth, self.deepest_meaningful);
        let mut footprint = match &self.form {
            Form::Smooth(hertz) => hertz.footprint(contact_modulus, depth_used),
            Form::Cut(growth, _) => cut(growth, contact_modulus, depth_used),
        };
        footprint.large_strain |= depth > self.deepest_meaningful || footprint.radius > self.widest;
        footprint.radius = min(footprint.radius, self.widest);
        footprint
    }

    /// The load of the footprint at `depth` > 0 \[m\], without the rest of it.
    pub fn push(&self, contact_modulus: f32, depth: f32) -> Push {
        let depth_used = min(depth, self.deepest_meaningful);
        let push = match &self.form {
            Form::Smooth(hertz) => hertz.push(contact_modulus, depth_used),
            Form::Cut(growth, _) => Section::new(growth, depth_used).push(growth, contact_modulus, depth_used),
        };
        if depth > self.deepest_meaningful { Push { slope: 0.0, ..push } } else { push }
    }
}

/// Where a part stands on the object.
struct Place<'a> {
    object: &'a ObjectShape<'a>,
    at: &'a Deepest,
    to_part: Quat,
    /// Origin of the part in world \[m\].
    origin: Vec3,
    /// The contact's normal and tangents in world.
    frame: [Vec3; 3],
}

impl Place<'_> {
    /// What the footprint of `shape` is read from, where the object is `bent`, and how many slices edges cut.
    fn form(&self, shape: &ProbeShape<'_>, bent: Curvature, widest: f32, meaningful: f32) -> (Form, u8) {
        let [d, e1, e2] = [-self.frame[0], self.frame[1], self.frame[2]].map(|e| self.to_part * e);
        let lowest = self.to_part * (self.at.point - self.origin);
        let edges = Edges::about(self.object, self.at, self.frame, self.to_part, lowest, 2.0 * support::reach(shape));
        let (depth, area) = (-self.at.gap.distance, PI * widest * widest);
        let used = min(depth, meaningful);
        let form = match (shape, shape.primitive()) {
            (&ProbeShape::Sphere { radius }, _) => {
                Form::Smooth(Hertz::new(Curvature::isotropic(1.0 / radius).plus(bent).principal()))
            }
            (&ProbeShape::Ellipsoid { semi_axes }, _) => {
                Form::Smooth(Hertz::new(curvature::of_ellipsoid(semi_axes, d, e1, e2).plus(bent).principal()))
            }
            (ProbeShape::Mesh(mesh), _) => {
                let (levels, middle) = outlined(mesh, lowest, [-d, e1, e2], bent, depth, edges.as_ref());
                Form::Cut(Growth::of_outlines(&levels, used, area), middle)
            }
            (_, Some(shape)) => {
                let edges = edges.as_ref().filter(|edges| edges.may_cut(&shape));
                // a part that lies deeper than where it touches, as one that holds the middle of a ball, is cut through its own middle at most
                let below =
                    clamp((support::support(&shape, d) - lowest).dot(d), 0.0, max(support::half_thickness(&shape) - depth, 0.0));
                let standing = Standing { shape: &shape, d, below, edges, curvature: bent.mean(), widest: area };
                let (growth, middle) = standing.growth(depth, used);
                Form::Cut(growth, middle)
            }
            (_, None) => Form::Smooth(Hertz::new(bent.principal())),
        };
        (form, edges.as_ref().map_or(0, Edges::cuts))
    }
}

/// Outlines of a mesh part whose deepest point is `lowest` in the part's frame, on an object of the curvature `bent` in the tangents of `frame`, and the centroid of
/// the last.
fn outlined(
    mesh: &MeshShape<'_>,
    lowest: Vec3,
    frame: [Vec3; 3],
    bent: Curvature,
    depth: f32,
    edges: Option<&Edges>,
) -> (Levels, Vec3) {
    let mut outlines = Stand { grid: mesh.grid(), lowest, frame, object: bent, reach: mesh.reach() }.outlines(depth);
    if let Some(edges) = edges {
        for (outline, s) in outlines.iter_mut().zip(LEVELS) {
            let (share, moved) = edges.kept(&outline.corners, depth * s * s);
            outline.area *= share;
            outline.centroid += moved;
        }
    }
    let [_, e1, e2] = frame;
    let middle = outlines[LEVELS.len() - 1].centroid;
    (Levels::new(depth, &outlines), lowest + e1 * middle.x + e2 * middle.y)
}

/// P = 2 E* integral of a over depth, with a from the profile of equal overlap area (theory.md, equations 3.6 to 3.9).
fn cut(growth: &Growth, contact_modulus: f32, depth: f32) -> Footprint {
    let section = Section::new(growth, depth);
    let (round, pressed) = section.means(growth);
    let load = section.load(contact_modulus, depth, pressed);
    let fullness = if section.whole > 0.0 { round / section.whole } else { FULLNESS_HERTZ };
    Footprint { radius: section.shrink * section.whole, load, fullness, aspect: growth.aspect(), large_strain: false }
}

/// Where a growing overlap is read, and what it says there.
struct Section {
    /// Square root of the share of the contact's depth.
    share: f32,
    /// Radius of the overlap \[m\].
    whole: f32,
    /// Contact radius over it.
    shrink: f32,
}

impl Section {
    fn new(growth: &Growth, depth: f32) -> Self {
        let share = growth.share(depth);
        let whole = growth.radius(share);
        Self { share, whole, shrink: contact_over_slice(exponent(whole, growth.half(share))) }
    }

    /// The slope leaves out how the ratio of the radii changes, which for a power does not.
    fn push(&self, growth: &Growth, contact_modulus: f32, depth: f32) -> Push {
        let (_, pressed) = self.means(growth);
        Push {
            load: self.load(contact_modulus, depth, pressed),
            slope: 2.0 * contact_modulus * self.shrink * growth.pressed(self.share),
        }
    }

    fn load(&self, contact_modulus: f32, depth: f32, pressed: f32) -> f32 {
        2.0 * contact_modulus * depth * self.shrink * pressed
    }

    /// Means over the depth of the radius, and of the same times the factor of a long footprint \[m\]. The rule runs over the square root of the depth's share, in
    /// which every power of the radius is a polynomial.
    fn means(&self, growth: &Growth) -> (f32, f32) {
        let (mut round, mut pressed) = (0.0, 0.0);
        for (s, w) in GAUSS_4 {
            pressed += w * 2.0 * s * growth.pressed(self.share * s);
            round += w * 2.0 * s * growth.radius(self.share * s);
        }
        (round, pressed)
    }
}

/// Local exponent n of depth over radius, from the radii of the overlap at a depth and at half of it.
fn exponent(radius: f32, half_radius: f32) -> f32 {
    let growth = ln(radius / half_radius);
    let n = if growth > 0.0 { ln(2.0) / growth } else { LARGEST_EXPONENT };
    if n.is_finite() { clamp(n, 1.0, LARGEST_EXPONENT) } else { LARGEST_EXPONENT }
}

/// Exponent that stands for a flat punch: its footprint is a flat one's within 0.1 %.
const LARGEST_EXPONENT: f32 = 1.0e4;

/// a over the slice radius for f = A r^n: kappa^(-1/n), kappa = sqrt(pi) Gamma(n/2 + 1) / Gamma(n/2 + 1/2); 0.4 % at n = 1, less above.
fn contact_over_slice(n: f32) -> f32 {
    let x = 0.5 * n;
    let ratio = x * x + 0.5 * x + 0.125;
    exp(-(0.5 * ln(PI) + 0.25 * ln(ratio)) / n)
}

/// Radius of the disc with the area of the object's face \[m\].
fn widest_disc(object: &ObjectShape<'_>, n: Vec3) -> f32 {
    match *object {
        ObjectShape::HalfSpace => f32::MAX,
        ObjectShape::Box { size } => {
            let area = n.z.abs() * size.x * size.y + n.y.abs() * size.x * size.z + n.x.abs() * size.y * size.z;
            sqrt(area / PI)
        }
        ObjectShape::Sphere { radius } => radius,
        ObjectShape::Ellipsoid { semi_axes } => semi_axes.max_element(),
        ObjectShape::Cylinder { radius, height } => {
            if n.z.abs() > 0.5 {
                radius
            } else {
                sqrt(2.0 * radius * height / PI)
            }
        }
        ObjectShape::Mesh(mesh) => widest_disc(&mesh.stand_in(), n),
    }
}

/// Largest a/R at which the true-sphere corrections hold (shared tables: a/R <= 0.35 is small strain).
const SMALL_STRAIN: f32 = 0.35;

/// Hertz with two curvatures and the true sphere's correction (theory.md, equations 3.1 and 3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hertz {
    /// R \[m\].
    radius: f32,
    f1: f32,
    f2: f32,
    aspect: f32,
}

impl Hertz {
    /// Of principal curvatures of the gap, larger first \[1/m\].
    fn new((k_large, k_small): (f32, f32)) -> Self {
        let k_small = max(k_small, k_large * LEAST_CURVATURE_RATIO);
        let radius = 1.0 / sqrt(k_large * k_small);
        let ratio = k_large / k_small;
        let (f1, f2) = if ratio > 1.000_1 { elliptic(ratio) } else { (1.0, 1.0) };
        let aspect = if ratio > 1.000_1 { cbrt(ratio * ratio) } else { 1.0 };
        Self { radius, f1, f2, aspect }
    }

    fn footprint(&self, contact_modulus: f32, depth: f32) -> Footprint {
        let share = self.share(depth);
        let a = root(self.radius * (depth / self.f2)) * self.f1 * (1.0 - share / 6.0);
        let load = self.paraboloid(contact_modulus, depth) * (1.0 - share / 10.0);
        Footprint { radius: a, load, fullness: FULLNESS_HERTZ, aspect: self.aspect, large_strain: a > SMALL_STRAIN * self.radius }
    }

    fn push(&self, contact_modulus: f32, depth: f32) -> Push {
        let (share, load) = (self.share(depth), self.paraboloid(contact_modulus, depth));
        // 3/2 (1 - share/10) and, while the share grows, -share/10
        let exponent = if share < 1.0 { 1.5 - 0.25 * share } else { 1.35 };
        Push { load: load * (1.0 - share / 10.0), slope: exponent * load / depth }
    }

    /// Load without the sphere's correction \[N\].
    fn paraboloid(&self, contact_modulus: f32, depth: f32) -> f32 {
        4.0 / 3.0 * contact_modulus * sqrt(self.radius) * pow_3_2(depth / self.f2)
    }

    /// Depth over radius, as far as the correction goes.
    fn share(&self, depth: f32) -> f32 {
        min(depth / self.radius, 1.0)
    }
}

/// A line contact is treated as one of this curvature ratio: beyond it the ellipse is longer than any body here.
const LEAST_CURVATURE_RATIO: f32 = 1.0e-4;

/// Factors F1 (radius) and F2 (depth) of an elliptic contact with curvature ratio R'/R'' >= 1: c = F1 (3PR/4E*)^(1/3) and
/// delta = F2 (9P^2/16 E*^2 R)^(1/3), fits of Johnson, Contact Mechanics, section 4.2 (c = sqrt(ab), R = sqrt(R'R'')).
fn elliptic(ratio: f32) -> (f32, f32) {
    let f1 = 1.0 - pow(pow(ratio, 0.0602) - 1.0, 1.456);
    let f2 = 1.0 - pow(pow(ratio, 0.0684) - 1.0, 1.531);
    (max(f1, 0.2), max(f2, 0.2))
}

/// Load of an explicit force law at `depth`, `None` where the footprint decides.
pub fn law_load(law: &ForceLaw, depth: f32) -> Option<f32> {
    law_push(law, depth).map(|push| push.load)
}

/// The same, and how it grows.
pub fn law_push(law: &ForceLaw, depth: f32) -> Option<Push> {
    match *law {
        ForceLaw::Hertz => None,
        ForceLaw::Cubic { k1, k3 } => {
            Some(Push { load: k1 * depth + k3 * depth * depth * depth, slope: k1 + 3.0 * k3 * depth * depth })
        }
        ForceLaw::Table { step, force } => {
            let place = clamp(depth / step, 0.0, (FORCE_TABLE_LEN - 1) as f32);
            let index = min(place, (FORCE_TABLE_LEN - 2) as f32) as usize;
            let [low, high] = force.get(index..).and_then(<[f32]>::first_chunk).copied().unwrap_or_default();
            let slope = if place < (FORCE_TABLE_LEN - 1) as f32 { (high - low) / step } else { 0.0 };
            Some(Push { load: low + (high - low) * (place - index as f32), slope })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const E_STAR: f32 = 4.0e6;

    /// A part upright on an object of this mean curvature, pressed by `depth`.
    fn level(shape: ProbeShape<'static>, object_mean: f32, depth: f32) -> Footprint {
        let standing = Standing { shape: &shape, d: -Vec3::Z, below: 0.0, edges: None, curvature: object_mean, widest: f32::MAX };
        let (growth, middle) = standing.growth(depth, depth);
        let form = Form::Cut(growth, middle);
        Seat { form, cuts: 0, object_mean, widest: f32::MAX, deepest_meaningful: 1.0 }.footprint(E_STAR, depth)
    }

    fn near(a: f32, b: f32, relative: f32) -> bool {
        (a - b).abs() <= relative * b.abs()
    }

    #[test]
    fn a_flat_punch_gives_2_e_a_delta() {
        let found = level(ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, 0.0, 1.0e-3);
        assert!(near(found.load, 2.0 * E_STAR * 0.01 * 1.0e-3, 2.0e-3) && near(found.radius, 0.01, 1.0e-3), "{found:?}");
        assert!(near(found.fullness, 1.0, 1.0e-3));
    }

    #[test]
    fn a_cone_gives_its_closed_form() {
        let (radius, height, depth) = (0.02, 0.01, 1.0e-3);
        let found = level(ProbeShape::Cone { radius, height }, 0.0, depth);
        let tan = radius / height;
        assert!(near(found.radius, 2.0 / PI * depth * tan, 5.0e-3), "{found:?}");
        assert!(near(found.load, 2.0 / PI * E_STAR * depth * depth * tan, 1.0e-2), "{found:?}");
        assert!(near(found.fullness, 0.5, 1.0e-2));
    }

    #[test]
    fn a_round_end_sliced_is_hertz() {
        let found = level(ProbeShape::Capsule { radius: 0.02, height: 0.03 }, 0.0, 1.0e-4);
        let hertz = Hertz::new((50.0, 50.0)).footprint(E_STAR, 1.0e-4);
        assert!(near(found.load, hertz.load, 1.0e-2) && near(found.radius, hertz.radius, 1.0e-2), "{found:?} {hertz:?}");
    }

    #[test]
    fn a_flat_end_on_a_ball_is_hertz_with_the_balls_radius() {
        let found = level(ProbeShape::Cylinder { radius: 0.05, height: 0.04 }, 1.0 / 0.05, 1.0e-4);
        let hertz = Hertz::new((20.0, 20.0)).footprint(E_STAR, 1.0e-4);
        assert!(near(found.load, hertz.load, 1.0e-2) && near(found.radius, hertz.radius, 1.0e-2), "{found:?} {hertz:?}");
    }

    #[test]
    fn a_crossed_pair_of_cylinders_is_the_ball() {
        let ball = Hertz::new((50.0, 50.0)).footprint(E_STAR, 1.0e-3);
        let ellipse = Hertz::new((100.0, 25.0)).footprint(E_STAR, 1.0e-3);
        assert!(near(ellipse.load, ball.load * 1.043, 0.03), "{ellipse:?} {ball:?}");
    }

    #[test]
    fn sphere_against_the_exact_solution() {
        // Sneddon: R = 20 mm, E = 3 MPa, nu = 0.5, depth 1 mm and 5 mm
        for (depth, load, radius) in [(1.0e-3, 23.7321, 0.004_434_84), (5.0e-3, 260.01, 0.009_587)] {
            let found = Hertz::new((50.0, 50.0)).footprint(E_STAR, depth);
            assert!(near(found.load, load, 3.0e-3) && near(found.radius, radius, 5.0e-3), "{found:?}");
        }
    }
}
