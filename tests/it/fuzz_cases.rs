//! The inputs of the fuzzer that are kept, without the fuzzer: those that once found something, and the few that reach most of each reader. The readers of scene files
//! have theirs beside them, in the tool.

use std::fs;

use crate::cli::root;

#[path = "../fuzz/src/targets/mod.rs"]
mod targets;

/// Every reader has inputs here, and stands them.
#[test]
fn kept_inputs_find_nothing() {
    for target in targets::ALL {
        let mut count = 0;
        for folder in ["corpus", "cases"] {
            let folder = root().join("tests/fuzz").join(folder).join(target.name);
            let Ok(entries) = fs::read_dir(&folder) else { continue };
            for entry in entries {
                let path = entry.unwrap().path();
                println!("{}", path.display());
                targets::run(target.name, &fs::read(&path).unwrap());
                count += 1;
            }
        }
        assert!(count > 10, "{}: {count} inputs; `cargo xtask fuzz {} --keep` keeps some", target.name, target.name);
    }
}

/// What the inputs are for: behind the checksums is where most of each reader lies, so mending must let good bytes through and put damaged ones right.
#[test]
fn a_damaged_checksum_is_mended() {
    use haptor_wire::scene_file::{FILE_MAX, decode_file, encode_file};
    use haptor_wire::{BakedScene, HostHello, ObjectShape, StreamDecoder, ToDevice, encode_stream};

    let hello = ToDevice::Hello(HostHello { version: 1, schema: 2, period_us: 1000 });
    let mut frame = [0; 64];
    let length = encode_stream(&hello, &mut frame).unwrap();
    // the last byte of the checksum
    frame[length - 2] ^= 0x55;
    let mut decoder = StreamDecoder::<64>::new();
    let mut heard = Vec::new();
    decoder.feed(&targets::mend::stream(&frame[..length]), |message: ToDevice| heard.push(message));
    assert_eq!(heard, [hello]);

    let scene = BakedScene::ball_on(ObjectShape::HalfSpace);
    let mut file = [0; FILE_MAX];
    let length = encode_file(&scene, &mut file).unwrap();
    // of the version and of the checksum
    (file[8], file[length - 1]) = (file[8] ^ 0xFF, file[length - 1] ^ 0xFF);
    assert!(decode_file(&file[..length]).is_err());
    assert_eq!(decode_file(&targets::mend::baked_scene(&file[..length])), Ok(scene));
}

/// A table is longer than an input: from its beginning mending makes one that the core takes.
#[test]
fn a_table_is_made_whole() {
    use haptor_engine::Scene;
    use haptor_wire::scene_file::{FILE_MAX, encode_file};
    use haptor_wire::sections::GREEN;
    use haptor_wire::{BakedScene, ObjectShape, Tier};

    let scene = BakedScene { tier: Tier::Green, samples: 52, ..BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }) };
    let mut file = vec![0; FILE_MAX];
    let length = encode_file(&scene, &mut file).unwrap();
    file.truncate(length);
    let head = [0.0_f32, 0.0, 0.05, 0.05, 0.05, 0.05, 0.01, 9.0, 1.0e-5];
    file.extend(GREEN.to_le_bytes().into_iter().chain(36_u32.to_le_bytes()));
    file.extend(head.iter().flat_map(|number| number.to_le_bytes()).chain([0; 4]));
    assert!(Scene::read(&file).is_err());
    assert!(Scene::read(&targets::mend::baked_scene(&file)).is_ok());
}
