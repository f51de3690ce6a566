//! The protocol of a stream of messages: a reader asks, its sender answers with pieces.
//!
//! A message on the wire is its header followed by its items, byte for byte as in shared memory.

use bytemuck::{Pod, Zeroable};

/// Version of this protocol, of greetings and of the parts of maps; the headers of the messages have their versions in
/// their names.
pub const VERSION: u32 = 3;

/// Most bytes of a message that one piece holds: small enough that a slow link brings one within
/// [`super::pull::PATIENCE`].
pub const PIECE: usize = 512 << 10;

/// A reader's question: go on with message `sequence` at byte `offset`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Ask {
    /// A number that the reader has drawn. A new reader gets everything that is still kept.
    pub reader: u64,
    /// The epoch to which the numbers refer, see [`Piece::epoch`]; 0 at first.
    pub epoch: u64,
    /// Number of the message; by asking for it the reader says that it has all earlier ones.
    pub sequence: u64,
    /// Number of bytes of the message that the reader has.
    pub offset: u64,
}

/// What the bytes of an answer are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Piece {
    /// Drawn by the sender whenever it counts its messages anew: for a new reader, and when it has been restarted.
    pub epoch: u64,
    /// Number of the message, from 0.
    pub sequence: u64,
    /// Where in the message the bytes belong.
    pub offset: u64,
    /// Length of the whole message \[bytes\].
    pub total: u64,
    /// What the answer is, as the code of an [`Answer`].
    pub kind: u64,
}

impl Piece {
    /// What the answer is; `None` for a code that this version does not know.
    pub fn answer(&self) -> Option<Answer> {
        Answer::ALL.into_iter().find(|answer| answer.code() == self.kind)
    }
}

/// What an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// A piece of a message.
    Piece,
    /// There is no such message yet.
    Nothing,
    /// There will be none: the sender ends.
    End,
}

impl Answer {
    /// All of them.
    const ALL: [Self; 3] = [Self::Piece, Self::Nothing, Self::End];

    /// The code that stands for it on the wire.
    pub const fn code(self) -> u64 {
        match self {
            Self::Piece => 1,
            Self::Nothing => 2,
            Self::End => 3,
        }
    }
}

/// The name under which `host` sends the messages of `topic` in a run.
pub fn key(run_id: u64, host: &str, topic: &str) -> String {
    format!("phasecloud/{run_id:012x}/{host}/{}", topic.rsplit('/').next().unwrap_or(topic))
}

/// A value of plain numbers, read from bytes that another host has sent.
pub fn read<T: Pod>(bytes: &[u8]) -> Option<T> {
    bytemuck::try_pod_read_unaligned(bytes).ok()
}
