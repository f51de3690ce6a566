//! The processes that a run has besides its propagators, and what they share.

pub mod comparator;
pub mod estimation;
pub mod estimator;
pub(crate) mod gathering;
pub mod passage_rules;
pub mod player;
pub mod reading;
pub mod recorder;
pub mod request;
mod roomy;
pub mod roster;
pub mod scenario;
pub mod yardstick;
