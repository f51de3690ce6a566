//! The Earth's shadow: a cylinder of one Earth radius behind the Earth, in which sunlight exerts no pressure.
//!
//! A satellite at `r` is in the shadow where `r·s < 0` and `|r|² - (r·s)² < R²`, with the direction to the Sun `s`.
//! Over a revolution the Sun then does work on the satellite, so that the semi-major axis becomes a variable of the
//! averaged orbit, and radiation pressure has no potential any more: the flow keeps no measure, and a density changes
//! at the rate of the flow's divergence ([`super::Model::divergence`]).
//!
//! | file | idea |
//! |---|---|
//! | [`edges`] | where an ellipse enters and leaves the shadow |
//! | [`averages`] | what sunlight does over a revolution of which a part is dark |
//! | [`averaged`] | the averaged model in space with the shadow |
//! | [`unaveraged`] | the unaveraged model with the shadow |

pub mod averaged;
pub mod averages;
pub mod edges;
pub mod unaveraged;

pub use averaged::ShadowedVectorial;
pub use unaveraged::ShadowedOsculating;
