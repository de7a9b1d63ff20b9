//! The core behind its C interface: header and library agree, a haptic loop in C feels what the engine says bit for bit, bad pointers
//! and bad files are refused, a step allocates nothing.

use std::ffi::{CStr, c_char};
use std::fmt::Write as _;
use std::fs;
use std::mem::{offset_of, size_of};
use std::path::PathBuf;
use std::process::Command;
use std::ptr::{self, null, null_mut};
use std::sync::OnceLock;
use std::thread;

use haptor_capi::{
    ABI, BAD_POINTER, BAD_VALUE, CPose, CReport, CWrench, Core, NOT_FINITE, OK, REFUSED, haptor_abi, haptor_close, haptor_fit,
    haptor_open, haptor_place, haptor_rest, haptor_step, haptor_version, tier_number,
};
use haptor_contact::{Flags, Pose, Quat, Vec3};
use haptor_engine::{OwnedEngine, Scene};
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{DeviceHello, PROTOCOL_VERSION, SCHEMA_HASH, Tier};

use crate::alloc::counted;
use crate::cli::{self, build, root};
use crate::host_rig::ball_on_cube;
use crate::served;

/// The reference scene's file.
fn file() -> Vec<u8> {
    let mut file = vec![0; FILE_MAX];
    let n = encode_file(&ball_on_cube(), &mut file).unwrap();
    file.truncate(n);
    file
}

fn open(file: &[u8]) -> Result<*mut Core, String> {
    let mut text = [1 as c_char; 200];
    // SAFETY: file and text are as long as is said
    let core = unsafe { haptor_open(file.as_ptr().cast(), file.len(), text.as_mut_ptr(), text.len()) };
    if core.is_null() {
        // SAFETY: the library ends its text with a zero
        return Err(unsafe { CStr::from_ptr(text.as_ptr()) }.to_str().unwrap().to_owned());
    }
    Ok(core)
}

fn include() -> String {
    format!("-I{}", root().join("core/capi/include").display())
}

/// A program in C that prints what the header says: constants, then sizes and offsets.
fn header_in_c(constants: &[(&str, i64)], layout: &[(&str, usize)]) -> String {
    let mut source = String::from("#include <stdio.h>\n#include \"haptor.h\"\nint main(void)\n{\n");
    let names = constants.iter().map(|(name, _)| *name).chain(layout.iter().map(|(expression, _)| *expression));
    for name in names {
        writeln!(source, "    printf(\"%ld\\n\", (long)({name}));").unwrap();
    }
    source + "    return 0;\n}\n"
}

#[test]
fn the_header_says_what_the_library_does() {
    let flag = |name, flag: Flags| (name, i64::from(flag.0));
    let tier = |name, tier| (name, i64::from(tier_number(tier)));
    let constants = [
        ("HAPTOR_ABI", ABI.into()),
        ("HAPTOR_OK", OK.into()),
        ("HAPTOR_BAD_POINTER", BAD_POINTER.into()),
        ("HAPTOR_BAD_VALUE", BAD_VALUE.into()),
        ("HAPTOR_REFUSED", REFUSED.into()),
        ("HAPTOR_NOT_FINITE", NOT_FINITE.into()),
        flag("HAPTOR_FLAG_POSE_REFUSED", Flags::POSE_REFUSED),
        flag("HAPTOR_FLAG_POSE_JUMP", Flags::POSE_JUMP),
        flag("HAPTOR_FLAG_REGION_REFUSED", Flags::REGION_REFUSED),
        flag("HAPTOR_FLAG_FORCE_LIMITED", Flags::FORCE_LIMITED),
        flag("HAPTOR_FLAG_TORQUE_LIMITED", Flags::TORQUE_LIMITED),
        flag("HAPTOR_FLAG_FORCE_SLEWED", Flags::FORCE_SLEWED),
        flag("HAPTOR_FLAG_TORQUE_SLEWED", Flags::TORQUE_SLEWED),
        flag("HAPTOR_FLAG_RAMPING_IN", Flags::RAMPING_IN),
        flag("HAPTOR_FLAG_LENGTH_FLOORED", Flags::LENGTH_FLOORED),
        flag("HAPTOR_FLAG_LARGE_STRAIN", Flags::LARGE_STRAIN),
        flag("HAPTOR_FLAG_NON_FINITE", Flags::NON_FINITE),
        flag("HAPTOR_FLAG_TIER_LOWERED", Flags::TIER_LOWERED),
        flag("HAPTOR_FLAG_BIRTH_WAITS", Flags::BIRTH_WAITS),
        flag("HAPTOR_FLAG_PASSIVITY_DAMPED", Flags::PASSIVITY_DAMPED),
        flag("HAPTOR_FLAG_POSE_COARSE", Flags::POSE_COARSE),
        tier("HAPTOR_TIER_POINT", Tier::Point),
        tier("HAPTOR_TIER_PAPER", Tier::Paper),
        tier("HAPTOR_TIER_BRISTLE", Tier::Bristle),
        tier("HAPTOR_TIER_INFLUENCE", Tier::Influence),
        tier("HAPTOR_TIER_GREEN", Tier::Green),
    ];
    let layout = [
        ("sizeof(haptor_pose)", size_of::<CPose>()),
        ("offsetof(haptor_pose, rotation)", offset_of!(CPose, rotation)),
        ("sizeof(haptor_wrench)", size_of::<CWrench>()),
        ("offsetof(haptor_wrench, torque)", offset_of!(CWrench, torque)),
        ("sizeof(haptor_report)", size_of::<CReport>()),
        ("offsetof(haptor_report, contact_torque)", offset_of!(CReport, contact_torque)),
        ("offsetof(haptor_report, depth)", offset_of!(CReport, depth)),
        ("offsetof(haptor_report, radius)", offset_of!(CReport, radius)),
        ("offsetof(haptor_report, stick)", offset_of!(CReport, stick)),
        ("offsetof(haptor_report, flags)", offset_of!(CReport, flags)),
        ("offsetof(haptor_report, regions)", offset_of!(CReport, regions)),
        ("offsetof(haptor_report, tier)", offset_of!(CReport, tier)),
    ];
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("header.c");
    fs::write(&source, header_in_c(&constants, &layout)).unwrap();
    let program = cli::compiled(source.to_str().unwrap(), "c-abi-header", &[include()]);
    let said = String::from_utf8(Command::new(program).output().unwrap().stdout).unwrap();
    let said: Vec<i64> = said.lines().map(|line| line.parse().unwrap()).collect();
    let expected = constants.iter().map(|&(name, value)| (name, value)).chain(layout.iter().map(|&(name, n)| (name, n as i64)));
    for ((name, value), said) in expected.zip(&said) {
        assert_eq!(*said, value, "{name}");
    }
    assert_eq!(said.len(), constants.len() + layout.len());
    // every flag has a name in the header
    assert_eq!(constants.iter().filter(|(name, _)| name.starts_with("HAPTOR_FLAG_")).count(), Flags::NAMES.len());
}

/// The engine, fitted as the loop fits it.
fn fitted() -> OwnedEngine {
    let mut engine = Scene::read(&file()).and_then(|scene| scene.engine()).unwrap();
    let (name, serial) = ([0; 12], [0; 12]);
    let (version, schema) = (PROTOCOL_VERSION, SCHEMA_HASH);
    let (max_force_un, max_torque_unm) = (8_500_000, 188_000);
    engine.fit(&DeviceHello { version, schema, name, serial, max_force_un, max_torque_unm, watchdog_ticks: 0 }).unwrap();
    engine
}

fn pose([x, y, z, qw, qx, qy, qz]: [f32; 7]) -> (Vec3, Quat) {
    (Vec3::new(x, y, z), Quat::from_xyzw(qx, qy, qz, qw))
}

/// The loop of `core/capi/examples/loop.c`, linked with the library.
fn example() -> &'static PathBuf {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let library = build("haptor-capi").join("libhaptor_capi.a");
        let more = [include(), library.to_str().unwrap().to_owned(), "-lpthread".into(), "-lm".into(), "-ldl".into()];
        cli::compiled("core/capi/examples/loop.c", "c-abi-loop", &more)
    })
}

#[test]
fn a_haptic_loop_in_c_feels_what_the_engine_says_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(example()).args([&served::model(folder.path()), "2000"]).output().unwrap();
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && complained.contains("2000 ticks"), "{complained}");
    assert!(complained.contains(" 0 refused, 0 device errors"), "{complained}");
    let mut engine = fitted();
    let mut largest: f32 = 0.0;
    for (tick, line) in String::from_utf8(output.stdout).unwrap().lines().enumerate() {
        let bits = line.split(' ').map(|word| f32::from_bits(u32::from_str_radix(word, 16).unwrap()));
        let numbers: [f32; 14] = bits.collect::<Vec<_>>().try_into().unwrap();
        let (position, rotation) = pose(numbers[..7].try_into().unwrap());
        let felt = engine.step(&Pose::new(position, rotation), numbers[7]).wrench;
        let ours = [felt.force.to_array(), felt.torque.to_array()].concat();
        assert!(ours.iter().map(|x| x.to_bits()).eq(numbers[8..].iter().map(|x| x.to_bits())), "tick {tick}: {ours:?} {line}");
        largest = largest.max(felt.force.length());
        if tick == 1999 {
            assert!(felt.force.x < -1.0 && felt.torque.length() > 0.005, "it was turned and dragged: {felt:?}");
        }
    }
    assert!((5.0..8.5).contains(&largest), "{largest} N");
}

#[test]
fn the_loop_says_why_it_cannot_begin() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no.model");
    fs::write(&path, b"HAPTORM2 and then nothing").unwrap();
    let output = Command::new(example()).arg(&path).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("bake the scene anew"), "{output:?}");
}

#[test]
fn what_is_no_scene_is_refused_in_words_that_fit() {
    let good = file();
    let mut flipped = good.clone();
    flipped[40] ^= 1;
    for bad in [&b""[..], b"HAPTOR", &good[..good.len() - 1], &flipped] {
        let text = open(bad).unwrap_err();
        assert!(text.len() > 10, "{text}");
    }
    let mut text = [7 as c_char; 9];
    // SAFETY: null is refused; the text has the room that is said
    unsafe {
        assert!(haptor_open(null(), 100, text.as_mut_ptr(), 8).is_null());
        assert_eq!(CStr::from_ptr(text.as_ptr()).to_bytes().len(), 7);
        assert_eq!(text[8], 7, "nothing beyond the room is written");
        assert!(haptor_open(null(), 100, null_mut(), 8).is_null());
        assert!(haptor_open(null(), 100, text.as_mut_ptr(), 0).is_null());
        assert_eq!(CStr::from_ptr(haptor_version()).to_str(), Ok(env!("CARGO_PKG_VERSION")));
    }
    assert_eq!(haptor_abi(), ABI);
}

const PRESSED: CPose = CPose { position: [0.0, 0.0, -5.4e-3], rotation: [1.0, 0.0, 0.0, 0.0] };

#[test]
fn bad_pointers_and_values_are_refused_and_change_nothing() {
    let core = open(&file()).unwrap();
    let (mut wrench, mut report) = (CWrench { force: [9.0; 3], torque: [9.0; 3] }, CReport::default());
    let mut place = CPose::default();
    let askew = |pointer: *mut u8| pointer.wrapping_add(1);
    // SAFETY: what is not null and aligned points to things of this test, used by it alone
    unsafe {
        assert_eq!(haptor_step(null_mut(), &PRESSED, 1e-3, &mut wrench, &mut report), BAD_POINTER);
        assert_eq!(wrench, CWrench::default(), "a wrench that is not computed is none");
        assert_eq!(haptor_step(core, null(), 1e-3, &mut wrench, &mut report), BAD_POINTER);
        assert_eq!(haptor_step(core, &PRESSED, 1e-3, null_mut(), &mut report), BAD_POINTER);
        assert_eq!(haptor_step(askew(core.cast()).cast(), &PRESSED, 1e-3, &mut wrench, null_mut()), BAD_POINTER);
        let askew_report = askew(ptr::from_mut(&mut report).cast()).cast();
        assert_eq!(haptor_step(core, &PRESSED, 1e-3, &mut wrench, askew_report), BAD_POINTER);
        assert_eq!(report, CReport::default());
        for (force, torque) in [(0.0, 0.1), (-1.0, 0.1), (f32::NAN, 0.1), (8.0, f32::INFINITY)] {
            assert_eq!(haptor_fit(core, force, torque), BAD_VALUE, "{force} N, {torque} N m");
        }
        assert_eq!((haptor_fit(null_mut(), 1.0, 1.0), haptor_rest(null_mut())), (BAD_POINTER, BAD_POINTER));
        assert_eq!((haptor_place(null(), &mut place), haptor_place(core, null_mut())), (BAD_POINTER, BAD_POINTER));
        assert_eq!((haptor_place(core, &mut place), place.position), (OK, ball_on_cube().place.p_wd));
        let nowhere = CPose { position: [f32::NAN; 3], ..PRESSED };
        assert_eq!(haptor_step(core, &nowhere, 1e-3, &mut wrench, &mut report), REFUSED);
        assert_eq!(report.flags, Flags::POSE_REFUSED.0);
        haptor_close(core);
        haptor_close(null_mut());
    }
}

/// Presses for so many ticks; the last wrench and its report, and what was allocated.
fn press(core: *mut Core, ticks: u32) -> (CWrench, CReport, u64) {
    let (mut wrench, mut report, mut calls) = (CWrench::default(), CReport::default(), 0);
    for tick in 0..ticks {
        let mut pose = PRESSED;
        pose.position[2] *= (tick as f32 / 100.0).min(1.0);
        // SAFETY: everything is this function's own, the core the caller's
        let (answer, by_tick) = counted(|| unsafe { haptor_step(core, &pose, 1e-3, &mut wrench, &mut report) });
        assert_eq!(answer, OK, "tick {tick}: {report:?}");
        calls += by_tick;
    }
    (wrench, report, calls)
}

#[test]
fn a_step_allocates_nothing_and_rest_forgets_all_but_the_fit() {
    let core = open(&file()).unwrap();
    // SAFETY: the core is open and this test's own
    unsafe { assert_eq!(haptor_fit(core, 3.0, 0.1), OK) };
    let first = press(core, 300);
    assert_eq!(first.2, 0, "calls to the allocator");
    assert!((2.9..=3.0).contains(&first.0.force[2]), "limited to the device's 3 N: {first:?}");
    assert!(first.1.contact_force[2] > 5.0 && first.1.regions == 1 && first.1.tier == tier_number(Tier::Bristle), "{first:?}");
    // SAFETY: as above
    let (rested, calls) = counted(|| unsafe { haptor_rest(core) });
    assert_eq!((rested, calls), (OK, 0));
    assert_eq!(press(core, 300), first, "bit for bit the same again");
    // SAFETY: as above; nobody uses it any more
    unsafe { haptor_close(core) };
}

#[test]
fn a_handle_goes_from_thread_to_thread_on_the_stacks_that_the_header_asks_for() {
    let on_a_stack = |kib: usize, body: Box<dyn FnOnce() -> usize + Send>| {
        thread::Builder::new().stack_size(kib << 10).spawn(body).unwrap().join().unwrap()
    };
    // a debug build takes several times the stack of a release, which is what the header speaks of
    let (making, stepping) = if cfg!(debug_assertions) { (4096, 512) } else { (1024, 64) };
    let core = on_a_stack(making, Box::new(|| open(&file()).unwrap().expose_provenance()));
    let force = on_a_stack(stepping, Box::new(move || press(ptr::with_exposed_provenance_mut(core), 200).0.force[2] as usize));
    assert_eq!(force, 6);
    let rested = on_a_stack(
        making,
        Box::new(move || {
            // SAFETY: the core is open; no other thread uses it
            unsafe { haptor_rest(ptr::with_exposed_provenance_mut(core)) as usize }
        }),
    );
    assert_eq!(rested, OK as usize);
    // SAFETY: nobody uses it any more
    unsafe { haptor_close(ptr::with_exposed_provenance_mut(core)) };
}
