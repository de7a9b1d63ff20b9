//! The truth along every motion, computed once for a scene and then compared with every setting.

use haptor_contact::{Tier, Vec3};
use haptor_mesh::DVec3;

use super::motions::{Kind, MOTIONS, Motion, SAMPLES};
use super::stage::Stage;
use super::truth::{Felt, Truth, Units};
use crate::failure::Failure;

/// Surroundings of a contact whose displacement is compared, in contact radii: beyond, the body's own motion is most of it.
const REACH: f64 = 3.0;

/// How fine the reference is.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// Cells over a contact that is alone.
    pub across: usize,
    /// Steps between two samples of a mixed motion in the coarser of the two solutions that are extrapolated; the finer has twice as many.
    pub substeps: usize,
}

impl Fineness {
    /// For the committed tables.
    pub const FULL: Self = Self { across: 18, substeps: 2 };
    /// For a first look.
    pub const QUICK: Self = Self { across: 12, substeps: 1 };

    /// Cells over each of `count` contacts: fewer where there are many, which hold by their arms and not by their cells.
    fn across(self, count: usize) -> usize {
        if count > 2 { (self.across / 2).max(6) } else { self.across }
    }
}

/// One motion's truth.
pub struct Led {
    /// What is felt at the samples.
    pub felt: Vec<Felt>,
    /// Displacement of the surface's places at the end \[m\].
    pub moved: Vec<DVec3>,
}

/// The truth of a scene.
pub struct Answers {
    /// Units of the contact at full depth.
    pub units: Units,
    /// During the press.
    pub pressed: Vec<Felt>,
    /// Displacement of the places under full press \[m\].
    pub dented: Vec<DVec3>,
    /// Places at rest in world \[m\].
    pub places: Vec<Vec3>,
    /// By motion.
    pub led: Vec<Led>,
    /// Largest torque under a steady twist \[N m\].
    pub torque: f64,
    /// Where the figures come from.
    pub source: String,
    /// Contacts.
    pub contacts: usize,
    /// Steps of the reference that did not converge.
    pub unconverged: usize,
}

/// Solves the scene; `units` in place of the contact's own leads the same motions as another solution did.
///
/// # Errors
/// When a probe's mesh has no skin to measure.
pub fn solve(
    stage: &Stage<'_>,
    fineness: Fineness,
    units: Option<Units>,
    progress: &mut dyn FnMut(),
) -> Result<Answers, Failure> {
    let (mut truth, contacts) = untouched(stage, fineness)?;
    let pressed = truth.press(stage.depth);
    progress();
    let (units, places) = (units.unwrap_or(truth.units()), truth.places(REACH));
    let moved = |truth: &Truth| places.iter().map(|&place| truth.displacement(place)).collect::<Vec<_>>();
    let dented = moved(&truth);
    let start = truth.contact();
    let mut led = Vec::new();
    for motion in &MOTIONS {
        let mut along = |substeps: usize| {
            truth.restore(start.clone());
            lead(&mut truth, stage, motion, &units, substeps)
        };
        let felt = finely(motion.kind, fineness.substeps, &mut along);
        led.push(Led { felt, moved: moved(&truth) });
        progress();
    }
    let torque = led[0].felt.iter().map(|felt| felt.torque[2].abs()).fold(0.0, f64::max);
    Ok(Answers {
        units,
        pressed,
        dented,
        places,
        led,
        torque,
        source: truth.source.clone(),
        contacts,
        unconverged: truth.unconverged(),
    })
}

/// The truth before the press, with the number of contacts there will be.
fn untouched(stage: &Stage<'_>, fineness: Fineness) -> Result<(Truth, usize), Failure> {
    let params = stage.params(Tier::Point, stage.scene.params.samples.min(256), 1);
    let mut simulation = stage.simulate(&params, None)?;
    stage.press(&mut simulation, 1.0e3, &mut 0.0);
    let patches = simulation.contacts();
    let truth = Truth::new(stage.scene, stage.touch, stage.depth, patches, fineness.across(patches.len()));
    let truth = truth.ok_or_else(|| Failure::problem("the probe's mesh has no skin: the gap cannot be measured"))?;
    Ok((truth, patches.len()))
}

/// Leads the truth along a motion, `substeps` steps from one sample to the next, and tells what was felt at the samples.
fn lead(truth: &mut Truth, stage: &Stage<'_>, motion: &Motion, units: &Units, substeps: usize) -> Vec<Felt> {
    let steps = SAMPLES * substeps;
    let felt: Vec<Felt> = (1..=steps).map(|i| truth.lead(stage.led(motion, units, i as f64 / steps as f64))).collect();
    felt.into_iter().skip(substeps - 1).step_by(substeps).collect()
}

/// What is felt along a motion of a kind, as finely as the kind needs.
fn finely(kind: Kind, substeps: usize, along: &mut dyn FnMut(usize) -> Vec<Felt>) -> Vec<Felt> {
    match kind {
        Kind::Mixed => extrapolated(&along(substeps), &along(2 * substeps)),
        Kind::Twist | Kind::Reversal => along(1),
    }
}

/// Slip follows the direction of a step, which is that of its middle: an error in proportion to the step, taken off by two solutions.
fn extrapolated(coarse: &[Felt], fine: &[Felt]) -> Vec<Felt> {
    let off = |coarse: [f64; 3], fine: [f64; 3]| std::array::from_fn(|k| 2.0 * fine[k] - coarse[k]);
    let pairs = coarse.iter().zip(fine);
    pairs.map(|(c, f)| Felt { force: off(c.force, f.force), torque: off(c.torque, f.torque) }).collect()
}

/// Steps of progress that [`solve`] tells.
pub const PROGRESS: u64 = 1 + MOTIONS.len() as u64;
