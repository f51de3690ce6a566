//! The propagators that come with phasecloud, by the name that a launch file gives as `node`.

use messages::content::DENSITY_HEAD;
use serde::{Deserialize, Deserializer, Serialize};

use crate::accuracy::AccuracySetting;
use crate::failure::Failure;
use crate::mc;
use crate::session::Session;
use crate::{dee, exact, gmm_ut, kit};

/// A setting that is not compatible with the others.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {problem}")]
pub struct Misfit {
    /// Its key.
    pub key: &'static str,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl Misfit {
    pub(crate) fn new(key: &'static str, problem: impl Into<String>) -> Self {
        Self { key, problem: problem.into() }
    }

    /// A setting that changes nothing, given what else is set.
    pub(crate) fn no_effect(key: &'static str, because: &str) -> Self {
        Self::new(key, format!("has no effect {because}; leave it out"))
    }
}

/// A built-in propagator with its settings.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum BuiltIn {
    /// `mc`.
    MonteCarlo(mc::Settings),
    /// `dee`.
    DensityEvolution(dee::Settings),
    /// `gmm-ut`.
    GaussianMixture(gmm_ut::Settings),
    /// `exact`.
    Exact(exact::Settings),
}

impl BuiltIn {
    /// The names.
    pub const NAMES: [&str; 4] = ["mc", "dee", "gmm-ut", "exact"];

    /// The propagator `name` with settings from a table; `None` if there is no such propagator.
    ///
    /// # Errors
    /// An unknown key or a value that is not allowed.
    pub fn from_settings<'de, D: Deserializer<'de>>(name: &str, table: D) -> Option<Result<Self, D::Error>> {
        Some(match name {
            "mc" => mc::Settings::deserialize(table).map(Self::MonteCarlo),
            "dee" => dee::Settings::deserialize(table).map(Self::DensityEvolution),
            "gmm-ut" => gmm_ut::Settings::deserialize(table).map(Self::GaussianMixture),
            "exact" => exact::Settings::deserialize(table).map(Self::Exact),
            _ => return None,
        })
    }

    /// The settings as lines `key = value`: all that have an effect, also those that were not set.
    ///
    /// # Errors
    /// If they cannot be written as TOML, which no settings here cause.
    pub fn to_lines(&self) -> Result<Vec<String>, toml::ser::Error> {
        Ok(toml::to_string(&self.resolved())?.lines().filter(|line| !line.is_empty()).map(Into::into).collect())
    }

    /// The same propagator with every setting that has an effect filled in, and without all other settings.
    fn resolved(&self) -> Self {
        match self {
            Self::DensityEvolution(settings) => Self::DensityEvolution(settings.resolved()),
            Self::GaussianMixture(settings) => Self::GaussianMixture(settings.resolved()),
            other => other.clone(),
        }
    }

    /// The setting of the accuracy of the propagation, if it is set.
    pub fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        match self {
            Self::MonteCarlo(settings) => &mut settings.accuracy,
            Self::DensityEvolution(settings) => &mut settings.accuracy,
            Self::GaussianMixture(settings) => &mut settings.accuracy,
            Self::Exact(settings) => &mut settings.accuracy,
        }
    }

    /// The most numbers that a snapshot can hold, with `bins` bins in `phi` and `e`.
    pub fn most_numbers(&self, bins: (usize, usize)) -> usize {
        match self {
            Self::MonteCarlo(settings) => settings.samples.saturating_mul(2),
            Self::DensityEvolution(settings) => settings.samples.saturating_mul(3),
            Self::GaussianMixture(settings) => settings.most_components().saturating_mul(6),
            Self::Exact(_) => bins.0.saturating_mul(bins.1).saturating_add(DENSITY_HEAD),
        }
    }

    /// Checks that settings that are each allowed are also compatible with one another.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    pub fn check(&self) -> Result<(), Misfit> {
        match self {
            Self::MonteCarlo(settings) => settings.check(),
            Self::DensityEvolution(settings) => settings.check(),
            Self::GaussianMixture(settings) => settings.check(),
            Self::Exact(settings) => settings.check(),
        }
    }

    /// Checks that its density can be computed on a grid with `bins` bins in `phi` and `e`.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    pub fn check_bins(&self, bins: (usize, usize)) -> Result<(), Misfit> {
        match self {
            Self::DensityEvolution(settings) => settings.check_bins(bins),
            _ => Ok(()),
        }
    }

    /// Checks that the case can run as `shards` shards.
    ///
    /// # Errors
    /// Why not.
    pub fn check_shards(&self, shards: u32) -> Result<(), String> {
        let rows = match self {
            Self::MonteCarlo(settings) => settings.samples,
            Self::DensityEvolution(settings) => settings.samples.isqrt().pow(2),
            Self::GaussianMixture(_) => {
                return Err(
                    "a mixture is planned, judged and read out as a whole, and neighbours share their sigma points; \
                    gmm-ut cannot be split"
                        .into(),
                );
            }
            Self::Exact(_) => {
                return Err(
                    "the exact density is refined where the whole of it needs that; exact cannot be split".into()
                );
            }
        };
        if rows >= shards as usize {
            return Ok(());
        }
        Err(format!("{shards} shards are too many for {rows} rows; every shard needs one"))
    }

    /// Checks that the samples of the case can be reduced before they are sent.
    ///
    /// # Errors
    /// Why not.
    pub fn check_reduce(&self) -> Result<(), String> {
        match self {
            Self::MonteCarlo(settings) if settings.replicates == 1 => Ok(()),
            Self::MonteCarlo(_) => {
                Err("the standard errors of replicates need the samples of each; leave out one".into())
            }
            _ => Err("only the samples of mc, or of a command, can be reduced".into()),
        }
    }

    /// Propagates scenario after scenario until asked to stop.
    ///
    /// # Errors
    /// [`Failure::Stopped`] is the normal end.
    pub fn serve(self, session: &Session) -> Result<(), Failure> {
        match self {
            Self::MonteCarlo(settings) => kit::serve(session, mc::MonteCarlo::new(settings)),
            Self::DensityEvolution(settings) => kit::serve(session, dee::DensityEvolution::new(settings)),
            Self::GaussianMixture(settings) => kit::serve(session, gmm_ut::GaussianMixture::new(settings)),
            Self::Exact(settings) => kit::serve(session, exact::ExactDensity::new(settings)),
        }
    }
}
