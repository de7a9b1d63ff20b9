//! A patch: the contact of one convex part with the object, and everything about it that survives a tick.

use glam::{Vec2, Vec3};

use crate::footprint::Footprint;
use crate::math::{direction, perpendicular};
use crate::model::Compliance;
use crate::tier::bristle::Grid;
use crate::tier::influence;
use crate::tier::paper::PaperMemory;
use crate::tier::point::PointMemory;

/// Rigid motion of the probe's material against the object at the patch, in the patch's frame c.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// Translation along the surface \[m\].
    pub drag: Vec2,
    /// Turn about the normal \[rad\].
    pub twist: f32,
}

impl Shift {
    /// No motion, to the bit.
    pub fn is_zero(&self) -> bool {
        self.drag == Vec2::ZERO && self.twist == 0.0
    }
}

impl core::ops::Sub for Shift {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { drag: self.drag - other.drag, twist: self.twist - other.twist }
    }
}

impl core::ops::Add for Shift {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { drag: self.drag + other.drag, twist: self.twist + other.twist }
    }
}

/// What the object's friction holds against: resultant of the tangential traction, in the sense of the shift that loaded it.
/// The probe feels its opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip {
    /// Tangential force in c \[N\].
    pub force: Vec2,
    /// Torque about the normal through the patch centre \[N m\].
    pub torque: f32,
    /// Stuck share of the contact area, 0..1.
    pub stick: f32,
}

/// Motion of one tick as a tier needs it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Turn of the probe since the previous tick, vector in world \[rad\].
    pub turn: Vec3,
    /// Shift since the previous tick.
    pub step: Shift,
    /// Distance the patch rolled over both surfaces \[m\]: material left at one side and entered free at the other.
    pub rolled: f32,
}

/// State of one patch.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Index of the probe's part.
    pub part: u8,
    /// Slot of the patch's samples in the state.
    pub slot: u8,
    /// Serial number of birth: order of birth among all patches of this state.
    pub born: u32,
    /// Index of the region, 0 = oldest; patches closer than `region_distance` share one.
    pub region: u8,
    /// Centre `p_wc` \[m\].
    pub centre: Vec3,
    /// Unit normal out of the object.
    pub normal: Vec3,
    /// First tangent of the frame c; the second is normal x first.
    pub tangent: Vec3,
    /// Geometric depth \[m\].
    pub depth: f32,
    /// Share of its load the patch carries: below 1 only while one region gives way to another at the limit.
    pub share: f32,
    /// Mean radius of curvature of the object at the patch \[m\].
    pub object_radius: f32,
    /// Radius, load, profile of this tick.
    pub footprint: Footprint,
    /// Those of the previous tick.
    pub previous: Footprint,
    /// Compliance of the body at the patch.
    pub body: Compliance,
    /// Shift since birth; what a tier counts on is `motion` and `pending`, which do not lose digits after a thousand turns.
    pub total: Shift,
    /// Shift that contact and body have not yet taken up: what the last tick's few passes left.
    pub pending: Shift,
    /// Motion of the ground under this patch by all grips, as of the last tick.
    pub ground: Shift,
    /// Motion of this tick.
    pub motion: Motion,
    /// Present grip.
    pub grip: Grip,
    /// Memory of tier `point`.
    pub point: PointMemory,
    /// Memory of tier `paper`.
    pub paper: PaperMemory,
    /// Sample grid of tier `bristle`; its samples lie in the state's slot.
    pub grid: Grid,
    /// Cell grid of tier `influence`; its cells lie in the same slot.
    pub cells: influence::Grid,
}

/// Squared length of a projected tangent below which a new one is taken: the normal then turned by more than 84 degrees in a tick.
const LEAST_KEPT: f32 = 0.01;

impl Patch {
    /// A newborn patch: no history, no grip.
    pub fn born(part: u8, slot: u8, serial: u32, centre: Vec3, normal: Vec3) -> Self {
        Self {
            part,
            slot,
            born: serial,
            region: 0,
            centre,
            normal,
            tangent: perpendicular(normal),
            depth: 0.0,
            share: 1.0,
            object_radius: f32::INFINITY,
            footprint: Footprint::NONE,
            previous: Footprint::NONE,
            body: Compliance::default(),
            total: Shift::default(),
            pending: Shift::default(),
            ground: Shift::default(),
            motion: Motion::default(),
            grip: Grip { stick: 1.0, ..Grip::default() },
            point: PointMemory::default(),
            paper: PaperMemory::default(),
            grid: Grid::default(),
            cells: influence::Grid::default(),
        }
    }

    /// Forgets how the grip came about, in every tier; the grip itself stays.
    pub fn forget_history(&mut self) {
        (self.pending, self.point, self.grid) = (Shift::default(), PointMemory::default(), Grid::default());
        self.cells = influence::Grid::default();
        self.paper = PaperMemory { anchor: self.total.drag, ..PaperMemory::default() };
    }

    /// Lets go of everything that friction held.
    pub fn forget_friction(&mut self) {
        self.forget_history();
        (self.grip, self.ground) = (Grip::default(), Shift::default());
    }

    /// Second tangent of c.
    pub fn second_tangent(&self) -> Vec3 {
        self.normal.cross(self.tangent)
    }

    /// The place of the patch on the undeformed surface \[m\], world: small strain counts lengths there.
    pub fn at_rest(&self) -> Vec3 {
        self.centre + self.normal * self.depth
    }

    /// A tangential vector of c in world.
    pub fn to_world(&self, v: Vec2) -> Vec3 {
        self.tangent * v.x + self.second_tangent() * v.y
    }

    /// Tangential part of a world vector in c.
    pub fn to_patch(&self, v: Vec3) -> Vec2 {
        Vec2::new(v.dot(self.tangent), v.dot(self.second_tangent()))
    }

    /// Moves the frame to a new normal without turning about it (parallel transport).
    pub fn carry_to(&mut self, centre: Vec3, normal: Vec3) {
        let kept = self.tangent - normal * self.tangent.dot(normal);
        // a normal that jumped onto the tangent leaves nothing to carry but rounding
        self.tangent = if kept.length_squared() > LEAST_KEPT { direction(kept, self.tangent) } else { perpendicular(normal) };
        self.centre = centre;
        self.normal = normal;
    }
}
