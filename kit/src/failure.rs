//! Why a node ends before its work is done.

use messages::port::PortError;

/// Why a node ends before its work is done.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// It was asked to stop.
    #[error("stopped on request")]
    Stopped,
    /// The transport refused something.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A trajectory left the range in which the equations of motion hold.
    #[error(transparent)]
    LostOrbit(#[from] density::orbits::LostOrbit),
    /// A trajectory left the range in which the equations of motion hold, in a computation that follows states of its
    /// own.
    #[error(transparent)]
    Escaped(#[from] density::flow::Escaped),
    /// The exact density cannot be computed.
    #[error(transparent)]
    Exact(#[from] density::exact::Error),
    /// A mesh cannot be made.
    #[error(transparent)]
    Mesh(#[from] density::mesh::MeshError),
    /// First passages of a mesh cannot be computed.
    #[error(transparent)]
    MeshPassage(#[from] density::mesh::passage::PassageError),
    /// A mixture cannot be made.
    #[error(transparent)]
    Mixture(#[from] density::mixture::MixtureError),
    /// A file could not be written or read.
    #[error("{file}: {cause}")]
    File {
        /// Which file.
        file: String,
        /// What the operating system or the format says.
        cause: String,
    },
    /// Anything else, in words: what was wrong and what would be right.
    #[error("{0}")]
    Refused(String),
}

impl Failure {
    /// A propagator was asked for a snapshot before it had a scenario.
    pub fn no_scenario() -> Self {
        Self::Refused("a snapshot was asked for before any scenario".into())
    }

    /// A propagator that cannot be split was to take a shard.
    pub fn no_shards() -> Self {
        Self::Refused("this propagator cannot be split into shards; leave out `shards`".into())
    }

    /// The same failure with `what` in front of its text, unless it must end the node.
    pub fn about(self, what: &str) -> Self {
        match self {
            Self::Stopped | Self::Port(_) => self,
            other => Self::Refused(format!("{what}: {other}")),
        }
    }

    /// A failure of a file operation.
    pub fn file(file: &std::path::Path, cause: impl std::fmt::Display) -> Self {
        Self::File { file: file.display().to_string(), cause: cause.to_string() }
    }
}
