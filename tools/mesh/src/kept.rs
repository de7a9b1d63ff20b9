//! Results kept in files of the user's cache folder: computed once, found again ever after; versioned, checked, whole or not there at all.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | what kind of result ([`Kind::magic`]) |
//! | u32 | version of its layout, little endian |
//! | 32 | key: SHA-256 of everything the result depends on |
//! | any | the result |
//! | 32 | SHA-256 of everything before |
//!
//! A file is written beside its goal and then takes its name.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// A kind of result.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// What its files begin with.
    pub magic: [u8; 8],
    /// Version of its layout.
    pub format: u32,
    /// Most bytes of a file.
    pub max_bytes: usize,
    /// Its folder within the cache, and the end of its files' names.
    pub name: &'static str,
}

/// SHA-256 of everything a result depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub [u8; 32]);

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Magic, format, key.
const HEAD: usize = 44;
const DIGEST: usize = 32;
/// Bytes of a file around the result.
pub const OVERHEAD: usize = HEAD + DIGEST;

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    /// The system says why.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        error: std::io::Error,
    },
    /// Too long, too short or of another length than its contents say.
    #[error("a file of {found} bytes: {expected} expected")]
    Length {
        /// Bytes found.
        found: usize,
        /// Bytes that fit.
        expected: usize,
    },
    /// Another kind of file.
    #[error("it does not begin with {expected:?}")]
    Magic {
        /// What it should begin with.
        expected: String,
    },
    /// Another version.
    #[error("format {found}; this program reads {expected}")]
    Format {
        /// Version found.
        found: u32,
        /// The version that is read.
        expected: u32,
    },
    /// The bytes are not those that were written.
    #[error("damaged: the digest at its end does not fit; delete it")]
    Damaged,
    /// A result of other inputs.
    #[error("a result of other inputs: key {found}, asked for {wanted}")]
    OtherInputs {
        /// Key in the file.
        found: Key,
        /// Key of the inputs.
        wanted: Key,
    },
    /// A value that the core refuses.
    #[error(transparent)]
    Invalid(#[from] haptor_contact::Invalid),
}

impl Kind {
    /// The user's cache folder for this kind: `$XDG_CACHE_HOME/haptor/NAME`, or `~/.cache/haptor/NAME`; none without a home.
    pub fn folder(&self) -> Option<PathBuf> {
        use etcetera::BaseStrategy;
        let base = etcetera::choose_base_strategy().ok()?;
        Some(base.cache_dir().join("haptor").join(self.name))
    }

    /// The file of a key in `folder`.
    pub fn path(&self, folder: &Path, key: &Key) -> PathBuf {
        folder.join(format!("{key}.{}", self.name))
    }

    /// A result as the bytes of a file.
    pub fn seal(&self, key: &Key, contents: &[u8]) -> Vec<u8> {
        let mut bytes = [&self.magic, &self.format.to_le_bytes()[..], &key.0, contents].concat();
        let digest: [u8; DIGEST] = Sha256::digest(&bytes).into();
        bytes.extend(digest);
        bytes
    }

    /// The key and the result in the bytes of a file.
    ///
    /// # Errors
    /// [`KeptError`] names what is wrong; nothing damaged, cut or foreign is accepted.
    pub fn open<'b>(&self, bytes: &'b [u8]) -> Result<(Key, &'b [u8]), KeptError> {
        if !(OVERHEAD..=self.max_bytes).contains(&bytes.len()) {
            return Err(KeptError::Length { found: bytes.len(), expected: bytes.len().clamp(OVERHEAD, self.max_bytes) });
        }
        let (body, digest) = bytes.split_at(bytes.len() - DIGEST);
        if body[..8] != self.magic {
            let expected = String::from_utf8_lossy(&self.magic).trim_end_matches('\0').to_owned();
            return Err(KeptError::Magic { expected });
        }
        let found = u32::from_le_bytes([body[8], body[9], body[10], body[11]]);
        if found != self.format {
            return Err(KeptError::Format { found, expected: self.format });
        }
        if <[u8; DIGEST]>::from(Sha256::digest(body)) != *digest {
            return Err(KeptError::Damaged);
        }
        let mut key = [0; 32];
        key.copy_from_slice(&body[12..HEAD]);
        Ok((Key(key), &body[HEAD..]))
    }

    /// Writes a result whole or not at all; its folder is made.
    ///
    /// # Errors
    /// [`KeptError::Io`] with the path, [`KeptError::Length`] for a result too large to be read again.
    pub fn write(&self, path: &Path, key: &Key, contents: &[u8]) -> Result<(), KeptError> {
        if contents.len() > self.max_bytes - OVERHEAD {
            return Err(KeptError::Length { found: contents.len() + OVERHEAD, expected: self.max_bytes });
        }
        let io = |error| KeptError::Io { path: path.to_path_buf(), error };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|error| KeptError::Io { path: folder.to_path_buf(), error })?;
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(io)?;
        file.write_all(&self.seal(key, contents)).map_err(io)?;
        file.as_file().sync_all().map_err(io)?;
        file.persist(path).map_err(|error| io(error.error))?;
        Ok(())
    }

    /// The bytes of a file that holds the result of these inputs.
    ///
    /// # Errors
    /// [`KeptError`] names the file, or what is wrong with it.
    pub fn read(&self, path: &Path, wanted: &Key) -> Result<Vec<u8>, KeptError> {
        let io = |error| KeptError::Io { path: path.to_path_buf(), error };
        let length = std::fs::metadata(path).map_err(io)?.len();
        if length > self.max_bytes as u64 {
            return Err(KeptError::Length { found: usize::try_from(length).unwrap_or(usize::MAX), expected: self.max_bytes });
        }
        let bytes = std::fs::read(path).map_err(io)?;
        match self.open(&bytes)?.0 {
            found if found == *wanted => Ok(bytes),
            found => Err(KeptError::OtherInputs { found, wanted: *wanted }),
        }
    }
}

/// A result, and where it is from.
#[derive(Debug)]
pub struct Fetched<T> {
    /// The result.
    pub result: T,
    /// True when it was computed now.
    pub computed: bool,
    /// Why it could not be kept or why a kept one was not used; the result is good all the same.
    pub trouble: Option<KeptError>,
}

/// A result that can be kept.
pub trait Keep: Sized {
    /// Its kind.
    const KIND: Kind;

    /// As the contents of a file.
    fn to_contents(&self) -> Vec<u8>;

    /// From the contents of a file.
    ///
    /// # Errors
    /// [`KeptError`] names what is wrong.
    fn from_contents(contents: &[u8]) -> Result<Self, KeptError>;
}

/// The result of `key` from `folder`, computed and kept there if it is missing or damaged; `None` keeps nothing.
///
/// # Errors
/// Those of `compute`.
pub fn fetch<T: Keep, E>(key: &Key, folder: Option<&Path>, compute: impl FnOnce() -> Result<T, E>) -> Result<Fetched<T>, E> {
    let path = folder.map(|folder| T::KIND.path(folder, key));
    let mut trouble = None;
    if let Some(path) = path.as_deref().filter(|path| path.exists()) {
        match kept(path, key) {
            Ok(result) => return Ok(Fetched { result, computed: false, trouble }),
            Err(error) => trouble = Some(error),
        }
    }
    let result = compute()?;
    if let Some(path) = path
        && let Err(error) = T::KIND.write(&path, key, &result.to_contents())
    {
        trouble = Some(error);
    }
    Ok(Fetched { result, computed: true, trouble })
}

fn kept<T: Keep>(path: &Path, key: &Key) -> Result<T, KeptError> {
    let bytes = T::KIND.read(path, key)?;
    T::from_contents(T::KIND.open(&bytes)?.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    struct Word(Vec<u8>);

    impl Keep for Word {
        const KIND: Kind = Kind { magic: *b"haptwrd\0", format: 3, max_bytes: 1000, name: "word" };

        fn to_contents(&self) -> Vec<u8> {
            self.0.clone()
        }

        fn from_contents(contents: &[u8]) -> Result<Self, KeptError> {
            Ok(Self(contents.to_vec()))
        }
    }

    #[test]
    fn a_result_is_computed_once_and_again_when_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("a/b");
        let key = Key([7; 32]);
        let fetch = || fetch(&key, Some(&inner), || Ok::<_, ()>(Word(vec![1, 2, 3]))).unwrap();
        assert!(matches!(fetch(), Fetched { computed: true, trouble: None, .. }));
        assert!(matches!(fetch(), Fetched { computed: false, trouble: None, result } if result.0 == [1, 2, 3]));
        let path = Word::KIND.path(&inner, &key);
        let other = Word::KIND.seal(&Key([8; 32]), &[1, 2, 3]);
        for (bytes, word) in [(b"haptwrd".to_vec(), "7 bytes"), (other, "other inputs"), (vec![0; 2000], "2000 bytes")] {
            std::fs::write(&path, bytes).unwrap();
            let found = fetch();
            let told = found.trouble.map(|trouble| trouble.to_string()).unwrap_or_default();
            assert!(found.computed && told.contains(word), "{told}");
            assert!(!fetch().computed);
        }
        assert_eq!(std::fs::read_dir(&inner).unwrap().count(), 1);
    }

    #[test]
    fn a_result_too_large_is_used_but_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let found = fetch(&Key([0; 32]), Some(folder.path()), || Ok::<_, ()>(Word(vec![0; 1000]))).unwrap();
        assert!(found.computed && found.trouble.is_some());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn no_damaged_or_cut_file_is_opened() {
        let bytes = Word::KIND.seal(&Key([1; 32]), &[5; 100]);
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(Word::KIND.open(&damaged).is_err() && Word::KIND.open(&bytes[..at]).is_err(), "{at}");
        }
        assert!(Word::KIND.open(&[&bytes[..], &[0]].concat()).is_err());
        let newer = Kind { format: 4, ..Word::KIND };
        assert!(newer.open(&bytes).unwrap_err().to_string().contains("format 3; this program reads 4"));
    }
}
