//! The core over a trajectory: offline, deterministic, no device.

use haptor_contact::green::Green;
use haptor_contact::surface::Surface;
use haptor_contact::{
    Input, Invalid, MAX_BRISTLES, MAX_PARTS, Model, ModelSpec, Output, Params, ParamsSpec, Patch, PatchReport, Pose, ProbeFrame,
    Scratch, State, World, patch_report, step,
};
use haptor_mesh::Mesh;

use crate::scene::Scene;
use crate::table::Table;
use crate::trajectory::Row;

/// A scene whose ticks are run one by one.
pub struct Simulation<'a> {
    model: Model<'a>,
    params: Params,
    state: Box<State<MAX_PARTS, MAX_BRISTLES, MAX_BRISTLES>>,
    scratch: Box<Scratch<MAX_PARTS>>,
    skin: Option<&'a Mesh>,
}

impl<'a> Simulation<'a> {
    /// A scene at rest, with `params` in place of its own.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(scene: &'a Scene, params: &ParamsSpec) -> Result<Self, Invalid> {
        Self::with_table(scene, params, None)
    }

    /// The same with the body's own table, which tier `green` reads.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn with_table(scene: &'a Scene, params: &ParamsSpec, table: Option<&'a Table>) -> Result<Self, Invalid> {
        let green = table.map(|table| Green::new(&table.spec())).transpose()?;
        Ok(Self {
            model: Model::new(&ModelSpec { green, ..scene.model_spec() })?,
            params: Params::new(params)?,
            state: Box::new(State::new()),
            scratch: Box::new(Scratch::new()),
            skin: scene.object.skin.as_ref().map(|skin| &skin.mesh),
        })
    }

    /// One tick.
    pub fn tick(&mut self, row: &Row) -> Output {
        let input = Input { pose: Pose::new(row.position, row.rotation), dt: row.dt };
        step(&self.model, &self.params, &mut self.state, &mut self.scratch, input)
    }

    /// The deformed surface after the last tick, whose pose was `row`; `body` as in [`Surface`].
    pub fn surface(&self, row: &Row, body: bool) -> Surface<'_> {
        Surface { model: &self.model, params: &self.params, patches: self.state.patches(), p_wp: self.probe(row).position, body }
    }

    /// The object's mesh, when it has one.
    pub fn skin(&self) -> Option<&'a Mesh> {
        self.skin
    }

    /// Pose `x_wp` of the probe after the last tick: where the coupling has brought it. Before one was accepted, the handle of `row`.
    pub fn probe(&self, row: &Row) -> Pose<World, ProbeFrame> {
        self.state.probe_pose().unwrap_or(Pose::new(row.position, row.rotation))
    }

    /// The contacts themselves after the last tick, oldest first.
    pub fn contacts(&self) -> &[Patch] {
        self.state.patches()
    }

    /// The patches in contact after the last tick, oldest first.
    pub fn patches(&self) -> impl Iterator<Item = PatchReport> {
        self.state.patches().iter().map(patch_report)
    }
}
