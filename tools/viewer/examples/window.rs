//! The window on a scripted session: a press, a twist with its slip ring, two legs, ten regions. Nothing here is computed by the core; the
//! moments are drawn by hand to show every sign of the window.
//!
//! ```text
//! cargo run --release -p haptor-viewer --features window --example window -- twist
//! cargo run --release -p haptor-viewer --features window --example window -- twist twist.png 2.1 cz
//! ```
//!
//! The second draws the window without a display: at 2.1 s, after the keys C and Z.

use std::sync::Arc;
use std::time::Duration;

use glam::{DQuat, DVec3, Vec3};
use haptor_mesh::{Mesh, tessellate};
use haptor_viewer::feed::{Displacement, Fault, Frame, Mode, Pose, Region, Script, Stage, Timing, Wrench};
use haptor_viewer::window::{Action, BINDINGS, Moment, Options, open, window_shot};

/// Edge of the object \[m\].
const EDGE: f64 = 0.1;

/// Length of a tick \[s\]: a hundredth part of what a host does, so that a script stays short.
const PERIOD: f64 = 0.01;

/// Vertices along an edge of the object: 10,088 in all.
const STEPS: u32 = 41;

/// Stiffness of a leg \[N/m^1.5\].
const STIFFNESS: f64 = 1.0e6;

/// Friction coefficient.
const FRICTION: f64 = 0.75;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().cloned().unwrap_or_else(|| "twist".to_owned());
    let legs: Vec<DVec3> = match name.as_str() {
        "press" | "twist" | "replay" | "fault" => vec![DVec3::ZERO],
        "legs" => vec![DVec3::new(-0.025, 0.0, 0.0), DVec3::new(0.025, 0.0, 0.0)],
        "ten" => (0..10).map(|k| DVec3::new(f64::from(k % 5 - 2) * 0.016, f64::from(k / 5 * 2 - 1) * 0.016, 0.0)).collect(),
        other => return Err(format!("no script {other:?}: press, twist, legs, ten, replay or fault").into()),
    };
    let stage = stage(&name, &legs);
    let frames = (0..600).map(|k| frame(&stage, &name, &legs, k)).collect();
    let script = if name == "replay" { Script::recording(stage, frames) } else { Script::session(stage, frames) };
    match &arguments[..] {
        [] | [_] => open(Box::new(script), &Options::default())?,
        [_, file, rest @ ..] => {
            let at = rest.first().map_or(Ok(1.0), |at| at.parse())?;
            let keys = rest.get(1).map_or("", String::as_str);
            std::fs::write(file, picture(script, at, keys)?)?;
        }
    }
    Ok(())
}

/// The window at a time \[s\] after some keys, as a PNG.
fn picture(script: Script, at: f64, keys: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let action = |key: char| {
        let found = BINDINGS.iter().find(|binding| binding.action.key().eq_ignore_ascii_case(&key.to_string()));
        found.map(|binding| binding.action).ok_or_else(|| format!("no key {key:?}"))
    };
    let actions: Vec<Action> = keys.chars().map(action).collect::<Result<_, _>>()?;
    let begin = Moment { at: Duration::ZERO, actions: Vec::new() };
    let moments = [begin, Moment { at: Duration::from_secs_f64(at), actions }];
    Ok(window_shot(Box::new(script), &moments, [1280, 720])?.png()?)
}

/// Radius of a tip \[m\].
fn tip(legs: &[DVec3]) -> f64 {
    if legs.len() == 1 { 0.02 } else { 0.006 }
}

fn stage(name: &str, legs: &[DVec3]) -> Stage {
    let radius = tip(legs);
    let part = |&leg: &DVec3| match legs.len() {
        1 => tessellate::ellipsoid(DVec3::splat(radius), 96),
        _ => tessellate::capsule(radius, 0.03, 64).mapped(|v| v + leg + DVec3::Z * 0.015),
    };
    let mut probe: Vec<Mesh> = legs.iter().map(part).collect();
    if legs.len() > 1 {
        probe.push(tessellate::cuboid(DVec3::new(0.08, 0.05, 0.006)).mapped(|v| v + DVec3::Z * 0.036));
    }
    Stage {
        name: format!("{name} (scripted)"),
        object_name: "rubber cube".to_owned(),
        probe_name: "steel".to_owned(),
        object: cube(),
        is_ground: false,
        probe,
        period: PERIOD,
        step_budget_us: 300.0,
        force_scale: 0.0,
        torque_scale: 0.0,
    }
}

/// A cube standing on z = 0, each face a grid.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    let faces = [(0, 1, 2), (1, 2, 0), (2, 0, 1)];
    for ((u, v, w), side) in faces.into_iter().flat_map(|axes| [(axes, 0.0), (axes, 1.0)]) {
        let first = mesh.vertices.len() as u32;
        for (i, j) in (0..STEPS * STEPS).map(|k| (k % STEPS, k / STEPS)) {
            let mut corner = DVec3::ZERO;
            (corner[u], corner[v]) = (f64::from(i) / f64::from(STEPS - 1), f64::from(j) / f64::from(STEPS - 1));
            corner[w] = side;
            mesh.vertices.push((corner - DVec3::new(0.5, 0.5, 0.0)) * EDGE);
        }
        for (i, j) in (0..(STEPS - 1) * (STEPS - 1)).map(|k| (k % (STEPS - 1), k / (STEPS - 1))) {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| first + j * STEPS + i);
            let quad = if side > 0.5 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            mesh.triangles.extend(quad);
        }
    }
    mesh
}

/// How deep \[m\] and how far turned \[rad\] the probe is at a share of the script.
fn motion(name: &str, share: f64) -> (f64, f64) {
    let depth = 1.4e-3 * (share / 0.2).min((1.0 - share) / 0.15).clamp(-0.3, 1.0);
    let turn = if name == "press" { 0.0 } else { 0.25 * (std::f64::consts::TAU * (share - 0.2) / 0.6).sin() };
    (depth, if (0.2..0.8).contains(&share) { turn } else { 0.0 })
}

fn frame(stage: &Stage, name: &str, legs: &[DVec3], tick: u32) -> Frame {
    let (depth, turn) = motion(name, f64::from(tick) / 600.0);
    let radius = tip(legs);
    let rotation = DQuat::from_rotation_z(turn);
    let position = DVec3::new(0.0, 0.0, EDGE - depth + radius);
    let regions: Vec<Region> =
        legs.iter().enumerate().filter_map(|(k, &leg)| region(radius, depth, turn, rotation * leg, k)).collect();
    let arm = |region: &Region| (region.centre - position).cross(region.force) + region.torque;
    let late = name == "fault" && tick > 300;
    Frame {
        tick: tick.into(),
        time: f64::from(tick) * PERIOD,
        probe: Pose { position, rotation },
        contact: Wrench { force: regions.iter().map(|r| r.force).sum(), torque: regions.iter().map(arm).sum() },
        sent: None,
        displacement: Some(Displacement { tick: tick.into(), moved: displaced(&stage.object, &regions) }),
        depth: if regions.is_empty() { 0.0 } else { depth },
        tier: "bristle".to_owned(),
        flags: if late { vec!["late".to_owned(), "closed".to_owned()] } else { Vec::new() },
        timing: Some(Timing {
            step_us: 18.0 + 9.0 * regions.len() as f64 + f64::from(tick * 7919 % 13),
            wake_us: 4.0 + f64::from(tick * 104_729 % 7),
            in_time: if late { 0.87 } else { 0.9998 },
        }),
        fault: late.then(|| Fault {
            what: "too many ticks late".to_owned(),
            advice: "The output is closed. Run `haptor doctor`, lower the rate or the samples, then re-arm (A).".to_owned(),
        }),
        regions,
        mode: Mode::Running,
        recording: false,
    }
}

/// A leg's region: Hertz' radius and force, a core that shrinks as the leg turns.
fn region(tip: f64, depth: f64, turn: f64, leg: DVec3, number: usize) -> Option<Region> {
    let depth = depth - 2.0e-5 * number as f64;
    if depth <= 0.0 {
        return None;
    }
    let radius = (tip * depth).sqrt();
    let normal = STIFFNESS * tip.sqrt() * depth.powf(1.5);
    let moved = turn.abs() * (leg.length() + 0.4 * radius) / (0.4 * depth);
    let stuck = (1.0 - 0.35 * moved).clamp(0.0, 1.0);
    let drag = leg.cross(DVec3::Z).normalize_or_zero() * turn.signum() * FRICTION * normal * moved.min(1.0);
    Some(Region {
        centre: leg.with_z(EDGE - 0.4 * depth),
        normal: DVec3::Z,
        radius,
        stick_radius: Region::core(radius, stuck),
        force: DVec3::Z * normal + drag,
        torque: -DVec3::Z * turn.signum() * 0.59 * FRICTION * normal * radius * moved.min(1.0),
        pressure: None,
    })
}

/// A dent under each region that fades out with the distance, and drag along.
fn displaced(object: &Mesh, regions: &[Region]) -> Arc<[Vec3]> {
    let moved = |vertex: &DVec3| {
        let dents = regions.iter().map(|region| {
            let share = (vertex.distance(region.centre.with_z(EDGE)) / region.radius).max(1.0e-9);
            let fade = if share < 1.0 { 1.0 - 0.5 * share * share } else { 0.5 / share };
            let depth = region.radius * region.radius / if regions.len() == 1 { 0.02 } else { 0.006 };
            (-DVec3::Z * depth - region.force.with_z(0.0) * 1.0e-5) * fade * (vertex.z / EDGE)
        });
        dents.sum::<DVec3>().as_vec3()
    };
    object.vertices.iter().map(moved).collect()
}
