//! How far a setting of the core is from the truth, each figure on its own scale.

use haptor_contact::{ParamsSpec, Vec3};
use haptor_mesh::DVec3;

use super::answers::Answers;
use super::motions::{Kind, MOTIONS};
use super::stage::Stage;
use super::truth::Felt;
use crate::failure::Failure;
use crate::motion::Place;
use crate::simulation::Simulation;
use crate::table::Table;

/// Largest and root-mean-square error, as shares of the figure's scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// Largest.
    pub max: f64,
    /// Root of the mean square.
    pub rms: f64,
}

impl Off {
    fn of(all: &[f64]) -> Self {
        let square = all.iter().map(|off| off * off).sum::<f64>() / all.len().max(1) as f64;
        Self { max: all.iter().copied().fold(0.0, f64::max), rms: square.sqrt() }
    }
}

/// Errors of one setting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Normal force while pressing, of the force at full depth.
    pub normal: Off,
    /// Torque under a steady twist, of its largest.
    pub twist: Off,
    /// Force along the surface (of mu P) and torque (of the steady twist's largest) where both change, the worse of the two.
    pub mixed: Off,
    /// Torque where the twist turns back, of the steady twist's largest.
    pub reversal: Off,
}

impl Errors {
    /// The worst of all.
    pub fn worst(&self) -> f64 {
        [self.normal, self.twist, self.mixed, self.reversal].iter().map(|off| off.max).fold(0.0, f64::max)
    }
}

/// Errors of the surface near the contacts, of the largest displacement there: pressed and after every motion, by amount of deformation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceErrors {
    /// Only the contacts' surroundings move.
    pub local: Off,
    /// The body moves, too.
    pub full: Off,
    /// Where the latter is largest.
    pub farthest: Farthest,
}

/// Where and when a surface is farthest from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Farthest {
    /// Its error.
    pub error: f64,
    /// After which motion; `None` when just pressed.
    pub after: Option<Kind>,
    /// At rest in world \[m\].
    pub place: Vec3,
}

/// Compares one setting at `rate` ticks a second.
///
/// # Errors
/// When the core refuses the parameters.
pub fn measure(
    stage: &Stage<'_>,
    answers: &Answers,
    params: &ParamsSpec,
    table: Option<&Table>,
    rate: f64,
) -> Result<(Errors, SurfaceErrors), Failure> {
    let mut gathered = Gathered::default();
    let mut surface = Seen::default();
    for (motion, truth) in MOTIONS.iter().zip(&answers.led) {
        let mut simulation = stage.simulate(params, table)?;
        let mut t = 0.0;
        let pressed = stage.press(&mut simulation, rate, &mut t);
        if motion.kind == Kind::Twist {
            gathered.normal = normal(&pressed, &answers.pressed);
            surface.add(stage, &simulation, answers, &answers.dented, (stage.pressed(1.0), None));
        }
        let felt = stage.follow(&mut simulation, motion, &answers.units, rate, &mut t);
        gathered.add(motion.kind, &felt, &truth.felt, answers);
        let end = stage.led(motion, &answers.units, 1.0);
        surface.add(stage, &simulation, answers, &truth.moved, (end, Some(motion.kind)));
    }
    let surface = SurfaceErrors { local: Off::of(&surface.local), full: Off::of(&surface.full), farthest: surface.farthest };
    Ok((gathered.errors(), surface))
}

/// Largest differences of two truths on the same scene, as a setting's errors would be: what the coarser one adds.
pub fn between(fine: &Answers, coarse: &Answers) -> Errors {
    let mut gathered = Gathered { normal: normal(&coarse.pressed, &fine.pressed), ..Gathered::default() };
    for (motion, (a, b)) in MOTIONS.iter().zip(coarse.led.iter().zip(&fine.led)) {
        gathered.add(motion.kind, &a.felt, &b.felt, fine);
    }
    gathered.errors()
}

/// Errors at every sample, by what they are errors of.
#[derive(Default)]
struct Gathered {
    normal: Vec<f64>,
    twist: Vec<f64>,
    reversal: Vec<f64>,
    mixed: Vec<f64>,
}

impl Gathered {
    fn add(&mut self, kind: Kind, felt: &[Felt], truth: &[Felt], answers: &Answers) {
        let torque = |a: &Felt, b: &Felt| (a.torque[2] - b.torque[2]).abs() / answers.torque;
        let drag = |a: &Felt, b: &Felt| (a.force[0] - b.force[0]).hypot(a.force[1] - b.force[1]) / answers.units.drag;
        let pairs = felt.iter().zip(truth);
        match kind {
            Kind::Twist => self.twist.extend(pairs.map(|(a, b)| torque(a, b))),
            Kind::Reversal => self.reversal.extend(pairs.map(|(a, b)| torque(a, b))),
            Kind::Mixed => self.mixed.extend(pairs.map(|(a, b)| torque(a, b).max(drag(a, b)))),
        }
    }

    fn errors(&self) -> Errors {
        let [normal, twist, mixed, reversal] = [&self.normal, &self.twist, &self.mixed, &self.reversal].map(|all| Off::of(all));
        Errors { normal, twist, mixed, reversal }
    }
}

fn normal(felt: &[Felt], truth: &[Felt]) -> Vec<f64> {
    let most = truth.iter().map(|felt| felt.force[2]).fold(0.0, f64::max);
    felt.iter().zip(truth).map(|(a, b)| (a.force[2] - b.force[2]).abs() / most).collect()
}

/// Errors of the surface at all places and times.
#[derive(Default)]
struct Seen {
    local: Vec<f64>,
    full: Vec<f64>,
    farthest: Farthest,
}

impl Seen {
    /// Adds the errors of all places with the probe at a place, after a motion.
    fn add(
        &mut self,
        stage: &Stage<'_>,
        simulation: &Simulation<'_>,
        answers: &Answers,
        truth: &[DVec3],
        (place, after): (Place, Option<Kind>),
    ) {
        let most = truth.iter().map(|u| u.length()).fold(0.0, f64::max);
        let row = stage.row(place, 1.0, 0.0);
        let errors = |body: bool| -> Vec<f64> {
            let mut moved = vec![Vec3::ZERO; answers.places.len()];
            simulation.surface(&row, body).update(&answers.places, &mut moved);
            moved.iter().zip(truth).map(|(found, truth)| (found.as_dvec3() - *truth).length() / most).collect()
        };
        let (local, full) = (errors(false), errors(true));
        for (&error, &place) in full.iter().zip(&answers.places) {
            if error > self.farthest.error {
                self.farthest = Farthest { error, after, place };
            }
        }
        self.local.extend(local);
        self.full.extend(full);
    }
}
