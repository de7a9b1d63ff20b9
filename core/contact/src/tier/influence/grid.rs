//! The square grid of a patch.
//!
//! The state keeps the cells place by place, four images each (see [`mirror`](super::mirror)). Cells have the width h and keep their place in the material while the contact radius a stays within a range of h: a growing contact
//! enters new, free cells and a shrinking one leaves cells behind. When a leaves the range the grid is laid anew and the forces are shared
//! out by overlap, so that force and torque of the patch are kept.

use glam::Vec2;

use crate::math::{PI, max, root, sqrt};
use crate::patch::{Grip, Shift};
use crate::tier::bristle::Bristle;
use crate::tier::influence::cells::reached;
use crate::tier::influence::mirror::{HALF, IMAGES, ORDER, Place, within};
use crate::tier::influence::share::share_out;
use crate::tier::influence::{Stored, Trace};

/// How many cells a patch is cut into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Cells in a contact on a fresh grid.
    pub cells: usize,
    /// Cells from the middle to the side of the square that is kept: room for the contact to grow.
    pub half: usize,
}

impl Layout {
    /// 52 cells: 8 across a fresh contact.
    pub const COARSE: Self = Self { cells: 52, half: 5 };
    /// 112 cells: 12 across.
    pub const FINE: Self = Self { cells: 112, half: HALF };

    /// The finest layout of at most `cells` cells that `room` samples can keep.
    pub fn fitting(cells: usize, room: usize) -> Option<Self> {
        [Self::FINE, Self::COARSE].into_iter().find(|layout| layout.cells <= cells && layout.slots() <= room)
    }

    /// Samples of the state that are used.
    pub const fn slots(&self) -> usize {
        IMAGES * self.places()
    }

    /// Places that a contact can reach.
    pub const fn places(&self) -> usize {
        within(self.half)
    }

    /// Contact radius over cell width of a fresh grid: the cells whose centre lies in the contact have its area.
    fn fresh(&self) -> f32 {
        sqrt(self.cells as f32 / PI)
    }
}

/// Smallest contact radius, as a share of a fresh grid's, before the grid is laid anew.
const FEWEST: f32 = 0.8;

/// The grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Width of a cell \[m\]; 0 before the first load.
    pub width: f32,
    /// Contact radius that the forces were last solved for \[m\].
    pub radius: f32,
    /// Cells from the middle to the side of the square.
    pub half: usize,
    /// Shift of the last tick.
    pub wanted: Shift,
}

impl Grid {
    /// Lays the grid anew when `radius` has left its range; a first grid takes up what another tier `held`.
    pub fn fit(&mut self, layout: &Layout, radius: f32, held: &Grip, cells: &mut Stored<'_>) {
        let width = radius / layout.fresh();
        if self.width <= 0.0 || self.half != layout.half {
            cells.clear();
            *self = Self { width, radius, half: layout.half, wanted: Shift::default() };
            seed(layout, self, held, cells.force);
        } else if radius > layout.half as f32 * self.width || radius < FEWEST * self.width * layout.fresh() {
            share_out(layout, self.width, width, cells.force);
            cells.trace.iter_mut().take(layout.slots()).for_each(|trace| *trace = Trace::default());
            // any cell of the new grid may have got a share
            (self.width, self.radius, self.wanted) = (width, layout.half as f32 * width, Shift::default());
        }
    }
}

/// Centre of the image of a place, in cell widths; `image` counts as the lanes do.
pub fn centre(place: Place, image: usize) -> Vec2 {
    let (x, y) = place.centre();
    Vec2::new(if image % 2 == 1 { -x } else { x }, if image / 2 == 1 { -y } else { y })
}

/// The cells with their centres in cell widths, place by place.
pub fn centred(cells: &mut [Bristle]) -> impl Iterator<Item = (Vec2, &mut Bristle)> {
    let places = ORDER.iter().zip(cells.chunks_exact_mut(IMAGES));
    places.flat_map(|(place, images)| images.iter_mut().enumerate().map(|(image, cell)| (centre(*place, image), cell)))
}

/// Spreads a grip over the cells in contact by the load of a round contact, force and hoop force alike: as a contact in full slip holds it, so that no
/// cap cuts what was held.
fn seed(layout: &Layout, grid: &Grid, held: &Grip, cells: &mut [Bristle]) {
    if held.force == Vec2::ZERO && held.torque == 0.0 {
        return;
    }
    let count = IMAGES * reached(grid.radius / grid.width, layout.places());
    let inside = cells.get_mut(..count).unwrap_or_default();
    let reach = grid.radius / grid.width;
    let load = |at: Vec2| root(max(1.0 - at.length_squared() / (reach * reach), 0.0));
    let (mut loads, mut arms) = (0.0, 0.0);
    for (at, _) in centred(inside) {
        loads += load(at);
        arms += grid.width * load(at) * root(at.length_squared());
    }
    for (at, cell) in centred(inside) {
        // no cell is centred on the patch
        let hoop = at.perp() * (held.torque / (arms * root(at.length_squared())));
        cell.force = (held.force / loads + hoop) * load(at);
    }
}
