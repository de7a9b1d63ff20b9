//! Interpolants of least bending energy between the anchors: thin plates across, natural cubic splines along.

#![expect(clippy::needless_range_loop, reason = "one index over several arrays is the form that becomes vector instructions")]

use glam::Vec3;

use super::LEVELS;
use super::anchors::{STATIONS, Station};

/// Numbers of a plate: ten vectors in rows of four, which is what vector registers hold.
const WIDE: usize = 40;

/// Displacement over a section: the cubic in xi = x/half width, eta = y/half width,
///
/// ```text
/// a + b xi + c eta + d xi^2 + e eta^2 + f xi eta + g xi^3 + h eta^3 + i xi eta^2 + k xi^2 eta
/// ```
///
/// Every cubic is biharmonic: it is the form of a thin plate loaded at its edge only, the one of least bending energy.
///
/// One row of four for each vector, the fourth number unused.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plate([f32; WIDE]);

impl Plate {
    /// A plate at rest.
    pub const ZERO: Self = Self([0.0; WIDE]);

    /// The plate through the axis and the anchors of a station. A cross beam leaves the axis with the section's slope: what its two
    /// ends have opposite beyond that is its cubic, what they have in common its bending. The cubics meet all eight anchors; of the
    /// bending the plate has one number less than the anchors, and the misfit is shared (least squares).
    pub fn through(station: &Station) -> Self {
        let at = |i: usize| station.anchors.get(i).map_or(Vec3::ZERO, |anchor| anchor.1 - station.axis);
        let slope = |ahead: usize, behind: usize, reach: f32| (at(ahead) - at(behind)) * (0.5 / reach);
        let bend = |ahead: usize, behind: usize, reach: f32| (at(ahead) + at(behind)) * (0.5 / (reach * reach));
        let (near, far) = (station.width, station.width * station.diagonal);
        let (near2, far2) = (near * near, far * far);

        let [b, c] = station.slopes;
        let (g, h) = ((slope(0, 1, near) - b) / near2, (slope(3, 2, near) - c) / near2);
        let (up, down) = (slope(5, 6, far), slope(4, 7, far));
        let (i, k) = (((up + down) * 0.5 - b) / far2 - g, ((up - down) * 0.5 - c) / far2 - h);

        let (d, e) = (bend(0, 1, near), bend(2, 3, near));
        let (up, down) = (bend(5, 6, far), bend(4, 7, far));
        let weight = station.diagonal * station.diagonal * station.diagonal * station.diagonal;
        let missing = ((up + down) * 0.5 - d - e) * (2.0 * weight / (1.0 + 4.0 * weight));
        let (d, e, f) = (d + missing, e + missing, (up - down) * 0.5);

        let mut plate = [0.0; WIDE];
        for (row, v) in plate.chunks_exact_mut(4).zip([station.axis, b, c, d, e, f, g, h, i, k]) {
            row.copy_from_slice(&[v.x, v.y, v.z, 0.0]);
        }
        Self(plate)
    }

    /// `scale` times `other` more.
    #[inline(always)]
    fn plus(&self, scale: f32, other: &Self) -> Self {
        let mut sum = self.0;
        for i in 0..WIDE {
            sum[i] += scale * other.0[i];
        }
        Self(sum)
    }
}

/// Plates over an interval of the height: the one at its start, and its growth to the end.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub(super) struct Span {
    start: [f32; WIDE],
    growth: [f32; WIDE],
}

impl Span {
    /// Nothing moved.
    pub const REST: Self = Self { start: [0.0; WIDE], growth: [0.0; WIDE] };

    /// Displacement \[m\] at a place, `share` of the way through the interval; the fourth number is nothing.
    #[inline(always)]
    pub fn at(&self, share: f32, xi: f32, eta: f32, found: &mut [f32; 4]) {
        let (xi2, eta2, both) = (xi * xi, eta * eta, xi * eta);
        let weights = [xi, eta, xi2, eta2, both, xi2 * xi, eta2 * eta, both * eta, both * xi];
        // one product after the other: sums of products in pairs do not become clean vector instructions
        for i in 0..4 {
            let at = |row: usize| self.start[4 * row + i] + self.growth[4 * row + i] * share;
            let mut sum = at(0);
            for (row, weight) in weights.iter().enumerate() {
                sum += at(row + 1) * weight;
            }
            found[i] = sum;
        }
    }
}

/// Sets spans at equal steps from the first station to the last: the natural cubic spline through every coefficient.
pub(super) fn spans(stations: &[Plate; STATIONS], spans: &mut [Span; LEVELS]) {
    let bending = second_differences(stations);
    let mut start = stations[0];
    for (i, span) in spans.iter_mut().enumerate() {
        let end = between(stations, &bending, (i + 1) as f32 * ((STATIONS - 1) as f32 / LEVELS as f32));
        span.start = start.0;
        span.growth = end.plus(-1.0, &start).0;
        start = end;
    }
}

/// The spline at a place counted in stations.
fn between(stations: &[Plate; STATIONS], bending: &[Plate; STATIONS], place: f32) -> Plate {
    let start = (place as usize).min(STATIONS - 2);
    let t = place - start as f32;
    let s = 1.0 - t;
    Plate::ZERO
        .plus(s, &stations[start])
        .plus(t, &stations[start + 1])
        .plus((s * s * s - s) / 6.0, &bending[start])
        .plus((t * t * t - t) / 6.0, &bending[start + 1])
}

/// Second derivatives M at the stations, one step apart: M_(i-1) + 4 M_i + M_(i+1) = 6 (u_(i-1) - 2 u_i + u_(i+1)). None at the free end; at the
/// base the moment runs on straight, as in a beam that is loaded further up: M_0 = 2 M_1 - M_2.
fn second_differences(u: &[Plate; STATIONS]) -> [Plate; STATIONS] {
    let mut bending = [Plate::ZERO; STATIONS];
    // of the first row 6 M_1 remains
    let mut pivots = [0.0; STATIONS];
    for i in 1..STATIONS - 1 {
        let right = Plate::ZERO.plus(6.0, &u[i - 1]).plus(-12.0, &u[i]).plus(6.0, &u[i + 1]);
        if i == 1 {
            bending[i] = Plate::ZERO.plus(1.0 / 6.0, &right);
        } else {
            pivots[i] = 1.0 / (4.0 - pivots[i - 1]);
            bending[i] = Plate::ZERO.plus(pivots[i], &right.plus(-1.0, &bending[i - 1]));
        }
    }
    for i in (1..STATIONS - 1).rev() {
        bending[i] = bending[i].plus(-pivots[i], &bending[i + 1]);
    }
    bending[0] = Plate::ZERO.plus(2.0, &bending[1]).plus(-1.0, &bending[2]);
    bending
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stations whose plates hold `f` of the height share in every coefficient.
    fn along(f: impl Fn(f32) -> f32) -> [Plate; STATIONS] {
        core::array::from_fn(|i| Plate([f(i as f32 / (STATIONS - 1) as f32); WIDE]))
    }

    #[test]
    fn the_spline_is_that_of_a_cantilever_and_keeps_the_base_at_rest() {
        let tip = |t: f32| t * t * (1.5 - 0.5 * t);
        for (f, allowed) in [(&(|t: f32| 2.0 * t) as &dyn Fn(f32) -> f32, 1.0e-6), (&tip, 1.0e-6)] {
            let mut spans = [Span::REST; LEVELS];
            super::spans(&along(f), &mut spans);
            assert_eq!(spans[0].start, [0.0; WIDE]);
            for (i, span) in spans.iter().enumerate() {
                let (found, exact) = (span.start[5] + span.growth[5], f((i + 1) as f32 / LEVELS as f32));
                assert!((found - exact).abs() < allowed, "{i}: {found} {exact}");
            }
        }
    }

    fn at(plate: &Plate, xi: f32, eta: f32) -> Vec3 {
        let mut found = [0.0; 4];
        Span { start: plate.0, growth: [0.0; WIDE] }.at(0.0, xi, eta, &mut found);
        Vec3::new(found[0], found[1], found[2])
    }

    #[test]
    fn a_plate_meets_axis_and_anchors_of_motions_a_section_makes() {
        use super::super::anchors::Motion;
        use crate::model::ObjectShape;
        use crate::surface::section::Section;
        use glam::Vec2;

        let motion = Motion {
            shift: Vec3::new(1.0e-3, -2.0e-3, 3.0e-3),
            slope: Vec2::new(0.02, -0.01),
            turn: 0.05,
            rim_turn: [0.008, 0.01],
            curved: Vec2::new(0.3, 0.2),
            swell: 0.004,
            ..Motion::default()
        };
        for object in [ObjectShape::Box { size: Vec3::new(0.1, 0.2, 0.05) }, ObjectShape::Cylinder { radius: 0.05, height: 0.1 }]
        {
            let section = Section::of(&object).unwrap();
            let mut station = Station::at_rest(&object, &section, 0.05);
            station.motion = motion;
            station.carry_anchors();
            let plate = Plate::through(&station);
            for (place, moved) in station.anchors {
                let found = at(&plate, place.x / section.half.x, place.y / section.half.y);
                assert!((found - moved).length() < 1.0e-6, "{object:?} {place}: {found} {moved}");
            }
            assert_eq!(at(&plate, 0.0, 0.0), motion.shift);
        }
    }
}
