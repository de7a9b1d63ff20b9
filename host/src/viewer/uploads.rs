//! Models that viewers sent, whole or in part. A part outlives the connection that brought it, so that an upload that was cut goes on where it ended.

use std::sync::Arc;
use std::time::{Duration, Instant};

use haptor_wire::{Denial, UploadBegin, UploadChunk, UploadState};

/// Bytes of a model at most: a table of 9.6 MB and a grid of 8.4 MB for the object and a few parts.
pub const MODEL_BYTES_MAX: usize = 64 << 20;

/// Bytes of all models at most, by the lengths announced: two of the largest.
const ALL_BYTES_MAX: usize = 2 * MODEL_BYTES_MAX;

/// Models at once at most.
const MODELS_MAX: usize = 8;

/// Time for which a model is kept that nobody touches, when another needs its room: longer than it takes to find a cable.
const KEEP: Duration = Duration::from_secs(120);

/// A model.
#[derive(Debug)]
struct Model {
    digest: u64,
    length: usize,
    bytes: Vec<u8>,
    /// All of it.
    whole: Option<Arc<[u8]>>,
    touched: Instant,
}

impl Model {
    fn state(&self, why: Option<Denial>) -> UploadState {
        let have = self.whole.as_ref().map_or(self.bytes.len(), |whole| whole.len());
        // both at most MODEL_BYTES_MAX
        UploadState { digest: self.digest, have: have as u32, of: self.length as u32, why }
    }

    fn finish(&mut self) {
        if self.bytes.len() == self.length {
            self.whole = Some(std::mem::take(&mut self.bytes).into());
        }
    }
}

/// The models there are.
#[derive(Debug, Default)]
pub struct Uploads {
    models: Vec<Model>,
}

impl Uploads {
    /// A model that is there already: the scene the host was started with.
    pub fn keep(&mut self, digest: u64, file: Arc<[u8]>, now: Instant) {
        self.models.push(Model { digest, length: file.len(), bytes: Vec::new(), whole: Some(file), touched: now });
    }

    /// A viewer wants to upload a model, or to go on with one.
    pub fn begin(&mut self, begin: &UploadBegin, now: Instant) -> UploadState {
        let (digest, length) = (begin.digest, begin.length as usize);
        let refused = |why| UploadState { digest, have: 0, of: 0, why: Some(why) };
        if length > MODEL_BYTES_MAX || length == 0 {
            return refused(Denial::TooLarge);
        }
        if let Some(model) = self.find(digest)
            && model.length == length
        {
            model.touched = now;
            return model.state(None);
        }
        // announced anew with another length: what there is cannot be a part of it
        self.models.retain(|model| model.digest != digest);
        if !self.make_room(length, now) {
            return refused(Denial::NoRoom);
        }
        let model = Model { digest, length, bytes: Vec::new(), whole: None, touched: now };
        let state = model.state(None);
        self.models.push(model);
        state
    }

    /// Bytes of a model begun.
    pub fn chunk(&mut self, chunk: &UploadChunk, now: Instant) -> UploadState {
        let Some(model) = self.find(chunk.digest) else {
            return UploadState { digest: chunk.digest, have: 0, of: 0, why: Some(Denial::NoModel) };
        };
        model.touched = now;
        let fits = model.whole.is_none()
            && chunk.offset as usize == model.bytes.len()
            && model.bytes.len() + chunk.bytes.len() <= model.length;
        if !fits {
            return model.state(Some(Denial::OutOfOrder));
        }
        model.bytes.extend_from_slice(&chunk.bytes);
        model.finish();
        model.state(None)
    }

    /// The whole model of this digest.
    pub fn whole(&mut self, digest: u64, now: Instant) -> Option<Arc<[u8]>> {
        let model = self.find(digest)?;
        model.touched = now;
        model.whole.clone()
    }

    /// Forgets a model: its bytes are not what they were announced as.
    pub fn forget(&mut self, digest: u64) {
        self.models.retain(|model| model.digest != digest);
    }

    fn find(&mut self, digest: u64) -> Option<&mut Model> {
        self.models.iter_mut().find(|model| model.digest == digest)
    }

    /// Makes room by forgetting what nobody has touched for long, the oldest first.
    fn make_room(&mut self, length: usize, now: Instant) -> bool {
        loop {
            let taken: usize = self.models.iter().map(|model| model.length).sum();
            if self.models.len() < MODELS_MAX && taken + length <= ALL_BYTES_MAX {
                return true;
            }
            let oldest = self.models.iter().enumerate().min_by_key(|(_, model)| model.touched);
            match oldest {
                Some((at, model)) if now.duration_since(model.touched) > KEEP => drop(self.models.remove(at)),
                _ => return false,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(digest: u64, offset: u32, bytes: &[u8]) -> UploadChunk {
        UploadChunk { digest, offset, bytes: heapless::Vec::from_slice(bytes).unwrap() }
    }

    #[test]
    fn an_upload_goes_on_where_it_was_cut() {
        let (mut uploads, now) = (Uploads::default(), Instant::now());
        let begin = UploadBegin { digest: 9, length: 5 };
        assert_eq!(uploads.begin(&begin, now).have, 0);
        assert_eq!(uploads.chunk(&chunk(9, 0, &[1, 2]), now).have, 2);
        assert_eq!(uploads.begin(&begin, now), UploadState { digest: 9, have: 2, of: 5, why: None });
        assert!(uploads.whole(9, now).is_none());
        // sent twice, ahead, too long, unknown
        assert_eq!(uploads.chunk(&chunk(9, 0, &[1, 2]), now).why, Some(Denial::OutOfOrder));
        assert_eq!(uploads.chunk(&chunk(9, 3, &[4]), now).why, Some(Denial::OutOfOrder));
        assert_eq!(uploads.chunk(&chunk(9, 2, &[3, 4, 5, 6]), now).why, Some(Denial::OutOfOrder));
        assert_eq!(uploads.chunk(&chunk(8, 0, &[1]), now).why, Some(Denial::NoModel));
        assert_eq!(uploads.chunk(&chunk(9, 2, &[3, 4, 5]), now).have, 5);
        assert_eq!(&*uploads.whole(9, now).unwrap(), [1, 2, 3, 4, 5]);
        assert_eq!(
            uploads.chunk(&chunk(9, 5, &[6]), now),
            UploadState { digest: 9, have: 5, of: 5, why: Some(Denial::OutOfOrder) }
        );
        // another length is another file
        assert_eq!(uploads.begin(&UploadBegin { digest: 9, length: 7 }, now).have, 0);
    }

    #[test]
    fn room_is_bounded_and_only_what_is_old_gives_way() {
        let (mut uploads, now) = (Uploads::default(), Instant::now());
        let most = MODEL_BYTES_MAX as u32;
        let begin = |digest, length| UploadBegin { digest, length };
        for (length, why) in [(0, Denial::TooLarge), (most + 1, Denial::TooLarge)] {
            assert_eq!(uploads.begin(&begin(0, length), now).why, Some(why));
        }
        assert_eq!(uploads.begin(&begin(1, most), now).why, None);
        assert_eq!(uploads.begin(&begin(2, most), now).why, None);
        assert_eq!(uploads.begin(&begin(3, 1), now).why, Some(Denial::NoRoom));
        let later = now + KEEP + Duration::from_secs(1);
        assert_eq!(uploads.begin(&begin(2, most), later).why, None, "touched");
        assert_eq!(uploads.begin(&begin(3, 1), later).why, None);
        assert_eq!(uploads.chunk(&chunk(1, 0, &[1]), later).why, Some(Denial::NoModel), "the oldest gave way");
        for digest in 10..10 + MODELS_MAX as u64 - 2 {
            assert_eq!(uploads.begin(&begin(digest, 1), later).why, None);
        }
        assert_eq!(uploads.begin(&begin(99, 1), later).why, Some(Denial::NoRoom), "too many");
    }
}
