//! Which setting to take, in words.

use super::point::{Point, Trade};

/// What the user can afford and needs.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest error \[per cent\], when one is asked for.
    pub error: Option<f64>,
    /// Largest share of the tick's period \[per cent\].
    pub share: f64,
}

/// Errors within this of each other are alike: the cheaper is taken.
const ALIKE: f64 = 0.005;

/// The setting to take at the rate that was asked for: with an error asked for the cheapest that meets it, else the most accurate that fits into the share of the period. Without costs
/// the first in the order of the settings counts as the cheapest.
pub fn choose<'a>(trade: &'a Trade, limits: &Limits) -> Option<&'a Point> {
    let fits = |point: &&Point| point.share().is_none_or(|share| 100.0 * share <= limits.share);
    let fitting: Vec<&Point> = trade.asked().filter(fits).collect();
    let least = fitting.iter().map(|point| point.errors.worst()).reduce(f64::min)?;
    let enough = limits.error.map_or(least + ALIKE, |error| error / 100.0);
    let price = |point: &Point| point.cost.map_or(0.0, |cost| cost.worst);
    fitting.into_iter().filter(|point| point.errors.worst() <= enough).min_by(|a, b| price(a).total_cmp(&price(b)))
}

/// The recommendation as a sentence or two.
pub fn words(trade: &Trade, limits: &Limits) -> String {
    let rate = rate(trade.rate);
    let Some(point) = choose(trade, limits) else { return nothing(trade, limits) };
    let errors = &point.errors;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut text = format!(
        "For {rate} on this machine take {}: {} in normal force, {} in twist, {} in mixed motion, {} where the twist turns back",
        point.setting.name(),
        percent(errors.normal.max),
        percent(errors.twist.max),
        percent(errors.mixed.max),
        percent(errors.reversal.max)
    );
    match (point.cost, point.share()) {
        (Some(cost), Some(share)) => {
            text += &format!(", {:.1} us for the dearest tick ({} of the period).", cost.worst, percent(share));
        }
        _ => text += "; costs were not taken.",
    }
    let accurate = |a: &&Point, b: &&Point| a.errors.worst().total_cmp(&b.errors.worst());
    match trade.asked().min_by(accurate) {
        Some(best) if best.setting != point.setting && best.errors.worst() + ALIKE < errors.worst() => {
            text += &format!(" The most accurate here is {} ({} at worst)", best.setting.name(), percent(best.errors.worst()));
            text += &best.cost.map_or(String::new(), |cost| format!(", {:.1} us", cost.worst));
            text += ".";
        }
        _ => {}
    }
    text
}

/// Nothing meets the limits: what would be nearest.
fn nothing(trade: &Trade, limits: &Limits) -> String {
    let asked = limits.error.map_or(String::new(), |error| format!(" within {error} %"));
    let mut text = format!("Nothing that was tried stays{asked} within {} % of the period at {}", limits.share, rate(trade.rate));
    let best = trade.asked().min_by(|a, b| a.errors.worst().total_cmp(&b.errors.worst()));
    if let Some(best) = best {
        text += &format!(": the most accurate, {}, errs by {:.1} %", best.setting.name(), 100.0 * best.errors.worst());
        text += &best.share().map_or(String::new(), |share| format!(" and takes {:.1} % of the period", 100.0 * share));
    }
    text + "; allow more with --error or --share, or lower --rate."
}

/// `1 kHz`, `500 Hz`.
pub fn rate(rate: f64) -> String {
    if rate >= 1000.0 { format!("{} kHz", rate / 1000.0) } else { format!("{rate} Hz") }
}

#[cfg(test)]
mod tests {
    use super::super::cost::Cost;
    use super::super::errors::{Errors, Off};
    use super::super::settings::ALL;
    use super::*;

    fn trade() -> Trade {
        let point = |index: usize, error: f64, worst: f64| Point {
            setting: ALL[index],
            rate: 1000.0,
            errors: Errors { mixed: Off { max: error, rms: error }, ..Errors::default() },
            surface: Default::default(),
            cost: Some(Cost { worst, ..Cost::default() }),
        };
        Trade {
            scene: "s".into(),
            depth: 1.0,
            contacts: 1,
            units: Default::default(),
            source: String::new(),
            own: None,
            unconverged: 0,
            rate: 1000.0,
            points: vec![
                point(0, 0.5, 1.0),
                point(4, 0.2, 3.0),
                point(6, 0.1, 9.0),
                point(11, 0.103, 40.0),
                point(15, 0.02, 700.0),
            ],
            notes: Vec::new(),
        }
    }

    #[test]
    fn the_most_accurate_that_fits_is_taken_or_the_cheapest_that_will_do() {
        let trade = trade();
        let name = |error, share| choose(&trade, &Limits { error, share }).map(|point| point.setting.name());
        assert_eq!(name(None, 50.0).as_deref(), Some("bristle 64"));
        assert_eq!(name(None, 80.0).as_deref(), Some("influence 112 x 4"));
        assert_eq!(name(Some(30.0), 50.0).as_deref(), Some("bristle 16"));
        assert_eq!(name(Some(1.0), 100.0), None);
        assert!(words(&trade, &Limits { error: Some(1.0), share: 100.0 }).contains("influence 112 x 4, errs by 2.0 %"));
        assert!(words(&trade, &Limits { error: None, share: 50.0 }).contains("take bristle 64: 0.0 % in normal force"));
    }

    #[test]
    fn what_is_dearer_and_worse_is_not_on_the_frontier() {
        let trade = trade();
        let on: Vec<bool> = trade.points.iter().map(|point| trade.on_frontier(point)).collect();
        assert_eq!(on, [true, true, true, false, true]);
    }
}
