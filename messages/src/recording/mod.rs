//! A recording: every message of a run in one file, header and payload byte for byte.
//!
//! Numbers are little-endian. The file starts with 16 bytes, [`MAGIC`], whose last is the version, and goes on with
//! frames:
//!
//! | bytes | what |
//! |---|---|
//! | 4 | kind of the frame, see [`frame`] |
//! | 4 | of a message: its topic, as a position in the table of topics, from 0 |
//! | 8 | length of the header in bytes |
//! | 8 | length of the payload in bytes |
//! | .. | header |
//! | .. | payload |
//! | 4 | CRC-32 (IEEE) of the frame up to here |
//!
//! The first frame is [`frame::ABOUT`], the second [`frame::TOPICS`], the last [`frame::END`]. Messages of one
//! publisher stand in the order in which it sent them; messages of different publishers in the order in which they
//! arrived.

mod read;
mod write;

use std::fmt;
use std::path::{Path, PathBuf};

pub use read::{Entry, Recording};
pub use write::{Writer, start};

use crate::describe::Described;
use crate::payload::Item;
use crate::topic::{Topic, Visitor, for_each};

/// What the file starts with.
pub const MAGIC: [u8; 16] = *b"phasecloud tape1";

/// Kinds of frames.
pub mod frame {
    /// Payload: what was recorded, as the text that the recorder was given.
    pub const ABOUT: u32 = 1;
    /// Payload: text, one line per topic: its name, the type name of the header, the header's size in bytes, the type
    /// name of an item, the item's size in bytes.
    pub const TOPICS: u32 = 2;
    /// A message.
    pub const MESSAGE: u32 = 3;
    /// Payload: the number of messages, as 8 bytes.
    pub const END: u32 = 4;
}

/// Bytes of a frame before its header.
const FRAME_HEAD: usize = 24;

/// A recording that cannot be read or written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingError {
    /// The file.
    pub file: PathBuf,
    /// The byte at which the part that is wrong starts.
    pub offset: u64,
    /// What is wrong.
    pub problem: String,
}

impl RecordingError {
    fn new(file: &Path, offset: u64, problem: &dyn fmt::Display) -> Self {
        Self { file: file.into(), offset, problem: problem.to_string() }
    }
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: byte {}: {}", self.file.display(), self.offset, self.problem)
    }
}

impl std::error::Error for RecordingError {}

/// The table of topics, one line per topic.
fn topic_lines() -> [String; 8] {
    struct Line;
    impl Visitor for Line {
        type Out = String;
        fn visit<T: Topic>(&mut self) -> String {
            let (header, item) = (T::Header::TYPE_NAME, T::Item::NAME);
            format!("{} {header} {} {item} {}", T::NAME, size_of::<T::Header>(), size_of::<T::Item>())
        }
    }
    for_each(&mut Line)
}

/// The position of a topic in the table.
fn position<T: Topic>() -> u32 {
    struct Name;
    impl Visitor for Name {
        type Out = &'static str;
        fn visit<T: Topic>(&mut self) -> &'static str {
            T::NAME
        }
    }
    for_each(&mut Name).iter().position(|name| *name == T::NAME).unwrap_or(usize::MAX) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{SnapshotHeader, StatusHeader};
    use crate::text::pack;
    use crate::topic::{Snapshot, Status};

    fn example(folder: &Path) -> PathBuf {
        let path = folder.join("a.tape");
        start(&path, "about").unwrap();
        let mut writer = Writer::append(&path).unwrap();
        let header = SnapshotHeader { run_id: 7, label: pack("mc"), ..SnapshotHeader::default() };
        writer.write::<Snapshot>(&header, &[1.0, -2.5]).unwrap();
        writer.write::<Status>(&StatusHeader::default(), &[]).unwrap();
        writer.finish().unwrap();
        path
    }

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let recording = Recording::open(&example(folder.path())).unwrap();
        assert_eq!(recording.about(), "about");
        let (header, entry) = recording.messages::<Snapshot>().next().unwrap();
        assert_eq!((header.run_id, header.label), (7, pack("mc")));
        let mut items = vec![0.0; entry.items::<Snapshot>()];
        recording.read::<Snapshot>(entry, &mut items).unwrap();
        assert_eq!(items, [1.0, -2.5]);
        assert_eq!(recording.messages::<Status>().count(), 1);
    }

    #[test]
    fn a_file_cut_short_anywhere_is_refused_with_the_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = example(folder.path());
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let error = Recording::open(&path).unwrap_err();
            assert!(error.offset <= length as u64 && error.problem.contains("truncated"), "{length}: {error}");
        }
    }

    #[test]
    fn a_flipped_bit_anywhere_is_refused_with_the_frame() {
        let folder = tempfile::tempdir().unwrap();
        let path = example(folder.path());
        let whole = std::fs::read(&path).unwrap();
        for byte in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[byte] ^= 1 << (byte % 8);
            std::fs::write(&path, &damaged).unwrap();
            let error = Recording::open(&path).unwrap_err();
            assert!(error.offset <= byte as u64, "{byte}: {error}");
        }
    }

    #[test]
    fn other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b");
        assert!(Recording::open(&path).unwrap_err().problem.contains("No such file"));
        std::fs::write(&path, [b'x'; 100]).unwrap();
        assert!(Recording::open(&path).unwrap_err().problem.contains("not a recording"));
        let newer = [b"phasecloud tape2".as_slice(), &[0; 100]].concat();
        std::fs::write(&path, newer).unwrap();
        assert!(Recording::open(&path).unwrap_err().problem.contains("version 2"));
    }
}
