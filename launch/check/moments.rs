//! The moments of all snapshots beside the right ones, and the worst of them in words.

use density::angle::nearest;

use super::amount::amount;

/// Tolerated error of a sample's moment, in standard errors: a larger one has a probability of 6e-7.
pub const SIGMAS: f64 = 5.0;
/// Tolerated error of other methods' moments, in standard deviations or products of them, and of probabilities.
pub const GENEROUS: f64 = 0.1;

/// In which unit an error is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Standard errors of samples.
    StandardErrors,
    /// Standard deviations of the cloud.
    Deviations,
}

impl Unit {
    /// How many are tolerated.
    fn tolerated(self) -> f64 {
        match self {
            Self::StandardErrors => SIGMAS,
            Self::Deviations => GENEROUS,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::StandardErrors => "standard errors",
            Self::Deviations => "standard deviations",
        }
    }
}

/// A moment beside the right one.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Which, and when.
    pub what: String,
    /// What the propagator says.
    pub seen: f64,
    /// What is right.
    pub right: f64,
    /// Whether it is an angle, whose error is measured the short way round.
    pub is_angle: bool,
    /// How far it may be off.
    pub allowed: f64,
    /// The unit in which its error is told.
    pub unit: Unit,
}

/// The worst moment of all snapshots.
#[derive(Debug, Default)]
pub struct Worst {
    good: Option<(f64, String)>,
    problems: Vec<String>,
    withheld: Vec<String>,
}

impl Worst {
    /// Why moments cannot be compared.
    pub fn trouble(&mut self, why: String) {
        self.problems.push(why);
    }

    /// Takes a moment, which may be withheld or not.
    pub fn take(&mut self, Compared { what, seen, right, is_angle, allowed, unit }: Compared, may_withhold: bool) {
        let difference = if is_angle { nearest(seen - right, 0.0) } else { seen - right };
        if seen.is_nan() && may_withhold {
            return self.withheld.push(what);
        }
        let error = (difference / allowed).abs();
        let in_units = || format!("{} {}", amount(error * unit.tolerated()), unit.name());
        let text = format!("{what} is {seen:.7}, exact {right:.7}");
        if error.is_nan() || error > 1.0 {
            let off = match () {
                () if error.is_finite() => format!("off by {}", in_units()),
                () if difference.is_nan() => "it is no number".into(),
                () => {
                    format!("off by {}, and the samples are all alike: no chance explains it", amount(difference.abs()))
                }
            };
            self.problems.push(format!("{text}: {off}"));
        } else if self.good.as_ref().is_none_or(|(worst, _)| error > *worst) {
            self.good = Some((error, format!("largest error {}: {text}", in_units())));
        }
    }

    /// What was found.
    ///
    /// # Errors
    /// What is wrong.
    pub fn verdict(self) -> Result<String, String> {
        match (self.problems.first(), self.good) {
            (Some(first), _) if self.problems.len() > 1 => {
                Err(format!("{first}; and {} more", self.problems.len() - 1))
            }
            (Some(first), _) => Err(first.clone()),
            (None, good) => {
                let withheld = match &self.withheld[..] {
                    [] => None,
                    all => Some(format!("withheld: {}", all.join(", "))),
                };
                Ok(good.map(|(_, text)| text).into_iter().chain(withheld).collect::<Vec<_>>().join("; "))
            }
        }
    }
}
