//! What is to be seen, and the order in which it is drawn.

use glam::{DQuat, DVec3};
use haptor_mesh::Mesh;
use haptor_wire::{BakedScene, ObjectShape};

use crate::camera::Camera;
use crate::image::Image;
use crate::legend;
use crate::model;
use crate::raster::{Canvas, Colour, Corner, Paint};

/// Where the probe is: pose `x_wp`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in world \[m\].
    pub position: DVec3,
    /// Rotation to world, unit quaternion.
    pub rotation: DQuat,
}

/// A contact region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Centre in world \[m\].
    pub centre: DVec3,
    /// Unit normal out of the object.
    pub normal: DVec3,
    /// Contact radius \[m\].
    pub radius: f64,
    /// Stuck share of its area, 0 to 1.
    pub stick: f64,
}

/// The deformed object.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Its surface, vertices where they have moved to \[m\].
    pub mesh: Mesh,
    /// How far each vertex has moved \[m\].
    pub moved: Vec<f64>,
}

impl Surface {
    /// How far the vertex that moved most has moved \[m\].
    pub fn most(&self) -> f64 {
        self.moved.iter().copied().fold(0.0, f64::max)
    }
}

/// A picture to be drawn.
#[derive(Clone, Debug)]
pub struct Shot<'a> {
    /// Object and probe.
    pub scene: &'a BakedScene,
    /// Meshes of the scene, by the number that a shape calls them; one that is missing is not drawn.
    pub skins: &'a [Mesh],
    /// Where the probe is.
    pub pose: Pose,
    /// Force on the probe in world \[N\]; its length is drawn as a share of `force_scale`.
    pub force: DVec3,
    /// Torque on the probe in world \[N m\]; drawn likewise about its axis.
    pub torque: DVec3,
    /// Force drawn at the full length of an arrow \[N\].
    pub force_scale: f64,
    /// Torque drawn as a full turn \[N m\].
    pub torque_scale: f64,
    /// Regions in contact.
    pub regions: Vec<Region>,
    /// The object's surface as it is deformed; `None` shows the object at rest.
    pub surface: Option<Surface>,
    /// Pixels across and down, each [`crate::MIN_SIDE`] to [`crate::MAX_SIDE`].
    pub size: (u32, u32),
}

const OBJECT: Colour = DVec3::new(0.80, 0.60, 0.33);
const PROBE: Colour = DVec3::new(0.30, 0.42, 0.55);
pub const FORCE: Colour = DVec3::new(0.75, 0.06, 0.04);
pub const TORQUE: Colour = DVec3::new(0.36, 0.12, 0.52);
pub const STUCK: Colour = DVec3::new(0.0, 0.17, 0.45);
pub const SLIPPING: Colour = DVec3::new(0.85, 0.25, 0.0);
/// The object's colours from where its surface rests to where it moved most.
const MOVED: [Colour; 3] = [OBJECT, DVec3::new(0.36, 0.58, 0.22), DVec3::new(0.0, 0.22, 0.12)];
const TILES: [Colour; 2] = [DVec3::new(0.86, 0.87, 0.88), DVec3::new(0.74, 0.76, 0.78)];
const SKY: [Colour; 2] = [DVec3::new(0.96, 0.97, 0.99), DVec3::new(0.84, 0.87, 0.91)];

/// Where the camera stands: before the scene, to the right, above.
const VIEW: DVec3 = DVec3::new(0.55, -1.0, 0.42);

/// How much the probe covers of what is behind it.
const PROBE_OPACITY: f64 = 0.7;

/// Full length of an arrow as a share of the scene's radius.
const ARROW: f64 = 0.7;

/// Forces and torques smaller than this share of their scale are not drawn.
const VISIBLE: f64 = 1.0e-3;

/// Draws a shot.
pub fn draw(shot: &Shot<'_>) -> Image {
    let object =
        shot.surface.as_ref().map_or_else(|| model::object(&shot.scene.object, shot.skins), |surface| surface.mesh.clone());
    let probe = placed_probe(shot);
    let (low, high) = bounds(probe.iter().chain([&object]));
    let radius = (high - low).length() / 2.0;
    // room for an arrow at its full length
    let mut seen: Vec<DVec3> = probe.iter().chain([&object]).flat_map(|mesh| mesh.vertices.iter().copied()).collect();
    seen.push(shot.pose.position + ARROW * radius * DVec3::Z);
    let camera = |width, height| Camera::framing(&seen, VIEW, width, height);
    let mut canvas = Canvas::new(camera, shot.size.0, shot.size.1, SKY[0], SKY[1]);
    draw_ground(&mut canvas, &shot.scene.object, radius);
    draw_object(&mut canvas, &object, shot.surface.as_ref());
    draw_probe(&mut canvas, &probe);
    // what can only be felt lies over what can be seen
    canvas.forget_depth();
    draw_regions(&mut canvas, &shot.regions);
    draw_wrench(&mut canvas, shot, radius);
    let mut image = canvas.finish();
    legend::draw(&mut image, shot);
    image
}

/// The object, coloured by how far its surface has moved.
fn draw_object(canvas: &mut Canvas, object: &Mesh, surface: Option<&Surface>) {
    let paint = Paint::solid(OBJECT);
    match surface {
        Some(surface) if surface.most() > 0.0 => {
            let most = surface.most();
            add_coloured(canvas, object, paint, |vertex| moved_colour(surface.moved[vertex as usize] / most));
        }
        _ => add(canvas, object, paint),
    }
}

/// Colour of a surface that moved by this share of the largest displacement.
pub fn moved_colour(share: f64) -> Colour {
    let at = 2.0 * share.clamp(0.0, 1.0);
    if at < 1.0 { MOVED[0].lerp(MOVED[1], at) } else { MOVED[1].lerp(MOVED[2], at - 1.0) }
}

fn placed_probe(shot: &Shot<'_>) -> Vec<Mesh> {
    let Pose { position, rotation } = shot.pose;
    let parts = shot.scene.probe.as_slice().iter();
    parts.map(|part| model::part(part, shot.skins).mapped(|v| position + rotation * v)).collect()
}

fn bounds<'m>(meshes: impl Iterator<Item = &'m Mesh>) -> (DVec3, DVec3) {
    let all = meshes.filter_map(Mesh::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    all.unwrap_or((DVec3::NEG_ONE, DVec3::ONE))
}

/// The ground that the object stands on; a half space is its own ground.
fn draw_ground(canvas: &mut Canvas, object: &ObjectShape, radius: f64) {
    if *object == ObjectShape::HalfSpace {
        return;
    }
    for (mesh, colour) in model::ground(1.6 * radius, -1.0e-3 * radius).iter().zip(TILES) {
        add(canvas, mesh, Paint::flat(colour));
    }
}

/// Regions as discs, mixed from the colours of stick and slip.
fn draw_regions(canvas: &mut Canvas, regions: &[Region]) {
    for region in regions {
        let disc = model::disc(region.centre, region.normal, region.radius);
        let colour = SLIPPING.lerp(STUCK, region.stick.clamp(0.0, 1.0));
        add(canvas, &disc, Paint::flat(colour));
    }
}

/// The force as an arrow from the probe's mass centre, the torque as an arc about its axis.
fn draw_wrench(canvas: &mut Canvas, shot: &Shot<'_>, radius: f64) {
    let thick = 0.018 * radius;
    let force = shot.force / shot.force_scale;
    if force.length() > VISIBLE {
        for mesh in model::arrow(shot.pose.position, ARROW * radius * force, thick) {
            add(canvas, &mesh, Paint::solid(FORCE));
        }
    }
    let torque = shot.torque / shot.torque_scale;
    if torque.length() > VISIBLE {
        let angle = std::f64::consts::TAU * torque.length().min(0.9);
        for mesh in model::arc(shot.pose.position, torque, 0.3 * radius, angle, 0.8 * thick) {
            add(canvas, &mesh, Paint::solid(TORQUE));
        }
    }
}

/// The probe, so that the surface below it shows through. Only the sides that face the camera are drawn: each pixel is covered
/// once.
fn draw_probe(canvas: &mut Canvas, parts: &[Mesh]) {
    for part in parts {
        add(canvas, part, Paint { opacity: PROBE_OPACITY, ..Paint::solid(PROBE) });
    }
}

/// Draws a mesh, shaded smooth where it is round and flat where it has edges; a translucent one without its far sides.
fn add(canvas: &mut Canvas, mesh: &Mesh, paint: Paint) {
    add_coloured(canvas, mesh, paint, |_| paint.colour);
}

/// As [`add`], each vertex in a colour of its own.
fn add_coloured(canvas: &mut Canvas, mesh: &Mesh, paint: Paint, colour: impl Fn(u32) -> Colour) {
    let normals: Vec<DVec3> = mesh.triangles.iter().map(|&t| face_normal(mesh, t)).collect();
    let mut around = vec![DVec3::ZERO; mesh.vertices.len()];
    for (triangle, normal) in mesh.triangles.iter().zip(&normals) {
        triangle.iter().for_each(|&index| around[index as usize] += *normal);
    }
    for (&triangle, &normal) in mesh.triangles.iter().zip(&normals) {
        let flat = normal.normalize_or(DVec3::Z);
        let corner = |index: u32| {
            let smooth = around[index as usize].normalize_or(flat);
            // an edge sharper than 30 degrees stays an edge
            let normal = if smooth.dot(flat) > 0.866 { smooth } else { flat };
            Corner { position: mesh.vertices[index as usize], normal, colour: colour(index) }
        };
        let corners = triangle.map(corner);
        if paint.opacity >= 1.0 || canvas.faces(corners[0].position, flat) {
            canvas.triangle(corners, paint);
        }
    }
}

fn face_normal(mesh: &Mesh, triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use haptor_wire::scene::{
        Breakaway, Coupling, Deformation, ForceLaw, GuardLimits, Place, ProbePart, ProbeParts, ProbeShape, Tier,
    };

    use super::*;

    fn scene(object: ObjectShape) -> BakedScene {
        let ball = ProbePart { shape: ProbeShape::Sphere { radius: 0.02 }, ..ProbePart::UNUSED };
        BakedScene {
            object,
            fixed_below: 0.0,
            young_modulus: 3.0e6,
            poisson_ratio: 0.5,
            density: 1100.0,
            compliance: None,
            probe: ProbeParts::from_slice(&[ball]).unwrap(),
            mass: 1.0,
            inertia: None,
            friction_static: 0.75,
            friction_dynamic: 0.75,
            region_distance: 0.004,
            max_regions: 10,
            tier: Tier::Bristle,
            samples: 64,
            sweeps: 4,
            deformation: Deformation::None,
            coupling: Coupling::Direct,
            breakaway: Breakaway::Smooth,
            gravity: false,
            force_law: ForceLaw::Hertz,
            guard: GuardLimits::DEVICE_S_OWN,
            paper_length: 0.1,
            place: Place { p_wd: [0.0; 3], q_wd: [1.0, 0.0, 0.0, 0.0] },
        }
    }

    fn shot(scene: &BakedScene) -> Shot<'_> {
        Shot {
            scene,
            skins: &[],
            pose: Pose { position: DVec3::new(0.0, 0.0, 0.119), rotation: DQuat::IDENTITY },
            force: DVec3::new(0.0, 0.0, 20.0),
            torque: DVec3::new(0.0, 0.0, -0.02),
            force_scale: 40.0,
            torque_scale: 0.05,
            regions: vec![Region { centre: DVec3::new(0.0, 0.0, 0.1), normal: DVec3::Z, radius: 0.0044, stick: 0.0 }],
            surface: None,
            size: (64, 48),
        }
    }

    #[test]
    fn every_object_is_drawn_and_the_same_twice() {
        let shapes = [
            ObjectShape::HalfSpace,
            ObjectShape::Box { size: [0.1; 3] },
            ObjectShape::Sphere { radius: 0.05 },
            ObjectShape::Ellipsoid { semi_axes: [0.05, 0.04, 0.05] },
            ObjectShape::Cylinder { radius: 0.05, height: 0.1 },
        ];
        let mut pictures = Vec::new();
        for shape in shapes {
            let scene = scene(shape);
            let picture = draw(&shot(&scene));
            assert_eq!(picture, draw(&shot(&scene)), "{shape:?}");
            assert_eq!(picture.rgb.len(), 64 * 48 * 3);
            let middle = picture.rgb[3 * (24 * 64 + 32)..][..3].to_vec();
            assert_ne!(middle, picture.rgb[..3], "{shape:?}: nothing in the middle");
            pictures.push(picture.rgb);
        }
        pictures.sort();
        pictures.dedup();
        assert_eq!(pictures.len(), shapes.len());
    }

    #[test]
    fn a_picture_is_a_png() {
        let scene = scene(ObjectShape::HalfSpace);
        let file = draw(&shot(&scene)).png().unwrap();
        assert_eq!(&file[..8], b"\x89PNG\r\n\x1a\n");
    }
}
