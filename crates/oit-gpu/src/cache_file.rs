//! Compiled pipelines kept on disk between processes.

use std::path::{Path, PathBuf};
use std::{fs, io, process};

/// Marks the file and the version of its layout.
const MAGIC: &[u8; 8] = b"oitpipe1";

/// A file that holds a driver's pipeline cache. Drivers check the header of what they are given but
/// not all of its body, so a checksum stands before it: a damaged file is taken for none.
#[derive(Debug)]
pub(crate) struct CacheFile {
    path: PathBuf,
    /// Bytes of the cache last read or written: a driver's cache only grows, so that a size
    /// unchanged means nothing new.
    known_bytes: usize,
}

impl CacheFile {
    /// The file of this name in this directory.
    pub(crate) fn new(directory: &Path, name: &str) -> Self {
        Self { path: directory.join(name), known_bytes: 0 }
    }

    /// What was stored, if it is there and whole.
    pub(crate) fn load(&mut self) -> Option<Vec<u8>> {
        let mut file = fs::read(&self.path).ok()?;
        let stored: [u8; 8] = file.get(8..16)?.try_into().ok()?;
        if !file.starts_with(MAGIC) || u64::from_le_bytes(stored) != checksum(&file[16..]) {
            return None;
        }
        file.drain(..16);
        self.known_bytes = file.len();
        Some(file)
    }

    /// Whether a cache of so many bytes holds anything that the file does not.
    pub(crate) fn is_new(&self, bytes: usize) -> bool {
        bytes != self.known_bytes
    }

    /// Stores a cache whole or not at all. A cache that cannot be written costs only time, so
    /// failing is no error.
    pub(crate) fn store(&mut self, cache: &[u8]) {
        if self.write(cache).is_ok() {
            self.known_bytes = cache.len();
        }
    }

    fn write(&self, cache: &[u8]) -> io::Result<()> {
        if let Some(directory) = self.path.parent() {
            fs::create_dir_all(directory)?;
        }
        // Another process may be writing its own.
        let mine = self.path.with_extension(format!("{}.tmp", process::id()));
        let file = [MAGIC.as_slice(), &checksum(cache).to_le_bytes(), cache].concat();
        let written = fs::write(&mine, file).and_then(|()| fs::rename(&mine, &self.path));
        if written.is_err() {
            // Best effort: what is left behind is never read.
            drop(fs::remove_file(&mine));
        }
        written
    }
}

/// FNV-1a, 64 bits.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_was_stored_and_refuses_damage() {
        let directory = tempfile::tempdir().expect("a directory");
        let nested = directory.path().join("a/b");
        let mut file = CacheFile::new(&nested, "device.bin");
        assert_eq!(file.load(), None);
        file.store(b"pipelines");
        assert!(!file.is_new(9) && file.is_new(10));

        let mut again = CacheFile::new(&nested, "device.bin");
        assert_eq!(again.load().as_deref(), Some(b"pipelines".as_slice()));
        assert_eq!(fs::read_dir(&nested).expect("listed").count(), 1, "no temporary file is left");

        let path = nested.join("device.bin");
        let whole = fs::read(&path).expect("read");
        for damaged in [&whole[..whole.len() - 1], &whole[..7], b"", &[0; 40]] {
            fs::write(&path, damaged).expect("written");
            assert_eq!(again.load(), None);
        }
        let mut flipped = whole.clone();
        flipped[20] ^= 1;
        fs::write(&path, &flipped).expect("written");
        assert_eq!(again.load(), None);
        again.store(b"others");
        assert_eq!(again.load().as_deref(), Some(b"others".as_slice()));
    }

    #[test]
    fn a_directory_that_cannot_be_written_is_no_error() {
        let directory = tempfile::tempdir().expect("a directory");
        let blocked = directory.path().join("file");
        fs::write(&blocked, b"").expect("written");
        let mut file = CacheFile::new(&blocked, "device.bin");
        file.store(b"pipelines");
        assert_eq!(file.load(), None);
    }
}
