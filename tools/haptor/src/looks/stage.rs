//! A scene as a stage: bodies in triangles, the object finer where the probe will touch it.

use haptor_engine::{Scene, SceneError};
use haptor_viewer::feed::Stage;
use haptor_viewer::{DVec3, Mesh};
use haptor_wire::{BakedScene, ObjectShape, ProbeShape};

use crate::surface;

/// Vertices of the object at least: a dent of millimetres then looks round on a body of a decimetre.
const VERTICES: usize = 10_000;

/// Radius of the contact for which the triangles are made, as a share of the object's smallest extent.
const CONTACT: f64 = 0.05;

/// Share of the tick that a step may take before the plots show it over its budget: what is left is for the link.
const STEP_SHARE: f64 = 0.5;

/// The stage of a scene, called `name`, run at `rate_hz`; `skins` are the meshes that its file carries.
///
/// # Errors
/// [`SceneError`], which the making of the scene has ruled out.
pub fn stage(scene: &Scene, skins: &[Mesh], name: &str, rate_hz: u32) -> Result<Stage, SceneError> {
    let baked = scene.setup().baked();
    let period = 1.0 / f64::from(rate_hz.max(1));
    let bodies = haptor_viewer::stage(baked, skins);
    let object = surface::at_rest(&scene.bodies()?.object, object_skin(baked, skins), &touched(baked, &bodies), VERTICES);
    Ok(Stage {
        name: name.to_owned(),
        object_name: object_name(baked),
        probe_name: probe_name(baked),
        object,
        period,
        step_budget_us: STEP_SHARE * period * 1.0e6,
        ..bodies
    })
}

fn object_skin<'s>(baked: &BakedScene, skins: &'s [Mesh]) -> Option<&'s Mesh> {
    match baked.object {
        ObjectShape::Mesh { grid } => skins.get(usize::from(grid)).filter(|mesh| !mesh.triangles.is_empty()),
        _ => None,
    }
}

/// Where the probe's parts will touch the object, and how widely: straight below where a session starts.
fn touched(baked: &BakedScene, rest: &Stage) -> Vec<(DVec3, f64)> {
    let Some((low, high)) = rest.object.bounds() else { return Vec::new() };
    let start = DVec3::from_array(baked.place.p_wd.map(f64::from));
    let radius = CONTACT * (high - low).min_element();
    let lowest = |part: &Mesh| part.vertices.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z));
    rest.probe.iter().filter_map(lowest).map(|tip| DVec3 { z: high.z, ..start + tip }).map(|place| (place, radius)).collect()
}

fn object_name(baked: &BakedScene) -> String {
    let shape = match baked.object {
        ObjectShape::HalfSpace => "half space".to_owned(),
        ObjectShape::Box { size } => format!("box {} mm", millimetres(&size)),
        ObjectShape::Sphere { radius } => format!("sphere of {} mm", millimetres(&[radius])),
        ObjectShape::Ellipsoid { semi_axes } => format!("ellipsoid of {} mm", millimetres(&semi_axes)),
        ObjectShape::Cylinder { radius, height } => format!("cylinder of {} mm", millimetres(&[radius, height])),
        ObjectShape::Mesh { .. } => "mesh".to_owned(),
    };
    format!("{shape}, E {} MPa, nu {}", baked.young_modulus / 1.0e6, baked.poisson_ratio)
}

fn probe_name(baked: &BakedScene) -> String {
    match baked.probe.as_slice() {
        [part] => part_name(&part.shape),
        parts => format!("{} parts", parts.len()),
    }
}

fn part_name(shape: &ProbeShape) -> String {
    match *shape {
        ProbeShape::Sphere { radius } => format!("sphere of {} mm", millimetres(&[radius])),
        ProbeShape::Box { size } => format!("box {} mm", millimetres(&size)),
        ProbeShape::Cylinder { radius, height } => format!("cylinder of {} mm", millimetres(&[radius, height])),
        ProbeShape::Cone { radius, height } => format!("cone of {} mm", millimetres(&[radius, height])),
        ProbeShape::Capsule { radius, height } => format!("capsule of {} mm", millimetres(&[radius, height])),
        ProbeShape::Ellipsoid { semi_axes } => format!("ellipsoid of {} mm", millimetres(&semi_axes)),
        ProbeShape::Mesh { .. } => "mesh".to_owned(),
    }
}

/// Lengths \[m\] in millimetres, to a hundredth.
fn millimetres(lengths: &[f32]) -> String {
    let each = lengths.iter().map(|&length| ((f64::from(length) * 1.0e5).round() / 1.0e2).to_string());
    each.collect::<Vec<_>>().join(" x ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::command::bake::bake;

    fn baked(scene: &str) -> Vec<u8> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes").join(scene);
        let scene = crate::scene::Scene::load(&path).unwrap();
        let file = tempfile::NamedTempFile::new().unwrap();
        bake(&scene, "scene", file.path()).unwrap();
        std::fs::read(file.path()).unwrap()
    }

    #[test]
    fn a_stage_has_the_bodies_and_a_fine_object() {
        for (scene, parts, object, probe) in [
            ("cube-twist.toml", 1, "box 100 x 100 x 100 mm, E 3 MPa, nu 0.5", "sphere of 20 mm"),
            ("compass.toml", 2, "ellipsoid of 60 x 50 x 40 mm", "2 parts"),
        ] {
            let file = baked(scene);
            let stage = stage(&Scene::read(&file).unwrap(), &crate::skins::read(&file).unwrap(), "s", 1000).unwrap();
            assert!(stage.probe.len() >= parts, "{scene}: {}", stage.probe.len());
            assert!((VERTICES..3 * VERTICES).contains(&stage.object.vertices.len()), "{scene}: {}", stage.object.vertices.len());
            assert!(stage.object_name.starts_with(object), "{}", stage.object_name);
            assert!(stage.probe.len() > 1 || stage.probe_name == probe, "{}", stage.probe_name);
            assert_eq!((stage.period, stage.step_budget_us), (1.0e-3, 500.0));
        }
    }
}
