//! A baked scene, checked: everything an engine is told once, but for the bodies.

use haptor_contact as contact;
use haptor_contact::{Invalid, Model, ModelSpec, Params, ParamsSpec, Pose, Vec3, World};
use haptor_wire::{BakedScene, Tuning};

use crate::bodies::Bodies;
use crate::error::SceneError;
use crate::frames::DeviceBase;
use crate::settings::params_spec;
use crate::tuned::stands;

/// A checked scene without its bodies.
#[derive(Clone, Debug)]
pub struct Setup {
    baked: BakedScene,
    /// Parameters on a device of the core's defaults.
    pub(crate) params: ParamsSpec,
    /// Where the device stands.
    pub(crate) x_wd: Pose<World, DeviceBase>,
}

impl Setup {
    /// Checks a baked scene.
    ///
    /// # Errors
    /// [`SceneError`] names the first key or value that does not pass.
    pub fn new(baked: &BakedScene) -> Result<Self, SceneError> {
        let params = params_spec(&baked.coupling, &Tuning::of(baked))?;
        Ok(Self { baked: *baked, params, x_wd: stands(&baked.place)? })
    }

    /// The scene as it was baked.
    #[must_use]
    pub const fn baked(&self) -> &BakedScene {
        &self.baked
    }

    /// The core's model and first parameters, on these bodies.
    pub(crate) fn core<'a>(&self, bodies: &'a Bodies<'a>) -> Result<(Model<'a>, Params), Invalid> {
        let baked = &self.baked;
        let material =
            contact::Material { young_modulus: baked.young_modulus, poisson_ratio: baked.poisson_ratio, density: baked.density };
        let compliance = baked.compliance.map(|c| contact::Compliance { normal: c.normal, drag: c.drag, twist: c.twist });
        let spec = ModelSpec {
            fixed_below: Some(baked.fixed_below),
            compliance,
            green: bodies.green,
            mass: baked.mass,
            inertia: baked
                .inertia
                .map(|i| contact::Inertia { moments: Vec3::from_array(i.moments), products: Vec3::from_array(i.products) }),
            paper_length: baked.paper_length,
            ..ModelSpec::new(bodies.object, material, &bodies.parts)
        };
        Ok((Model::new(&spec)?, Params::new(&self.params)?))
    }
}
