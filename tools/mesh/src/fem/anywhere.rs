//! Loads anywhere on a body and moves everywhere else: u = u_h + u_r for every disc of a list.
//!
//! u_h is what the half spaces of the disc's points do ([`super::disc`]); the remainder u_r carries minus their tractions on the free surface and
//! minus their displacement on the base. One factorisation, all loads. The surface's points and normals are the body's own, not the mesh's, so that
//! no load ever comes to lie beside its surface.

use glam::{DMat3, DVec3};

use super::FemError;
use super::bricks::{Bricks, Face, Skin};
use super::disc::{Block, Disc, Point, add};
use super::element::{GAUSS, Lame, line};
use super::solid::Cut;
use super::system::{Factored, Stiffness};

/// Radius of the circle that stands for the surface close around a disc, in radii of the disc; within the reach of edges that discs keep.
pub(crate) const NEAR: f64 = 1.4;

/// What the four unit loads on one disc do.
#[derive(Clone, Debug)]
pub(crate) struct Moved {
    /// Mean moves of the targets.
    pub at: Vec<Block>,
    /// Mean move of the circle of [`NEAR`] radii around the disc.
    pub near: Block,
}

/// Points whose mean move is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub points: Vec<Point>,
    reading: Reading,
}

/// One quadrature point of a face.
struct Sample {
    at: DVec3,
    /// Area vector, outwards.
    area: DVec3,
    value: [f64; 9],
}

/// A free face, sampled ever more finely: chosen by the distance of the load.
struct Panel {
    nodes: [u32; 9],
    middle: DVec3,
    reach: f64,
    samples: [Vec<Sample>; 3],
}

/// Pieces along an edge of a face at the three finenesses, and the distance in face sizes from which each is enough.
const PIECES: [(usize, f64); 3] = [(1, 4.0), (2, 2.0), (6, 0.0)];

/// Mean move of points as a sum over nodes: node, share of a displacement, turn per displacement.
type Reading = Vec<(u32, f64, DVec3)>;

/// A body ready for loads.
pub(crate) struct Body<'a> {
    cut: &'a Cut,
    nu: f64,
    mesh: &'a Bricks,
    panels: Vec<Panel>,
    factored: Factored<'a, 'a>,
}

/// The stiffness of a mesh and what it holds.
pub(crate) fn stiffness(mesh: &Bricks, nu: f64) -> Result<Stiffness<'_>, FemError> {
    Stiffness::new(mesh, Lame::of_unit_shear(nu))
}

impl<'a> Body<'a> {
    pub(crate) fn new(cut: &'a Cut, nu: f64, mesh: &'a Bricks, stiffness: &'a Stiffness<'a>) -> Result<Self, FemError> {
        let mut held = vec![false; 3 * mesh.nodes.len()];
        for face in mesh.faces.iter().filter(|face| face.skin == Skin::Base) {
            for &node in &face.nodes {
                held[3 * node as usize..3 * node as usize + 3].fill(true);
            }
        }
        let panels = mesh.faces.iter().filter(|face| face.skin == Skin::Free).map(|face| panel(cut, mesh, face)).collect();
        Ok(Self { cut, nu, mesh, panels, factored: stiffness.factor(&held)? })
    }

    /// Points to be read.
    pub(crate) fn target(&self, points: &[Point]) -> Result<Target, FemError> {
        Ok(Target { points: points.to_vec(), reading: self.reading(points)? })
    }

    /// Loads each disc; what it moves.
    pub(crate) fn moves(&self, discs: &[&Disc], targets: &[Target]) -> Result<Vec<Moved>, FemError> {
        let solved = self.solved(discs);
        let read = |(disc, columns): (&&Disc, &[Vec<f64>])| {
            let at = targets.iter().map(|target| self.mean(disc, target, columns)).collect();
            let circle = self.target(&disc.circle(self.cut, NEAR * disc.radius))?;
            Ok(Moved { at, near: self.mean(disc, &circle, columns) })
        };
        discs.iter().zip(solved.chunks_exact(4)).map(read).collect()
    }

    /// Loads each disc: its own mean move beyond the half space's.
    pub(crate) fn own(&self, discs: &[&Disc]) -> Result<Vec<Block>, FemError> {
        let solved = self.solved(discs);
        let read = |(disc, columns): (&&Disc, &[Vec<f64>])| {
            let mut own = disc.bent(self.nu);
            apply(&mut own, &self.reading(&disc.fine)?, columns);
            Ok(own)
        };
        discs.iter().zip(solved.chunks_exact(4)).map(read).collect()
    }

    fn solved(&self, discs: &[&Disc]) -> Vec<Vec<f64>> {
        let loads: Vec<_> = discs.iter().flat_map(|disc| self.loads(disc)).collect();
        let held: Vec<_> = discs.iter().flat_map(|disc| self.base(disc)).collect();
        self.factored.solve_many(&loads, &held)
    }

    fn mean(&self, disc: &Disc, target: &Target, columns: &[Vec<f64>]) -> Block {
        let mut block = Block::default();
        apply(&mut block, &target.reading, columns);
        for point in &target.points {
            add(&mut block, point, &disc.moves(point.at, self.nu));
        }
        block
    }

    /// Minus the half spaces' tractions on the free surface as nodal forces, one list per load.
    fn loads(&self, disc: &Disc) -> [Vec<f64>; 4] {
        let mut loads: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; 3 * self.mesh.nodes.len()]);
        for panel in &self.panels {
            if self.cut.is_flat(disc.spot.normal) && panel.is_level_with(disc) {
                continue;
            }
            for sample in panel.samples(disc) {
                let pulls = disc.tractions(sample.at, sample.area, self.nu);
                for (load, pull) in loads.iter_mut().zip(pulls) {
                    for (&node, value) in panel.nodes.iter().zip(sample.value) {
                        for axis in 0..3 {
                            load[3 * node as usize + axis] -= pull[axis] * value;
                        }
                    }
                }
            }
        }
        loads
    }

    /// Minus the half spaces' displacement on the base, one list per load.
    fn base(&self, disc: &Disc) -> [Vec<f64>; 4] {
        let mut moved: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; 3 * self.mesh.nodes.len()]);
        for face in self.mesh.faces.iter().filter(|face| face.skin == Skin::Base) {
            for &node in &face.nodes {
                let columns = disc.moves(self.mesh.nodes[node as usize], self.nu);
                for (list, u) in moved.iter_mut().zip(columns) {
                    list[3 * node as usize..3 * node as usize + 3].copy_from_slice(&(-u).to_array());
                }
            }
        }
        moved
    }

    fn reading(&self, points: &[Point]) -> Result<Reading, FemError> {
        let mut reading = Reading::new();
        for point in points {
            let (panel, value) = self.locate(point.at).ok_or(FemError::Outside)?;
            for (&node, n) in panel.nodes.iter().zip(value) {
                reading.push((node, point.share * n, point.around * n));
            }
        }
        Ok(reading)
    }

    /// The face that the ray from the body's middle to `at` pierces, and its shape functions there.
    fn locate(&self, at: DVec3) -> Option<(&Panel, [f64; 9])> {
        let ray = at - self.cut.centre;
        let mut best: Option<(f64, &Panel, [f64; 2])> = None;
        for panel in self.panels.iter().filter(|panel| panel.middle.distance(at) < 1.5 * panel.reach) {
            let Some(found) = pierced(self.mesh, &panel.nodes, self.cut.centre, ray) else { continue };
            let outside = found[0].abs().max(found[1].abs()) - 1.0;
            if best.is_none_or(|(least, ..)| outside < least) {
                best = Some((outside, panel, found));
            }
        }
        let (_, panel, [s, t]) = best.filter(|(outside, ..)| *outside < SLACK)?;
        Some((panel, values(s.clamp(-1.0, 1.0), t.clamp(-1.0, 1.0))))
    }
}

/// How far outside its face a surface point may seem to lie, in element coordinates: meshes meet round rims to that.
const SLACK: f64 = 0.02;

/// Newton steps to find a point on a face; more than one that holds it ever needs.
const STEPS: usize = 12;

fn apply(block: &mut Block, reading: &Reading, columns: &[Vec<f64>]) {
    for &(node, share, around) in reading {
        for (load, column) in columns.iter().enumerate() {
            let start = 3 * node as usize;
            let u = DVec3::new(column[start], column[start + 1], column[start + 2]);
            for axis in 0..3 {
                block[axis][load] += share * u[axis];
            }
            block[3][load] += around.dot(u);
        }
    }
}

fn values(s: f64, t: f64) -> [f64; 9] {
    let (a, b) = (line(s).0, line(t).0);
    std::array::from_fn(|i| a[i % 3] * b[i / 3])
}

/// Place and slopes of a face at (s, t).
fn on_face(mesh: &Bricks, nodes: &[u32; 9], s: f64, t: f64) -> [DVec3; 3] {
    let ((a, da), (b, db)) = (line(s), line(t));
    let mut found = [DVec3::ZERO; 3];
    for (i, &node) in nodes.iter().enumerate() {
        let at = mesh.nodes[node as usize];
        found[0] += at * (a[i % 3] * b[i / 3]);
        found[1] += at * (da[i % 3] * b[i / 3]);
        found[2] += at * (a[i % 3] * db[i / 3]);
    }
    found
}

/// Where the ray from `centre` pierces a face.
fn pierced(mesh: &Bricks, nodes: &[u32; 9], centre: DVec3, ray: DVec3) -> Option<[f64; 2]> {
    let (mut at, mut reach) = ([0.0_f64; 2], 1.0);
    for _ in 0..STEPS {
        let [place, along_s, along_t] = on_face(mesh, nodes, at[0], at[1]);
        let slopes = DMat3::from_cols(along_s, along_t, -ray);
        if slopes.determinant() == 0.0 {
            return None;
        }
        let step = slopes.inverse() * (centre + ray * reach - place);
        at = [(at[0] + step.x).clamp(-2.0, 2.0), (at[1] + step.y).clamp(-2.0, 2.0)];
        reach += step.z;
    }
    (reach > 0.0).then_some(at)
}

fn panel(cut: &Cut, mesh: &Bricks, face: &Face) -> Panel {
    let middle = mesh.nodes[face.nodes[4] as usize];
    let reach = face.nodes.iter().map(|&node| mesh.nodes[node as usize].distance(middle)).fold(0.0, f64::max);
    let samples = PIECES.map(|(pieces, _)| {
        let step = 1.0 / pieces as f64;
        let mut list = Vec::new();
        for cell in 0..pieces * pieces {
            let low = |index: usize| -1.0 + 2.0 * step * index as f64;
            for (s, ws) in GAUSS {
                for (t, wt) in GAUSS {
                    let (s, t) = (low(cell % pieces) + (1.0 + s) * step, low(cell / pieces) + (1.0 + t) * step);
                    list.push(sample(cut, mesh, face, [s, t], ws * wt * step * step));
                }
            }
        }
        list
    });
    Panel { nodes: face.nodes, middle, reach, samples }
}

fn sample(cut: &Cut, mesh: &Bricks, face: &Face, [s, t]: [f64; 2], weight: f64) -> Sample {
    let [place, along_s, along_t] = on_face(mesh, &face.nodes, s, t);
    let area = along_s.cross(along_t) * weight;
    let area = if area.dot(place - face.inside) < 0.0 { -area } else { area };
    let spot = cut.along(place, area.normalize_or_zero());
    Sample { at: spot.point, area: spot.normal * area.length(), value: values(s, t) }
}

impl Panel {
    fn samples(&self, disc: &Disc) -> &[Sample] {
        let sizes = (self.middle.distance(disc.spot.point) - disc.radius) / self.reach;
        let level = PIECES.iter().position(|&(_, from)| sizes > from).unwrap_or(PIECES.len() - 1);
        &self.samples[level]
    }

    /// True when the panel lies in the plane of a flat disc: the half space leaves it free of traction.
    fn is_level_with(&self, disc: &Disc) -> bool {
        let off = |sample: &Sample| (sample.at - disc.spot.point).dot(disc.spot.normal).abs();
        self.samples[0].iter().all(|sample| off(sample) < 1.0e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::solid::Solid;
    use crate::fem::whole;

    /// Largest entry of a block.
    fn size(block: &Block) -> f64 {
        block.iter().flatten().fold(0.0, |size, value| size.max(value.abs()))
    }

    fn bodies() -> [(Cut, f64); 3] {
        [
            (Cut::new(Solid::Box { size: DVec3::new(2.0, 1.6, 1.8) }, 0.0), 0.005),
            (Cut::new(Solid::Cylinder { radius: 1.0, height: 1.6 }, 0.0), 0.02),
            (Cut::new(Solid::Ellipsoid { axes: DVec3::new(1.0, 0.9, 0.8) }, 0.2), 0.02),
        ]
    }

    #[test]
    fn what_the_free_surface_does_not_carry_the_base_does() {
        for (cut, tolerance) in bodies() {
            let mesh = whole::mesh(&cut, 4);
            let stiffness = stiffness(&mesh, 0.3).unwrap();
            let body = Body::new(&cut, 0.3, &mesh, &stiffness).unwrap();
            for direction in [DVec3::Z, DVec3::new(0.3, 0.1, 1.0), DVec3::new(1.0, 0.2, 0.1)] {
                let disc = Disc::new(&cut, cut.ray(direction), 0.1);
                let loads = body.loads(&disc);
                let base: Vec<Panel> =
                    mesh.faces.iter().filter(|face| face.skin == Skin::Base).map(|face| panel(&cut, &mesh, face)).collect();
                for (axis, load) in loads.iter().take(3).enumerate() {
                    let free: DVec3 = load.chunks_exact(3).map(DVec3::from_slice).sum();
                    // the base's own samples lie on the plane, not on the round surface
                    let held: DVec3 = base
                        .iter()
                        .flat_map(|panel| &panel.samples[1])
                        .map(|sample| {
                            disc.tractions(DVec3::new(sample.at.x, sample.at.y, cut.base), -DVec3::Z * sample.area.length(), 0.3)
                                [axis]
                        })
                        .sum();
                    let left = (free - held - DVec3::AXES[axis]).length();
                    assert!(left < tolerance, "{cut:?} {direction} {axis}: {free} {held}");
                }
            }
        }
    }

    #[test]
    fn places_answer_each_other_alike() {
        for (cut, tolerance) in bodies() {
            let mesh = whole::mesh(&cut, 4);
            let stiffness = stiffness(&mesh, 0.4999).unwrap();
            let body = Body::new(&cut, 0.4999, &mesh, &stiffness).unwrap();
            let disc = |direction: DVec3| Disc::new(&cut, cut.ray(direction), 0.1);
            let (top, side) = (disc(DVec3::new(0.2, 0.3, 1.0)), disc(DVec3::new(1.0, -0.3, 0.1)));
            let targets = [body.target(&top.ring).unwrap(), body.target(&side.ring).unwrap()];
            let moved = body.moves(&[&top, &side], &targets).unwrap();
            let (there, back) = (&moved[0].at[1], &moved[1].at[0]);
            for row in 0..4 {
                for column in 0..4 {
                    let off = (there[row][column] - back[column][row]).abs();
                    assert!(
                        off < tolerance * size(there),
                        "{cut:?} {row} {column}: {} {}",
                        there[row][column],
                        back[column][row]
                    );
                }
            }
            for own in body.own(&[&top, &side]).unwrap() {
                for (row, column) in [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)] {
                    assert!((own[row][column] - own[column][row]).abs() < 2.0 * tolerance * size(&own), "{cut:?} {own:?}");
                }
            }
        }
    }

    #[test]
    fn own_moves_are_the_body_s_constants() {
        use crate::fem::{Body as Shape, Elastic, Fineness, Place, body_constants};
        let cut = Cut::new(Solid::Box { size: DVec3::splat(2.0) }, 0.0);
        let mesh = whole::mesh(&cut, 4);
        let stiffness = stiffness(&mesh, 0.45).unwrap();
        let body = Body::new(&cut, 0.45, &mesh, &stiffness).unwrap();
        for direction in [DVec3::Z, DVec3::X] {
            let spot = cut.ray(direction);
            let own = body.own(&[&Disc::new(&cut, spot, 0.2)]).unwrap()[0];
            let place = Place { point: spot.point, normal: spot.normal, radius: 0.2 };
            let elastic = Elastic { shear_modulus: 1.0, poisson_ratio: 0.45 };
            let known =
                body_constants(&Shape::Box { size: DVec3::splat(2.0) }, &elastic, &place, Fineness::Coarse, &mut |_, _| ())
                    .unwrap()
                    .constants;
            let drag = if direction == DVec3::Z { [own[0][0], own[1][1]] } else { [own[1][1], own[2][2]] };
            let normal = if direction == DVec3::Z { own[2][2] } else { own[0][0] };
            for (found, expected) in
                [(normal, known.normal), (drag[0], known.drag[0]), (drag[1], known.drag[1]), (own[3][3], known.twist)]
            {
                assert!((found - expected).abs() < 0.01 * known.drag[0].max(known.normal), "{direction}: {found} {expected}");
            }
        }
    }
}
