//! What the past does to the present: loads that change under friction, births and deaths, holding still, rolling, legs that part and meet.

use std::f64::consts::PI;

use glam::{Quat, Vec3};
use haptor_contact::{Breakaway, Flags, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier, Wrench};

use crate::support::drive::{CUBE, Drive, RUBBER};
use crate::support::led::{Units, follow, worst};
use crate::support::tables::pressed_table;

/// Tiers whose memory is meant to be physical.
const TIERS: [Tier; 2] = [Tier::Point, Tier::Bristle];

fn tier(tier: Tier) -> ParamsSpec {
    ParamsSpec { tier, ..ParamsSpec::default() }
}

/// A ball of 20 mm on the half space, pressed `depth` \[m\] deep.
fn ball(depth: f32, params: &ParamsSpec) -> Drive {
    let mut drive = Drive::ball(ObjectShape::HalfSpace, 0.02, 0.5, params);
    drive.press_to(0.02, depth);
    drive
}

fn ball_at(position: Vec3, radius: f32) -> ProbePart<'static> {
    ProbePart { position, ..ProbePart::at_origin(ProbeShape::Sphere { radius }) }
}

/// Probe of balls of 20 mm at `places` \[m\], touching the half space when the origin is at 20 mm.
fn legs(places: &[Vec3], params: &ParamsSpec) -> Drive {
    let parts: Vec<ProbePart<'static>> = places.iter().map(|&place| ball_at(place, 0.02)).collect();
    let mut drive = Drive::new(ObjectShape::HalfSpace, RUBBER, &parts, params);
    drive.position = Vec3::Z * 0.021;
    drive
}

/// Force and torque that a wrench differs from another by, the torque over an arm of 20 mm \[N\].
fn difference(a: &Wrench, b: &Wrench) -> f32 {
    (a.force - b.force).length() + (a.torque - b.torque).length() / 0.02
}

/// Boundary elements under a load that changes: press deeper, lift, press again, with drag and twist held or moving.
#[test]
fn loads_that_change() {
    let table = pressed_table();
    assert_eq!((table.unconverged, table.histories.len()), (0, 14));
    for (choice, most) in [(Tier::Point, 0.45), (Tier::Bristle, 0.05)] {
        for path in &table.histories {
            let (drag, torque) = worst(&follow(path, &tier(choice), 2), &path.answer);
            println!("{choice:?} {}: {drag:.4} of mu P, {torque:.4} of T_max", path.name);
            assert!(drag < most && torque < most, "{choice:?} {}: {drag} of mu P, {torque} of T_max", path.name);
        }
    }
}

/// What lifting sheds does not come back when pressed again.
#[test]
fn torque_shed_does_not_come_back() {
    for choice in TIERS {
        for share in [0.1, 0.4, 0.7, 0.95] {
            let mut drive = ball(2.0e-3, &tier(choice));
            let full = Units::of(&drive, 0.75);
            let twisted = drive.turn(Vec3::Z, full.angle as f32, 50);
            drive.shift(Vec3::Z * (2.0e-3 * share), 50);
            let lifted = drive.held()[2];
            drive.shift(Vec3::Z * (-2.0e-3 * share), 50);
            let again = drive.held()[2];
            assert!(again <= lifted + 0.01 * full.torque, "{choice:?} {share}: {lifted} -> {again} N m");
            assert!(lifted <= -f64::from(twisted.torque.z) + 1e-6);
            // and what was kept is not lost either
            assert!(again >= lifted - 0.03 * full.torque, "{choice:?} {share}: {lifted} -> {again} N m");
        }
    }
}

/// A contact that has been left starts without friction when it is made again.
#[test]
fn a_new_contact_is_free() {
    for choice in [Tier::Point, Tier::Paper, Tier::Bristle] {
        let mut drive = ball(1.0e-3, &tier(choice));
        drive.turn(Vec3::Z, 0.3, 20);
        drive.shift(Vec3::X * 1.0e-3, 20);
        drive.shift(Vec3::Z * 2.0e-3, 20);
        assert_eq!(drive.contact(), Wrench::ZERO, "{choice:?}: lifted");
        assert_eq!((drive.report().regions, drive.report().depth, drive.report().stick), (0, 0.0, 1.0), "{choice:?}");
        let pressed = drive.press_to(0.02, 1.0e-3);
        assert_eq!((pressed.force.x, pressed.force.y, pressed.torque.z), (0.0, 0.0, 0.0), "{choice:?}: pressed again");
        assert!(pressed.force.z > 20.0);
    }
}

/// Holding still changes no bit: an hour at 1 kHz would be 3.6 million of these ticks.
#[test]
fn holding_still_changes_nothing() {
    for choice in [Tier::Point, Tier::Paper, Tier::Bristle] {
        let mut drive = ball(1.0e-3, &tier(choice));
        drive.turn(Vec3::new(0.1, 0.2, 0.97).normalize(), 0.07, 20);
        drive.shift(Vec3::new(1.0e-4, 5.0e-5, 0.0), 20);
        let (position, rotation) = (drive.position, drive.rotation);
        let held = drive.tick(position, rotation).contact;
        let ticks = if cfg!(debug_assertions) { 100_000 } else { 1_000_000 };
        for tick in 0..ticks {
            assert_eq!(drive.tick(position, rotation).contact, held, "{choice:?} tick {tick}");
        }
    }
}

/// The last bit of the pose flickers: nothing may creep.
#[test]
fn flicker_of_the_last_bit_does_not_creep() {
    for choice in [Tier::Point, Tier::Paper, Tier::Bristle] {
        let mut drive = ball(1.0e-3, &tier(choice));
        let units = Units::of(&drive, 0.75);
        drive.turn(Vec3::Z, (0.6 * units.angle) as f32, 20);
        drive.shift(Vec3::X * (0.3 * units.shift) as f32, 20);
        let (position, rotation) = (drive.position, drive.rotation);
        let flicker = |x: f32, up: bool| if up { f32::from_bits(x.to_bits() + 1) } else { x };
        let before = drive.held();
        let ticks = if cfg!(debug_assertions) { 20_000 } else { 100_000 };
        for tick in 0..ticks {
            let up = tick % 2 == 0;
            let at = Vec3::new(flicker(position.x, up), position.y, flicker(position.z, !up));
            let turned = Quat::from_xyzw(rotation.x, rotation.y, flicker(rotation.z, up), rotation.w);
            drive.tick(at, turned);
        }
        drive.tick(position, rotation);
        let after = drive.held();
        let off = (0..2).map(|k| (after[k] - before[k]).abs() / units.force).fold(0.0, f64::max);
        let twisted = (after[2] - before[2]).abs() / units.torque;
        println!("{choice:?}: crept {off:.5} of mu P, {twisted:.5} of T_max");
        assert!(off < 0.01 && twisted < 0.01, "{choice:?}: {off} of mu P, {twisted} of T_max");
    }
}

/// The same motion in four times as many ticks.
#[test]
fn finer_trajectories_agree() {
    let motion = |choice: Tier, per_second: usize| {
        let mut drive = ball(1.0e-3, &tier(choice));
        let units = Units::of(&drive, 0.75);
        let mut answers = Vec::new();
        for second in 0..40 {
            for part in 1..=per_second {
                let t = f64::from(second) + part as f64 / per_second as f64;
                let shift = Vec3::new((0.02 * t).sin() as f32, (0.3 * t).sin() as f32, 0.0) * (0.7 * units.shift) as f32;
                let depth = 1.0e-3 * (1.0 + 0.5 * (0.21 * t).sin());
                let turn = Quat::from_rotation_z((1.5 * (0.17 * t).sin() * units.angle) as f32);
                drive.tick(shift + Vec3::Z * (0.02 - depth) as f32, turn);
            }
            answers.push(units.share(drive.held()));
        }
        answers
    };
    for choice in TIERS {
        let (drag, torque) = worst(&motion(choice, 5), &motion(choice, 20));
        println!("{choice:?}, four times finer: {drag:.4} of mu P, {torque:.4} of T_max");
        // tier point wears torque by the length of a step, of which a slow hand's at 5 Hz is a twentieth of the full-slip shift
        let most = if choice == Tier::Point { 0.04 } else { 0.02 };
        assert!(torque < most && drag < most, "{choice:?}: {drag} of mu P, {torque} of T_max");
    }
}

/// Torque over a steady twist with mu_s = 1, mu_d = 0.5, in T_max of mu_d, per 1/50 of phi0.
fn breakaway(choice: Tier, how: Breakaway) -> Vec<f64> {
    let params = ParamsSpec { friction_static: Some(1.0), friction_dynamic: 0.5, breakaway: how, ..tier(choice) };
    let mut drive = ball(1.0e-3, &params);
    let units = Units::of(&drive, 0.5);
    (0..2000)
        .map(|_| {
            drive.turn(Vec3::Z, (0.02 * units.angle) as f32, 1);
            drive.held()[2] / units.torque
        })
        .collect()
}

/// Static friction above dynamic: both end at mu_d, and smooth breakaway changes torque by no more per tick than sticking does.
#[test]
fn static_friction_breaks_away() {
    for choice in TIERS {
        for how in [Breakaway::Sharp, Breakaway::Smooth] {
            let curve = breakaway(choice, how);
            let peak = curve.iter().copied().fold(0.0, f64::max);
            let last = *curve.last().unwrap();
            let jump = curve.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            println!("{choice:?} {how:?}: peak {peak:.3}, end {last:.3}, largest change in a tick {jump:.4}");
            assert!((last - 1.0).abs() < 0.03, "{choice:?} {how:?}: ends at {last}");
            assert!(peak <= 2.0 + 1e-3, "{choice:?} {how:?}: beyond static friction, {peak}");
            if how == Breakaway::Smooth {
                // the stuck slope is 0.02 per tick; doubled in release
                assert!(jump < 0.05, "{choice:?}: {jump} in a tick");
            }
        }
    }
}

/// A ball that rolls without slipping lays new material down: friction from an old drag leaves with the old contact.
#[test]
fn a_rolling_ball_renews_its_contact() {
    for choice in TIERS {
        let mut drive = ball(1.0e-3, &tier(choice));
        let units = Units::of(&drive, 0.75);
        drive.shift(Vec3::Y * (0.5 * units.shift) as f32, 50);
        let dragged = drive.held()[1];
        assert!(dragged > 0.4 * units.force);
        // the arm from the mass centre to where the contact is told to be
        let arm = drive.position.z - drive.state().patches()[0].centre.z;
        let (start, step) = (drive.position, 0.05 * drive.radius() as f32);
        for tick in 1..=200 {
            let way = step * tick as f32;
            drive.tick(start + Vec3::X * way, Quat::from_rotation_y(way / arm));
        }
        let held = drive.held();
        assert!(held[1].abs() < 0.02 * units.force, "{choice:?}: {} of {dragged} N left", held[1]);
        assert!(held[0].abs() < 0.05 * units.force, "{choice:?}: rolling drags, {} N", held[0]);
    }
}

/// Two balls 40 mm apart, twisted about the middle: each leg's drag times 20 mm plus its own torsion. The reference is each leg alone.
#[test]
fn two_legs_are_the_sum_of_their_legs() {
    for choice in TIERS {
        let mut both = legs(&[Vec3::X * -0.02, Vec3::X * 0.02], &tier(choice));
        let mut one = legs(&[Vec3::X * 0.02], &tier(choice));
        for drive in [&mut both, &mut one] {
            (0..3).for_each(|_| drop(Box::new(drive.press_to(0.02, 1.0e-3))));
        }
        assert_eq!((both.report().regions, both.load() > 1.7 * one.load()), (2, true));
        for step in 1..=40 {
            let (pair, single) = (both.turn(Vec3::Z, 4.0e-3, 4), one.turn(Vec3::Z, 4.0e-3, 4));
            let share = pair.torque.z / (2.0 * single.torque.z);
            // a leg presses a surface that the other has lowered by up to 7 % of the depth; legs that pull opposite ways hold each other's ground
            assert!((0.85..=1.02).contains(&share), "{choice:?} step {step}: {share} of two single legs");
            assert!(pair.force.x.abs() + pair.force.y.abs() < 1e-3 * single.force.length(), "{choice:?}: {pair:?}");
        }
        let full = 0.75 * both.load() * 0.02;
        let share = both.held()[2] / full;
        println!("{choice:?}: two legs at full slip hold {share:.4} of mu P times the offset");
        assert!((0.98..1.03).contains(&share), "{choice:?}: {share}");
    }
}

/// Legs that approach, overlap and coincide while pressed and dragged: a region's label merges, forces do not jump. The distance is the
/// probe's own, so that each distance is its own probe; neighbours must agree.
#[test]
fn merging_legs_are_continuous() {
    for choice in TIERS {
        let at = |distance: f32| {
            let mut drive = legs(&[Vec3::X * -0.5 * distance, Vec3::X * 0.5 * distance], &tier(choice));
            for _ in 0..3 {
                drive.press_to(0.02, 1.0e-3);
            }
            drive.shift(Vec3::Y * 2.0e-4, 10);
            drive.turn(Vec3::Z, 0.01, 10);
            (drive.contact(), drive.report().regions)
        };
        let (mut last, mut merges) = (at(0.024), 0);
        for step in 1..=240 {
            let next = at(0.024 - 1.0e-4 * step as f32);
            let change = difference(&next.0, &last.0);
            assert!(change < 0.03 * last.0.force.length(), "{choice:?} at {} mm: {last:?} {next:?}", 24.0 - 0.1 * step as f32);
            merges += usize::from(next.1 < last.1);
            last = next;
        }
        let alone = legs(&[Vec3::ZERO], &tier(choice)).press_to(0.02, 1.0e-3).force.z;
        println!("{choice:?}: coincident legs hold {:.4} of one", last.0.force.z / alone);
        assert_eq!(merges, 1, "{choice:?}: two regions become one, once");
        assert!((last.0.force.z / alone - 1.0).abs() < 0.05, "{choice:?}: {} of one ball", last.0.force.z / alone);
    }
}

/// A leg comes down beside another and leaves again: force and torque follow without a step, within a patch's own share.
#[test]
fn births_and_deaths_are_continuous() {
    for choice in TIERS {
        let mut drive = legs(&[Vec3::X * -0.02, Vec3::new(0.02, 0.0, 0.2e-3)], &tier(choice));
        let mut last = drive.press_to(0.02, 0.0);
        let mut seen = [false; 3];
        for tick in 1..=800 {
            let depth = 4.0e-4 * (1.0 - (PI as f32 * tick as f32 / 400.0).cos());
            let next = drive.press_to(0.02, depth);
            let change = difference(&next, &last);
            // 800 ticks for 0.8 mm there and back: at most 6.3 um, 45 kN/m
            assert!(change < 0.8, "{choice:?} tick {tick}: {last:?} {next:?}");
            seen[usize::from(drive.report().regions)] = true;
            last = next;
        }
        assert_eq!(seen, [true; 3], "{choice:?}: none, one and two regions were seen");
    }
}

/// A pair of balls 10 mm apart is tilted to and fro: the load passes from one to the other without a step.
#[test]
fn a_tilting_pair_is_continuous() {
    for choice in TIERS {
        let mut drive = legs(&[Vec3::X * -5.0e-3, Vec3::X * 5.0e-3], &tier(choice));
        // the legs' mutual dents settle over a few ticks that move
        for tick in 0..20 {
            drive.press_to(0.02, 1.0e-3 + 1.0e-8 * (tick % 2) as f32);
        }
        let mut last = drive.contact();
        for tick in 1..=4000 {
            let tilt = 0.3 * (2.0 * PI as f32 * tick as f32 / 2000.0).sin();
            let next = drive.tick(drive.position, Quat::from_rotation_y(tilt)).contact;
            let change = difference(&next, &last);
            // 0.95 mrad a tick moves each ball by 4.7 um along z and 20 um along the surface: 0.2 N and 0.4 N, and as much in torque
            assert!(change < 1.8, "{choice:?} tick {tick}, tilt {tilt}: {last:?} {next:?}");
            last = next;
        }
    }
}

/// Twelve balls on a ring of 60 mm, all pressed at once, each a little deeper than the one before.
fn ring_of_twelve(params: &ParamsSpec) -> Drive {
    let places: Vec<Vec3> = (0..12)
        .map(|i| {
            let angle = 2.0 * PI as f32 * i as f32 / 12.0;
            Vec3::new(0.06 * angle.cos(), 0.06 * angle.sin(), -2.0e-5 * i as f32)
        })
        .collect();
    legs(&places, params)
}

/// At most one birth a tick, deepest first; ten regions at once; the rest is refused and counted, and the deepest are kept.
#[test]
fn ten_regions_are_kept_and_the_rest_is_counted() {
    for choice in TIERS {
        let mut drive = ring_of_twelve(&tier(choice));
        for tick in 1..=10_u8 {
            drive.press_to(0.02, 1.0e-3);
            assert_eq!(drive.report().regions, tick, "{choice:?}: one birth a tick");
            let newest = drive.state().patches().iter().max_by_key(|patch| patch.born).unwrap();
            assert_eq!(newest.part, 12 - tick, "{choice:?}: the deepest first");
            assert!(drive.report().flags.contains(Flags::BIRTH_WAITS));
        }
        let before = drive.report().refused;
        for _ in 0..20 {
            drive.press_to(0.02, 1.0e-3);
            assert_eq!((drive.report().regions, drive.report().high_water), (10, 10), "{choice:?}");
            assert!(drive.report().flags.contains(Flags::REGION_REFUSED), "{choice:?}: {}", drive.report().flags);
        }
        assert!(drive.report().refused >= before + 20, "{choice:?}: {} refused", drive.report().refused);
        let mut parts: Vec<u8> = drive.state().patches().iter().map(|patch| patch.part).collect();
        parts.sort_unstable();
        assert_eq!(parts, (2..12).collect::<Vec<u8>>(), "{choice:?}: the deepest ten");
        let held = drive.contact();
        assert_eq!(drive.press_to(0.02, 1.0e-3), held, "{choice:?}: a refusal is not a flicker");
    }
}

/// With tilt the order of depth turns round: newcomers that are clearly deeper take the place of the shallowest, each in some hundred ticks.
#[test]
fn a_deeper_newcomer_takes_the_shallowest_place() {
    let mut drive = ring_of_twelve(&tier(Tier::Bristle));
    for _ in 0..12 {
        drive.press_to(0.02, 1.0e-3);
    }
    for tick in 1..=100 {
        drive.tick(drive.position, Quat::from_rotation_y(0.005 * tick as f32 / 100.0));
        assert!(drive.report().regions <= 10);
    }
    for _ in 0..1000 {
        drive.tick(drive.position, drive.rotation);
        assert!(drive.report().regions <= 10);
    }
    let depth_of = |part: usize| {
        let parts = drive.model().probe();
        0.02 - (drive.position + drive.rotation * parts[part].position).z
    };
    let kept: Vec<usize> = drive.state().patches().iter().map(|patch| usize::from(patch.part)).collect();
    let shallowest = kept.iter().map(|&part| depth_of(part)).fold(f32::INFINITY, f32::min);
    assert_eq!(kept.len(), 10);
    for part in (0..12).filter(|part| !kept.contains(part)) {
        assert!(depth_of(part) < 1.1 * shallowest, "{part} is outside: {} m against {shallowest} m", depth_of(part));
    }
    assert!(!kept.contains(&5) || !kept.contains(&6), "the tilt changed nothing: {kept:?}");
}

/// Parts closer than `region_distance` are one region, and neighbours chain.
#[test]
fn regions_are_counted_by_distance() {
    let row: Vec<Vec3> = (0..4).map(|i| Vec3::X * (0.012 * i as f32)).collect();
    // rims of balls pressed by 1 mm lie 12 mm - 2 x 4.4 mm = 3.1 mm apart
    for (distance, regions) in [(0.001, 4), (0.002, 4), (0.005, 1), (0.02, 1)] {
        let mut drive = legs(&row, &ParamsSpec { region_distance: distance, ..tier(Tier::Bristle) });
        for _ in 0..6 {
            drive.press_to(0.02, 1.0e-3);
        }
        let radii: Vec<f32> = drive.state().patches().iter().map(|patch| patch.footprint.radius).collect();
        assert_eq!(drive.report().regions, regions, "{distance} m: {radii:?}");
    }
}

/// A start inside the object is ramped in over the guard's time; the contact itself is told in full.
#[test]
fn a_start_inside_is_ramped() {
    let mut drive = Drive::ball(CUBE, 0.02, 0.5, &tier(Tier::Bristle));
    let first = {
        drive.press_to(0.12, 1.0e-4);
        drive.output.unwrap()
    };
    assert!(first.report.flags.contains(Flags::RAMPING_IN), "{}", first.report.flags);
    assert!(first.wrench.force.length() < 0.01 * first.contact.force.length());
    let mut last = 0.0;
    for tick in 2..=520 {
        drive.press_to(0.12, 1.0e-4);
        let output = drive.output.unwrap();
        let share = output.wrench.force.z / output.contact.force.z;
        assert!(share >= last && share <= 1.0 && share <= tick as f32 / 500.0 + 1e-3, "tick {tick}: {share}");
        last = share;
    }
    assert_eq!(last, 1.0);
    assert_eq!(drive.report().flags, Flags::CLEAN);
}
