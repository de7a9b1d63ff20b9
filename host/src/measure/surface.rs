//! The surface as a viewer watches it, after the last tick of a recording.

use std::hint::black_box;

use haptor_contact::Vec3;
use haptor_contact::surface::{Prepared, Surface};
use haptor_engine::Engine;
use haptor_wire::Deformation;

/// Side of the square that is watched \[m\].
const SIDE: f32 = 0.1;

/// Points, and the memory of an update.
#[derive(Debug)]
pub struct Seen {
    rest: Vec<Vec3>,
    moved: Vec<Vec3>,
    prepared: Box<Prepared>,
}

impl Seen {
    /// With room for so many points.
    #[must_use]
    pub fn new(points: u16) -> Self {
        let none = vec![Vec3::ZERO; points.into()];
        Self { rest: none.clone(), moved: none, prepared: Box::default() }
    }

    /// One update after the engine's last tick, of a square around the deepest contact, level, rows of as many points as there are rows.
    pub fn update(&mut self, engine: &Engine<'_>) {
        let deepest = engine.patches().iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        let (centre, per_row) = (deepest.map_or(Vec3::ZERO, haptor_contact::Patch::at_rest), self.rest.len().isqrt().max(1));
        for (k, point) in self.rest.iter_mut().enumerate() {
            let at = |k: usize| SIDE * ((k as f32 + 0.5) / per_row as f32 - 0.5);
            *point = centre + Vec3::new(at(k % per_row), at(k / per_row), 0.0);
        }
        let p_wp = engine.probe_pose().map_or(Vec3::ZERO, |pose| pose.position);
        let body = engine.tuning().deformation == Deformation::Full;
        let surface = engine.surface(engine.params(), engine.patches(), p_wp, body);
        measured_surface(&mut self.prepared, &surface, &self.rest, black_box(&mut self.moved));
    }
}

/// One update; the name is what an instruction counter is told.
#[inline(never)]
pub fn measured_surface(prepared: &mut Prepared, surface: &Surface<'_>, rest: &[Vec3], moved: &mut [Vec3]) {
    prepared.prepare(surface);
    prepared.update(rest, moved);
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_contact::{Pose, Quat};
    use haptor_engine::Scene;
    use haptor_wire::{BakedScene, ObjectShape};

    #[test]
    fn the_square_is_under_the_probe() {
        let scene = Scene::new(&BakedScene::ball_on(ObjectShape::HalfSpace)).unwrap();
        let mut engine = scene.engine().unwrap();
        let pose = Pose::new(Vec3::new(0.0, 0.0, 0.019), Quat::IDENTITY);
        engine.step(&pose, 1.0e-3);
        let mut seen = Seen::new(121);
        seen.update(engine.get());
        let deepest = seen.moved.iter().map(|u| -u.z).fold(0.0, f32::max);
        assert_eq!((seen.rest[60].x, seen.rest[60].y), (0.0, 0.0));
        assert!((deepest - 1.0e-3).abs() < 2.0e-5 && seen.moved[60].z == -deepest, "{deepest}");
    }
}
