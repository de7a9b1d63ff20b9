//! What lives for one tick only.

use glam::Vec3;
use heapless::Vec;

use crate::footprint::Seat;
use crate::green::drawn::Discs;
use crate::stage::ground::Ground;

/// A part that overlaps the object. Filled by stage 1.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Index of the part.
    pub part: u8,
    /// Centre of the patch, `p_wc` \[m\].
    pub centre: Vec3,
    /// The part's deepest point, `p_wq` \[m\].
    pub deepest: Vec3,
    /// Unit normal out of the object.
    pub normal: Vec3,
    /// Depth \[m\], above 0.
    pub depth: f32,
    /// Geometry the footprint needs.
    pub seat: Seat,
}

/// Workspace of one tick. `CONTACTS` bounds the parts found in contact; 16 covers every probe.
#[derive(Clone, Debug, Default)]
pub struct Scratch<const CONTACTS: usize> {
    pub(crate) contacts: Vec<Contact, CONTACTS>,
    /// Grounds of the patches, where patches move each other. Filled by stage 4.
    pub(crate) grounds: Vec<Ground, CONTACTS>,
    /// Discs of the patches, where they move each other in closed form. Filled by stage 4.
    pub(crate) discs: Discs,
}

impl<const CONTACTS: usize> Scratch<CONTACTS> {
    /// An empty workspace.
    pub const fn new() -> Self {
        Self { contacts: Vec::new(), grounds: Vec::new(), discs: Discs::new() }
    }

    /// Forgets the previous tick. In debug builds the old contacts are overwritten with NaN first, so that a stage that read
    /// them would be found at once.
    pub(crate) fn poison(&mut self) {
        if cfg!(debug_assertions) {
            for contact in &mut self.contacts {
                contact.centre = Vec3::NAN;
                contact.depth = f32::NAN;
            }
        }
        self.contacts.clear();
        self.grounds.clear();
    }
}
