//! A loaded disc anywhere on a body: points that carry its load, and what it does to the half spaces that touch the body there.
//!
//! The tractions are those of the bonded rigid disc on a half space, 1/sqrt(a^2 - r^2) for a force and r/sqrt(a^2 - r^2) for a torque, summed over
//! points. Each point lies on the true surface and loads **its own** half space, the one that touches the body there: on curved bodies no point then
//! floats above the surface, and what is left to finite elements grows no faster than 1/r towards the disc.
//!
//! Loads and moves are four numbers: along world x, y, z and about the disc's normal.

use glam::{DMat3, DVec3};

use super::element::GAUSS;
use super::half_space;
use super::solid::{Cut, Spot};

/// What four unit loads do: row = move, column = load.
pub(crate) type Block = [[f64; 4]; 4];

/// Rays of the quadrature.
const RAYS: usize = 8;

/// From here on, in radii of the disc, one ring of points stands for it: the ring has the disc's second moments, the fourth differ by some 1e-3 of
/// the field.
const FAR: f64 = 5.0;

/// Mean of 1/r over a square of side s about its middle, as a distance in s: no sample of tractions that grow as 1/r may count for more.
const CORE: f64 = 0.284;

/// A point of the disc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// In the plane that touches the disc's middle.
    pub flat: DVec3,
    /// On the surface.
    pub at: DVec3,
    /// Axes of its half space: two along the surface, the third into the body.
    axes: DMat3,
    /// Share of a force.
    pub share: f64,
    /// Force per torque about the disc's normal.
    pub around: DVec3,
}

impl Point {
    /// A point whose displacement is read.
    pub(crate) fn alone(at: DVec3) -> Self {
        Self { flat: at, at, axes: DMat3::IDENTITY, share: 1.0, around: DVec3::ZERO }
    }
}

/// A disc.
#[derive(Clone, Debug)]
pub(crate) struct Disc {
    pub spot: Spot,
    pub radius: f64,
    /// Points of the disc.
    pub fine: Vec<Point>,
    /// The same between the rays of `fine`.
    pub between: Vec<Point>,
    /// One ring with the disc's second moments.
    pub ring: Vec<Point>,
}

/// Axes along the surface and into it.
fn inwards(normal: DVec3) -> DMat3 {
    let (e1, _) = normal.any_orthonormal_pair();
    DMat3::from_cols(e1, e1.cross(normal), -normal)
}

/// Points on a circle of radius `r` about `spot`, the first `start` rays on; they share the load `weight`, of a disc with mean square radius `square`.
fn circle(cut: &Cut, spot: &Spot, r: f64, start: f64, weight: f64, square: f64) -> impl Iterator<Item = Point> {
    let (e1, e2) = spot.normal.any_orthonormal_pair();
    // e1, e2, normal right-handed
    let e2 = if e1.cross(e2).dot(spot.normal) < 0.0 { -e2 } else { e2 };
    let (cut, spot) = (*cut, *spot);
    (0..RAYS).map(move |ray| {
        let (sin, cos) = ((ray as f64 + start) * std::f64::consts::TAU / RAYS as f64).sin_cos();
        let flat = spot.point + (e1 * cos + e2 * sin) * r;
        let Spot { point: at, normal } = cut.along(flat, spot.normal);
        let share = weight / RAYS as f64;
        Point { flat, at, axes: inwards(normal), share, around: (e2 * cos - e1 * sin) * (share * r / square) }
    })
}

impl Disc {
    /// A disc of `radius` about `spot`.
    pub(crate) fn new(cut: &Cut, spot: Spot, radius: f64) -> Self {
        let square = radius * radius * 2.0 / 3.0;
        // r = a sqrt(1 - c^2): the bonded disc's weights are even in c
        let all = |start: f64| {
            GAUSS
                .iter()
                .flat_map(|(g, w)| {
                    let c = 0.5 * (1.0 + g);
                    circle(cut, &spot, radius * (1.0 - c * c).sqrt(), start, 0.5 * w, square)
                })
                .collect()
        };
        let ring = circle(cut, &spot, square.sqrt(), 0.5, 1.0, square).collect();
        Self { spot, radius, fine: all(0.5), between: all(0.0), ring }
    }

    /// Points of a circle of radius `r` about the disc's middle, whose mean move stands for that of the surface there.
    pub(crate) fn circle(&self, cut: &Cut, r: f64) -> Vec<Point> {
        circle(cut, &self.spot, r, 0.5, 1.0, r * r).collect()
    }

    /// The points that stand for the disc at `distance` from its middle.
    pub(crate) fn points(&self, distance: f64) -> &[Point] {
        if distance > FAR * self.radius { &self.ring } else { &self.fine }
    }

    /// Displacement of `x` under the four unit loads.
    pub(crate) fn moves(&self, x: DVec3, nu: f64) -> [DVec3; 4] {
        self.sum(x, |point| half_space::displacements(point.axes.transpose() * (x - point.at), nu))
    }

    /// Tractions under the four unit loads at `x` on a surface with the area vector `n`.
    pub(crate) fn tractions(&self, x: DVec3, n: DVec3, nu: f64) -> [DVec3; 4] {
        let least = CORE * n.length().sqrt();
        self.sum(x, |point| {
            let r = point.axes.transpose() * (x - point.at);
            half_space::tractions(r, point.axes.transpose() * n, nu) * (r.length() / least).min(1.0)
        })
    }

    fn sum(&self, x: DVec3, local: impl Fn(&Point) -> DMat3) -> [DVec3; 4] {
        let (mut whole, mut turned) = (DMat3::ZERO, DVec3::ZERO);
        for point in self.points(x.distance(self.spot.point)) {
            let world = point.axes * local(point) * point.axes.transpose();
            whole += world * point.share;
            turned += world * point.around;
        }
        [whole.x_axis, whole.y_axis, whole.z_axis, turned]
    }

    /// Mean move of the disc on its own half spaces beyond that on the one half space that touches its middle: what its curvature adds nearby.
    pub(crate) fn bent(&self, nu: f64) -> Block {
        let axes = inwards(self.spot.normal);
        let mut block = Block::default();
        for to in &self.between {
            let (mut whole, mut turned) = (DMat3::ZERO, DVec3::ZERO);
            for from in &self.fine {
                let curved =
                    from.axes * half_space::displacements(from.axes.transpose() * (to.at - from.at), nu) * from.axes.transpose();
                let flat = axes * half_space::displacements(axes.transpose() * (to.flat - from.flat), nu) * axes.transpose();
                whole += (curved - flat) * from.share;
                turned += (curved - flat) * from.around;
            }
            add(&mut block, to, &[whole.x_axis, whole.y_axis, whole.z_axis, turned]);
        }
        block
    }
}

/// Adds what the displacements `columns` at `point`, one per load, do to the mean move.
pub(crate) fn add(block: &mut Block, point: &Point, columns: &[DVec3; 4]) {
    for (load, u) in columns.iter().enumerate() {
        for axis in 0..3 {
            block[axis][load] += point.share * u[axis];
        }
        block[3][load] += point.around.dot(*u);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::solid::Solid;

    #[test]
    fn on_a_plane_the_points_carry_the_disc_and_nothing_is_bent() {
        let cut = Cut::new(Solid::Box { size: DVec3::splat(2.0) }, 0.0);
        let disc = Disc::new(&cut, Spot { point: DVec3::Z * 2.0, normal: DVec3::Z }, 0.1);
        assert!(disc.bent(0.3).iter().flatten().all(|value| value.abs() < 1.0e-12));
        for points in [&disc.fine, &disc.between, &disc.ring] {
            let force: f64 = points.iter().map(|p| p.share).sum();
            let torque: DVec3 = points.iter().map(|p| (p.flat - disc.spot.point).cross(p.around)).sum();
            assert!((force - 1.0).abs() < 1.0e-12 && (torque - DVec3::Z).length() < 1.0e-12, "{force} {torque}");
        }
        // Mindlin's and Reissner-Sagoci's fields at twice the radius
        let at = disc.moves(DVec3::new(0.2, 0.0, 2.0), 0.5);
        let exact = 1.5 / 8.0 / 0.1 * std::f64::consts::FRAC_2_PI * (0.5_f64.asin() + 1.0 / 3.0 * 0.5 * 0.75_f64.sqrt());
        assert!((at[0].x / exact - 1.0).abs() < 5.0e-3, "{} {exact}", at[0].x);
        let turn = 3.0 / 16.0e-3 * std::f64::consts::FRAC_2_PI * (0.5_f64.asin() - 0.5 * 0.75_f64.sqrt());
        assert!((at[3].y / (0.2 * turn) - 1.0).abs() < 2.0e-2, "{} {turn}", at[3].y / 0.2);
    }
}
