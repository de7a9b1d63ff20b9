//! A trade's result: points, each a setting at a rate with its errors and costs.

use super::cost::Cost;
use super::errors::{Errors, SurfaceErrors};
use super::settings::Setting;
use super::truth::Units;

/// One setting at one rate.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The setting.
    pub setting: Setting,
    /// Ticks a second \[Hz\].
    pub rate: f64,
    /// Errors.
    pub errors: Errors,
    /// Errors of the surface.
    pub surface: SurfaceErrors,
    /// Cost, when it was taken.
    pub cost: Option<Cost>,
}

impl Point {
    /// Share of the tick's period that the dearest tick takes.
    pub fn share(&self) -> Option<f64> {
        self.cost?.times.map(|times| 1.0e-6 * times.worst * self.rate)
    }

    /// What points are compared by, when any cost was taken.
    pub fn price(&self) -> Option<f64> {
        self.cost?.price()
    }
}

/// A scene's trade.
pub struct Trade {
    /// Name of the scene.
    pub scene: String,
    /// Depth of the press \[m\].
    pub depth: f64,
    /// Contacts at that depth.
    pub contacts: usize,
    /// Units of the contact.
    pub units: Units,
    /// Where the truth comes from.
    pub source: String,
    /// What a coarser reference differs by, when it was solved.
    pub own: Option<Errors>,
    /// Steps of the reference that did not converge.
    pub unconverged: usize,
    /// The rate that was asked for \[Hz\].
    pub rate: f64,
    /// Points, in the order of the settings, then of the rates.
    pub points: Vec<Point>,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl Trade {
    /// Points at the rate that was asked for.
    pub fn asked(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| point.rate == self.rate)
    }

    /// Whether no other point at this rate is both cheaper and more accurate.
    pub fn on_frontier(&self, point: &Point) -> bool {
        let Some(price) = point.price() else { return false };
        let better = |other: &Point| {
            other.rate == point.rate
                && other.setting != point.setting
                && other.errors.worst() <= point.errors.worst()
                && other.price().is_some_and(|its| its <= price)
        };
        !self.points.iter().any(better)
    }
}
