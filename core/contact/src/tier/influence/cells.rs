//! Which places of a grid lie in the contact, and what load each of their cells carries.

use crate::lanes::Lanes;
use crate::math::{ln, min, root};
use crate::profile::{FULLNESS_CONE, FULLNESS_HERTZ, FULLNESS_PUNCH};
use crate::tier::Hold;
use crate::tier::influence::mirror::{IMAGES, ORDER, PLACES, Place};

/// Midpoints along the edge of a cell at the rim or in a cone's middle that its load is summed from: 16 per cell are good to 2 %.
const POINTS: usize = 4;

/// Gauss's two points on -1/2..1/2: in the smooth part of the pressure four per cell are good to 0.1 %.
const GAUSS_2: [f32; 2] = [-0.288_675_13, 0.288_675_13];

/// Square of the farthest corner, in contact radii, up to which the pressure counts as smooth.
const SMOOTH: f32 = 0.8;

/// Distance of a cell's centre from the rim, in cell widths, from which on it carries its whole load: nearer, it enters or leaves the contact by and by.
const ENTERING: f32 = 0.25;

/// The cells in contact.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Places in contact: the first ones.
    pub count: usize,
    /// Normal load of each of a place's cells \[N\]; 0 outside the contact.
    pub load: [f32; PLACES],
    /// Factor on the places of cells as arms of a twist, so that the torque of full slip is exact.
    pub arm: f32,
}

impl Cells {
    /// Cells of `width` \[m\] under the load of `hold`, at most `most` places. A cell is in contact when its centre is, with less than its load
    /// next to the rim.
    pub fn new(hold: &Hold, width: f32, most: usize) -> Self {
        let step = width / hold.radius;
        let mut cells = Self { count: reached(1.0 / step, most), load: [0.0; PLACES], arm: 1.0 };
        let (mut total, mut torque) = (0.0, 0.0);
        let mut last = 0.0;
        for (place, load) in ORDER.iter().zip(&mut cells.load).take(cells.count) {
            let r = step * root(place.distance2());
            // the image in the diagonal comes next and is the same
            if place.column <= place.row {
                last = around(hold.profile.fullness(), *place, step) * min((1.0 - r) / (ENTERING * step), 1.0);
            }
            *load = last;
            total += last;
            torque += last * r;
        }
        let scale = hold.load / (IMAGES as f32 * total);
        cells.load.iter_mut().take(cells.count).for_each(|cell| *cell *= scale);
        cells.arm = hold.profile.full_slip_torque() * total / torque * (hold.arm / hold.radius);
        cells
    }
}

/// Places whose centres lie within `reach` cell widths, at most `most`.
pub fn reached(reach: f32, most: usize) -> usize {
    ORDER.iter().take(most).take_while(|place| place.distance2() < reach * reach).count()
}

/// Load of a square cell of edge `step`, up to a factor common to all cells; lengths in contact radii.
fn around(fullness: f32, place: Place, step: f32) -> f32 {
    let (x, y) = place.centre();
    let (far_x, far_y) = (step * (x + 0.5), step * (y + 0.5));
    let smooth = far_x * far_x + far_y * far_y < SMOOTH && (place != ORDER[0] || fullness >= FULLNESS_HERTZ);
    let four = |at_x: Lanes, at_y: Lanes| pressure(fullness, (x + at_x) * step, (y + at_y) * step);
    if smooth {
        return 0.25 * four(GAUSS_X, GAUSS_Y).total();
    }
    let rows = MIDPOINTS.map(|at| four(Lanes::splat(at), Lanes(MIDPOINTS)));
    ((rows[0] + rows[1]) + (rows[2] + rows[3])).total() / (POINTS * POINTS) as f32
}

/// Gauss's points of a cell.
const GAUSS_X: Lanes = Lanes([GAUSS_2[0], GAUSS_2[0], GAUSS_2[1], GAUSS_2[1]]);
const GAUSS_Y: Lanes = Lanes([GAUSS_2[0], GAUSS_2[1], GAUSS_2[0], GAUSS_2[1]]);

/// Midpoints of `POINTS` parts of -1/2..1/2.
const MIDPOINTS: [f32; POINTS] = [-0.375, -0.125, 0.125, 0.375];

/// Pressure over P/(pi a^2) at (x, y), in contact radii: the mixture of cone, paraboloid and punch of the profile's fullness. 0 outside the contact.
fn pressure(fullness: f32, x: Lanes, y: Lanes) -> Lanes {
    let q2 = x * x + y * y;
    let x = (Lanes::splat(1.0) - q2).larger(Lanes::default()).roots();
    let hertz = x * 1.5;
    if fullness == FULLNESS_HERTZ {
        return hertz;
    }
    // a point outside, of which x is 0, has none of the others either
    let inside = |of: fn(f32, f32) -> f32| {
        let ([a, b, c, d], [e, f, g, h]) = (x.0, q2.0);
        let one = |x: f32, q2: f32| if x > 0.0 { of(x, q2) } else { 0.0 };
        Lanes([one(a, e), one(b, f), one(c, g), one(d, h)])
    };
    if fullness < FULLNESS_HERTZ {
        let cone = inside(|x, q2| ln((1.0 + x) / root(q2)));
        return cone + (hertz - cone) * ((fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE));
    }
    let punch = inside(|x, _| 0.5 / x);
    hertz + (punch - hertz) * ((fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ))
}
