//! What a tick costs on this machine, scene by scene: the core alone, one thread, no device.
//!
//! Every tick is timed by itself, on the wall clock and on the thread's own CPU clock: on a machine with other work the first says what a hand would wait, the second
//! what the tick needs. What reading both clocks takes, measured beforehand, is taken off. Only ticks in contact count.

pub mod cases;
mod clock;
mod line;

use std::time::{Duration, Instant};

use crate::simulation::Simulation;
use crate::surface;
use crate::table::Table;
use crate::trajectory::Row;
use cases::{Setting, Stand};
use clock::Clocks;
use haptor_contact::{Invalid, Output, Vec3};
pub use line::{Line, quantiles};

/// Ticks in contact that are run before any is counted: caches and predictors have seen the scene.
const WARM: usize = 100;

/// Fewest ticks that are counted, however little time is given: a p99 needs as many.
const FEWEST: usize = 100;

/// Most ticks that are counted: 16 MB.
const MOST: usize = 1_000_000;

/// Vertices of the deformed surface, where it is computed: as many as the window shows.
const VERTICES: usize = 4_096;

/// Runs a scene in one setting for about `time` and counts its ticks in contact.
///
/// # Errors
/// [`Invalid`] names the value that the core refuses.
pub fn measure(stand: &Stand, setting: &Setting, table: Option<&Table>, time: Duration) -> Result<Line, Invalid> {
    let params = setting.params(&stand.scene);
    let clocks = Clocks::new();
    let mut work = Work::new(stand, setting);
    let mut spent = Vec::new();
    let (mut touching, start) = (0, Instant::now());
    'rounds: loop {
        let mut simulation = Simulation::with_table(&stand.scene, &params, table)?;
        for row in &stand.rows {
            let (output, took) = clocks.time(|| work.tick(&mut simulation, row));
            if output.report.regions == 0 {
                continue;
            }
            touching += 1;
            if touching > WARM {
                spent.push(took);
            }
            if spent.len() >= MOST || (spent.len() >= FEWEST && start.elapsed() >= time) {
                break 'rounds;
            }
        }
    }
    Ok(Line::new("haptor", env!("CARGO_PKG_VERSION"), &stand.name, setting.name, &spent))
}

/// What is timed: a tick, and the surface after it where the setting asks for it.
struct Work {
    rest: Vec<Vec3>,
    moved: Vec<Vec3>,
}

impl Work {
    fn new(stand: &Stand, setting: &Setting) -> Self {
        if !setting.surface {
            return Self { rest: Vec::new(), moved: Vec::new() };
        }
        let mesh = surface::at_rest(&stand.scene.object.shape, None, &[], VERTICES);
        let rest: Vec<Vec3> =
            mesh.vertices.iter().take(VERTICES).map(|v| Vec3::from_array(v.to_array().map(|x| x as f32))).collect();
        Self { moved: rest.clone(), rest }
    }

    fn tick(&mut self, simulation: &mut Simulation<'_>, row: &Row) -> Output {
        let output = simulation.tick(row);
        if !self.rest.is_empty() {
            simulation.surface(row, true).update(&self.rest, &mut self.moved);
        }
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_out_of_contact_do_not_count() {
        let stand = cases::stands().unwrap().into_iter().find(|stand| stand.name == "cube-twist").unwrap();
        let setting = stand.settings().find(|setting| setting.name == "point").unwrap();
        let line = measure(&stand, setting, None, Duration::ZERO).unwrap();
        assert_eq!(
            (line.peer.as_str(), line.scene.as_str(), line.case.as_str(), line.n),
            ("haptor", "cube-twist", "point", FEWEST)
        );
        let mut simulation = Simulation::new(&stand.scene, &setting.params(&stand.scene)).unwrap();
        assert_eq!(simulation.tick(&stand.rows[0]).report.regions, 0, "the first row is one of those");
    }
}
