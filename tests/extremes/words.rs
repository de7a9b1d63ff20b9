//! The document and the tables beside it.

use std::fmt::Write;

use haptor_contact::Tier;

use super::axes::{AXES, Axis, Found, HOLDS};
use super::laws::{LAWS, Law, place_of};
use super::rig::index;
use super::run::{Tallies, Tally};

/// What a run was.
#[derive(Clone, Debug)]
pub struct About {
    /// Its seed.
    pub seed: u64,
    /// Ticks asked for.
    pub asked: u64,
    /// Ticks of the axes.
    pub axis_steps: u64,
    /// Machine and date.
    pub machine: String,
}

/// A value in few characters.
pub fn number(value: f64) -> String {
    if value == 0.0 || (1.0e-2..1.0e4).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// The document.
pub fn document(map: &[Vec<[Found; 5]>], tallies: &Tallies, about: &About) -> String {
    let mut out = HEAD.to_owned();
    let _ = writeln!(
        out,
        "Last run: `cargo xtask extremes --steps {} --seed {} --accept`, {}. {} ticks of {} random cases and {} ticks along the axes; {} ticks warned of themselves, {} poses were refused; \
         digest of all outputs {:016x}.\n",
        about.asked,
        about.seed,
        about.machine,
        spaced(tallies.steps()),
        spaced(tallies.cases()),
        spaced(about.axis_steps),
        spaced(tallies.warned),
        spaced(tallies.refused_poses),
        tallies.digest.0
    );
    axes(&mut out, map);
    laws(&mut out, tallies);
    out.push_str(FOOT);
    out
}

fn spaced(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

const HEAD: &str = "# Extremes

What the core does at the ends of its ranges and beyond, and which laws hold in random corners of the whole box. Written by `cargo xtask extremes --accept`; the short version runs with the
tests (`tests/it/corners.rs`).

![what an f32 loses at the ends of the ranges](extremes.png)

";

fn axes(out: &mut String, map: &[Vec<[Found; 5]>]) {
    let _ = writeln!(
        out,
        "## Axes\n\nOne quantity at a time, the rest in the middle of the box (a ball of 20 mm radius 1 mm deep in a half space of 3 MPa, nu 0.3, mu 0.75, but for tier `green`, which takes a cube of 125 mm \
         with its table). At every value the ball is laid on, dragged and twisted to one and a half times full slip and back; force and torque, told in the contact's own units, are compared with \
         the same session at the value named: the units come from closed forms in f64, so that an error is a loss of digits or a threshold told in SI units. A value **holds** when no component is off by more than {} %. \
         All values: `extremes.csv`.\n\n\
         | axis | asked | holds | worst there | beyond, or what breaks first | refused or flagged |\n|---|---|---|---:|---|---|",
        100.0 * HOLDS
    );
    for (axis, found) in AXES.iter().zip(map) {
        let _ = writeln!(out, "{}", axis_row(axis, found));
    }
}

/// Worst error at a value that was neither refused nor warned of; `None` when any tier was.
fn silent(cells: &[Found; 5]) -> Option<f64> {
    let held = cells.iter().filter_map(|cell| if let Found::Held(off) = cell { Some(*off) } else { None });
    held.fold(None, |most, off| Some(most.map_or(off, |most: f64| most.max(off))))
}

fn axis_row(axis: &Axis, found: &[[Found; 5]]) -> String {
    let holds: Vec<(f64, f64)> = axis
        .values
        .iter()
        .zip(found)
        .filter(|(_, cells)| cells.iter().all(|cell| !matches!(cell, Found::Refused | Found::Warned(_) | Found::Untold)))
        .filter_map(|(value, cells)| silent(cells).filter(|&off| off <= HOLDS).map(|off| (*value, off)))
        .collect();
    let range = match (holds.first(), holds.last()) {
        (Some(first), Some(last)) => format!("{} to {}", number(first.0), number(last.0)),
        _ => "nowhere".to_owned(),
    };
    let worst = holds.iter().map(|(_, off)| *off).fold(0.0, f64::max);
    let pick = |of: &dyn Fn(&Found) -> bool| -> Vec<String> {
        let values = axis.values.iter().zip(found).filter(|(_, cells)| cells.iter().any(of));
        values.map(|(value, _)| number(*value)).collect()
    };
    let wrong = pick(&|cell| matches!(cell, Found::Held(off) if *off > HOLDS));
    let coarse = pick(&|cell| matches!(cell, Found::Warned(off) if *off > HOLDS));
    let breaks = match (wrong.is_empty(), coarse.is_empty()) {
        (true, true) => "nothing".to_owned(),
        (true, false) => format!("off by more, and flagged, at {}", coarse.join(", ")),
        _ => format!("**off by more without a word at {}**", wrong.join(", ")),
    };
    let (warned, refused) = (pick(&|cell| matches!(cell, Found::Warned(_))), pick(&|cell| *cell == Found::Refused));
    let told = |what: &str, values: &[String]| {
        if values.is_empty() { String::new() } else { format!("{what} at {}; ", values.join(", ")) }
    };
    let untold = pick(&|cell| *cell == Found::Untold);
    let said =
        format!("{}{}{}", told("no contact for the pose's digits", &untold), told("flagged", &warned), told("refused", &refused));
    format!(
        "| {} \\[{}\\] | {} to {} | {range} | {worst:.1e} | {breaks} | {} |",
        axis.name,
        axis.unit,
        number(axis.asked.0),
        number(axis.asked.1),
        said.trim_end_matches("; ")
    )
}

fn laws(out: &mut String, tallies: &Tallies) {
    out.push_str(LAWS_HEAD);
    for law in LAWS {
        let _ = writeln!(out, "- **{}**: {}", law.name(), meaning(law));
    }
    let _ = writeln!(
        out,
        "\nIn every tick of every case: no panic, no number that is not finite, the guard's limits kept, no more regions than allowed, every patch within its friction budget. Broken in {} cases.\n",
        tallies.faulty
    );
    for fault in &tallies.faults {
        let _ = writeln!(out, "- `{} {:016x}`: {}", fault.law.name(), fault.seed, fault.what);
    }
    out.push_str(
        "\n| law | tier | cases | ticks | in contact | measured | bound | worst | its seed | above the bound |\n|---|---|---:|---:|---:|---:|---:|---:|---|---:|\n",
    );
    for law in LAWS {
        for tier in Tier::ALL {
            let tally = &tallies.laws[place_of(law)][index(tier)];
            let _ = writeln!(out, "| {} | {} | {}", law.name(), tier.name(), tally_row(tally, law.bound(tier)));
        }
    }
}

fn tally_row(tally: &Tally, bound: f64) -> String {
    let (worst, seed) =
        tally.worst.map_or(("-".to_owned(), "-".to_owned()), |(worst, seed)| (format!("{worst:.1e}"), format!("`{seed:016x}`")));
    let touching = if tally.steps > 0 { 100.0 * tally.touching as f64 / tally.steps as f64 } else { 0.0 };
    let bound = if bound == 0.0 {
        "0".to_owned()
    } else if bound.is_finite() {
        format!("{bound:.0e}")
    } else {
        "none".to_owned()
    };
    format!(
        "{} | {} | {touching:.0} % | {} | {bound} | {worst} | {seed} | {} |",
        spaced(tally.cases),
        spaced(tally.steps),
        spaced(tally.measured),
        tally.above
    )
}

const LAWS_HEAD: &str = "
## Laws

A case is made from a seed: tier, object (half space, box, ball, ellipsoid, cylinder, mesh), one to sixteen parts of any shape (ball, box, cylinder, cone, capsule, ellipsoid, mesh), size 1e-6 to 1e2 m, modulus 1e2 to 1e12 Pa, nu 0
to 0.5, mu 0 to 10, depth 1e-12 m to the thickness, from any side, edges, corners and coincident surfaces among them. It is drawn in the middle of the box and taken to its corner by powers of two, so that every
case has a twin with the same digits. Figures are taken where ticks do not warn of themselves (large strain, pose coarse, length floored, region refused).

";

/// What a law says, what its figure is, and why its bound.
fn meaning(law: Law) -> &'static str {
    match law {
        Law::Wander => {
            "motions of a millionth of the probe to all of it at ticks of 1 us to 1 s, every twelfth pose not finite, too far, not a unit quaternion, denormal, or at a tick that is none; run twice with the same \
             bits. Figure: excess over a friction budget; the bound is rounding of sums over 256 samples."
        }
        Law::Coupled => {
            "the same on a virtual coupling of any stiffness, damping and saturation, with a probe of 0 to 1e4 kg. Figure and bound as above."
        }
        Law::Cycle => {
            "three to twelve closed cycles of the pose in all six directions. Figure: work that came out of a cycle over all that was exchanged in it. Every tier is passive as an elastic body with Coulomb friction is; what may \
             come out is the rule of integration over 240 ticks and, beside edges and on bodies whose curvature changes, a normal force that depends on the place along with the depth, which no potential has."
        }
        Law::Units => {
            "the case and its twin feel alike, forces as E L^2, torques as E L^3. Figure: largest difference over the largest wrench. Exact but where a threshold is told in metres or the range of an f32 ends."
        }
        Law::Turned => {
            "the world turned by a quarter about the vertical, the probe's own axes with it, so that both worlds have the same digits. Figure as above. Samples stand in a pattern that does not turn with the world: two per cent."
        }
        Law::Moved => {
            "on a half space the same poses up to 700 m away; both sessions have the far one's digits. Figure as above; the bound is rounding of arms."
        }
        Law::Stick => {
            "a motion along the surface of a thousandth of what slips, out and back. Figure: what is left of the change over its largest."
        }
        Law::Deeper => {
            "pressed deeper without friction, the force against the press does not fall. Figure: largest fall over the largest force."
        }
        Law::Continuous => {
            "steps of a ten-thousandth of the depth in all six directions. Figure: largest change of force in a step over the force; a smooth contact changes by some 1e-3."
        }
        Law::Times => "the same poses at ticks of 1 us to 1 s and at an hour. Figure: ticks whose contact differs in any bit.",
        Law::Repeated => {
            "each pose up to four times over, as a stream that stutters has it, at steps of up to a fiftieth of the depth. Figure: largest difference over the largest wrench: what a tick's few passes leave for the next."
        }
        Law::Hold => {
            "holding still: after at most 96 ticks every tick has the bits of the one before. Figure: ticks that differ."
        }
    }
}

const FOOT: &str = "
## Cases that are kept

`extremes-cases.csv` holds the worst case of every law and tier. The tests run each: nothing may break that must never break, and a figure above its bound, or of a law without one, may grow by a twentieth at most. A case alone: `cargo run --release -p haptor-tests --bin extremes -- --law NAME --case SEED`.
";

/// The map: axis, value, tier, what was found, error.
pub fn map_csv(map: &[Vec<[Found; 5]>]) -> String {
    let mut out = "axis,unit,value,tier,found,error\n".to_owned();
    for (axis, found) in AXES.iter().zip(map) {
        for (value, cells) in axis.values.iter().zip(found) {
            for (tier, cell) in Tier::ALL.iter().zip(cells) {
                let (word, off) = match cell {
                    Found::Nothing => continue,
                    Found::Untold => ("untold", String::new()),
                    Found::Refused => ("refused", String::new()),
                    Found::Warned(off) => ("flagged", format!("{off:.2e}")),
                    Found::Held(off) => ("held", format!("{off:.2e}")),
                };
                let _ = writeln!(out, "{},{},{value:e},{},{word},{off}", axis.name, axis.unit, tier.name());
            }
        }
    }
    out
}

/// The worst case of every law and tier.
pub fn cases_csv(tallies: &Tallies) -> String {
    let mut out = "law,tier,seed,figure\n".to_owned();
    for law in LAWS {
        for tier in Tier::ALL {
            if let Some((worst, seed)) = tallies.laws[place_of(law)][index(tier)].worst {
                let _ = writeln!(out, "{},{},{seed:016x},{worst:.3e}", law.name(), tier.name());
            }
        }
    }
    out
}
