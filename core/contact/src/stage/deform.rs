//! Stage 5: displacement of the object's surface.
//!
//! Two askers. Another region feels the dents of its neighbours ([`dent`], inside the tick; nothing with one region). Somebody looks at the
//! surface: the host calls [`deform`] after the tick, whole or in blocks; nobody looks, nobody calls, nothing is spent. The forms are those of
//! [`crate::surface`] (theory.md, sections 4 and 9).

use glam::Vec3;

use crate::budget;
use crate::frames::{Pose, ProbeFrame, World};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::state::State;
use crate::surface::local::paraboloid;
use crate::surface::{Surface, SurfaceState, Updated};

/// Displacement into the object \[m\] that `patch` makes at the surface point `p_wq`: the dent of a paraboloid with the same load
/// and radius. Inside the radius the surface follows the probe.
pub(crate) fn dent(model: &Model<'_>, patch: &Patch, p_wq: Vec3) -> f32 {
    let (a, load) = (patch.footprint.radius, patch.footprint.load);
    if a <= 0.0 || load <= 0.0 {
        return 0.0;
    }
    let offset = p_wq - patch.centre;
    let along = offset.dot(patch.normal);
    let r2 = offset.length_squared() - along * along;
    // 1/R of the paraboloid with this load and radius: a^3 / R = 3 P / (4 E*)
    let curvature = 0.75 * load / (model.material.contact_modulus() * a * a * a);
    paraboloid(curvature, a, r2)
}

/// What somebody wants to see of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// The object's vertices at rest \[m\], world.
    pub rest: &'a [Vec3],
    /// With the motion of the whole body; without it only the surroundings of the contacts move.
    pub body: bool,
    /// Most vertices to update in this call; their number or more updates the whole surface at once. Where the parameters set a work budget, no more
    /// than what the last tick left of it has room for, none if need be: a surface gives way before the grip does.
    pub vertices: usize,
}

/// Updates the vertices whose turn it is, to the state that the last tick with the probe at `x_wp` left. Work is bounded by `look.vertices` times
/// the patches, and by what the tick has left of its budget. Vertices beyond the capacity are counted and stay at rest.
pub fn deform<const PATCHES: usize, const SAMPLES: usize, const TRACES: usize, const VERTICES: usize>(
    model: &Model<'_>,
    params: &Params,
    state: &State<PATCHES, SAMPLES, TRACES>,
    x_wp: &Pose<World, ProbeFrame>,
    look: &Look<'_>,
    surface: &mut SurfaceState<VERTICES>,
) -> Updated {
    let now = Surface { model, params, patches: state.patches(), p_wp: x_wp.position, body: look.body };
    let left = budget::vertices_left(params, &state.memory, state.patches().len(), look.body);
    surface.update(&now, look.rest, look.vertices.min(left))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Input, Material, ModelSpec, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Quat, Scratch, step};

    #[test]
    fn a_surface_in_blocks_is_the_whole_one_after_a_round() {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let model = Model::new(&ModelSpec::new(cube, material, &ball)).unwrap();
        let params = Params::new(&ParamsSpec::default()).unwrap();
        let (mut state, mut scratch) = (State::<2, 64>::new(), Scratch::<2>::new());
        let pose = Pose::new(Vec3::new(0.01, 0.0, 0.118), Quat::IDENTITY);
        step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0e-3 });

        let rest: [Vec3; 150] = core::array::from_fn(|i| Vec3::new(5.0e-4 * i as f32, 0.01, 0.1 - 5.0e-4 * i as f32));
        let look = |vertices: usize| Look { rest: &rest, body: true, vertices };
        let (mut whole, mut parts, mut small) =
            (SurfaceState::<150>::new(), SurfaceState::<200>::new(), SurfaceState::<100>::new());
        let updated = deform(&model, &params, &state, &pose, &look(usize::MAX), &mut whole);
        assert_eq!(updated, Updated { first: 0, count: 150, round: true, left_out: 0 });
        for (first, count, round) in [(0, 64, false), (64, 64, false), (128, 22, true), (0, 64, false)] {
            let updated = deform(&model, &params, &state, &pose, &look(64), &mut parts);
            assert_eq!(updated, Updated { first, count, round, left_out: 0 });
        }
        assert_eq!(whole.moved(), &parts.moved()[..150]);
        assert_ne!(whole.moved()[0], Vec3::ZERO);
        let updated = deform(&model, &params, &state, &pose, &look(1_000), &mut small);
        assert_eq!(updated, Updated { first: 0, count: 100, round: true, left_out: 50 });
        assert_eq!(whole.moved()[..100], small.moved()[..]);
    }
}
