//! The eleventh region: the deepest ten are kept, the rest is refused and counted, and nothing jumps when one gives way to another.

use haptor_contact::{Flags, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Quat, Tier, Vec3};

use crate::support::drive::{Drive, RUBBER};

const TIERS: [Tier; 4] = [Tier::Point, Tier::Bristle, Tier::Influence, Tier::Paper];

/// Twelve tips in a row, 20 mm apart.
fn row(tier: Tier) -> Drive {
    let tip = ProbeShape::Sphere { radius: 0.01 };
    let at = |i: usize| Vec3::new(0.02 * (i as f32 - 5.5), 0.0, 0.0);
    let parts: Vec<_> = (0..12).map(|i| ProbePart { position: at(i), ..ProbePart::at_origin(tip) }).collect();
    let samples = if tier == Tier::Influence { 52 } else { 64 };
    Drive::new(ObjectShape::HalfSpace, RUBBER, &parts, &ParamsSpec { tier, samples, ..ParamsSpec::default() })
}

/// The row rocks: ends take turns at being the deepest, so that two regions of twelve are always outside.
#[test]
fn rocking_over_the_limit_has_no_step() {
    for tier in TIERS {
        let mut drive = row(tier);
        let pose = |t: f32| (Vec3::new(1.0e-4 * (3.0 * t).sin(), 0.0, 0.0092), Quat::from_rotation_y(0.004 * t.sin()));
        // one birth a tick
        (0..12).for_each(|_| _ = drive.tick(pose(0.5).0, pose(0.5).1));
        let (mut last, mut most, mut worst_force, mut worst_torque) = (drive.contact(), 0, 0.0_f32, 0.0_f32);
        let mut swapped = 0;
        for tick in 1..=4000 {
            let (position, rotation) = pose(0.5 + 0.003 * tick as f32);
            let before: Vec<u8> = drive.state().patches().iter().map(|patch| patch.part).collect();
            let out = drive.tick(position, rotation);
            swapped += usize::from(before != drive.state().patches().iter().map(|patch| patch.part).collect::<Vec<_>>());
            let told = Flags(out.report.flags.0 & (Flags::REGION_REFUSED | Flags::BIRTH_WAITS).0);
            assert!(told != Flags::CLEAN, "{tier:?} tick {tick}");
            most = most.max(out.report.regions);
            worst_force = worst_force.max((out.contact.force - last.force).length());
            worst_torque = worst_torque.max((out.contact.torque - last.torque).length());
            last = out.contact;
        }
        println!("{tier:?}: {swapped} swaps, largest step {worst_force} N, {worst_torque} N m of {} N", last.force.length());
        assert!(most == 10 && swapped >= 6, "{tier:?}: {most} regions, {swapped} swaps");
        // a 64th of a tip's 12 N changes place, at up to 0.11 m from the middle on either side, beside what the motion itself does
        if tier != Tier::Paper {
            assert!(worst_force < 0.35 && worst_torque < 0.05, "{tier:?}: {worst_force} N, {worst_torque} N m");
        }
    }
}

/// The ten deepest of twelve are those that carry.
#[test]
fn the_deepest_are_kept() {
    for tier in TIERS {
        let mut drive = row(tier);
        (0..16).for_each(|_| _ = drive.tick(Vec3::Z * 0.0092, Quat::from_rotation_y(0.003)));
        let mut kept: Vec<u8> = drive.state().patches().iter().map(|patch| patch.part).collect();
        kept.sort_unstable();
        assert_eq!(kept, (2..12).collect::<Vec<u8>>(), "{tier:?}");
        assert!(drive.report().refused > 0);
    }
}
