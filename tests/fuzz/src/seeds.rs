//! Inputs to begin with: good ones of this build, small, and one of each kind. What changes them into others is the fuzzer's business.

use std::path::Path;
use std::{fs, io};

use haptor_engine::Scene;
use haptor_engine::replay::{Follower, Step, answered};
use haptor_mesh::body::{Recipe, Role, make};
use haptor_mesh::kept::Keep;
use haptor_mesh::{BakeSpec, DVec3, Mesh, save_as, tessellate};
use haptor_wire::recording::{Chunk, FRAME_MAX};
use haptor_wire::scene_file::{FILE_MAX, digest, encode_file};
use haptor_wire::sections::{GREEN, GRID, SECTION_OVERHEAD, encode_section};
use haptor_wire::viewer::NO_TOKEN;
use haptor_wire::{
    Ask, BakedScene, Coupling, ForceLaw, FromViewer, HostHello, Mode, ObjectShape, PROTOCOL_VERSION, Passivity, Place, Record,
    RecordHeader, SCHEMA_HASH, Subscription, TOOL_SCHEMA_HASH, TickRecord, Tier, ToDevice, Tuning, UploadBegin, UploadChunk,
    ViewerHello, VirtualCoupling, Wish, WrenchCommand, encode_stream,
};
use serde::Serialize;

use crate::scene::grid_contents;

/// The ready scenes, as they stand in the repository.
const SCENES: [&str; 4] = [
    include_str!("../../scenes/compass.toml"),
    include_str!("../../scenes/cube-twist.toml"),
    include_str!("../../scenes/mallet.toml"),
    include_str!("../../scenes/ten-regions.toml"),
];

/// A mesh in a scene, as coarse as they are baked.
const COARSE: BakeSpec = BakeSpec { cells: 8, samples: 8 };

/// A tick a millisecond.
const RATE_HZ: u32 = 1000;

/// Ticks of a recording: into the object, a turn in it, and out.
const TICKS: u16 = 12;

/// Writes the inputs of every target into a folder of its name within `folder`.
///
/// # Errors
/// When a file cannot be written.
///
/// # Panics
/// When one is not good any more.
pub fn write(folder: &Path) -> io::Result<()> {
    let scenes = scenes();
    let files: Vec<_> = scenes.iter().map(baked).chain([with_mesh(), with_table()]).collect();
    let meshes = [tessellate::cuboid(DVec3::splat(0.02)), tessellate::cone(0.01, 0.02, 8)];
    let saved = |extension| meshes.iter().map(move |mesh| save_as(mesh, Some(extension)).expect("a known format")).collect();
    let all: [(&str, Vec<Vec<u8>>); 9] = [
        ("device_link", vec![host_s_words()]),
        ("viewer_link", vec![viewer_s_words()]),
        ("recording", files.iter().take(scenes.len()).map(|file| recording(file)).collect()),
        ("baked_scene", files),
        ("kept_body", meshes.iter().map(kept).collect()),
        ("mesh_stl", saved("stl")),
        ("mesh_obj", saved("obj")),
        ("mesh_ply", saved("ply")),
        ("scene_toml", SCENES.map(|scene| scene.as_bytes().to_vec()).to_vec()),
    ];
    for (name, inputs) in all {
        let folder = folder.join(name);
        fs::create_dir_all(&folder)?;
        for (index, input) in inputs.iter().enumerate() {
            fs::write(folder.join(format!("seed-{index}")), input)?;
        }
    }
    Ok(())
}

fn frames<T: Serialize>(messages: &[T]) -> Vec<u8> {
    let mut out = Vec::new();
    for message in messages {
        let mut frame = [0; FRAME_MAX];
        let length = encode_stream(message, &mut frame).expect("a message fits a frame");
        out.extend(&frame[..length]);
    }
    out
}

fn host_s_words() -> Vec<u8> {
    let push = WrenchCommand { seq: 1, echo: 1, force_un: [0, 0, 1_000_000], torque_unm: [0, 0, 10_000], hold_us: 2000 };
    let hello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };
    frames(&[
        ToDevice::Hello(hello),
        ToDevice::SetMode(Mode::Idle),
        ToDevice::SetMode(Mode::Force),
        ToDevice::Wrench(push),
        ToDevice::Wrench(WrenchCommand { seq: 2, ..push }),
    ])
}

fn viewer_s_words() -> Vec<u8> {
    let model = baked(&BakedScene::ball_on(ObjectShape::HalfSpace));
    let (length, name) = (model.len() as u32, digest(&model));
    let tuning = Tuning::of(&BakedScene::ball_on(ObjectShape::HalfSpace));
    let ask = |number, what| FromViewer::Ask(Ask { number, what });
    frames(&[
        FromViewer::Hello(ViewerHello::new(NO_TOKEN)),
        FromViewer::Subscribe(Subscription { every: 10, surface: 1, statistics_ms: 500 }),
        FromViewer::UploadBegin(UploadBegin { digest: name, length }),
        FromViewer::UploadChunk(UploadChunk { digest: name, offset: 0, bytes: model.iter().copied().collect() }),
        ask(1, Wish::Activate(name)),
        ask(2, Wish::Tune(tuning)),
        FromViewer::Ping(3),
    ])
}

/// Every shape, tier and optional part of a scene once.
fn scenes() -> Vec<BakedScene> {
    let edges = [0.1, 0.08, 0.06];
    let on = |object, tier| BakedScene { tier, ..BakedScene::ball_on(object) };
    let table = ForceLaw::Table { step: 1.0e-4, force: std::array::from_fn(|i| i as f32) };
    let passivity = Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1.0e-6, reserve: 0.1, delay_ticks: 2 };
    let mut pulled = BakedScene { samples: 52, ..on(ObjectShape::Ellipsoid { semi_axes: edges }, Tier::Influence) };
    pulled.coupling =
        Coupling::Virtual(VirtualCoupling { translational_stiffness: Some(500.0), ..VirtualCoupling::DEVICE_S_OWN });
    pulled.guard.passivity = Some(passivity);
    vec![
        on(ObjectShape::HalfSpace, Tier::Point),
        BakedScene {
            force_law: ForceLaw::Cubic { k1: 1.0e3, k3: 2.0e9 },
            ..on(ObjectShape::Sphere { radius: 0.05 }, Tier::Paper)
        },
        BakedScene { force_law: table, ..on(ObjectShape::Box { size: edges }, Tier::Bristle) },
        pulled,
        BakedScene {
            gravity: true,
            work: Some(40_000),
            ..on(ObjectShape::Cylinder { radius: 0.05, height: 0.1 }, Tier::Bristle)
        },
    ]
}

/// A scene's file; the device stands where the ball hovers 5 mm above what is 0.1 m high.
fn baked(scene: &BakedScene) -> Vec<u8> {
    let scene = BakedScene { place: Place { p_wd: [0.0, 0.0, 0.125], ..scene.place }, ..*scene };
    let mut file = vec![0; FILE_MAX];
    let length = encode_file(&scene, &mut file).expect("a scene fits its file");
    file.truncate(length);
    file
}

/// A scene whose object is a mesh, with its grid behind it.
fn with_mesh() -> Vec<u8> {
    let mut file = baked(&BakedScene::ball_on(ObjectShape::Mesh { grid: 0 }));
    let recipe = Recipe { scale: 1.0, role: Role::Object, mend: false, bake: COARSE };
    let body = make(&tessellate::cuboid(DVec3::splat(0.1)), &recipe, &mut |_| {}).expect("a cube is a body");
    for part in &body.parts {
        file.extend(section(GRID, &grid_contents(&part.baked)));
    }
    file
}

/// A scene with the beginning of a body's table; mending makes it whole.
fn with_table() -> Vec<u8> {
    let scene = BakedScene { tier: Tier::Green, samples: 52, ..BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }) };
    // centre, half extents, radius of the discs, nodes along an edge; own moves by unit loads
    let head = [0.0, 0.0, 0.05, 0.05, 0.05, 0.05, 0.01, 3.0];
    let own: [f32; 16] = std::array::from_fn(|i| if i % 5 == 0 { 1.0e-5 } else { 0.0 });
    let contents: Vec<u8> = head.iter().chain(&own).flat_map(|number| number.to_le_bytes()).collect();
    [baked(&scene), section(GREEN, &contents)].concat()
}

fn section(kind: u32, contents: &[u8]) -> Vec<u8> {
    let mut section = vec![0; contents.len() + SECTION_OVERHEAD];
    encode_section(kind, contents, &mut section).expect("it fits a section");
    section
}

fn kept(mesh: &Mesh) -> Vec<u8> {
    let recipe = Recipe { scale: 1.0, role: Role::Probe, mend: false, bake: COARSE };
    make(mesh, &recipe, &mut |_| {}).expect("a simple solid is a body").to_contents()
}

/// A scene pressed, turned and left.
fn recording(scene: &[u8]) -> Vec<u8> {
    let header = RecordHeader {
        version: PROTOCOL_VERSION,
        schema: TOOL_SCHEMA_HASH,
        rate_hz: RATE_HZ,
        scene_digest: digest(scene),
        start_unix_s: 0,
        schema_bytes: 0,
        scene_bytes: scene.len() as u32,
    };
    let read = Scene::read(scene).expect("a good scene");
    let mut engine = read.engine().expect("a good scene");
    let mut follower = Follower::new(&header);
    let mut records = vec![Record::Header(header)];
    records.extend(Chunk::of(scene).map(Record::Scene));
    records.push(Record::Tuning(Tuning::of(read.setup().baked())));
    records.push(Record::Rest);
    records.extend((0..TICKS).map(|tick| Record::Tick(asked(tick))));
    for record in &mut records {
        let step = engine.with(|engine| follower.take(engine, record));
        if let (Record::Tick(asked), Step::Felt(felt, _)) = (&mut *record, step) {
            *asked = answered(asked, &felt);
        }
    }
    frames(&records)
}

/// The pose of a tick: down by a millimetre each, half way through turned, and up again.
fn asked(tick: u16) -> TickRecord {
    let depth = 1.0e-3 * f32::from(tick.min(TICKS - tick));
    let turned = if tick > TICKS / 2 { [0.8, 0.0, 0.0, 0.6] } else { [1.0, 0.0, 0.0, 0.0] };
    TickRecord {
        tick: tick.into(),
        t_us: 1000 * u64::from(tick),
        position: [0.0, 0.0, -depth],
        rotation: turned,
        ..TickRecord::default()
    }
}
