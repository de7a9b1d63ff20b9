//! Files over the viewer link: models up, with resume; scenes and recordings down; and the points whose displacement one wants to see.

use std::io::Write;

use haptor_wire::viewer::{CHUNK_BYTES, POINTS_IN_MESSAGE};
use haptor_wire::{
    Denial, FromViewer, RestBegin, RestPoints, RestState, SceneBytes, ToViewer, UploadBegin, UploadChunk, UploadState, Wish,
    scene_file,
};

use super::connection::{ANSWER_WITHIN, Connection, answer};
use super::error::ClientError;

/// Bytes sent ahead of the host's word that it has them: enough for loopback and a room, and little is lost when the connection is.
const AHEAD: usize = 16 * CHUNK_BYTES;

impl Connection {
    /// Uploads a model, going on where an earlier upload ended; yields its digest. `progress` gets the bytes there are and will be.
    ///
    /// # Errors
    /// [`ClientError`]; after one that lost the connection, the same on a new connection goes on where this ended.
    pub fn upload(&mut self, file: &[u8], mut progress: impl FnMut(u64, u64)) -> Result<u64, ClientError> {
        let digest = scene_file::digest(file);
        let length = u32::try_from(file.len()).map_err(|_| ClientError::TooLong("the model"))?;
        self.say(&FromViewer::UploadBegin(UploadBegin { digest, length }))?;
        let mut have = self.uploaded(digest)?;
        let mut sent = have;
        while have < file.len() {
            while sent < file.len() && sent < have + AHEAD {
                let bytes = file[sent..].iter().copied().take(CHUNK_BYTES).collect::<heapless::Vec<_, CHUNK_BYTES>>();
                let offset = sent as u32;
                sent += bytes.len();
                self.say(&FromViewer::UploadChunk(UploadChunk { digest, offset, bytes }))?;
            }
            have = self.uploaded(digest)?;
            progress(have as u64, file.len() as u64);
        }
        Ok(digest)
    }

    fn uploaded(&mut self, digest: u64) -> Result<usize, ClientError> {
        let state: UploadState = self.until(ANSWER_WITHIN, |message| match message {
            ToViewer::Upload(state) if state.digest == digest => Some(*state),
            _ => None,
        })?;
        state.why.map_or(Ok(state.have as usize), |why| Err(ClientError::NotTaken(why)))
    }

    /// The file of the scene that runs.
    ///
    /// # Errors
    /// [`ClientError`]; [`ClientError::Damaged`] when the bytes do not have the digest they were announced with.
    pub fn download(&mut self) -> Result<Vec<u8>, ClientError> {
        let number = self.ask(Wish::Download)?;
        let mut file = Vec::new();
        let mut digest = None;
        loop {
            let piece = self.until(ANSWER_WITHIN, |message| match message {
                ToViewer::SceneBytes(piece) => Some(Ok(piece.clone())),
                message => answer(message, number).map(Err),
            })?;
            match piece {
                Ok(SceneBytes { digest: of, offset, bytes, .. }) => {
                    if offset as usize != file.len() {
                        return Err(ClientError::Damaged("the scene"));
                    }
                    digest = Some(of);
                    file.extend_from_slice(&bytes);
                }
                Err(done) => {
                    done?;
                    let good = digest == Some(scene_file::digest(&file));
                    return if good { Ok(file) } else { Err(ClientError::Damaged("the scene")) };
                }
            }
        }
    }

    /// Says which points of the undeformed surface \[m\], in world, are to be watched.
    ///
    /// # Errors
    /// [`ClientError`]; [`ClientError::NotTaken`] when there are too many, or one is not finite.
    pub fn watch_points(&mut self, points: &[[f32; 3]]) -> Result<(), ClientError> {
        let count = u32::try_from(points.len()).map_err(|_| ClientError::TooLong("the list of points"))?;
        self.say(&FromViewer::RestBegin(RestBegin { count }))?;
        self.rested()?;
        for (i, some) in points.chunks(POINTS_IN_MESSAGE).enumerate() {
            let offset = (i * POINTS_IN_MESSAGE) as u32;
            self.say(&FromViewer::RestPoints(RestPoints { offset, points: some.iter().copied().collect() }))?;
            self.rested()?;
        }
        Ok(())
    }

    fn rested(&mut self) -> Result<(), ClientError> {
        let state: RestState = self.until(ANSWER_WITHIN, |message| match message {
            ToViewer::Rest(state) => Some(*state),
            _ => None,
        })?;
        state.why.map_or(Ok(()), |why: Denial| Err(ClientError::NotTaken(why)))
    }

    /// Has the host send a recording into `out` until `enough` says so or the session ends; yields its bytes.
    ///
    /// # Errors
    /// [`ClientError`], or the reason why `out` does not take it.
    pub fn record(&mut self, out: &mut impl Write, mut enough: impl FnMut() -> bool) -> anyhow::Result<u64> {
        self.request(Wish::Record(true))?;
        let (mut bytes, mut ending) = (0, None);
        loop {
            if ending.is_none() && enough() {
                ending = Some(self.ask(Wish::Record(false))?);
            }
            match self.next(ANSWER_WITHIN / 100)? {
                Some(ToViewer::RecordBytes(piece)) => {
                    anyhow::ensure!(piece.offset == bytes, ClientError::Damaged("the recording"));
                    out.write_all(&piece.bytes)?;
                    bytes += piece.bytes.len() as u64;
                }
                Some(ToViewer::End(_)) => break,
                Some(message) => {
                    if let Some(done) = ending.and_then(|number| answer(&message, number)) {
                        done?;
                        break;
                    }
                }
                None => {}
            }
        }
        out.flush()?;
        Ok(bytes)
    }
}
