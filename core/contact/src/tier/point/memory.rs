//! Reversal memory of a hysteretic curve: Masing's rule with return points, in the plane (drag) or on a line (twist).
//!
//! The first entry is where the fresh curve starts; each reversal pushes a turning point, from which the curve runs with doubled
//! scale. A branch that comes back to where the previous one began forgets both (Madelung's rules); full slip forgets all. A shift
//! that turns leads its branch around faster than a rope would follow (equation 6.3c).

use glam::Vec2;

use crate::math::{min, root};
use crate::tier::point::curve::Curve;

/// Turning points kept. A hand turns back inside a shrinking loop two or three times; more are folded into the last.
const TURNS: usize = 8;

/// A place where a branch starts: seen from the present displacement, so that a thousand turns lose no digits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Turn {
    at: Vec2,
    load: Vec2,
}

impl Turn {
    /// The same seen after a displacement by `step`.
    fn after(self, step: Vec2) -> Self {
        Self { at: self.at - step, ..self }
    }
}

/// What the present load depends on.
#[derive(Clone, Copy, Debug)]
struct Branch {
    /// Turning points up to where it starts.
    len: usize,
    /// Where it starts.
    last: Turn,
    /// How far that is.
    distance: f32,
}

impl Branch {
    fn new(len: usize, last: Turn) -> Self {
        Self { len, last, distance: root(last.at.length_squared()) }
    }

    fn load(&self, curve: &Curve) -> Vec2 {
        let Self { len, last, distance } = *self;
        let scale = scale(len - 1);
        held(curve, last.load + along(-last.at, distance) * (scale * curve.load(min(distance / scale, curve.reach()))))
    }

    fn beyond_full_slip(self, curve: &Curve) -> Self {
        let reach = curve.reach();
        if self.distance >= scale(self.len - 1) * reach {
            Self::new(1, Turn { at: along(self.last.at, self.distance) * reach, load: Vec2::ZERO })
        } else {
            self
        }
    }
}

/// How much more than itself a sideways shift counts at full slip. A branch that followed like a rope as long as the full-slip shift would lag too far
/// behind a path that turns. Fitted on the turning paths of the reference.
const ASTRAY: f32 = 0.25;

/// What a shift by `step` counts more because it leads away from the line of a branch that began at `at`: a share of its part across that line, by the eighth
/// power of how far this is of `reach`, so that cycles which never slip fully repeat. Nothing on a line, to the bit (equation 6.3c).
fn astray(at: Vec2, step: Vec2, reach: f32) -> Vec2 {
    let way = at / reach;
    let (across, far2) = (way.perp_dot(step), way.length_squared());
    if across.is_finite() { way.perp() * (ASTRAY * across * (far2 * far2 * far2)) } else { Vec2::ZERO }
}

/// 1 on the fresh curve, 2 after a reversal.
fn scale(index: usize) -> f32 {
    if index == 0 { 1.0 } else { 2.0 }
}

/// The memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    turns: [Turn; TURNS],
    len: usize,
}

impl Default for Memory {
    fn default() -> Self {
        Self { turns: [Turn::default(); TURNS], len: 1 }
    }
}

impl Memory {
    fn last(&self) -> Turn {
        self.turns.get(self.len.wrapping_sub(1)).copied().unwrap_or_default()
    }

    /// The branch that the present displacement lies on.
    fn branch(&self) -> Branch {
        Branch::new(self.len, self.last())
    }

    /// Load at the present displacement.
    pub fn load(&self, curve: &Curve) -> Vec2 {
        self.branch().load(curve)
    }

    /// Load after a displacement by `step` from where it is `now`; follows nothing.
    pub fn load_after(&self, curve: &Curve, now: Vec2, step: Vec2) -> Vec2 {
        self.follow(curve, now, step).load(curve)
    }

    /// Loads of the turning points, oldest first: from nothing to the first, from each to the next, and from the last to the present load.
    pub fn turning_loads(&self) -> impl Iterator<Item = Vec2> {
        self.turns.iter().take(self.len).skip(1).map(|turn| turn.load)
    }

    /// Stuck share of the area.
    pub fn stick(&self, curve: &Curve) -> f32 {
        let c = curve.stick_radius(polar(self.last().at).0 / scale(self.len - 1));
        c * c
    }

    /// Follows a displacement by `step` from where the load is `now`; the load there.
    pub fn advance(&mut self, curve: &Curve, now: Vec2, step: Vec2) -> Vec2 {
        let branch = self.follow(curve, now, step);
        let Branch { len, last, .. } = branch;
        for turn in self.turns.iter_mut().take(len) {
            turn.at -= step;
        }
        self.len = len;
        if let Some(place) = self.turns.get_mut(len.wrapping_sub(1)) {
            *place = last;
        }
        branch.load(curve)
    }

    /// The branch after a displacement by `step`: a new one after a reversal, an older one once a loop is closed, the first beyond full slip.
    fn follow(&self, curve: &Curve, now: Vec2, step: Vec2) -> Branch {
        let last = self.last();
        let branch = if step.dot(last.at) > 0.0 {
            Branch::new((self.len + 1).min(TURNS), Turn { at: Vec2::ZERO - step, load: now })
        } else {
            Branch::new(self.len, last.after(step + astray(last.at, step, scale(self.len - 1) * curve.reach())))
        };
        self.close_loops(branch, step).beyond_full_slip(curve)
    }

    fn close_loops(&self, mut branch: Branch, step: Vec2) -> Branch {
        let kept = |len: usize| self.turns.get(len.wrapping_sub(1)).copied().unwrap_or_default().after(step);
        for _ in 0..TURNS {
            if branch.len < 2 {
                break;
            }
            let swing = polar(branch.last.at - kept(branch.len - 1).at).0;
            let mirrored = branch.len == 2;
            let needed = if mirrored { 2.0 * swing } else { swing };
            if branch.distance < needed {
                break;
            }
            let len = branch.len - if mirrored { 1 } else { 2 };
            branch = Branch::new(len, kept(len));
        }
        branch
    }

    /// Fits the memory to a new curve so that the present displacement carries `load`: when load or radius of the patch change, what was
    /// held stays held as far as friction allows, and turning points keep their loads.
    pub fn rebuild(&mut self, curve: &Curve, load: Vec2) {
        let (mut at, mut load) = (Vec2::ZERO, held(curve, load));
        for (index, turn) in self.turns.iter_mut().take(self.len).enumerate().rev() {
            let turn_load = if index == 0 { Vec2::ZERO } else { held(curve, turn.load) };
            let scale = scale(index);
            let (size, along) = polar(load - turn_load);
            // a patch that is only dragged, or only twisted, asks for no inverse of the other
            if size > 0.0 {
                at -= along * (scale * curve.inverse(size / scale));
            }
            *turn = Turn { at, load: turn_load };
            load = turn_load;
        }
    }
}

/// What friction can hold of `load`.
pub fn held(curve: &Curve, load: Vec2) -> Vec2 {
    if load.length_squared() > curve.full() * curve.full() { polar(load).1 * curve.full() } else { load }
}

/// Length and direction; the direction of nothing is nothing.
fn polar(v: Vec2) -> (f32, Vec2) {
    let length = root(v.length_squared());
    (length, along(v, length))
}

/// Direction of what is `length` long.
fn along(v: Vec2, length: f32) -> Vec2 {
    if length > 0.0 { v / length } else { Vec2::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVE: Curve = Curve::Drag { full: 1.0, reach: 1.0, fullness: 2.0 / 3.0 };

    fn walk(path: &[f32]) -> f32 {
        let mut memory = Memory::default();
        let (mut here, mut load) = (0.0, Vec2::ZERO);
        for &goal in path {
            (0..100).for_each(|_| load = memory.advance(&CURVE, load, Vec2::X * ((goal - here) / 100.0)));
            here = goal;
        }
        assert_eq!(load, memory.load(&CURVE));
        load.x
    }

    #[test]
    fn masing_loops_close() {
        let cattaneo = |s: f32| 1.0 - (1.0 - s) * root(1.0 - s);
        let cases: [(&[f32], f32); 6] = [
            (&[0.5], cattaneo(0.5)),
            (&[0.5, 0.0], cattaneo(0.5) - 2.0 * cattaneo(0.25)),
            (&[0.5, -0.5], -cattaneo(0.5)),
            (&[0.5, 0.2, 0.5], cattaneo(0.5)),
            (&[0.5, 0.2, 0.7], cattaneo(0.7)),
            (&[3.0, 1.0], -1.0),
        ];
        for (path, expected) in cases {
            let found = walk(path);
            assert!((found - expected).abs() < 1.0e-4, "{path:?}: {found} expected {expected}");
        }
    }

    #[test]
    fn a_rebuilt_memory_carries_the_same_load() {
        let mut memory = Memory::default();
        let load = memory.advance(&CURVE, Vec2::ZERO, Vec2::X * 0.6);
        let load = memory.advance(&CURVE, load, Vec2::X * -0.2);
        let larger = Curve::Drag { full: 1.5, reach: 1.3, fullness: 2.0 / 3.0 };
        memory.rebuild(&larger, load);
        assert!((memory.load(&larger) - load).length() < 1.0e-5);
    }
}
