//! A scene with the meshes and tables that its file carries, and engines that own what they run on.

use std::sync::Arc;

use haptor_contact::{Invalid, Pose};
use haptor_wire::{BakedScene, DeviceHello, Tuning, scene_file};
use self_cell::self_cell;

use crate::bodies::Bodies;
use crate::data::Data;
use crate::engine::{Engine, Felt};
use crate::error::SceneError;
use crate::frames::{DeviceBase, Handle};
use crate::setup::Setup;
use crate::tuned::{Placed, Tuned};
use crate::work::Limit;

/// A checked scene with all its data. Clones share the data.
#[derive(Clone, Debug)]
pub struct Scene {
    setup: Setup,
    data: Arc<Data>,
}

impl Scene {
    /// Reads and checks the file of a baked scene, with what it carries behind the scene.
    ///
    /// # Errors
    /// [`SceneError`] names the first thing that does not pass.
    pub fn read(file: &[u8]) -> Result<Self, SceneError> {
        let baked = scene_file::decode_file(file)?;
        Self::with_data(&baked, Data::read(file)?)
    }

    /// Checks a baked scene that carries no data by making the core's model and parameters from it.
    ///
    /// # Errors
    /// [`SceneError`] names the first key or value that does not pass.
    pub fn new(baked: &BakedScene) -> Result<Self, SceneError> {
        Self::with_data(baked, Data::default())
    }

    fn with_data(baked: &BakedScene, data: Data) -> Result<Self, SceneError> {
        let data = Arc::new(data);
        let bodies = Bodies::new(baked, &data.as_ref(), data.green()?)?;
        let setup = Setup::new(baked)?;
        setup.core(&bodies)?;
        drop(bodies);
        Ok(Self { setup, data })
    }

    /// The scene without its data.
    #[must_use]
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The scene's bodies, borrowing its meshes and table.
    ///
    /// # Errors
    /// [`SceneError`], which [`Self::new`] has ruled out.
    pub fn bodies(&self) -> Result<Bodies<'_>, SceneError> {
        Bodies::new(self.setup.baked(), &self.data.as_ref(), self.data.green()?)
    }

    /// Checks a tuning for engines of this scene.
    ///
    /// # Errors
    /// [`SceneError`] names the first value that does not pass.
    pub fn tuned(&self, tuning: &Tuning) -> Result<Tuned, SceneError> {
        Tuned::new(&self.setup, self.data.table.is_some(), tuning)
    }

    /// An engine at rest that keeps this scene's data alive.
    ///
    /// # Errors
    /// [`SceneError`], which [`Self::new`] has ruled out.
    pub fn engine(&self) -> Result<OwnedEngine, SceneError> {
        let loaded = Loaded::try_new(self.clone(), Self::bodies)?;
        Ok(OwnedEngine(Running::try_new(loaded, |loaded| Engine::new(&loaded.borrow_owner().setup, loaded.borrow_dependent()))?))
    }
}

self_cell! {
    struct Loaded {
        owner: Scene,
        #[covariant]
        dependent: Bodies,
    }

    impl { Debug }
}

self_cell! {
    struct Running {
        owner: Loaded,
        #[covariant]
        dependent: Engine,
    }

    impl { Debug }
}

/// An engine and the scene it runs on, in one piece of memory: it goes from thread to thread as a pointer.
#[derive(Debug)]
pub struct OwnedEngine(Running);

impl OwnedEngine {
    /// The engine.
    #[must_use]
    pub fn get(&self) -> &Engine<'_> {
        self.0.borrow_dependent()
    }

    /// Does something with the engine.
    pub fn with<T>(&mut self, act: impl FnOnce(&mut Engine<'_>) -> T) -> T {
        self.0.with_dependent_mut(|_, engine| act(engine))
    }

    /// See [`Engine::fit`].
    ///
    /// # Errors
    /// As [`Engine::fit`].
    pub fn fit(&mut self, device: &DeviceHello) -> Result<(), Invalid> {
        self.0.with_dependent_mut(|_, engine| engine.fit(device))
    }

    /// See [`Engine::tune`].
    pub fn tune(&mut self, tuned: &Tuned) {
        self.0.with_dependent_mut(|_, engine| engine.tune(tuned));
    }

    /// See [`Engine::limit`].
    pub fn limit(&mut self, limit: Limit) {
        self.0.with_dependent_mut(|_, engine| engine.limit(limit));
    }

    /// See [`Engine::place`].
    pub fn place(&mut self, placed: &Placed) {
        self.0.with_dependent_mut(|_, engine| engine.place(placed));
    }

    /// See [`Engine::rest`].
    pub fn rest(&mut self) {
        self.0.with_dependent_mut(|_, engine| engine.rest());
    }

    /// See [`Engine::step`].
    pub fn step(&mut self, x_dh: &Pose<DeviceBase, Handle>, dt: f32) -> Felt {
        self.0.with_dependent_mut(|_, engine| engine.step(x_dh, dt))
    }
}
