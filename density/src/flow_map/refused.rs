//! Why there is no map, or none of a part of the cloud.

use std::fmt;

use crate::model::variable::{Place, Variable};

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// More accurate than the orbits.
    #[error(
        "a flow map cannot have an error of {error:e}: orbits themselves are known to {of_orbits:e} after {years} yr; it can have \
         {least:e} or more"
    )]
    TooFine {
        /// The error asked for.
        error: f64,
        /// The error of the orbits.
        of_orbits: f64,
        /// The last snapshot time \[yr\].
        years: f64,
        /// The least error that can be asked for.
        least: f64,
    },
    /// There is no angle.
    #[error(
        "a flow map by action and angle needs a planar model whose eccentricity grows wherever e sin(phi) > 0, and this is none: the \
         pull towards the Sun must outweigh all else that drives the eccentricity; a map by cells has no such limit"
    )]
    TurnsBack,
    /// The map is of too small a part of the cloud.
    #[error(
        "a flow map of {orbits} orbits covers {} % of the cloud only, less than the {} % for which it is worth its orbits; \
         {unresolved}", (1e3 * mapped).floor() / 10.0, 100.0 * least
    )]
    CoversTooLittle {
        /// Number of orbits taken.
        orbits: usize,
        /// Probability covered.
        mapped: f64,
        /// Least probability to be covered.
        least: f64,
        /// The most probable part without a map.
        unresolved: Box<Unresolved>,
    },
}

/// The most probable part of a cloud that has no map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unresolved {
    /// Its middle.
    pub place: Place,
    /// Its probability.
    pub share: f64,
    /// Why no polynomial does for it.
    pub cause: Cause,
    /// Why it was not halved.
    pub limit: Limit,
}

/// Why no polynomial does for a part of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// It is off by too much.
    Bends {
        /// The first snapshot time at which it is \[yr\].
        years: f64,
        /// The estimate of its error then; infinite if an orbit could not be followed.
        error: f64,
    },
    /// Some orbits first reach the critical value and others just miss it, or the time at which they do is no smooth
    /// function of the start.
    FirstPassages,
}

/// Why a part of a cloud was not halved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// There were no orbits left for its halves.
    Orbits,
    /// It holds too little of the cloud to be worth the orbits of its halves.
    Share,
    /// Halves would be no better.
    NoGain,
}

impl fmt::Display for Unresolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, share, cause, limit } = self;
        write!(f, "about {place} ")?;
        match cause {
            Cause::Bends { error, .. } if error.is_infinite() => write!(f, "some orbits cannot be followed")?,
            Cause::Bends { years, error } => write!(f, "the map is off by {error:.1e} at t = {years} yr")?,
            Cause::FirstPassages => write!(
                f,
                "some orbits first reach the critical value and others just miss it, so that the time of the first passage is no smooth \
                 function of the start"
            )?,
        }
        let percent = 100.0 * share;
        match limit {
            Limit::Orbits => {
                write!(f, ", and no orbits were left to halve that part, which holds {percent:.2} % of the cloud")
            }
            Limit::Share => {
                write!(
                    f,
                    ", and that part holds {percent:.2} % of the cloud, too few starts to be worth the orbits of its halves"
                )
            }
            Limit::NoGain => write!(f, ", and halving that part does not help"),
        }
    }
}

/// A place in six digits, as many as a reader needs to find it.
pub(super) fn rounded_place(variables: &'static [Variable], values: impl Fn(usize) -> f64) -> Place {
    Place::new(variables, |k| format!("{:.5e}", values(k)).parse().unwrap_or_else(|_| values(k)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::plane::VARIABLES;

    #[test]
    fn a_refusal_says_what_stood_in_the_way() {
        let place = rounded_place(&VARIABLES, |k| [2.0 / 3.0, 1.0 / 7.0][k]);
        let with = |cause, limit| {
            let unresolved = Box::new(Unresolved { place, share: 0.125, cause, limit });
            Refused::CoversTooLittle { orbits: 500, mapped: 0.25, least: 0.5, unresolved }.to_string()
        };
        let text = with(Cause::Bends { years: 2.0, error: 1.234e-5 }, Limit::Orbits);
        assert!(text.contains("covers 25 % of the cloud only, less than the 50 %"), "{text}");
        assert!(text.contains("about phi = 0.666667 rad, e = 0.142857 the map is off by 1.2e-5 at t = 2 yr"), "{text}");
        assert!(text.ends_with("no orbits were left to halve that part, which holds 12.50 % of the cloud"), "{text}");
        let text = with(Cause::FirstPassages, Limit::Share);
        assert!(text.contains("others just miss it") && text.contains("too few starts"), "{text}");
        assert!(with(Cause::Bends { years: 0.0, error: f64::INFINITY }, Limit::NoGain).contains("cannot be followed"));
    }
}
