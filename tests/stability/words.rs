//! The map in words and tables.

use std::fmt::Write;

use super::map::{HANDS, LONGEST, MACHINES, MODULI, Map, Panel, RATES, VARIANTS, on_two_threads};
use super::plot::text;
use super::rig::{Case, QUIET, TOGGLE};

/// The stated region: loops of at most this gain K (n + 1/2) T / b hold still.
pub const REGION: f32 = 0.3;

/// Gain from which a loop is expected to shake.
pub const BEYOND: f32 = 2.0;

/// Masses of the probe at which the region is checked \[kg\].
const MASSES: [f32; 3] = [0.0, 0.1, 1.0];

/// How the loops of one kind of coupling lie against their gain.
#[derive(Clone, Copy, Debug, Default)]
pub struct Census {
    /// Loops of gain up to [`REGION`], and how many of them shake.
    pub inside: (u32, u32),
    /// Loops between.
    pub between: (u32, u32),
    /// Loops of gain from [`BEYOND`] on.
    pub beyond: (u32, u32),
    /// Least gain of a loop that shakes.
    pub least: f32,
    /// Inside: most energy the device gave the hand over a stroke, over what the damping of hand and handle took \[1\].
    pub given: f32,
}

/// Every loop of the map without the controller: direct, and virtual at a mass of the probe.
pub fn every(coupled: bool, mass: f32) -> Vec<Case> {
    let mut cases = Vec::new();
    for machine in MACHINES {
        for (_, hand) in HANDS {
            for rate_hz in RATES {
                for young_modulus in MODULI {
                    cases.extend((0..=LONGEST).map(|delay| Case {
                        machine,
                        hand,
                        young_modulus,
                        rate_hz,
                        delay,
                        coupled,
                        passive: false,
                        mass,
                    }));
                }
            }
        }
    }
    cases
}

/// Runs `cases` and counts.
pub fn census(cases: &[Case]) -> Census {
    let results = on_two_threads(cases, |case| {
        let seen = case.run();
        (case.gain(&seen), !seen.is_bounded(), seen.energy / seen.spent)
    });
    let mut census = Census { least: f32::INFINITY, given: f32::NEG_INFINITY, ..Census::default() };
    for (gain, shakes, given) in results {
        let class = if gain <= REGION {
            census.given = census.given.max(given);
            &mut census.inside
        } else if gain < BEYOND {
            &mut census.between
        } else {
            &mut census.beyond
        };
        *class = (class.0 + 1, class.1 + u32::from(shakes));
        census.least = if shakes { census.least.min(gain) } else { census.least };
    }
    census
}

/// The document.
pub fn document(map: &Map) -> String {
    let mut out = String::new();
    out.push_str(HEAD);
    let _ = writeln!(
        out,
        "- **quiet**: in the second half of the hold the handle's speed above 20 Hz is below {} mm/s (spin counted at 20 mm);\n\
         - **toggles**: louder, but within {TOGGLE} encoder steps from end to end: the encoder's own buzz on a stiff contact, which cannot grow;\n\
         - **shakes**: a limit cycle that grows until the device's force limit stops it.\n",
        1e3 * QUIET
    );
    region(&mut out);
    out.push_str(LIMITS);
    machines(&mut out);
    out.push_str(TABLES);
    for (machine, hands) in MACHINES.iter().zip(map) {
        for ((hand, _), panels) in HANDS.iter().zip(hands) {
            let _ = writeln!(out, "\n### {}, {hand} grip\n", machine.preset.name);
            table(&mut out, panels);
        }
    }
    out
}

const HEAD: &str = "# Stability of the closed loop

Written by `cargo run --release -p haptor-tests --bin stability -- -o tests/bench/STABILITY.md`; no figure depends on the machine it runs on.

![ticks of delay that a loop stands](stability.png)

One loop: the simulated hand and handle (`firmware-sim`, integrated at 8 kHz), the device's own encoder steps and force limits, the core (tier `bristle`, slew limits off), the
link's delay of n ticks beyond the tick itself, the wrench held from tick to tick. A ball of 20 mm radius is pressed on a half space with Poisson's ratio 0.5, to 0.6 of the device's force where
the hand is strong enough, twisted by 0.05 rad, held, and lifted, in a second. `damped` is with the passivity controller, told the delay and given the damping that the device can render.

";

const LIMITS: &str = "
What limits the region:

- **Delay times stiffness.** A spring of stiffness K that is late by (n + 1/2) T, n ticks of link and half a tick of holding, gives out K (n + 1/2) T times the square of the speed. Hand and handle
  take b times it. With a direct coupling K is the contact's: 2 E a/(1 - nu^2), 25 kN/m for rubber of 3 MPa at 6 N, so a firm grip of the arm (152 N s/m) stands one tick of delay at
  1 kHz inside the region and fingers on a stylus (7 N s/m) stand none at any rate up to 4 kHz. With a virtual coupling K is the coupling's, **whatever the object is made of**.
- **The device's own stiffness figure.** A virtual coupling at what the maker says the device closes (sigma.7 and omega.6: 4 and 5 kN/m) assumes a hand that damps: fingers alone stay inside the region
  only without delay at 1 kHz there. Set `translational_stiffness` to 0.3 b/((n + 1/2) T) for the lightest grip expected.
- **Encoder steps.** With a direct coupling a step of 30 um on 25 kN/m is 0.75 N: the handle toggles. The virtual coupling makes it 24 mN, and 0.12 N within a tick with the damper of a heavy probe.
- **The probe's mass.** The critical damper of a probe of 1 kg adds, within a tick, four times the coupling's stiffness (theory.md, 10.4); in the tables fingers feel it as toggling of coarse encoders. With a
  light probe (below 0.1 kg) there is less of it and with none at all nothing.
- **The passivity controller** acts after energy has come out, and what it adds is as late as the wrench. It gains a tick or two of delay for direct couplings on devices that render 30 N s/m, more above
  4 kHz, and next to nothing where 4 or 5 N s/m is all there is. With a virtual coupling it hardly acts within a second: what the coupling's damper took from the hand is a credit that a limit cycle has to
  use up first. It is a last line, no replacement for a softer coupling.

Not in the map: the device's flexible parts and its motors' own dynamics, jitter of the link, slew limits (which make a stiff loop worse when they act), several contacts.
";

const TABLES: &str = "
## Tables

Longest delay in ticks, of 0 to 8, up to which the hold is quiet; after a slash, up to which it is quiet or toggles; `-`: not even without delay.
";

fn region(out: &mut String) {
    let _ = writeln!(
        out,
        "## The stable region\n\n**K (n + 1/2) T <= {REGION} b**: stiffness closed by the loop, times its mean delay, at most {REGION} of the damping of hand and handle, in translation and in rotation. \
         K is the coupling's stiffness, or with a direct coupling the contact's. Inside it no loop of the map shakes:\n\n\
         | coupling | loops inside | of these shake | between | of these shake | at {BEYOND} or more | of these shake | least gain that shakes | most energy given, of what the hand's damping takes |\n|---|---|---|---|---|---|---|---|---|"
    );
    let mut row = |name: &str, cases: &[Case]| {
        let Census { inside, between, beyond, least, given } = census(cases);
        let least = if least.is_finite() { format!("{least:.2}") } else { "none".to_owned() };
        let _ = writeln!(
            out,
            "| {name} | {} | {} | {} | {} | {} | {} | {least} | {given:.2} |",
            inside.0, inside.1, between.0, between.1, beyond.0, beyond.1
        );
    };
    row("direct", &every(false, 1.0));
    for mass in MASSES {
        row(&format!("virtual, probe of {mass} kg"), &every(true, mass));
    }
}

fn machines(out: &mut String) {
    out.push_str(
        "\n## Devices and hands\n\nLimits, masses and encoders are `firmware-sim`'s presets; what the device closes and damps is as the CHAI3D library has it.\n\n\
         | device | force N | handle kg | handle N s/m | encoder um | coupling N/m, N m/rad | controller's damping at most N s/m, N m s/rad |\n|---|---|---|---|---|---|---|\n",
    );
    for machine in MACHINES {
        let p = machine.preset;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {}, {} | {}, {} |",
            p.name,
            p.max_force,
            p.mass,
            p.damping,
            1e6 * p.encoder,
            machine.closes.0,
            machine.closes.1,
            machine.damps.0,
            machine.damps.1
        );
    }
    for (name, h) in HANDS {
        let _ = writeln!(
            out,
            "\nHand, {name} grip: {} kg, {} N/m, {} N s/m; {:e} kg m^2, {} N m/rad, {} N m s/rad.",
            h.mass, h.stiffness, h.damping, h.inertia, h.spin_stiffness, h.spin_damping
        );
    }
}

fn table(out: &mut String, panels: &[Panel]) {
    let moduli = MODULI.map(|e| format!("{e:.0e}")).join(" | ");
    let _ = writeln!(out, "| coupling | rate Hz | {moduli} |\n|---|---|{}", "---|".repeat(MODULI.len()));
    for (variant, panel) in VARIANTS.iter().zip(panels) {
        for (rate, cells) in RATES.iter().zip(panel) {
            let cells = cells.map(text).join(" | ");
            let _ = writeln!(out, "| {} | {rate} | {cells} |", variant.name);
        }
    }
}
