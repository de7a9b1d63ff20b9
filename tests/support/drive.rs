//! Drives the core along paths in a few words: a test is then data plus expectation.

use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Output, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Quat, Scratch, State, Vec3,
    Wrench, step,
};

/// Rubber of the paper's Table I: 3 MPa, incompressible, 1100 kg/m^3.
pub const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// The cube of the shared tables: 0.1 m edges.
pub const CUBE: ObjectShape = ObjectShape::Box { size: Vec3::splat(0.1) };

/// The session state every test uses: room for every part and the finest samples.
pub type FullState = State<16, 256>;

/// A scene that is being felt.
pub struct Drive {
    model: Model<'static>,
    params: Params,
    state: Box<FullState>,
    scratch: Scratch<16>,
    /// Position of the probe in world \[m\].
    pub position: Vec3,
    /// Rotation of the probe.
    pub rotation: Quat,
    /// What the last tick returned.
    pub output: Option<Output>,
}

impl Drive {
    /// A scene; the parts live as long as the test process.
    pub fn new(object: ObjectShape, material: Material, probe: &[ProbePart], params: &ParamsSpec) -> Self {
        let parts: &'static [ProbePart] = Box::leak(probe.to_vec().into_boxed_slice());
        Self::from_spec(&ModelSpec::new(object, material, parts), params)
    }

    /// A scene from a whole model spec.
    pub fn from_spec(spec: &ModelSpec<'static>, params: &ParamsSpec) -> Self {
        Self {
            model: Model::new(spec).expect("valid model"),
            params: Params::new(params).expect("valid parameters"),
            state: Box::new(FullState::new()),
            scratch: Scratch::new(),
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            output: None,
        }
    }

    /// A ball of `radius` on an object of rubber with Poisson's ratio `nu`.
    pub fn ball(object: ObjectShape, radius: f32, nu: f32, params: &ParamsSpec) -> Self {
        let material = Material { poisson_ratio: nu, ..RUBBER };
        let mut drive = Self::new(object, material, &[ProbePart::at_origin(ProbeShape::Sphere { radius })], params);
        drive.position = Vec3::Z * (object.height() + radius);
        drive
    }

    /// One tick at a pose.
    pub fn tick(&mut self, position: Vec3, rotation: Quat) -> Output {
        (self.position, self.rotation) = (position, rotation);
        let input = Input { pose: Pose::new(position, rotation), dt: 1.0e-3 };
        let output = step(&self.model, &self.params, &mut self.state, &mut self.scratch, input);
        self.output = Some(output);
        output
    }

    /// Moves by `by` \[m\] in `ticks` equal steps.
    pub fn shift(&mut self, by: Vec3, ticks: usize) -> Wrench {
        let start = self.position;
        (1..=ticks).for_each(|i| drop(self.tick(start + by * (i as f32 / ticks as f32), self.rotation)));
        self.wrench()
    }

    /// Turns by `angle` \[rad\] about the world axis `axis` through the mass centre, in `ticks` equal steps.
    pub fn turn(&mut self, axis: Vec3, angle: f32, ticks: usize) -> Wrench {
        let start = self.rotation;
        for i in 1..=ticks {
            let turned = Quat::from_axis_angle(axis, angle * i as f32 / ticks as f32) * start;
            self.tick(self.position, turned.normalize());
        }
        self.wrench()
    }

    /// Contact wrench of the last tick.
    pub fn wrench(&self) -> Wrench {
        self.output.expect("at least one tick").contact
    }

    /// Report of the last tick.
    pub fn report(&self) -> haptor_contact::Report {
        self.output.expect("at least one tick").report
    }

    /// The state, to look inside.
    pub fn state(&self) -> &FullState {
        &self.state
    }
}
