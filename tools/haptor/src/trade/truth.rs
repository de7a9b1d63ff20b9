//! What the probe of a scene should feel: the reference (`haptor_reference`) on the scene's own shapes.
//!
//! Every patch is solved on the half space that touches the object there. Its gap is measured on the undeformed bodies along the normal, by rays, at every pose, so that true
//! shapes, sliding on curved bodies and elliptic footprints count. Cells go along with the probe, as in the theories of partial slip, where slip is small beside the contact. Where the patches are and how their normals stand is taken from the core's contact at full depth.
//!
//! What the body adds to the half space is given, not solved: finite elements' figures for a cube and for the ellipsoid 60:50:40 ([`Known`]), else the scene's own compliance, which the
//! core uses too, so that its error does not show in a trade; [`Truth::source`] says which. On flat bodies patches move each other as point forces on the half space do.
//!
//! All lengths in metres, forces in newtons, torques in newton metres.

use std::f64::consts::PI;

use haptor_contact::{Patch as CorePatch, Vec3};
use haptor_mesh::DVec3;
use haptor_reference::contact::{Contact, Ground, Patch};
use haptor_reference::kernel::Solid;
use haptor_reference::lattice::Lattice;

use super::bodies::Known;
use super::rays::Placed;
use crate::motion::Place;
use crate::scene::Scene;

/// Room that a lattice leaves beyond the contact on each side, as a share of the contact: what sliding on curved bodies moves it by.
const ROOM: f64 = 1.15;

/// Cells over the overlap of the bodies in the first, coarse solution that finds how far the contact reaches.
const SCOUT: usize = 16;

/// Steps in which the depth is reached.
const PRESS_STEPS: usize = super::motions::PRESS_SAMPLES;

/// Where a patch is: a plane on the object, and the part of the probe that presses there.
struct Site {
    centre: DVec3,
    normal: DVec3,
    tangents: [DVec3; 2],
    part: Placed,
    lattice: Lattice,
    /// How far the lattice has gone with the probe, in the plane.
    moved: [f64; 2],
    /// Height of the object over the plane at every cell.
    ground: Vec<f64>,
    reach: f64,
}

impl Site {
    fn at(&self, [x, y]: [f64; 2]) -> DVec3 {
        self.middle() + self.tangents[0] * x + self.tangents[1] * y
    }

    /// Middle of the lattice now.
    fn middle(&self) -> DVec3 {
        self.centre + self.tangents[0] * self.moved[0] + self.tangents[1] * self.moved[1]
    }

    fn level(&self, v: DVec3) -> [f64; 2] {
        self.tangents.map(|t| t.dot(v))
    }
}

/// Units of a contact's friction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Units {
    /// Normal force at full depth \[N\].
    pub load: f64,
    /// mu times it \[N\].
    pub drag: f64,
    /// Shift that a contact that sticks needs to reach full slip, the body's part included \[m\].
    pub shift: f64,
    /// The same for a twist \[rad\].
    pub angle: f64,
}

/// Force and torque on the probe about its mass centre.
#[derive(Clone, Copy, Debug, Default)]
pub struct Felt {
    /// \[N\]
    pub force: [f64; 3],
    /// \[N m\]
    pub torque: [f64; 3],
}

/// The reference on a scene, at a pose.
pub struct Truth {
    object: Placed,
    sites: Vec<Site>,
    contact: Contact,
    solid: Solid,
    /// Shift per drag and turn per torque that the whole body adds.
    body: [f64; 2],
    friction: f64,
    touch: f64,
    /// Full depth, unmoved: where the patches were found.
    deepest: Place,
    place: Place,
    /// Factor on the normal force from finite elements, 1 where there is none.
    stiffer: f64,
    /// Where the figures come from, in words.
    pub source: String,
}

impl Truth {
    /// The scene with the probe at first touch; `patches` are the core's at `depth`, `across` cells go over each of them. `None` for a part that is a mesh without skin.
    pub fn new(scene: &Scene, touch: f64, depth: f64, patches: &[CorePatch], across: usize) -> Option<Self> {
        let material = scene.object.material;
        let solid = Solid { shear_modulus: material.shear_modulus().into(), poisson_ratio: material.poisson_ratio.into() };
        let skin = scene.object.skin.as_ref().map(|skin| &skin.mesh);
        let object = Placed::object(&scene.object.shape, skin);
        let deepest = Place { depth, angle: 0.0, shift: [0.0; 2] };
        let friction = f64::from(scene.params.friction_dynamic);
        let mut sites = Vec::new();
        for patch in patches {
            let at = usize::from(patch.part);
            let part = Placed::part(&scene.probe.parts[at], scene.probe.skins[at].as_ref().map(|skin| &skin.mesh))?;
            sites.push(site(patch, part, &object, touch, deepest, solid, across));
        }
        let flat = patches.iter().all(|patch| f64::from(patch.object_radius) > 1.0e3 * f64::from(patch.footprint.radius));
        let made: Vec<Patch> = sites.iter().map(|site| Patch::of_gap(solid, site.lattice, |_, _| f64::INFINITY)).collect();
        let (ground, body, source) = ground(scene, &sites, patches, solid, flat);
        let contact = Contact::new(solid, friction, made, ground);
        let start = Place { depth: 0.0, ..deepest };
        let stiffer = stiffer(scene, solid, depth);
        let mut truth = Self { object, deepest, sites, contact, solid, body, friction, touch, place: start, stiffer, source };
        truth.source = format!("{}{}", truth.source, if stiffer == 1.0 { "" } else { "; normal force by finite elements" });
        Some(truth)
    }

    /// Presses to full depth; what is felt after each step.
    pub fn press(&mut self, depth: f64) -> Vec<Felt> {
        let step = |i: usize| depth * i as f64 / PRESS_STEPS as f64;
        (1..=PRESS_STEPS).map(|i| self.lead(Place { depth: step(i), ..self.place })).collect()
    }

    /// Leads the probe to `place` in one step.
    pub fn lead(&mut self, place: Place) -> Felt {
        let by = |site: &Site| site.motion(site.middle(), self.place, place, self.touch);
        let motions: Vec<[f64; 3]> = self.sites.iter().map(by).collect();
        for (index, site) in self.sites.iter_mut().enumerate() {
            let [x, y, _] = site.motion(site.centre, self.deepest, place, self.touch);
            site.moved = [x, y];
            site.survey(&self.object);
            self.contact.set_separation(index, &site.separation(place, self.touch));
        }
        self.contact.advance(&vec![0.0; motions.len()], &motions);
        self.place = place;
        self.felt()
    }

    /// Steps of the reference that did not converge.
    pub fn unconverged(&self) -> usize {
        self.contact.unconverged
    }

    /// A copy to lead along another motion.
    pub fn contact(&self) -> (Contact, Place) {
        (self.contact.clone(), self.place)
    }

    /// Goes back to a copy.
    pub fn restore(&mut self, (contact, place): (Contact, Place)) {
        (self.contact, self.place) = (contact, place);
        for site in &mut self.sites {
            let [x, y, _] = site.motion(site.centre, self.deepest, place, self.touch);
            site.moved = [x, y];
        }
    }

    /// The wrench of all cells about the mass centre.
    fn felt(&self) -> Felt {
        let origin = position(self.place, self.touch);
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for (site, patch) in self.sites.iter().zip(self.contact.patches()) {
            let area = site.lattice.area();
            let [qx, qy] = patch.traction();
            for (index, cell) in site.lattice.cells() {
                let f = (site.normal * patch.pressure()[index] * self.stiffer
                    - site.tangents[0] * qx[index]
                    - site.tangents[1] * qy[index])
                    * area;
                force += f;
                torque += (site.at(cell) - origin).cross(f);
            }
        }
        Felt { force: force.to_array(), torque: torque.to_array() }
    }

    /// Units of the contact as it is pressed now.
    pub fn units(&self) -> Units {
        let origin = position(self.place, self.touch);
        let g = self.solid.shear_modulus;
        let (mut load, mut torque, mut shift, mut angle) = (0.0, 0.0, 0.0, 0.0);
        let mut grips = [Vec::new(), Vec::new()];
        for (site, patch) in self.sites.iter().zip(self.contact.patches()) {
            let (p, a) = (patch.load(), patch.radius());
            let most = self.friction * p;
            let s0 = 3.0 * most * (2.0 - self.solid.poisson_ratio) / (16.0 * a * g);
            let spin = self.friction * patch.full_slip_torque();
            let arm = (site.centre - origin).with_z(0.0);
            // a leg slips when it has been led by s0, a patch under the axis when it has been turned
            let turn = 1.0 / (arm.length() / s0 + 16.0 / 3.0 * g * a.powi(3) / spin);
            let along = DVec3::Z.cross(arm).normalize_or_zero();
            let [tx, ty] = site.level(along);
            let share = arm.length() * most / (arm.length() * most + spin);
            grips[0].extend([site.tangents[0].x * most, site.tangents[1].x * most, 0.0]);
            grips[1].extend([tx * most * share, ty * most * share, spin * (1.0 - share)]);
            load += p;
            torque += (arm.length() * most).max(spin);
            shift += s0 / self.sites.len() as f64;
            angle += turn / self.sites.len() as f64;
        }
        let work = |grips: &[f64]| self.contact.moved_by(grips).iter().zip(grips).map(|(u, f)| u * f).sum::<f64>();
        let drag = self.friction * load;
        Units { load, drag, shift: shift + work(&grips[0]) / drag, angle: angle + work(&grips[1]) / torque }
    }

    /// Places on the object's surface about every contact, at rest in world, out to `reach` contact radii.
    pub fn places(&self, reach: f64) -> Vec<Vec3> {
        const RINGS: usize = 8;
        const SPOKES: usize = 12;
        let mut places = Vec::new();
        for (site, patch) in self.sites.iter().zip(self.contact.patches()) {
            for ring in 0..=RINGS {
                let r = patch.radius() * reach * ring as f64 / RINGS as f64;
                for spoke in 0..if ring == 0 { 1 } else { SPOKES } {
                    let (sin, cos) = (2.0 * PI * spoke as f64 / SPOKES as f64).sin_cos();
                    let foot = site.at([r * cos, r * sin]);
                    if let Some(height) = height(&self.object, foot, site.normal, site.reach) {
                        places.push((foot + site.normal * height).as_vec3());
                    }
                }
            }
        }
        places
    }

    /// Displacement in world at a place on the surface near a contact: every patch's half space, and the motion of the whole body at the nearest.
    pub fn displacement(&self, place: Vec3) -> DVec3 {
        let place = place.as_dvec3();
        let pairs = || self.sites.iter().zip(self.contact.patches());
        let mut sum = DVec3::ZERO;
        for (site, patch) in pairs() {
            let [ux, uy, sunk] = patch.displacement(self.solid, site.level(place - site.middle()));
            sum += site.tangents[0] * ux + site.tangents[1] * uy - site.normal * sunk;
        }
        let away = |site: &Site| (site.middle() - place).length();
        let Some(near) = self.sites.iter().min_by(|a, b| away(a).total_cmp(&away(b))) else { return sum };
        let [x, y] = near.level(place - near.middle());
        for (site, patch) in pairs() {
            let columns = columns_of_body(near, site, self.body[0], self.body[1]);
            for ([gx, gy, turn], share) in columns.into_iter().zip(patch.grip()) {
                sum += (near.tangents[0] * (gx - turn * y) + near.tangents[1] * (gy + turn * x)) * share;
            }
        }
        sum
    }
}

impl Site {
    /// Gap of the undeformed bodies over every cell, negative where they overlap.
    fn separation(&self, place: Place, touch: f64) -> Vec<f64> {
        let origin = position(place, touch);
        let (sin, cos) = place.angle.sin_cos();
        let into = |v: DVec3| DVec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
        let mut gap = vec![f64::INFINITY; self.lattice.len()];
        for (index, cell) in self.lattice.cells() {
            let from = self.at(cell) - self.normal * self.reach;
            if let Some([enters, _]) = self.part.stretch(into(from - origin), into(self.normal)) {
                gap[index] = enters - self.reach - self.ground[index];
            }
        }
        gap
    }

    /// Motion along the plane of the probe's material that is at `point` when the probe is at `from`.
    fn motion(&self, point: DVec3, from: Place, to: Place, touch: f64) -> [f64; 3] {
        let (sin, cos) = (to.angle - from.angle).sin_cos();
        let arm = point - position(from, touch);
        let turned = DVec3::new(cos * arm.x - sin * arm.y, sin * arm.x + cos * arm.y, arm.z);
        let [x, y] = self.level(position(to, touch) + turned - point);
        [x, y, (to.angle - from.angle) * self.normal.z]
    }
}

/// The mass centre.
fn position(place: Place, touch: f64) -> DVec3 {
    DVec3::new(place.shift[0], place.shift[1], touch - place.depth)
}

/// Height of the object over a foot on a plane, measured from outside.
fn height(object: &Placed, foot: DVec3, normal: DVec3, reach: f64) -> Option<f64> {
    object.stretch(foot + normal * reach, -normal).map(|[meets, _]| reach - meets.max(0.0))
}

/// The site of a core's patch, its lattice as large as the contact that a coarse solution finds.
fn site(patch: &CorePatch, part: Placed, object: &Placed, touch: f64, deepest: Place, solid: Solid, across: usize) -> Site {
    let normal = patch.normal.as_dvec3().normalize();
    let first = (DVec3::X - normal * normal.x).normalize();
    let a = f64::from(patch.footprint.radius);
    // an elongated footprint reaches up to four times the radius of equal area
    let wide = Lattice::square(4 * SCOUT, 2.0 * 4.0 * a / (4 * SCOUT) as f64);
    let reach = 8.0 * a + 4.0 * deepest.depth;
    let tangents = [first, normal.cross(first)];
    let mut site = Site {
        centre: patch.centre.as_dvec3(),
        normal,
        tangents,
        part,
        lattice: wide,
        moved: [0.0; 2],
        ground: Vec::new(),
        reach,
    };
    site.survey(object);
    let gap = site.separation(deepest, touch);
    let overlap = extent(&wide, |index| gap[index] < 0.0);
    site.fit(object, overlap, SCOUT);
    let mut scout = Contact::new(solid, 0.0, vec![Patch::of_gap(solid, site.lattice, |_, _| f64::INFINITY)], Ground::firm(1));
    scout.set_separation(0, &site.separation(deepest, touch));
    scout.press(&[0.0]);
    let found = extent(&site.lattice, |index| scout.patches()[0].pressure()[index] > 0.0);
    site.fit(object, found.map(|half| half * ROOM), across);
    site
}

impl Site {
    /// Measures the object under the lattice.
    fn survey(&mut self, object: &Placed) {
        let mut ground = vec![f64::NEG_INFINITY; self.lattice.len()];
        for (index, cell) in self.lattice.cells() {
            if let Some(height) = height(object, self.at(cell), self.normal, self.reach) {
                ground[index] = height;
            }
        }
        self.ground = ground;
    }

    /// A lattice over the given half widths, `across` cells over the wider.
    fn fit(&mut self, object: &Placed, half: [f64; 2], across: usize) {
        let edge = 2.0 * half[0].max(half[1]) / across as f64;
        let [columns, rows] = half.map(|half| ((2.0 * half / edge).ceil() as usize).max(4));
        self.lattice = Lattice::new(columns, rows, edge);
        self.survey(object);
    }
}

/// Half widths along x and y of the cells that count.
fn extent(lattice: &Lattice, counts: impl Fn(usize) -> bool) -> [f64; 2] {
    let inside = lattice.cells().filter(|&(index, _)| counts(index));
    let [x, y] = inside.fold([0.0_f64; 2], |[x, y], (_, cell)| [x.max(cell[0].abs()), y.max(cell[1].abs())]);
    [x + 0.5 * lattice.edge, y + 0.5 * lattice.edge]
}

/// Finite elements' factor on the force of a ball on a cube; 1 elsewhere.
fn stiffer(scene: &Scene, solid: Solid, depth: f64) -> f64 {
    match (Known::of(&scene.object.shape), scene.probe.parts.as_slice()) {
        (Some(known), [part]) => match part.shape {
            haptor_contact::ProbeShape::Sphere { radius } => {
                known.press(solid.poisson_ratio, radius.into(), depth).unwrap_or(1.0)
            }
            _ => 1.0,
        },
        _ => 1.0,
    }
}

/// What moves the ground under the patches beyond their own half space, and where that comes from.
fn ground(scene: &Scene, sites: &[Site], patches: &[CorePatch], solid: Solid, flat: bool) -> (Ground, [f64; 2], String) {
    let (nu, g, count) = (solid.poisson_ratio, solid.shear_modulus, sites.len());
    let (drag, twist, whose) = of_body(scene, sites, patches, solid, flat);
    let normal = mean_of(patches, |patch| patch.body.normal);
    let mut ground = Ground::firm(count);
    for i in 0..count {
        for j in 0..count {
            let mut columns = columns_of_body(&sites[i], &sites[j], drag, twist);
            if flat && i != j {
                add_neighbour(&mut columns, &sites[i], &sites[j], solid);
                let r = (sites[i].centre - sites[j].centre).length();
                ground.normal[i * count + j] = (1.0 - nu) / (2.0 * PI * g * r);
            }
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                ground.level[(3 * i + row) * 3 * count + 3 * j + column] = columns[column][row];
            }
        }
        ground.normal[i * count + i] = normal;
    }
    (ground, [drag, twist], format!("half space solved{whose}"))
}

/// Compliance of the whole body in drag and twist, and where it comes from, to be said after the half space.
fn of_body(scene: &Scene, sites: &[Site], patches: &[CorePatch], solid: Solid, flat: bool) -> (f64, f64, &'static str) {
    let (nu, g, count) = (solid.poisson_ratio, solid.shear_modulus, sites.len());
    let a = mean_of(patches, |patch| patch.footprint.radius);
    let (drag, twist) = (mean_of(patches, |patch| patch.body.drag), mean_of(patches, |patch| patch.body.twist));
    match Known::of(&scene.object.shape) {
        Some(known) => {
            let offset = sites.iter().map(|site| site.centre.with_z(0.0).length()).fold(0.0, f64::max);
            let apart = (count > 1).then(|| known.couple(nu, g, offset)).flatten();
            let twist = apart.unwrap_or_else(|| known.twist(nu, g, a));
            match known.drag(nu, g, a) {
                Some(drag) => (drag, twist, "; body's compliance by finite elements"),
                None => (drag, twist, "; body's compliance by finite elements in twist, the scene's own in drag"),
            }
        }
        None if twist == 0.0 && drag == 0.0 => (drag, twist, ""),
        None => {
            let of = |patch: &CorePatch| 0.735 * patch.footprint.radius / patch.object_radius;
            let round = if flat { 0.0 } else { mean_of(patches, of).min(0.75) };
            let own = 3.0 / (16.0 * g * a.powi(3)) * (1.0 / (1.0 - round) - 1.0) / count as f64;
            (drag, twist + own, "; body's compliance is the scene's own")
        }
    }
}

/// Mean of a figure over all patches.
fn mean_of(patches: &[CorePatch], of: fn(&CorePatch) -> f32) -> f64 {
    patches.iter().map(|patch| f64::from(of(patch))).sum::<f64>() / patches.len() as f64
}

/// Motion of patch `i` by a unit of each component of patch `j`'s grip, by shear and twist of the whole body.
fn columns_of_body(i: &Site, j: &Site, drag: f64, twist: f64) -> [[f64; 3]; 3] {
    let arm = |site: &Site| site.centre.with_z(0.0);
    [0, 1, 2].map(|component| {
        let (force, torque) = match component {
            0 | 1 => (j.tangents[component], arm(j).cross(j.tangents[component]).z),
            _ => (DVec3::ZERO, j.normal.z),
        };
        let moved = force * drag + DVec3::Z.cross(arm(i)) * twist * torque;
        let [x, y] = i.level(moved);
        [x, y, twist * torque * i.normal.z]
    })
}

/// The same by the flat surface between them: point force and point torque on the half space.
fn add_neighbour(columns: &mut [[f64; 3]; 3], i: &Site, j: &Site, solid: Solid) {
    let (nu, g) = (solid.poisson_ratio, solid.shear_modulus);
    let [x, y] = j.level(i.centre - j.centre);
    let r = x.hypot(y);
    let k = 1.0 / (2.0 * PI * g);
    let point = [
        // by a force along x, along y: displacement, turn
        [k * ((1.0 - nu) / r + nu * x * x / r.powi(3)), k * nu * x * y / r.powi(3), -0.5 * k * -y / r.powi(3)],
        [k * nu * x * y / r.powi(3), k * ((1.0 - nu) / r + nu * y * y / r.powi(3)), -0.5 * k * x / r.powi(3)],
        // by a torque
        [-0.5 * k * y / r.powi(3), 0.5 * k * x / r.powi(3), -0.25 * k / r.powi(3)],
    ];
    for (column, point) in columns.iter_mut().zip(point) {
        for (sum, term) in column.iter_mut().zip(point) {
            *sum += term;
        }
    }
}
