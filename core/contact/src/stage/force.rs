//! Stage 3: normal force, contact radius and pressure profile of every patch.
//!
//! A patch feels the surface as the other patches displace it (equation 4.1 of theory.md). Patches are taken in birth order, each with
//! the latest loads of the others, starting from those of the previous tick; the paper's one-way order is the first pass of a newborn.

use crate::body;
use crate::footprint::{Footprint, Push, Seat, law_load, law_push};
use crate::math::{clamp, max, min, pow, root};
use crate::model::Model;
use crate::params::{ForceLaw, Params};
use crate::patch::Patch;
use crate::report::Flags;
use crate::scratch::Contact;
use crate::stage::deform::dent;
use crate::stage::ground;

/// How often the patches of a tick are pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    /// The newborn is pressed once alone before, the paper's one-way order: it feels its neighbours, and then they feel it.
    pub newborn: bool,
    /// Passes over all patches.
    pub whole: usize,
}

/// Passes over all patches in a tick with a birth. Each shrinks the coupling's error by the share a neighbour's dent has of the depth, at most a third for separate patches.
/// Otherwise one pass follows on from the last tick.
const PASSES_AT_BIRTH: usize = 2;

impl Passes {
    /// As these patches need it.
    pub fn of(patches: &[Patch]) -> Self {
        let newborn = patches.len() > 1 && patches.last().is_some_and(|patch| patch.footprint == Footprint::NONE);
        Self { newborn, whole: if newborn { PASSES_AT_BIRTH } else { 1 } }
    }

    /// The newborn feels its neighbours in this tick, and they feel it in the next.
    pub fn fewest(self) -> Self {
        Self { whole: 1, ..self }
    }

    /// So many patches, each pressed in as many trials as there may be.
    pub fn at_most(self, patches: usize) -> Pressed {
        Pressed { passes: self, trials: SERIES_STEPS * (self.whole * patches + usize::from(self.newborn)) }
    }

    /// Fewer than a birth needs.
    pub fn is_short(self) -> bool {
        self.newborn && self.whole < PASSES_AT_BIRTH
    }
}

/// What pressing met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pressed {
    /// How often the patches were pressed.
    pub passes: Passes,
    /// Depths that were tried in all.
    pub trials: usize,
}

/// Sets footprint and body compliance of every patch.
pub fn press(
    model: &Model<'_>,
    params: &Params,
    contacts: &[Contact],
    patches: &mut [Patch],
    passes: Passes,
) -> (Pressed, Flags) {
    let mut trials = 0;
    if passes.newborn {
        trials += press_one(model, params, contacts, patches, patches.len() - 1);
    }
    for _ in 0..passes.whole {
        for i in 0..patches.len() {
            trials += press_one(model, params, contacts, patches, i);
        }
    }
    let mut flags = Flags::CLEAN;
    for patch in patches.iter_mut() {
        patch.body = body::compliance(model, patch.at_rest(), patch.normal, patch.footprint.radius, 1.0 / patch.object_radius);
        if patch.footprint.large_strain {
            flags |= Flags::LARGE_STRAIN;
        }
    }
    (Pressed { passes, trials }, flags)
}

/// Presses one patch; returns how many depths that took.
fn press_one(model: &Model<'_>, params: &Params, contacts: &[Contact], patches: &mut [Patch], i: usize) -> usize {
    let displaced = displaced_by_others(model, patches, i);
    let Some(patch) = patches.get_mut(i) else { return 0 };
    let (pressed, trials) = footprint(model, params, contacts, patch, displaced);
    patch.footprint = Footprint { load: pressed.load * patch.share, ..pressed };
    trials
}

fn displaced_by_others(model: &Model<'_>, patches: &[Patch], i: usize) -> f32 {
    let Some(here) = patches.get(i) else { return 0.0 };
    let others = patches.iter().enumerate().filter(|(j, other)| *j != i && other.footprint.load > 0.0);
    let near = others.fold(0.0, |sum, (_, other)| {
        sum + dent(model, other, here.centre) * clip(other.normal.dot(here.normal)) * yielding(here, other)
    });
    near + ground::lowered(model, patches, i)
}

/// Relative difference of depth over which the ownership of a shared area passes from one patch to the other.
const OWNERSHIP: f32 = 0.4;

/// How much of the other's dent a patch feels: all of it while the two are apart. Where they overlap they share one area, which the deeper
/// owns, so that a pair on one spot carries the load once, without memory and without a second solution (theory.md, section 4).
fn yielding(here: &Patch, other: &Patch) -> f32 {
    let b = other.footprint.radius;
    // a newborn has no radius yet: it will be about as wide
    let a = if here.footprint.radius > 0.0 { here.footprint.radius } else { b };
    let distance2 = (here.centre - other.centre).length_squared();
    if distance2 >= (a + b) * (a + b) {
        return 1.0;
    }
    let distance = root(distance2);
    let overlap = min((a + b - distance) / (2.0 * min(a, b)), 1.0);
    let lead = (other.depth - here.depth) / (OWNERSHIP * max(other.depth, here.depth));
    let owned = clamp(0.5 + lead, 0.0, 1.0);
    let owned = owned * owned * (3.0 - 2.0 * owned);
    1.0 - overlap * (1.0 - owned - EVEN * owned * (1.0 - owned))
}

/// At equal depth on one spot each feels w of the other's dent with 2 / (1 + w)^(3/2) = 1, so w = 2^(2/3) - 1 = 1/2 + EVEN / 4.
const EVEN: f32 = 0.349_6;

fn clip(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The footprint, and how many depths were tried.
fn footprint(model: &Model<'_>, params: &Params, contacts: &[Contact], patch: &Patch, displaced: f32) -> (Footprint, usize) {
    let Some(contact) = contacts.iter().find(|contact| contact.part == patch.part) else { return (Footprint::NONE, 0) };
    let free = patch.depth - displaced;
    if free <= 0.0 {
        return (Footprint::NONE, 0);
    }
    let spring = Spring { seat: &contact.seat, modulus: model.material.contact_modulus(), law: &params.force_law };
    let series = in_series(&spring, free, body::normal(model, patch.at_rest(), patch.normal));
    let pressed = spring.footprint(series.depth);
    (Footprint { load: min(pressed.load, series.most), ..pressed }, series.trials)
}

/// A contact as a spring along its normal.
struct Spring<'a> {
    seat: &'a Seat,
    /// E* \[Pa\].
    modulus: f32,
    law: &'a ForceLaw,
}

impl Spring<'_> {
    fn push(&self, depth: f32) -> Push {
        law_push(self.law, depth).unwrap_or_else(|| self.seat.push(self.modulus, depth))
    }

    fn footprint(&self, depth: f32) -> Footprint {
        let footprint = self.seat.footprint(self.modulus, depth);
        law_load(self.law, depth).map_or(footprint, |load| Footprint { load, ..footprint })
    }

    /// Its slope jumps.
    const fn is_kinked(&self) -> bool {
        matches!(self.law, ForceLaw::Table { .. })
    }
}

/// Trials that share the depth between contact and body. A power needs two where the body takes up to a third; the others are for bodies given as softer, and
/// for loads that grow as no power does.
pub const SERIES_STEPS: usize = 8;

/// Share of the contact's part of the depth by which it may be off: the load is then good to 2e-5, a hundredth of what is known of it.
const SETTLED: f32 = 1.0e-5;

/// How contact and body share a depth.
struct Series {
    /// The contact's part \[m\].
    depth: f32,
    /// What the body bears at most when the contact takes at least what it certainly does \[N\]; infinite where the search settled.
    most: f32,
    /// Depths that were tried.
    trials: usize,
}

/// The part of `depth` that is the contact's beside a body of this compliance \[m/N\], and in how many trials it was found: x of equation 3.12. What both take only grows
/// with x, so that x is bracketed.
fn in_series(spring: &Spring<'_>, depth: f32, compliance: f32) -> Series {
    if compliance <= 0.0 {
        return Series { depth, most: f32::INFINITY, trials: 0 };
    }
    // places, and how much more than the depth is taken there
    let (mut low, mut high) = ((0.0, -depth), (depth, 0.0));
    let (mut x, mut last, mut before) = (depth, depth, None);
    for trial in 1..=SERIES_STEPS {
        let push = spring.push(x);
        let excess = (x - depth) + compliance * push.load;
        if excess < 0.0 {
            low = (x, excess);
        } else {
            high = (x, excess);
        }
        let (fit, off) = if spring.is_kinked() { (1.0, 1.0) } else { fit(x, &push, before) };
        let next = if spring.is_kinked() {
            x - excess / (1.0 + compliance * push.slope)
        } else {
            as_power(x, &Push { slope: fit * push.slope, ..push }, excess, depth, compliance)
        };
        // what is no number is not inside either
        let next = if next > low.0 && next < high.0 { next } else { between(low, high, depth, x) };
        let step = (next - x).abs();
        // a step leaves no larger a share of it than it is of the one before, or than the slope was off; where it may have crossed a kink, all of it
        let share = min(max(step / min(last, next), off), 1.0);
        let left = share * step;
        (x, last, before) = (next, step, Some((x, push)));
        if left <= SETTLED * x {
            return Series { depth: x, most: f32::INFINITY, trials: trial };
        }
    }
    // a law as steep as a step: where it lies may be known too roughly for its load, but not what is left for the body
    Series { depth: x, most: (depth - low.0) / compliance, trials: SERIES_STEPS }
}

/// What makes the mean slope of `push` at `x` and of the trial `before` their secant: a cut part tells its slope but for how its exponent changes.
/// And the share by which the slope may be off after that.
fn fit(x: f32, push: &Push, before: Option<(f32, Push)>) -> (f32, f32) {
    let Some((x0, push0)) = before else { return (1.0, 0.0) };
    if 2.0 * (x - x0).abs() > x {
        return (1.0, 1.0);
    }
    let fit = clamp(2.0 * (push.load - push0.load) / ((x - x0) * (push.slope + push0.slope)), 0.5, 2.0);
    (fit, (fit - 1.0).abs())
}

/// A place in a bracket of places and excesses: their false position; from a lower end beside a far higher one the middle of their logarithms.
fn between(low: (f32, f32), high: (f32, f32), depth: f32, x: f32) -> f32 {
    if x == low.0 && high.1 > depth {
        return root(low.0 * high.0);
    }
    low.0 - low.1 * ((high.0 - low.0) / (high.1 - low.1))
}

/// Where nothing is in excess if the load is the power of the depth that goes through `push` at `x` with its slope (equation 3.13).
fn as_power(x: f32, push: &Push, excess: f32, depth: f32, compliance: f32) -> f32 {
    let (body, growth) = (compliance * push.load, compliance * push.slope);
    if body > depth {
        // so soft a body makes the equation nearly the power alone, a straight line in logarithms
        let taken = x + body;
        return x * pow(depth / taken, min(taken / (x + growth * x), 1.0));
    }
    let step = excess / (1.0 + growth);
    let bend = if push.load > 0.0 { growth * (push.slope / push.load - 1.0 / x) / (1.0 + growth) } else { 0.0 };
    x - step / (1.0 - 0.5 * clamp(step * bend, -1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};
    use heapless::Vec;

    use super::*;
    use crate::frames::Pose;
    use crate::geometry::support::support;
    use crate::math::FRAC_PI_2;
    use crate::stage::detect::{Seen, detect};
    use crate::{Material, ModelSpec, ObjectShape, ProbePart, ProbeShape};

    const MATERIAL: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1100.0 };

    const SHAPES: [ProbeShape<'static>; 7] = [
        ProbeShape::Sphere { radius: 0.02 },
        ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.01, 0.02, 0.03) },
        ProbeShape::Cylinder { radius: 0.01, height: 0.04 },
        ProbeShape::Cone { radius: 0.02, height: 0.01 },
        ProbeShape::Cone { radius: 0.01, height: 0.04 },
        ProbeShape::Capsule { radius: 0.006, height: 0.02 },
        ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) },
    ];

    const OBJECTS: [ObjectShape<'static>; 4] = [
        ObjectShape::HalfSpace,
        ObjectShape::Box { size: Vec3::splat(0.1) },
        ObjectShape::Sphere { radius: 0.05 },
        ObjectShape::Cylinder { radius: 0.03, height: 0.1 },
    ];

    /// From upright over nearly upright to lying.
    const TILTS: [f32; 6] = [0.0, 1.0e-3, 0.05, 0.4, 1.1, FRAC_PI_2];

    /// In the middle, and where the first object with edges has one.
    const ASIDE: [f32; 3] = [0.0, 0.045, 0.0499];

    const DEPTHS: [f32; 6] = [1.0e-6, 1.0e-5, 1.0e-4, 1.0e-3, 5.0e-3, 2.0e-2];

    /// What the others leave of the depth.
    const FREE: [f32; 3] = [1.0, 0.7, 0.2];

    const COMPLIANCES: [f32; 8] = [1.0e-9, 1.0e-7, 1.0e-6, 1.0e-5, 3.0e-5, 1.0e-4, 1.0e-3, 1.0e-2];

    fn laws() -> [ForceLaw; 3] {
        let force = core::array::from_fn(|i| 0.05 * (i * i) as f32 + if i > 8 { 2.0 * (i - 8) as f32 } else { 0.0 });
        [ForceLaw::Hertz, ForceLaw::Cubic { k1: 800.0, k3: 4.0e7 }, ForceLaw::Table { step: 5.0e-4, force }]
    }

    /// The same by halving, of the balance in f64, from `low` to `high`.
    fn halved(spring: &Spring<'_>, depth: f32, compliance: f32, (mut low, mut high): (f64, f64)) -> f64 {
        for _ in 0..50 {
            let x = 0.5 * (low + high);
            let body = f64::from(compliance) * f64::from(spring.push(x as f32).load);
            if x + body < f64::from(depth) { low = x } else { high = x }
        }
        0.5 * (low + high)
    }

    /// Whether the load grows wherever it is looked at.
    fn grows(spring: &Spring<'_>, depth: f32) -> bool {
        let at = |i: u8| spring.push(depth * f32::from(i) / 64.0).load;
        (1..64).all(|i| at(i) <= at(i + 1))
    }

    /// Every contact of the shapes on the objects, in all attitudes and depths.
    fn for_each_seat(mut with: impl FnMut(&dyn core::fmt::Debug, &Contact)) {
        for (object, shape) in OBJECTS.iter().flat_map(|object| SHAPES.iter().map(move |shape| (object, shape))) {
            let parts = [ProbePart::at_origin(*shape)];
            let model = Model::new(&ModelSpec::new(*object, MATERIAL, &parts)).unwrap();
            let top = match *object {
                ObjectShape::Box { size } => size.z,
                ObjectShape::Sphere { radius } => 2.0 * radius,
                ObjectShape::Cylinder { height, .. } => height,
                _ => 0.0,
            };
            for (tilt, aside) in TILTS.iter().flat_map(|&tilt| ASIDE.map(|aside| (tilt, aside))) {
                let rotation = Quat::from_rotation_y(tilt);
                let reach = support(shape, rotation.conjugate() * -Vec3::Z);
                for depth in DEPTHS {
                    let pose = Pose::new(Vec3::new(aside, 0.0, top - depth - (rotation * reach).z), rotation);
                    let mut contacts = Vec::<Contact, 1>::new();
                    detect(&model, &pose, None, Seen { contacts: &[], pose: None }, &mut contacts);
                    if let Some(contact) = contacts.first() {
                        with(&(shape, object, tilt, aside, depth), contact);
                    }
                }
            }
        }
    }

    /// Worst of these cases: 9.4e-6 of the depth, and 3.2e-4 beside the softest body, where a flat's edge carries nothing up to some depth and the body takes
    /// all that follows. False position in five trials left 1.2e-5 at 1e-7 m/N, 9e-4 at 1e-6 m/N and from 1e-5 m/N on more than 1e-2.
    #[test]
    fn contact_and_body_share_the_depth_as_halving_finds() {
        let modulus = MATERIAL.contact_modulus();
        let mut count = 0;
        for_each_seat(|name, contact| {
            for (law, free) in laws().iter().flat_map(|law| FREE.map(|free| (law, free * contact.depth))) {
                let spring = Spring { seat: &contact.seat, modulus, law };
                for compliance in COMPLIANCES {
                    // a load that falls as it is pressed leaves the softest body a jump
                    if compliance == 1.0e-2 && !grows(&spring, free) {
                        continue;
                    }
                    let found = f64::from(in_series(&spring, free, compliance).depth);
                    let within = f64::from(free) * if compliance < 1.0e-2 { 1.0e-5 } else { 5.0e-4 };
                    // the nearest balance: a cut flat's load may fall for a while, and then there are others
                    let expected = halved(&spring, free, compliance, ((found - 2.0 * within).max(0.0), found + 2.0 * within));
                    let off = (found - expected).abs();
                    assert!(off <= within, "{name:?}, {law:?}, {compliance} m/N: {found} {expected}: {off}");
                    count += 1;
                }
            }
        });
        assert!(count > 100_000, "{count}");
    }

    /// A law that rises from nearly nothing to kilonewtons within a fiftieth of the depth: the body bears no more than the depth leaves it.
    #[test]
    fn a_step_that_no_trial_finds_is_no_larger_load_than_the_body_bears() {
        let steep = |i: usize| [0.0, 7.6e-5, 9.8e-4, 0.145, 1.04, 1.07].get(i).copied().unwrap_or(8958.0 + i as f32);
        let law = ForceLaw::Table { step: 1.158e-7, force: core::array::from_fn(steep) };
        for_each_seat(|name, contact| {
            let spring = Spring { seat: &contact.seat, modulus: MATERIAL.contact_modulus(), law: &law };
            for compliance in [1.0e-6, 6.2e-4, 1.0e-2] {
                let series = in_series(&spring, 5.45e-6, compliance);
                let load = min(spring.push(series.depth).load, series.most);
                assert!(load > 0.0 && load * compliance <= 5.45e-6, "{name:?}, {compliance} m/N: {load} N");
            }
        });
    }

    /// Trials that a press takes decide what it costs.
    #[test]
    fn two_trials_find_the_share_of_a_real_body() {
        let modulus = MATERIAL.contact_modulus();
        for_each_seat(|name, contact| {
            let spring = Spring { seat: &contact.seat, modulus, law: &ForceLaw::Hertz };
            let full = spring.push(contact.depth);
            // twice what a rubber cube's side of 0.1 m gives
            let compliance = 2.4e-5;
            if contact.seat.centroid().is_some() || compliance * full.load > 0.3 * contact.depth {
                return;
            }
            let mut x = contact.depth;
            for _ in 0..2 {
                let push = spring.push(x);
                x = as_power(x, &push, x - contact.depth + compliance * push.load, contact.depth, compliance);
            }
            let off = (x / in_series(&spring, contact.depth, compliance).depth - 1.0).abs();
            assert!(off <= SETTLED, "{name:?}: {off}");
        });
    }
}
