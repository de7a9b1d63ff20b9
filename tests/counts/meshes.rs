//! Balls given by a grid and samples: what a mesh costs, without the tool that bakes one.

use haptor_contact::{DistanceGrid, MeshShape, MeshSpec, SurfaceSample, Vec3};

/// Nodes along an axis of the grid.
const NODES: usize = 24;

/// Layers between the ball and the grid's border: one more than a grid must have.
const LAYERS: f32 = 4.0;

/// A ball of `radius` \[m\] with so many samples, whose centre is `up` \[m\] above its own origin. Its memory is the program's until it ends.
pub fn ball(radius: f32, up: f32, count: usize) -> MeshShape<'static> {
    let spacing = 2.0 * radius / (NODES as f32 - 1.0 - 2.0 * LAYERS);
    let (centre, border) = (Vec3::Z * up, radius + LAYERS * spacing);
    let origin = centre - Vec3::splat(border);
    let node =
        |i: usize| origin + spacing * Vec3::new((i % NODES) as f32, (i / NODES % NODES) as f32, (i / NODES / NODES) as f32);
    let distances: Vec<f32> = (0..NODES * NODES * NODES).map(|i| (node(i) - centre).length() - radius).collect();
    let samples: Vec<SurfaceSample> = (0..count).map(|i| sample(i, count, centre, radius)).collect();
    let extent = Vec3::splat(radius);
    let spec = MeshSpec {
        grid: DistanceGrid::new(origin, spacing, [NODES; 3], distances.leak()).expect("a ball inside its grid"),
        samples: samples.leak(),
        low: centre - extent,
        high: centre + extent,
        volume: 4.0 / 3.0 * std::f32::consts::PI * radius.powi(3),
        reach: radius + up,
    };
    MeshShape::new(&spec).expect("a ball with samples")
}

/// A sample of a ball; the bits of its number turned round spread any first ones over the whole.
fn sample(index: usize, count: usize, centre: Vec3, radius: f32) -> SurfaceSample {
    let share = (index as u32).reverse_bits() as f32 / 2.0_f32.powi(32);
    let (z, angle) = (1.0 - 2.0 * share, 2.399_963 * index as f32);
    let flat = (1.0 - z * z).max(0.0).sqrt();
    let normal = Vec3::new(flat * angle.cos(), flat * angle.sin(), z);
    let area = 4.0 * std::f32::consts::PI * radius * radius / count as f32;
    SurfaceSample { position: centre + normal * radius, normal, area }
}
