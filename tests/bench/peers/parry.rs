//! parry's contact search, timed: balls against a mesh, all contact manifolds, along a motion.
//!
//! Scenes come as JSON, one a line, on standard input; `parry_peer.py` writes them, so that scenes and motion are said once, for all programs. For each a line goes to
//! standard output, with the fields of `haptor bench --json`. The clocks are `haptor bench`'s.
#![forbid(unsafe_code)]

#[path = "../../../tools/haptor/src/bench/clock.rs"]
mod clock;
#[path = "../../../tools/haptor/src/bench/line.rs"]
mod line;

use std::error::Error;
use std::io::{self, BufRead};
use std::time::{Duration, Instant};

use clock::Clocks;
use line::Line;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::{Ball, TriMesh};
use serde::Deserialize;

/// Calls before any counts.
const WARM: usize = 100;

/// Fewest calls that count: a p99 needs as many.
const FEWEST: usize = 100;

/// A mesh, and where the balls are, tick by tick.
#[derive(Deserialize)]
struct Scene {
    peer: String,
    version: String,
    scene: String,
    case: String,
    seconds: f64,
    radius: f64,
    /// Corners of the mesh \[m\].
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Centre of each ball \[m\], for each tick.
    places: Vec<Vec<[f64; 3]>>,
}

/// What parry keeps of a pair from call to call.
#[derive(Default)]
struct Pair {
    manifolds: Vec<ContactManifold<(), ()>>,
    workspace: Option<ContactManifoldsWorkspace>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let clocks = Clocks::new();
    for text in io::stdin().lock().lines() {
        println!("{}", serde_json::to_string(&measure(&clocks, &serde_json::from_str(&text?)?)?)?);
    }
    Ok(())
}

fn measure(clocks: &Clocks, scene: &Scene) -> Result<Line, Box<dyn Error>> {
    let vertices = scene.vertices.iter().map(|&[x, y, z]| Vector::new(x, y, z)).collect();
    let mesh = TriMesh::new(vertices, scene.triangles.clone())?;
    let ball = Ball::new(scene.radius);
    let mut pairs: Vec<Pair> = scene.places.first().ok_or("a scene has ticks")?.iter().map(|_| Pair::default()).collect();
    let (mut spent, start) = (Vec::new(), Instant::now());
    for (call, places) in scene.places.iter().cycle().enumerate() {
        let (found, took) = clocks.time(|| find(&mesh, &ball, places, &mut pairs));
        if found? < places.len() {
            return Err(format!("{}: a ball does not touch at tick {call}", scene.scene).into());
        }
        if call >= WARM {
            spent.push(took);
        }
        if spent.len() >= FEWEST && start.elapsed() >= Duration::from_secs_f64(scene.seconds) {
            break;
        }
    }
    Ok(Line::new(&scene.peer, &scene.version, &scene.scene, &scene.case, &spent))
}

/// Contact points of all balls.
fn find(mesh: &TriMesh, ball: &Ball, places: &[[f64; 3]], pairs: &mut [Pair]) -> Result<usize, Box<dyn Error>> {
    let mut found = 0;
    for (&[x, y, z], pair) in places.iter().zip(pairs) {
        let pose = Pose::from_translation(Vector::new(x, y, z));
        DefaultQueryDispatcher.contact_manifolds(&pose, mesh, ball, 0.0, &mut pair.manifolds, &mut pair.workspace)?;
        found += pair.manifolds.iter().map(|manifold| manifold.points.len()).sum::<usize>();
    }
    Ok(found)
}
