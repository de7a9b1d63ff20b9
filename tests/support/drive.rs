//! Drives the core along paths in a few words: a test is then data plus expectation.

use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Output, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Quat, Scratch,
    State, Vec3, Wrench, step,
};

/// Rubber of the paper's Table I: 3 MPa, incompressible, 1100 kg/m^3.
pub const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// The cube of the shared tables: 0.1 m edges.
pub const CUBE: ObjectShape<'static> = ObjectShape::Box { size: Vec3::splat(0.1) };

/// The session state every test uses: room for every part and the finest samples.
pub type FullState = State<16, 256, 256>;

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
    pub fn new(object: ObjectShape<'static>, material: Material, probe: &[ProbePart<'static>], params: &ParamsSpec) -> Self {
        let parts: &'static [ProbePart<'static>] = Box::leak(probe.to_vec().into_boxed_slice());
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
    pub fn ball(object: ObjectShape<'static>, radius: f32, nu: f32, params: &ParamsSpec) -> Self {
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
        for i in 1..=ticks {
            self.tick(start + by * (i as f32 / ticks as f32), self.rotation);
        }
        self.contact()
    }

    /// Turns by `angle` \[rad\] about the world axis `axis` through the mass centre, in `ticks` equal steps.
    pub fn turn(&mut self, axis: Vec3, angle: f32, ticks: usize) -> Wrench {
        let start = self.rotation;
        for i in 1..=ticks {
            let turned = Quat::from_axis_angle(axis, angle * i as f32 / ticks as f32) * start;
            self.tick(self.position, turned.normalize());
        }
        self.contact()
    }

    /// Contact wrench of the last tick.
    pub fn contact(&self) -> Wrench {
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

    /// Puts the probe at height `z` above where it touches, without turning it, in one tick; negative presses.
    ///
    /// `touch` is the height of the probe's origin at which the gap is zero \[m\].
    pub fn press_to(&mut self, touch: f32, depth: f32) -> Wrench {
        let at = Vec3::new(self.position.x, self.position.y, touch - depth);
        self.tick(at, self.rotation).contact
    }

    /// The model, to read its shapes.
    pub fn model(&self) -> &Model<'static> {
        &self.model
    }

    /// Normal load of all patches \[N\].
    pub fn load(&self) -> f64 {
        self.state.patches().iter().map(|patch| f64::from(patch.footprint.load)).sum()
    }

    /// Contact radius of the deepest patch \[m\].
    pub fn radius(&self) -> f64 {
        f64::from(self.report().radius)
    }

    /// What the object holds against on its level top: drag force along x and y \[N\], torque about z through the mass centre \[N m\].
    /// The probe feels the opposite.
    pub fn held(&self) -> [f64; 3] {
        let wrench = self.contact();
        [-f64::from(wrench.force.x), -f64::from(wrench.force.y), -f64::from(wrench.torque.z)]
    }
}
