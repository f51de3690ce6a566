//! Reading a recording. A file is checked from end to end before any part of it is used.

use std::fs::File;
use std::io::{BufReader, Read};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use super::{FRAME_HEAD, MAGIC, RecordingError, frame, position, topic_lines};
use crate::topic::Topic;

/// Longest piece of a payload that is read at once \[bytes\].
const PIECE: usize = 1 << 20;
/// Longest header that a recording may have \[bytes\]; a longer one means that the file is damaged.
const LONGEST_HEADER: u64 = 1 << 16;
/// Longest text in which a recording describes itself \[bytes\]; a longer one means that the file is damaged.
const LONGEST_TEXT: u64 = 1 << 26;

/// A recording that has been checked and is complete.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: File,
    about: String,
    entries: Vec<Entry>,
}

/// Where a message lies in the file.
#[derive(Debug, Clone)]
pub struct Entry {
    topic: u32,
    header: Vec<u8>,
    payload_at: u64,
    payload_bytes: u64,
}

impl Entry {
    /// Where it lies in the file: messages lie there in the order in which they were written.
    pub fn position(&self) -> u64 {
        self.payload_at
    }

    /// How many items the message has.
    pub fn items<T: Topic>(&self) -> usize {
        self.payload_bytes as usize / size_of::<T::Item>()
    }
}

impl Recording {
    /// Opens a recording and checks all of it.
    ///
    /// # Errors
    /// [`RecordingError`] if it cannot be read, is not a recording, is of another version, truncated or damaged.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|e| RecordingError::new(path, 0, &e))?;
        let mut checker = Checker::begin(path, &file)?;
        let about = checker.text(frame::ABOUT)?;
        let topics = checker.text(frame::TOPICS)?;
        check_topics(&topics).map_err(|problem| RecordingError::new(path, checker.offset, &problem))?;
        let mut entries = Vec::new();
        loop {
            let start = checker.offset;
            let (head, entry, payload) = checker.frame()?;
            match head.kind {
                frame::MESSAGE => entries.push(checked(entry).map_err(|p| RecordingError::new(path, start, &p))?),
                frame::END if payload == (entries.len() as u64).to_le_bytes() => break,
                _ => return Err(RecordingError::new(path, start, &"no message belongs here: the file is damaged")),
            }
        }
        match checker.left() {
            0 => Ok(Self { path: path.into(), file, about, entries }),
            left => Err(RecordingError::new(path, checker.offset, &format!("{left} bytes follow the end mark"))),
        }
    }

    /// The description of what was recorded, as the recorder was given it.
    pub fn about(&self) -> &str {
        &self.about
    }

    /// The messages of a topic, in the order in which they arrived.
    pub fn messages<T: Topic>(&self) -> impl Iterator<Item = (T::Header, &Entry)> {
        let wanted = position::<T>();
        let of_topic = self.entries.iter().filter(move |entry| entry.topic == wanted);
        of_topic.map(|entry| (bytemuck::pod_read_unaligned(&entry.header), entry))
    }

    /// Reads the items of a message; `items` has [`Entry::items`] of them.
    ///
    /// # Errors
    /// [`RecordingError`] if the file can no longer be read, or `entry` belongs to another topic.
    pub fn read<T: Topic>(&self, entry: &Entry, items: &mut [T::Item]) -> Result<(), RecordingError> {
        let failed = |problem: &dyn std::fmt::Display| RecordingError::new(&self.path, entry.payload_at, problem);
        if entry.topic != position::<T>() || items.len() != entry.items::<T>() {
            return Err(failed(&"the message is of another topic or length"));
        }
        self.file.read_exact_at(bytemuck::cast_slice_mut(items), entry.payload_at).map_err(|e| failed(&e))
    }
}

/// Whether the recording's topics are those of this version.
fn check_topics(recorded: &str) -> Result<(), String> {
    let ours = topic_lines();
    match recorded.lines().zip(&ours).find(|(recorded, ours)| *recorded != ours.as_str()) {
        Some((recorded, ours)) => Err(format!("was recorded with \"{recorded}\", this version has \"{ours}\"")),
        None if recorded.lines().count() == ours.len() => Ok(()),
        None => Err(format!("was recorded with {} topics, this version has {}", recorded.lines().count(), ours.len())),
    }
}

/// Returns the message if its sizes fit its topic.
fn checked(entry: Entry) -> Result<Entry, String> {
    let lines = topic_lines();
    let Some(line) = lines.get(entry.topic as usize) else {
        return Err(format!("a message on topic {}, there are {}: the file is damaged", entry.topic, lines.len()));
    };
    let sizes: Vec<u64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    match sizes[..] {
        [header, item] if entry.header.len() as u64 == header && entry.payload_bytes.is_multiple_of(item) => Ok(entry),
        _ => Err(format!("a message of {} + {} bytes does not fit {line}", entry.header.len(), entry.payload_bytes)),
    }
}

/// The head of a frame.
struct FrameHead {
    kind: u32,
    topic: u32,
    header_bytes: u64,
    payload_bytes: u64,
}

/// Reads frame after frame.
struct Checker<'a> {
    path: &'a Path,
    file: BufReader<&'a File>,
    offset: u64,
    length: u64,
}

impl<'a> Checker<'a> {
    fn begin(path: &'a Path, file: &'a File) -> Result<Self, RecordingError> {
        let failed = |problem: &dyn std::fmt::Display| RecordingError::new(path, 0, problem);
        let length = file.metadata().map_err(|e| failed(&e))?.len();
        let mut checker = Self { path, file: BufReader::with_capacity(PIECE, file), offset: 0, length };
        if length < MAGIC.len() as u64 {
            return Err(failed(&"not a recording, or truncated in its first bytes"));
        }
        let mut magic = MAGIC;
        checker.take(&mut magic)?;
        let ([.., version], [.., own]) = (magic, MAGIC);
        if magic[..MAGIC.len() - 1] != MAGIC[..MAGIC.len() - 1] {
            return Err(failed(&"not a recording of phasecloud"));
        }
        if version != own {
            let (version, own) = (version.escape_ascii(), own.escape_ascii());
            return Err(failed(&format!("a recording of version {version}, this program reads version {own}")));
        }
        Ok(checker)
    }

    fn left(&self) -> u64 {
        self.length.saturating_sub(self.offset)
    }

    fn take(&mut self, bytes: &mut [u8]) -> Result<(), RecordingError> {
        self.file.read_exact(bytes).map_err(|e| RecordingError::new(self.path, self.offset, &e))?;
        self.offset += bytes.len() as u64;
        Ok(())
    }

    /// The text in the next frame, which must be of kind `kind`.
    fn text(&mut self, kind: u32) -> Result<String, RecordingError> {
        let start = self.offset;
        let (head, _, payload) = self.frame()?;
        let text = String::from_utf8(payload).ok().filter(|_| head.kind == kind);
        text.ok_or_else(|| RecordingError::new(self.path, start, &"what it says of itself is damaged"))
    }

    /// Checks the next frame and returns its head, the place of its payload, and the payload itself unless it is that
    /// of a message.
    fn frame(&mut self) -> Result<(FrameHead, Entry, Vec<u8>), RecordingError> {
        let start = self.offset;
        let wrong = |problem: &str| RecordingError::new(self.path, start, &problem);
        const TRUNCATED: &str = "the file ends here without an end mark: truncated, or the run did not end well";
        const DAMAGED: &str = "the checksum does not match: this part of the file is damaged";
        if self.left() == 0 {
            return Err(wrong(TRUNCATED));
        }
        if self.left() < FRAME_HEAD as u64 + 4 {
            return Err(wrong("the file ends in the middle of this frame: truncated"));
        }
        let mut checksum = crc32fast::Hasher::new();
        let mut bytes = [0; FRAME_HEAD];
        self.take(&mut bytes)?;
        checksum.update(&bytes);
        let head = FrameHead::parse(&bytes);
        let body = head.header_bytes.saturating_add(head.payload_bytes).saturating_add(4);
        let too_long =
            head.header_bytes > LONGEST_HEADER || (head.kind != frame::MESSAGE && head.payload_bytes > LONGEST_TEXT);
        if body > self.left() || too_long {
            let problem = format!(
                "this frame should have {} bytes, the file has {} more: truncated or damaged",
                body,
                self.left()
            );
            return Err(RecordingError::new(self.path, start, &problem));
        }
        let mut header = vec![0; head.header_bytes as usize];
        self.take(&mut header)?;
        checksum.update(&header);
        let payload_at = self.offset;
        let payload = self.payload(&head, &mut checksum)?;
        let mut expected = [0; 4];
        self.take(&mut expected)?;
        if checksum.finalize().to_le_bytes() != expected {
            return Err(RecordingError::new(self.path, start, &DAMAGED));
        }
        let entry = Entry { topic: head.topic, header, payload_at, payload_bytes: head.payload_bytes };
        Ok((head, entry, payload))
    }

    /// Reads a payload piece by piece, and keeps it unless it is that of a message.
    fn payload(&mut self, head: &FrameHead, checksum: &mut crc32fast::Hasher) -> Result<Vec<u8>, RecordingError> {
        let mut kept = Vec::new();
        let mut left = head.payload_bytes;
        let mut piece = vec![0; PIECE.min(left as usize)];
        while left > 0 {
            let length = (PIECE as u64).min(left) as usize;
            let bytes = &mut piece[..length];
            self.take(bytes)?;
            checksum.update(&piece[..length]);
            if head.kind != frame::MESSAGE {
                kept.extend_from_slice(&piece[..length]);
            }
            left -= length as u64;
        }
        Ok(kept)
    }
}

impl FrameHead {
    fn parse(bytes: &[u8; FRAME_HEAD]) -> Self {
        let [a, b, c, d, e, f, g, h, rest @ ..] = *bytes;
        let (lengths, _) = rest.as_chunks::<8>();
        let [header_bytes, payload_bytes] = [0, 1].map(|k| u64::from_le_bytes(lengths[k]));
        Self {
            kind: u32::from_le_bytes([a, b, c, d]),
            topic: u32::from_le_bytes([e, f, g, h]),
            header_bytes,
            payload_bytes,
        }
    }
}
