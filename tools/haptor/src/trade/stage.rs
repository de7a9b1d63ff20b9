//! A scene made ready for a trade: where the probe first touches, how deep it presses, and the core led there.

use haptor_contact::{CouplingSpec, ParamsSpec, ProbePart, ProbeShape, Quat, Tier, Vec3};

use super::motions::{Motion, PRESS_SAMPLES, SAMPLES, SECONDS};
use super::truth::{Felt, Units};
use crate::failure::Failure;
use crate::motion::{Place, first_touch};
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::table::Table;
use crate::trajectory::Row;

/// Depth of the press as a share of the contact's own length: inside what small strain describes, and deep enough that radii differ from points.
const DEPTH: f64 = 0.05;

/// Time of the press \[s\].
const PRESS_SECONDS: f64 = 0.2;

/// Steps of the press that finds the length.
const FEEL_STEPS: usize = 20;

/// A scene, first touch and depth.
pub struct Stage<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Height of the probe's origin at first touch \[m\].
    pub touch: f64,
    /// Depth of the press \[m\].
    pub depth: f64,
}

impl<'a> Stage<'a> {
    /// `depth` in place of the scene's own length's share.
    ///
    /// # Errors
    /// When nothing is touched on the way down.
    pub fn new(scene: &'a Scene, name: &str, depth: Option<f64>) -> Result<Self, Failure> {
        let parts = &scene.probe.parts;
        let touch = first_touch(&scene.object.shape, parts, scene.touch_height()).into();
        let smallest = parts.iter().map(length).fold(f64::INFINITY, f64::min);
        let mut stage = Self { scene, touch, depth: depth.unwrap_or(DEPTH * smallest) };
        let params = stage.params(Tier::Point, scene.params.samples.min(256), 1);
        let mut simulation = stage.simulate(&params, None)?;
        for i in 1..=FEEL_STEPS {
            stage.tick(&mut simulation, stage.pressed(i as f64 / FEEL_STEPS as f64), 1.0e-3, &mut 0.0);
        }
        // the part that touches counts, not the smallest one
        let found = simulation.contacts().iter().map(|patch| length(&parts[usize::from(patch.part)]));
        let Some(length) = found.reduce(f64::min) else {
            return Err(Failure::bad_input(format!(
                "{name}: the probe touches nothing when it is lowered at x = y = 0; move the object or the probe's parts there"
            )));
        };
        stage.depth = depth.unwrap_or(DEPTH * length);
        Ok(stage)
    }

    /// The scene's parameters with a tier of so many samples and sweeps: contact only, probe tied to the handle directly.
    pub fn params(&self, tier: Tier, samples: usize, sweeps: usize) -> ParamsSpec {
        ParamsSpec { tier, samples, sweeps, coupling: CouplingSpec::Direct, gravity: false, ..self.scene.contact_only() }
    }

    /// A core at rest.
    ///
    /// # Errors
    /// When the core refuses the parameters.
    pub fn simulate<'b>(&'b self, params: &ParamsSpec, table: Option<&'b Table>) -> Result<Simulation<'b>, Failure> {
        Simulation::with_table(self.scene, params, table).map_err(Failure::bad_input)
    }

    /// The place at a share of the press.
    pub fn pressed(&self, share: f64) -> Place {
        Place { depth: self.depth * share, angle: 0.0, shift: [0.0; 2] }
    }

    /// The place on a motion.
    pub fn led(&self, motion: &Motion, units: &Units, progress: f64) -> Place {
        let [x, y, angle] = motion.at(progress);
        Place { depth: self.depth, angle: angle * units.angle, shift: [x * units.shift, y * units.shift] }
    }

    /// The pose of a place, as the core reads it.
    pub fn row(&self, place: Place, dt: f64, t: f64) -> Row {
        let [x, y] = place.shift.map(|shift| shift as f32);
        let position = Vec3::new(x, y, (self.touch - place.depth) as f32);
        let (sin, cos) = (0.5 * place.angle).sin_cos();
        Row { written_t: String::new(), t, dt: dt as f32, position, rotation: Quat::from_xyzw(0.0, 0.0, sin as f32, cos as f32) }
    }

    /// One tick at a place; the time goes on.
    pub fn tick(&self, simulation: &mut Simulation<'_>, place: Place, dt: f64, t: &mut f64) -> Felt {
        *t += dt;
        let felt = simulation.tick(&self.row(place, dt, *t)).contact;
        Felt { force: felt.force.to_array().map(f64::from), torque: felt.torque.to_array().map(f64::from) }
    }

    /// Presses at `rate` ticks a second; what was felt at the samples.
    pub fn press(&self, simulation: &mut Simulation<'_>, rate: f64, t: &mut f64) -> Vec<Felt> {
        let per_sample = (PRESS_SECONDS * rate / PRESS_SAMPLES as f64).ceil() as usize;
        self.tick(simulation, Place::START, 1.0 / rate, t);
        let ticks = per_sample * PRESS_SAMPLES;
        let felt: Vec<Felt> =
            (1..=ticks).map(|i| self.tick(simulation, self.pressed(i as f64 / ticks as f64), 1.0 / rate, t)).collect();
        felt.into_iter().skip(per_sample - 1).step_by(per_sample).collect()
    }

    /// Leads a pressed core along a motion; what was felt at the samples.
    pub fn follow(&self, simulation: &mut Simulation<'_>, motion: &Motion, units: &Units, rate: f64, t: &mut f64) -> Vec<Felt> {
        let per_sample = ticks_per_sample(rate);
        let ticks = per_sample * SAMPLES;
        let felt: Vec<Felt> =
            (1..=ticks).map(|i| self.tick(simulation, self.led(motion, units, i as f64 / ticks as f64), 1.0 / rate, t)).collect();
        felt.into_iter().skip(per_sample - 1).step_by(per_sample).collect()
    }
}

/// Ticks between two samples of a motion.
pub fn ticks_per_sample(rate: f64) -> usize {
    ((SECONDS * rate / SAMPLES as f64).round() as usize).max(1)
}

/// The length that a part's depth is told in: what it is round or wide by \[m\].
fn length(part: &ProbePart<'_>) -> f64 {
    let length = match part.shape {
        ProbeShape::Sphere { radius } | ProbeShape::Capsule { radius, .. } => radius,
        ProbeShape::Cylinder { radius, height } | ProbeShape::Cone { radius, height } => radius.min(height),
        ProbeShape::Box { size } => 0.5 * size.min_element(),
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.min_element(),
        ProbeShape::Mesh(mesh) => {
            let (low, high) = mesh.bounds();
            0.5 * (high - low).min_element()
        }
    };
    length.into()
}
