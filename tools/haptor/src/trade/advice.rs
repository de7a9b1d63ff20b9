//! Which setting to take, in words.

use super::cost::{Cost, VERTICES};
use super::errors::{Errors, Off};
use super::motions::Kind;
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
    let fitting: Vec<&Point> = fitting(trade, limits).collect();
    let least = fitting.iter().map(|point| point.errors.worst()).reduce(f64::min)?;
    let enough = limits.error.map_or(least + ALIKE, |error| error / 100.0);
    let price = |point: &Point| point.price().unwrap_or(0.0);
    fitting.into_iter().filter(|point| point.errors.worst() <= enough).min_by(|a, b| price(a).total_cmp(&price(b)))
}

/// Points that fit into the share of the period, as far as times are known.
fn fitting<'a>(trade: &'a Trade, limits: &Limits) -> impl Iterator<Item = &'a Point> {
    let share = limits.share;
    trade.asked().filter(move |point| point.share().is_none_or(|its| 100.0 * its <= share))
}

/// The recommendation in sentences: what to write, what it errs by and costs, what is given up, what would be cheaper.
pub fn words(trade: &Trade, limits: &Limits) -> String {
    let Some(point) = choose(trade, limits) else { return nothing(trade, limits) };
    let Errors { normal, twist, mixed, reversal } = point.errors;
    let mut text = format!(
        "For {} on this machine take {} ({}): {} in normal force, {} in twist, {} in mixed motion, {} where the twist turns back",
        rate(trade.rate),
        point.setting.name(),
        point.setting.keys(),
        percent(normal.max),
        percent(twist.max),
        percent(mixed.max),
        percent(reversal.max)
    );
    text += &match (point.cost, point.share()) {
        (Some(cost), Some(share)) => format!(", {}, {} of the period.", told(&cost), percent(share)),
        (Some(cost), None) if cost.instructions.is_some() => format!(", {}; times were not taken.", told(&cost)),
        _ => "; costs were not taken.".to_owned(),
    };
    text + &given_up(trade, point) + &cheaper(trade, point) + &surface(point)
}

/// The dearest tick's price: its time, or its instructions where no time was taken.
fn told(cost: &Cost) -> String {
    match (cost.times, cost.instructions) {
        (Some(times), _) => format!("{:.1} us for the dearest tick", times.worst),
        (None, Some(count)) => format!("{count} instructions for the dearest tick"),
        (None, None) => "no cost taken".to_owned(),
    }
}

/// What the most accurate setting would do better.
fn given_up(trade: &Trade, point: &Point) -> String {
    let best = trade.asked().min_by(|a, b| a.errors.worst().total_cmp(&b.errors.worst()));
    let Some(best) = best.filter(|best| best.errors.worst() + ALIKE < point.errors.worst()) else {
        return " Nothing that was tried is more accurate by half a per cent.".to_owned();
    };
    let its = format!(
        " Given up: {} errs by {} at worst instead of {}",
        best.setting.name(),
        percent(best.errors.worst()),
        percent(point.errors.worst())
    );
    its + &best.cost.filter(|cost| cost.price().is_some()).map_or(String::new(), |cost| format!(", with {}", told(&cost))) + "."
}

/// The next cheaper setting on the frontier.
fn cheaper(trade: &Trade, point: &Point) -> String {
    let Some(price) = point.price() else { return String::new() };
    let below = trade.asked().filter(|other| trade.on_frontier(other)).filter_map(|other| Some((other, other.price()?)));
    let next = below.filter(|(_, its)| *its < price).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((other, cost)) = next.and_then(|(other, _)| Some((other, other.cost?))) else { return String::new() };
    format!(" Cheaper: {}, {}, {} at worst.", other.setting.name(), told(&cost), percent(other.errors.worst()))
}

/// What the surface errs by for who looks, by amount of deformation.
fn surface(point: &Point) -> String {
    let times = point.cost.and_then(|cost| cost.times);
    let told = |name: &str, off: Off, time: Option<f64>| {
        let takes = time.map_or(String::new(), |time| format!(" in {time:.0} us for {VERTICES} vertices"));
        format!("deformation = \"{name}\" errs by {} ({} at worst){takes}", percent(off.rms), percent(off.max))
    };
    let full = told("full", point.surface.full, times.map(|times| times.surface_full));
    let local = told("local", point.surface.local, times.map(|times| times.surface_local));
    let after = point.surface.farthest.after.map_or("pressing", Kind::name);
    format!(" For the surface {full}, farthest after {after}; {local}; if nobody looks, take \"none\".")
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Nothing meets the limits: what would be nearest.
fn nothing(trade: &Trade, limits: &Limits) -> String {
    let asked = limits.error.map_or(String::new(), |error| format!(" within {error} %"));
    let mut text = format!("Nothing that was tried stays{asked} within {} % of the period at {}", limits.share, rate(trade.rate));
    let best = trade.asked().min_by(|a, b| a.errors.worst().total_cmp(&b.errors.worst()));
    if let Some(best) = best {
        text += &format!(": the most accurate, {}, errs by {}", best.setting.name(), percent(best.errors.worst()));
        text += &best.share().map_or(String::new(), |share| format!(" and takes {} of the period", percent(share)));
    }
    text + "; allow more with --error or --share, or lower --rate."
}

/// `1 kHz`, `500 Hz`.
pub fn rate(rate: f64) -> String {
    if rate >= 1000.0 { format!("{} kHz", rate / 1000.0) } else { format!("{rate} Hz") }
}

#[cfg(test)]
mod tests {
    use super::super::cost::Times;
    use super::super::settings::ALL;
    use super::*;

    fn trade() -> Trade {
        let point = |index: usize, error: f64, worst: f64| Point {
            setting: ALL[index],
            rate: 1000.0,
            errors: Errors { mixed: Off { max: error, rms: error }, ..Errors::default() },
            surface: Default::default(),
            cost: Some(Cost { times: Some(Times { worst, ..Times::default() }), ..Cost::default() }),
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
        let said = words(&trade, &Limits { error: None, share: 50.0 });
        for part in [
            "take bristle 64 (tier = \"bristle\", samples = 64): 0.0 % in normal force",
            "9.0 us for the dearest tick, 0.9 % of the period",
            "Given up: influence 112 x 4 errs by 2.0 % at worst instead of 10.0 %, with 700.0 us",
            "Cheaper: bristle 16, 3.0 us for the dearest tick, 20.0 % at worst",
        ] {
            assert!(said.contains(part), "{said}");
        }
    }

    /// Where no time was taken, instructions are the price.
    #[test]
    fn instructions_stand_in_for_times() {
        let mut trade = trade();
        for (point, count) in trade.points.iter_mut().zip([100, 300, 200, 250, 900]) {
            point.cost = Some(Cost { instructions: Some(count), ..Cost::default() });
        }
        let on: Vec<bool> = trade.points.iter().map(|point| trade.on_frontier(point)).collect();
        assert_eq!(on, [true, false, true, false, true]);
        let said = words(&trade, &Limits { error: Some(30.0), share: 1.0 });
        assert!(said.contains("take bristle 64") && said.contains("200 instructions for the dearest tick; times"), "{said}");
    }

    #[test]
    fn what_is_dearer_and_worse_is_not_on_the_frontier() {
        let trade = trade();
        let on: Vec<bool> = trade.points.iter().map(|point| trade.on_frontier(point)).collect();
        assert_eq!(on, [true, true, true, false, true]);
    }
}
