//! Meshes of 27-node bricks: a box, and a quarter of a body with a round section.
//!
//! A body is made of **blocks**: cubes of parameters (u, v, w) in [0, 1]^3 cut by lists of **breaks** and mapped into space.
//! Nodes of neighbouring blocks that coincide are joined. Faces know what they are: the plane of the contact, free, or held.

use std::collections::HashMap;

use glam::DVec3;

use super::element::NODES;

/// What holds at an outer face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skin {
    /// Lies in the plane of the contact: the half space leaves it free of traction already.
    Contact,
    /// Free of traction.
    Free,
    /// Held.
    Base,
}

/// A face of a brick: its nine nodes, tensor order, and a point inside the brick (outward is away from it).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub nodes: [u32; 9],
    pub inside: DVec3,
    pub skin: Skin,
}

/// Nodes \[m\], bricks and outer faces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bricks {
    pub nodes: Vec<DVec3>,
    pub bricks: Vec<[u32; NODES]>,
    pub faces: Vec<Face>,
    /// True when only x >= 0, y >= 0 is meshed and the load decides what the mirrors do.
    pub quarter: bool,
    found: HashMap<[i64; 3], u32>,
}

/// Nodes closer than this, in units of the body, are the same.
const SAME: f64 = 1.0e-7;

/// Skins of a block's six sides: u low, u high, v low, v high, w low, w high; `None` inside the body or on a mirror.
pub(crate) type Skins = [Option<Skin>; 6];

impl Bricks {
    fn node(&mut self, at: DVec3) -> u32 {
        let key = (at / SAME).round().to_array().map(|c| c as i64);
        let next = self.nodes.len() as u32;
        // a coordinate on the edge between two cells may round either way: look at both
        for offset in 0..27 {
            let near = [key[0] + offset % 3 - 1, key[1] + offset / 3 % 3 - 1, key[2] + offset / 9 - 1];
            if let Some(&found) = self.found.get(&near) {
                return found;
            }
        }
        self.found.insert(key, next);
        self.nodes.push(at);
        next
    }

    /// Adds a block cut at `breaks` (each list runs from 0 to 1) and mapped by `place`.
    pub(crate) fn block(&mut self, breaks: [&[f64]; 3], skins: Skins, place: impl Fn(f64, f64, f64) -> DVec3) {
        let n = breaks.map(|list| list.len() - 1);
        for cell in 0..n[0] * n[1] * n[2] {
            let index = [cell % n[0], cell / n[0] % n[1], cell / (n[0] * n[1])];
            let at = |axis: usize, step: usize| {
                let (low, high) = (breaks[axis][index[axis]], breaks[axis][index[axis] + 1]);
                low + (high - low) * 0.5 * step as f64
            };
            let mut brick = [0; NODES];
            for (node, slot) in brick.iter_mut().enumerate() {
                *slot = self.node(place(at(0, node % 3), at(1, node / 3 % 3), at(2, node / 9)));
            }
            self.skin(&brick, index, n, skins);
            self.bricks.push(brick);
        }
    }

    fn skin(&mut self, brick: &[u32; NODES], index: [usize; 3], n: [usize; 3], skins: Skins) {
        for (side, skin) in skins.into_iter().enumerate() {
            let (axis, high) = (side / 2, side % 2 == 1);
            let outer = if high { index[axis] + 1 == n[axis] } else { index[axis] == 0 };
            let Some(skin) = skin.filter(|_| outer) else { continue };
            let stride = [1, 3, 9][axis];
            let (a, b) = [(3, 9), (1, 9), (1, 3)][axis];
            let start = if high { 2 * stride } else { 0 };
            let nodes = std::array::from_fn(|i| brick[start + i % 3 * a + i / 3 * b]);
            self.faces.push(Face { nodes, inside: self.nodes[brick[13] as usize], skin });
        }
    }

    /// The places of a brick's nodes.
    pub(crate) fn corners(&self, brick: &[u32; NODES]) -> [DVec3; NODES] {
        brick.map(|node| self.nodes[node as usize])
    }
}

/// `n` equal steps from 0 to 1.
pub(crate) fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// A box with its base at z = 0 and its middle on the z axis. `contact` is the outward normal of the touched side.
pub(crate) fn cuboid(size: DVec3, contact: DVec3, cells: [usize; 3]) -> Bricks {
    let mut skins = [Some(Skin::Free); 6];
    skins[4] = Some(Skin::Base);
    for (side, skin) in skins.iter_mut().enumerate() {
        let outward = [DVec3::X, DVec3::Y, DVec3::Z][side / 2] * if side % 2 == 1 { 1.0 } else { -1.0 };
        if outward.dot(contact) > 0.5 {
            *skin = Some(Skin::Contact);
        }
    }
    let mut mesh = Bricks::default();
    let [x, y, z] = cells.map(even);
    mesh.block([&x, &y, &z], skins, |u, v, w| DVec3::new((u - 0.5) * size.x, (v - 0.5) * size.y, w * size.z));
    mesh
}

/// How a quarter of a round body is cut: `rings` are breaks of the section's radius (0 to 1, the first is the edge of the
/// innermost patch of bricks), `layers` those of the height, `turns` the bricks over a right angle (even).
#[derive(Clone, Debug)]
pub(crate) struct RoundCut {
    pub rings: Vec<f64>,
    pub layers: Vec<f64>,
    pub turns: usize,
}

/// A quarter (x, y >= 0) of a round column: half section `meridian(s, w)` -> (radius, height), s and w in [0, 1], s = 0 the axis,
/// w = 0 the base. `top` is the skin at w = 1.
pub(crate) fn round_quarter(cut: &RoundCut, top: Skin, meridian: impl Fn(f64, f64) -> (f64, f64)) -> Bricks {
    bent_quarter(cut, top, meridian, |x, y| (x, y), |at| at)
}

/// The same, with the section's parameters bent by `bend` before and the places moved by `finish` after the half section is applied.
pub(crate) fn bent_quarter(
    cut: &RoundCut,
    top: Skin,
    meridian: impl Fn(f64, f64) -> (f64, f64),
    bend: impl Fn(f64, f64) -> (f64, f64),
    finish: impl Fn(DVec3) -> DVec3,
) -> Bricks {
    let mut mesh = Bricks { quarter: true, ..Bricks::default() };
    let first = cut.rings[0];
    let core = first * CORE;
    let place = |x: f64, y: f64, w: f64| {
        let (x, y) = bend(x, y);
        let s = x.hypot(y);
        let (radius, height) = meridian(s, w);
        let scale = if s > 0.0 { radius / s } else { 0.0 };
        finish(DVec3::new(x * scale, y * scale, height))
    };
    let half = even(cut.turns / 2);
    let ends = [Some(Skin::Base), Some(top)];
    mesh.block([&half, &half, &cut.layers], [None, None, None, None, ends[0], ends[1]], |u, v, w| place(core * u, core * v, w));
    let quarter_turn = std::f64::consts::FRAC_PI_4;
    let join = [0.0, 1.0];
    for upper in [false, true] {
        mesh.block([&join, &half, &cut.layers], [None, None, None, None, ends[0], ends[1]], |u, v, w| {
            let v = if upper { 1.0 - v } else { v };
            let angle = v * quarter_turn;
            let (x, y) = (core + (first * angle.cos() - core) * u, core * v + (first * angle.sin() - core * v) * u);
            if upper { place(y, x, w) } else { place(x, y, w) }
        });
    }
    let all = even(cut.turns);
    let span = 1.0 - first;
    let outward: Vec<f64> = cut.rings.iter().map(|ring| (ring - first) / span).collect();
    mesh.block([&outward, &all, &cut.layers], [None, Some(Skin::Free), None, None, ends[0], ends[1]], |u, v, w| {
        let (s, angle) = (first + span * u, 2.0 * quarter_turn * v);
        place(s * angle.cos(), s * angle.sin(), w)
    });
    mesh
}

/// Half the side of the innermost square of bricks, as a share of the first ring's radius.
const CORE: f64 = 0.58;
