//! What a bristle of each ring can hold and how stiff it is.

use crate::math::min;
use crate::patch::Grip;
use crate::profile::Inside;
use crate::tier::Hold;
use crate::tier::bristle::{AROUND, Bristle, Grid, Layout, MAX_RINGS};

/// One bristle's figures; the same for both bristles of a ring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ring {
    /// Normal load of the cell \[N\]; its cap is mu times this.
    pub load: f32,
    /// Force per drag \[N/m\].
    pub drag: f32,
    /// Hoop force per twist \[N/rad\].
    pub twist: f32,
    /// Arm of the cell's force about the centre, so that the torque capacity is exact \[m\].
    pub arm: f32,
    /// Area that counts as stuck with this cell in pure drag and in pure twist, shares of the contact area.
    pub stuck: (f32, f32),
}

/// The rings inside the contact.
#[derive(Clone, Debug)]
pub struct Rings {
    rings: heapless::Vec<Ring, MAX_RINGS>,
}

impl Rings {
    /// Rings of `grid` under the load of `hold`.
    #[inline]
    pub fn new(hold: &Hold, layout: &Layout, grid: &Grid) -> Self {
        let mut rings = heapless::Vec::new();
        let mut inner = Inside::default();
        for k in 0..layout.rings {
            if grid.width * k as f32 >= hold.radius {
                break;
            }
            let outer = hold.profile.inside(min(grid.width * (k + 1) as f32 / hold.radius, 1.0));
            let _ = rings.push(between(hold, &inner, &outer));
            inner = outer;
        }
        Self { rings }
    }

    /// Rings in contact.
    pub fn len(&self) -> usize {
        self.rings.len()
    }

    /// True when no ring is in contact.
    pub fn is_empty(&self) -> bool {
        self.rings.is_empty()
    }

    /// The rings, innermost first.
    pub fn as_slice(&self) -> &[Ring] {
        &self.rings
    }

    /// Resultant of the bristles; `stick` is left at 0.
    pub fn sum(&self, layout: &Layout, bristles: &[Bristle]) -> Grip {
        let mut grip = Grip::default();
        for (k, (ring, cells)) in self.as_slice().iter().zip(bristles.chunks_exact(AROUND)).enumerate() {
            for (j, cell) in cells.iter().enumerate() {
                grip.force += cell.force;
                grip.torque += ring.arm * layout.direction(k, j).perp_dot(cell.force);
            }
        }
        grip
    }
}

/// Stiffness is taken where the cell's force acts; integrating it over the ring would count the soft rim twice.
fn between(hold: &Hold, inner: &Inside, outer: &Inside) -> Ring {
    let share = 1.0 / AROUND as f32;
    let load = outer.load - inner.load;
    let arm = if load > 0.0 { min((outer.torque - inner.torque) / load, 1.0) } else { 1.0 };
    let (drag_softness, twist_softness) = hold.profile.softness(arm);
    let stuck = |outer: f32, inner: f32| (outer * outer - inner * inner) * share;
    Ring {
        load: hold.load * load * share,
        drag: share * load * hold.drag_stiffness / (drag_softness + LEAST_SOFTNESS),
        twist: share * load * hold.twist_stiffness / (hold.arm * (twist_softness + LEAST_SOFTNESS)),
        arm: arm * hold.arm,
        stuck: (stuck(outer.drag_stick, inner.drag_stick), stuck(outer.twist_stick, inner.twist_stick)),
    }
}

/// Keeps the stiffness of a rim cell finite; 1e-6 of the full-slip shift.
const LEAST_SOFTNESS: f32 = 1.0e-6;
