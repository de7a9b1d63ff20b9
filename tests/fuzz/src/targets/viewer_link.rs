//! Who looks on, both ends, and the host's pipe to a tool: frames, the uploads they make, and what they ask the core to be tuned to.

use std::time::{Duration, Instant};

use haptor_engine::{OwnedEngine, Scene};
use haptor_wire::{
    BakedScene, FromHost, FromViewer, ObjectShape, StreamDecoder, ToViewer, Wish, encode_stream, scene_file, stream_bound,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{mend, push};
use crate::uploads::{MODEL_BYTES_MAX, Uploads};

/// Tunings of one input that are tried on the core: each costs some ticks.
const TUNINGS: usize = 4;

/// Bytes as they are, and mended.
pub fn run(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), mend::stream(bytes)] {
        decoded::<ToViewer, { stream_bound(ToViewer::MAX_ENCODED) }>(&bytes);
        decoded::<FromHost, { stream_bound(FromHost::MAX_ENCODED) }>(&bytes);
        let said = decoded::<FromViewer, { stream_bound(FromViewer::MAX_ENCODED) }>(&bytes);
        uploads(&said);
        tunings(&said);
    }
}

/// Every message goes into a frame and comes back as the same bytes: some hold numbers that are none.
fn decoded<T: Serialize + DeserializeOwned, const N: usize>(bytes: &[u8]) -> Vec<T> {
    let (mut decoder, mut messages) = (StreamDecoder::<N>::new(), Vec::new());
    decoder.feed(bytes, |message| messages.push(message));
    for message in &messages {
        let frame = frame::<T, N>(message);
        let again: T = decoder_of::<T, N>(&frame).expect("a frame of ours is a message");
        assert_eq!(frame, self::frame::<T, N>(&again));
    }
    messages
}

fn frame<T: Serialize, const N: usize>(message: &T) -> Vec<u8> {
    let mut frame = vec![0; N];
    let length = encode_stream(message, &mut frame).expect("a message fits its bound");
    frame.truncate(length);
    frame
}

fn decoder_of<T: DeserializeOwned, const N: usize>(frame: &[u8]) -> Option<T> {
    let mut decoder = StreamDecoder::<N>::new();
    frame.iter().find_map(|&byte| decoder.push(byte))
}

/// The host keeps no more of an upload than was announced, nor than it allows.
fn uploads(said: &[FromViewer]) {
    let (mut uploads, mut now) = (Uploads::default(), Instant::now());
    for message in said {
        now += Duration::from_secs(1);
        let state = match message {
            FromViewer::UploadBegin(begin) => uploads.begin(begin, now),
            FromViewer::UploadChunk(chunk) => uploads.chunk(chunk, now),
            _ => continue,
        };
        assert!(state.have <= state.of && state.of as usize <= MODEL_BYTES_MAX, "{state:?}");
        if let Some(file) = uploads.whole(state.digest, now) {
            assert_eq!(file.len(), state.of as usize);
            // as the host's workshop does before it builds
            if scene_file::digest(&file) == state.digest {
                let _ = Scene::read(&file);
            }
        }
    }
}

/// What the core takes to be tuned to, it can run.
fn tunings(said: &[FromViewer]) {
    let wishes = said.iter().filter_map(|message| if let FromViewer::Ask(ask) = message { Some(ask.what) } else { None });
    let tunings = wishes.filter_map(|wish| if let Wish::Tune(tuning) = wish { Some(tuning) } else { None });
    let mut engine: Option<OwnedEngine> = None;
    for tuning in tunings.take(TUNINGS) {
        let engine = engine.get_or_insert_with(|| {
            let scene = Scene::new(&BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }));
            scene.and_then(|scene| scene.engine()).expect("a good scene")
        });
        if let Ok(tuned) = engine.get().tuned(&tuning) {
            engine.tune(&tuned);
            push::push(engine);
        }
    }
}
