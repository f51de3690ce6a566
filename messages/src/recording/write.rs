//! Writing a recording.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{MAGIC, RecordingError, frame, position, topic_lines};
use crate::topic::Topic;

/// A recording in the making.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: BufWriter<File>,
    offset: u64,
    messages: u64,
}

/// Begins a recording in a new file; `about` says what is recorded.
///
/// # Errors
/// [`RecordingError`] if the file exists or cannot be written.
pub fn start(path: &Path, about: &str) -> Result<(), RecordingError> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let mut writer = Writer::on(path, file.map_err(|e| RecordingError::new(path, 0, &e))?, 0);
    writer.put(&MAGIC)?;
    writer.frame(frame::ABOUT, 0, &[], about.as_bytes())?;
    writer.frame(frame::TOPICS, 0, &[], topic_lines().join("\n").as_bytes())?;
    writer.file.flush().map_err(|e| RecordingError::new(path, writer.offset, &e))
}

impl Writer {
    /// Continues a recording that [`start`] has begun.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn append(path: &Path) -> Result<Self, RecordingError> {
        let failed = |e| RecordingError::new(path, 0, &e);
        let file = OpenOptions::new().append(true).open(path).map_err(failed)?;
        let offset = file.metadata().map_err(failed)?.len();
        Ok(Self::on(path, file, offset))
    }

    fn on(path: &Path, file: File, offset: u64) -> Self {
        Self { path: path.into(), file: BufWriter::with_capacity(1 << 20, file), offset, messages: 0 }
    }

    /// Adds a message.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn write<T: Topic>(&mut self, header: &T::Header, items: &[T::Item]) -> Result<(), RecordingError> {
        self.messages += 1;
        self.frame(frame::MESSAGE, position::<T>(), bytemuck::bytes_of(header), bytemuck::cast_slice(items))
    }

    /// Ends the recording; only then can it be read.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        let messages = self.messages;
        self.frame(frame::END, 0, &[], &messages.to_le_bytes())?;
        let written = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        written.map_err(|e| RecordingError::new(&self.path, self.offset, &e))
    }

    fn frame(&mut self, kind: u32, topic: u32, header: &[u8], payload: &[u8]) -> Result<(), RecordingError> {
        let mut checksum = crc32fast::Hasher::new();
        let (kind, topic) = (kind.to_le_bytes(), topic.to_le_bytes());
        let lengths = [header.len() as u64, payload.len() as u64].map(u64::to_le_bytes);
        for part in [&kind[..], &topic, &lengths[0], &lengths[1], header, payload] {
            checksum.update(part);
            self.put(part)?;
        }
        self.put(&checksum.finalize().to_le_bytes())
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), RecordingError> {
        self.file.write_all(bytes).map_err(|e| RecordingError::new(&self.path, self.offset, &e))?;
        self.offset += bytes.len() as u64;
        Ok(())
    }
}

// The headers and payloads are written as they lie in memory.
#[cfg(target_endian = "big")]
compile_error!("recordings are little-endian");
