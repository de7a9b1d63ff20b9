//! What stays the same while a scene is active.

use haptor_mesh::Mesh;

/// A scene as something to look at.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// The scene, for the title.
    pub name: String,
    /// The elastic body in words.
    pub object_name: String,
    /// The rigid body in words.
    pub probe_name: String,
    /// The object at rest, in world; some 10,000 vertices show a dent well.
    pub object: Mesh,
    /// The object is its own ground: none is drawn below it.
    pub is_ground: bool,
    /// Parts of the probe, in the probe's frame `p`.
    pub probe: Vec<Mesh>,
    /// Length of a tick \[s\].
    pub period: f64,
    /// What a step may take at most \[us\].
    pub step_budget_us: f64,
    /// Largest force to be expected \[N\]: drawn at the full length of an arrow. 0 = by the largest seen.
    pub force_scale: f64,
    /// Largest torque to be expected \[N m\], likewise.
    pub torque_scale: f64,
}
