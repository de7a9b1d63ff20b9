//! Histories in which the load changes while the probe is dragged and twisted: what is shed, what is kept, what enters free.
//!
//! A sphere of small strain: the contact radius a goes as the root of the depth and the load as its cube. Radii are told in the largest
//! one of the history; shifts, angles and answers in the units of the contact of that radius (`led`).

use super::led::{Answer, Led};
use super::paths::legs;
use super::profile::Profile;
use super::table::{SUBSTEPS, rounded};
use serde::Serialize;

/// Contact radius in the largest one, shift along x and y in s0, angle in phi0.
pub type Pressed = [f64; 4];

/// A history: its name and a function of progress 0..=1.
#[derive(Clone, Copy)]
pub struct History {
    /// Name in the table.
    pub name: &'static str,
    /// State at progress `t`.
    pub at: fn(f64) -> Pressed,
}

impl std::fmt::Debug for History {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "History {}", self.name)
    }
}

/// Every history. Each starts pressed and untouched by friction; the radius is never below 0.3.
pub const HISTORIES: &[History] = &[
    history("twist_hold_press", |t| {
        legs(t, &[[0.6, 0.0, 0.0, 0.0], [0.6, 0.0, 0.0, 0.3], [1.0, 0.0, 0.0, 0.3], [1.0, 0.0, 0.0, 1.5]])
    }),
    history("twist_hold_lift", |t| legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.8], [0.4, 0.0, 0.0, 0.8]])),
    history("twist_lift_press", |t| {
        legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.8], [0.5, 0.0, 0.0, 0.8], [1.0, 0.0, 0.0, 0.8], [1.0, 0.0, 0.0, 2.0]])
    }),
    history("twist_lift_press_back", |t| {
        legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.8], [0.7, 0.0, 0.0, 0.8], [1.0, 0.0, 0.0, 0.8], [1.0, 0.0, 0.0, -0.8]])
    }),
    history("twist_while_pressing", |t| legs(t, &[[0.3, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.6]])),
    history("twist_fast_while_pressing", |t| legs(t, &[[0.3, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.5]])),
    history("twist_while_lifting", |t| legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.3], [0.4, 0.0, 0.0, 0.7]])),
    history("drag_hold_press", |t| {
        legs(t, &[[0.6, 0.0, 0.0, 0.0], [0.6, 0.3, 0.0, 0.0], [1.0, 0.3, 0.0, 0.0], [1.0, 1.2, 0.0, 0.0]])
    }),
    history("drag_hold_lift", |t| legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.5, 0.0, 0.0], [0.4, 0.5, 0.0, 0.0]])),
    history("drag_lift_press", |t| {
        legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.5, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [1.0, 0.5, 0.0, 0.0], [1.0, 1.4, 0.0, 0.0]])
    }),
    history("drag_while_pressing", |t| legs(t, &[[0.3, 0.0, 0.0, 0.0], [1.0, 0.6, 0.0, 0.0]])),
    history("both_lift_press", |t| {
        legs(t, &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.5, 0.0, 0.5], [0.6, 0.5, 0.0, 0.5], [1.0, 0.5, 0.0, 0.5], [1.0, 0.5, 0.8, 1.0]])
    }),
    history("both_while_pressing", |t| {
        legs(t, &[[0.4, 0.0, 0.0, 0.0], [1.0, 0.6, 0.0, 1.0], [0.7, 0.9, 0.3, 1.2], [1.0, 0.6, 0.8, 0.4]])
    }),
    history("taps_in_a_twist", |t| {
        legs(
            t,
            &[
                [0.8, 0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0, 0.4],
                [0.6, 0.0, 0.0, 0.8],
                [1.0, 0.0, 0.0, 1.2],
                [0.6, 0.0, 0.0, 0.8],
                [1.0, 0.0, 0.0, 0.4],
            ],
        )
    }),
];

const fn history(name: &'static str, at: fn(f64) -> Pressed) -> History {
    History { name, at }
}

/// One history with its answers, one row per `SUBSTEPS` steps.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name.
    pub name: &'static str,
    /// The start, and then the state of each row.
    pub state: Vec<Pressed>,
    /// Force in the largest mu P (x, y), torque in the largest T_max; zero at the start.
    pub answer: Vec<Answer>,
}

/// Everything one run writes.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// What the numbers mean.
    pub note: &'static str,
    /// Number of square cells on the largest patch.
    pub cells: usize,
    /// Steps solved per row; each was iterated to convergence.
    pub substeps: usize,
    /// Steps that did not converge; zero in a good table.
    pub unconverged: usize,
    /// The histories.
    pub histories: Vec<Row>,
}

const NOTE: &str = "Half-space boundary elements, nu 0.5, sphere of small strain (a ~ depth^(1/2), P ~ a^3), Coulomb friction iterated at \
each step. state: contact radius in the largest one, shift x, y in s0, angle in phi0 of the largest contact (s0 = 3 mu P (2-nu)/(16 a G), \
phi0 = 9 pi mu P/(256 G a^2)). answer: Q_x, Q_y in its mu P, T in its T_max, that the object feels. Written by the binary `reference`.";

/// Runs every history on `across` cells over the largest diameter and keeps `rows` rows of each.
#[must_use]
pub fn run(across: usize, rows: usize, progress: &mut dyn FnMut(&str)) -> Table {
    let fresh = Led::new(across, Profile::Hertz);
    let mut table = Table { note: NOTE, cells: fresh.cells(), substeps: SUBSTEPS, unconverged: 0, histories: Vec::new() };
    for history in HISTORIES {
        let mut patch = fresh.clone();
        table.histories.push(follow(history, &mut patch, rows));
        table.unconverged += patch.unconverged();
        progress(&format!("{} {} sweeps", history.name, patch.sweeps()));
    }
    table
}

fn follow(history: &History, patch: &mut Led, rows: usize) -> Row {
    let mut row = Row { name: history.name, state: vec![(history.at)(0.0)], answer: vec![[0.0; 3]] };
    let steps = rows * SUBSTEPS;
    for step in 1..=steps {
        let state @ [radius, x, y, angle] = (history.at)(step as f64 / steps as f64);
        patch.press(radius);
        let answer = patch.step([x, y, angle]);
        if step % SUBSTEPS == 0 {
            row.state.push(state.map(rounded));
            row.answer.push(answer.map(rounded));
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(name: &str) -> Row {
        let history = HISTORIES.iter().find(|h| h.name == name).expect("a history of this name exists");
        follow(history, &mut Led::new(12, Profile::Hertz), 24)
    }

    #[test]
    fn what_is_shed_does_not_come_back() {
        let row = answers("twist_lift_press");
        let (lifted, pressed) = (row.answer[12][2], row.answer[18][2]);
        assert!(lifted < 0.2 && (pressed - lifted).abs() < 0.01, "{lifted} {pressed}");
    }

    #[test]
    fn pressing_deeper_under_a_held_twist_changes_no_torque() {
        let row = answers("twist_hold_press");
        let (held, pressed) = (row.answer[8][2], row.answer[16][2]);
        assert!((pressed - held).abs() < 0.02, "{held} {pressed}");
    }
}
