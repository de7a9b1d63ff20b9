//! What the tables say in words, each sentence from the lines.

use std::fmt::Write;

use crate::lines::Lines;
use crate::speed::{self, short};
use crate::{DEFAULT, OURS, accuracy};

/// Title, machine, versions.
pub fn head(lines: &Lines) -> String {
    let run = &lines.run;
    let mut text = format!(
        "# Beside other programs\n\nWritten by `cargo xtask peers` from [peers/results.jsonl](peers/results.jsonl); `cargo test -p haptor-peers` fails when the two differ. Rounds: {}, in each every \
         program for {} s a case, one thread; {}; {}; load of the machine {:.1} at the start, {:.1} at the end. On a machine with other work ratios within a round hold, absolute times do not: a median is the \
         middle one of the rounds', a maximum that of all rounds; n is the number of calls of all rounds.\n\n![Torque against twist](peers.png)\n\n| program | version |\n|---|---|\n",
        run.rounds, run.seconds, run.machine, run.date, run.load[0], run.load[1]
    );
    for (peer, version) in lines.versions() {
        let _ = writeln!(text, "| {peer} | {version} |");
    }
    text
}

/// Where another program is better than the default of ours.
pub fn better(lines: &Lines) -> String {
    let mut text = BETTER.to_owned();
    let times = speed::cases(lines, "ball-on-cube");
    let time = |peer: &str, case: &str| times.iter().find(|c| (c.peer, c.case) == (peer, case)).map(|c| c.ratio);
    let errors = accuracy::all(lines);
    let own = errors.iter().find(|(peer, case, _)| (*peer, *case) == (OURS, DEFAULT));
    for (what, of) in MEASURES {
        for own in own.iter().flat_map(|(.., errors)| errors) {
            let _ = writeln!(text, "- {what} at {} mm: haptor {:.1} %.", own.depth_mm, of(own));
            let others = errors.iter().filter(|(peer, ..)| *peer != OURS);
            let same = others.flat_map(|(peer, case, all)| all.iter().map(move |errors| (*peer, *case, errors)));
            for (peer, case, errors) in same.filter(|(.., errors)| errors.depth_mm == own.depth_mm && of(errors) < of(own)) {
                let cost = time(peer, case).map_or(String::new(), |ratio| format!(", at {} times the CPU time", short(ratio)));
                let _ = writeln!(text, "  - {peer}, {case}: {:.1} %{cost}.", of(errors));
            }
        }
    }
    text += &dragged(lines);
    for scene in ["ball-on-cube", "box-k10", "ellipsoid-k10"] {
        let faster: Vec<_> =
            speed::cases(lines, scene).into_iter().filter(|case| case.peer != OURS && case.ratio < 1.0).collect();
        let _ = writeln!(text, "- CPU time, {scene}: {}", if faster.is_empty() { "none is faster." } else { "faster are" });
        for case in faster {
            let _ = writeln!(text, "  - {}, {}: {} times ours.", case.peer, case.case, short(case.ratio));
        }
    }
    text
}

/// Programs that are nearer to the truth in the drag with twist.
fn dragged(lines: &Lines) -> String {
    let rows = accuracy::drags(lines);
    let off = |shares: [f64; 2]| {
        let [force, torque] = lines.run.sliding;
        100.0 * (shares[0] - force).abs().max((shares[1] - torque).abs())
    };
    let own = rows.iter().find(|(peer, case, _)| (*peer, *case) == (OURS, DEFAULT)).map_or(f64::NAN, |(.., shares)| off(*shares));
    let mut text = format!("- Twist while dragging, larger error of the two shares: haptor {own:.1} %.\n");
    for (peer, case, shares) in rows.into_iter().filter(|(peer, _, shares)| *peer != OURS && off(*shares) < own) {
        let _ = writeln!(text, "  - {peer}, {case}: {:.1} %.", off(shares));
    }
    text
}

const BETTER: &str = "\
## Where another program is better than `bristle 64`

What is not listed is not better. A force that was fitted at 3 mm is right at 3 mm. Programs of contact search do a part of the work only.

";

/// What is compared, and how large it is at a depth.
type Measure = (&'static str, fn(&accuracy::Errors) -> f64);

const MEASURES: [Measure; 3] = [
    ("Normal force", |errors| errors.force.abs()),
    ("Stick stiffness", |errors| errors.stick.abs()),
    ("Torque against twist", |errors| errors.curve),
];

/// What each cannot do.
pub fn cannot(lines: &Lines) -> String {
    let mut text = "## What each cannot do\n\n| program | cannot | seen by |\n|---|---|---|\n".to_owned();
    for limit in &lines.limits {
        let _ = writeln!(text, "| {} | {} | {} |", limit.peer, limit.cannot, limit.reason.replace('|', "/"));
    }
    text
}

/// How it was measured.
pub fn how(_: &Lines) -> String {
    HOW.to_owned()
}

const HOW: &str = "\
## How

- Scenes and motion are those of `haptor bench`: `ball-on-cube` (depth 2.5 to 3.5 mm, shift 1 mm, twist half a radian, a round of 1024 ticks of 1 ms) and `box-k1` to `ellipsoid-k10` (balls of
  10 mm on a ring of 50 mm, on a box of 0.2 x 0.2 x 0.1 m and an ellipsoid of semi-axes 120, 100, 80 mm). Every call is timed by itself on both clocks, what reading them takes is taken off.
- Programs in Python: only the library's call is timed, with what hands the pose over; the binding costs 0.3 to 2 us.
- haptor is timed on shapes; coal and parry search meshes of these shapes, of about as many triangles as the case says. They do no physics: compare them with `no friction`, which presses as well.
- haptor's physics is `haptor eval` on tests/scenes/cube-twist.toml, nu = 0.5. MuJoCo's rigid contact has no modulus and no area: its stiffness and its torsional friction are fitted to the truth at 3 mm; its flex takes
  E and nu = 0.45. Drake's hydroelastic modulus is E. The condensed finite elements have nu = 0.45, because 0.5 divides by zero there.
- Rigid MuJoCo and Drake have no Poisson's ratio: compared with the truth for 0.5.
- The condensed finite elements are this project's own, written as the strongest baseline: a compliance matrix of the surface patch made beforehand, projected Gauss-Seidel with 4 sweeps a tick, all of
  it compiled. Its *whole shape* is a solve with SuperLU's factor, which a supernodal Cholesky factor would beat several times over.
- haptor computes in f32, the others in f64. Neither SOFA nor CHAI3D is a package of pip or cargo: not compared.
- Truth: finite elements with Coulomb friction, tests/truth/B5_twist_cube.json. haptor's constants of a cube were fitted to tables of the same source, so its errors are in sample.
- Again: `cargo xtask peers` (a Python virtual environment in the target folder, some 400 MB of packages, pinned in peers/requirements.txt).
";
