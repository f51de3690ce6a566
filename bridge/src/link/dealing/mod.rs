//! The parts of a map, for which worker hosts ask.
//!
//! A worker asks home for parts, computes them, and brings what it has found with its next question. Until it asks
//! again for something to do it says from time to time that it is there. Every question may be asked again if its
//! answer is lost: home answers with the parts that the worker has not brought yet, and takes what comes twice once.
//!
//! - [`Dealing`]: home's end, which leaves to a [`Dealer`] who gets what
//! - [`Asker`]: a worker's end

mod home;
mod worker;

use serde::{Deserialize, Serialize};

pub use home::{Dealer, Dealing};
pub use worker::Asker;

/// Which part of a map: its place.
pub type Place = (usize, usize);

/// What a worker has found for a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Brought {
    /// The part.
    pub place: Place,
    /// Value and error of each of its points, as bits, so that none is lost; or what is wrong with one of them.
    pub found: Result<Vec<[u64; 2]>, String>,
}

/// What a worker says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {
    /// The number of the map in its plan.
    pub map_id: u64,
    /// The number with which the process has greeted home.
    pub process: u64,
    /// What it has found since home last answered.
    pub brought: Vec<Brought>,
    /// Whether it has nothing to do.
    pub is_free: bool,
    /// Whether these are its last words.
    pub is_leaving: bool,
}

/// What home answers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// What the worker is to compute.
    Compute(Vec<Place>),
    /// There is nothing to do at this moment, or nothing new for a worker that is not free.
    Nothing,
    /// The map is complete.
    Complete,
    /// The map cannot be completed, for this reason.
    Failed(String),
    /// Home was asked to stop; the map goes on when home is started again.
    Interrupted,
    /// Home does not know the process: home was started anew, or another process has taken the name of its host.
    Stranger,
}

/// Where home listens for questions.
const KEY: &str = "phasecloud/map";
