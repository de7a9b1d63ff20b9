//! What a bristle of each ring can hold and how stiff it is, four rings at a time.

use crate::lanes::{LANES, Lanes};
use crate::tier::Hold;
use crate::tier::bristle::{AROUND, Grid, Layout, MAX_RINGS};

/// One bristle's figures in each of four rings, the same for both bristles of a ring; or those of four bristles. What lies outside the contact
/// carries nothing and has no stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Four {
    /// Normal load of the cell \[N\]; its cap is mu times this.
    pub load: Lanes,
    /// Force per drag \[N/m\].
    pub drag: Lanes,
    /// Hoop force per twist \[N/rad\].
    pub twist: Lanes,
    /// Arm of the cell's force about the centre, so that the torque capacity is exact \[m\].
    pub arm: Lanes,
    /// Area that counts as stuck with this cell in pure drag and in pure twist, shares of the contact area.
    pub stuck: (Lanes, Lanes),
}

/// The rings inside the contact.
#[derive(Clone, Debug)]
pub struct Rings {
    fours: heapless::Vec<Four, { MAX_RINGS / LANES }>,
    rings: usize,
}

impl Rings {
    /// Rings of `grid` under the load of `hold`.
    #[inline]
    pub fn new(hold: &Hold, layout: &Layout, grid: &Grid) -> Self {
        let (mut fours, mut rings) = (heapless::Vec::new(), 0);
        // the load and the torque inside, and what sticks there
        let mut last = [0.0; 4];
        for first in (0..layout.rings).step_by(LANES) {
            let begin = first as f32 + Lanes([0.0, 1.0, 2.0, 3.0]);
            let [a, b, c, d] = (begin * grid.width).0.map(|inner| usize::from(inner < hold.radius));
            if a == 0 {
                break;
            }
            rings = first + a + b + c + d;
            let ends = (first as f32 + Lanes([1.0, 2.0, 3.0, 4.0])) * grid.width / Lanes::splat(hold.radius);
            let outer = hold.profile.inside_four(ends.smaller(Lanes::splat(1.0)));
            let _ = fours.push(between(hold, last, &outer));
            last = outer.map(|Lanes([_, _, _, last])| last);
        }
        Self { fours, rings: rings.min(layout.rings) }
    }

    /// Rings in contact.
    pub fn len(&self) -> usize {
        self.rings
    }

    /// True when no ring is in contact.
    pub fn is_empty(&self) -> bool {
        self.rings == 0
    }

    /// The rings by fours, innermost first.
    pub fn fours(&self) -> &[Four] {
        &self.fours
    }
}

/// Rings between radii with `outer` inside, the first from one with `last` inside. Stiffness is taken where the cell's force acts; integrating it over
/// the ring would count the soft rim twice.
#[inline(always)]
fn between(hold: &Hold, last: [f32; 4], outer: &[Lanes; 4]) -> Four {
    let share = 1.0 / AROUND as f32;
    let inner = |i: usize| {
        let [a, b, c, _] = outer[i].0;
        Lanes([last[i], a, b, c])
    };
    let load = outer[0] - inner(0);
    let ratio = (outer[1] - inner(1)) / load;
    let one = Lanes::splat(1.0);
    // a ring without load has its arm at the rim
    let ([a, b, c, d], [e, f, g, h]) = (load.0, ratio.smaller(one).0);
    let loaded = |load: f32, arm: f32| if load > 0.0 { arm } else { 1.0 };
    let arm = Lanes([loaded(a, e), loaded(b, f), loaded(c, g), loaded(d, h)]);
    let (drag, twist) = hold.profile.softness_of_four(arm);
    let softness = Lanes::splat(LEAST_SOFTNESS);
    let stuck = |i: usize| (outer[i] * outer[i] - inner(i) * inner(i)) * share;
    Four {
        load: load * hold.load * share,
        drag: load * share * hold.drag_stiffness / (drag + softness),
        twist: load * share * hold.twist_stiffness / ((twist + softness) * hold.arm),
        arm: arm * hold.arm,
        stuck: (stuck(2), stuck(3)),
    }
}

impl Four {
    /// Those of the inner two rings, each twice.
    #[inline(always)]
    pub fn inner(&self) -> Self {
        self.each(|Lanes([a, b, ..])| Lanes([a, a, b, b]))
    }

    /// Those of the outer two rings, each twice.
    #[inline(always)]
    pub fn outer(&self) -> Self {
        self.each(|Lanes([.., c, d])| Lanes([c, c, d, d]))
    }

    #[inline(always)]
    fn each(&self, pick: impl Fn(Lanes) -> Lanes) -> Self {
        Self {
            load: pick(self.load),
            drag: pick(self.drag),
            twist: pick(self.twist),
            arm: pick(self.arm),
            stuck: (pick(self.stuck.0), pick(self.stuck.1)),
        }
    }
}

/// Keeps the stiffness of a rim cell finite; 1e-6 of the full-slip shift.
const LEAST_SOFTNESS: f32 = 1.0e-6;
