//! The propagators that come with phasecloud, by the name that a launch file gives as `node`.
//!
//! A method is one file here with an `impl` of [`Method`] for its settings and one of [`kit::Propagator`], and one line
//! of the registry.
//!
//! | file | idea |
//! |---|---|
//! | `method` | what a method says of itself: [`Method`] |
//! | [`exact`], [`mc`], [`qmc`], [`dee`], [`gmm_ut`], [`flow_map`] | the methods |
//! | `sampling_settings`, [`accuracy`], `lattice_degree` | settings that several methods have |
//! | `choices` | what a sampling case may choose for itself: a simpler model, or some of the forces |
//! | `drawing` | the orbits that a sampling method draws, in the scenario's model or in a simpler one |
//! | `course` | orbits on their way through the snapshots |
//! | `mapped_samples`, `mapped_characteristics` | samples and characteristics that move by a flow map |
//! | `map_refusal` | a refused flow map in the words of the settings that help |
//! | `radiation` | what samples say of an uncertain radiation parameter |

pub mod accuracy;
mod choices;
mod course;
pub mod dee;
mod drawing;
pub mod exact;
pub mod flow_map;
pub mod gmm_ut;
mod lattice_degree;
mod map_refusal;
mod mapped_characteristics;
mod mapped_samples;
pub mod mc;
mod method;
pub mod qmc;
mod radiation;
mod sampling_settings;

use kit::assignment::Assignment;
use kit::shard::Shard;
use kit::{Failure, Propagator, Session};
use serde::{Deserialize, Deserializer, Serialize};

use accuracy::AccuracySetting;
pub use method::{Method, Misfit};

/// The registry: an enumeration of all methods with their settings.
macro_rules! methods {
    ($($(#[doc = $doc:literal])* $variant:ident($settings:ty)),+ $(,)?) => {
        /// A built-in propagator with its settings.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(untagged)]
        pub enum BuiltIn {
            $($(#[doc = $doc])* $variant($settings)),+
        }

        impl BuiltIn {
            /// The names of all methods.
            pub const NAMES: &'static [&'static str] = &[$(<$settings as Method>::NAME),+];

            /// The propagator `name` with settings from a table; `None` if there is no such propagator.
            ///
            /// # Errors
            /// An unknown key or a value that is not allowed.
            pub fn from_settings<'de, D: Deserializer<'de>>(name: &str, table: D) -> Option<Result<Self, D::Error>> {
                $(if name == <$settings as Method>::NAME {
                    return Some(<$settings>::deserialize(table).map(Self::$variant));
                })+
                None
            }

            /// The schema of the settings of the propagator `name`.
            pub fn schema(name: &str, generator: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
                $(if name == <$settings as Method>::NAME {
                    return Some(<$settings as schemars::JsonSchema>::json_schema(generator));
                })+
                None
            }

            /// The same with every setting that has an effect filled in, and no other.
            fn resolved(&self) -> Self {
                match self { $(Self::$variant(settings) => Self::$variant(settings.resolved())),+ }
            }

            /// See [`Method::accuracy_mut`].
            pub fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
                match self { $(Self::$variant(settings) => settings.accuracy_mut()),+ }
            }

            /// See [`Method::most_numbers`].
            pub fn most_numbers(&self, bins: (usize, usize), variables: usize) -> usize {
                match self { $(Self::$variant(settings) => settings.most_numbers(bins, variables)),+ }
            }

            /// See [`Method::check`].
            ///
            /// # Errors
            /// What is wrong and what would be right.
            pub fn check(&self) -> Result<(), Misfit> {
                match self { $(Self::$variant(settings) => Method::check(settings)),+ }
            }

            /// See [`Method::check_bins`].
            ///
            /// # Errors
            /// What is wrong and what would be right.
            pub fn check_bins(&self, bins: (usize, usize)) -> Result<(), Misfit> {
                match self { $(Self::$variant(settings) => Method::check_bins(settings, bins)),+ }
            }

            /// See [`Method::check_scenario`].
            ///
            /// # Errors
            /// Why the case cannot do the scenario.
            pub fn check_scenario(&self, assignment: &Assignment, shard: Shard) -> Result<(), Failure> {
                match self { $(Self::$variant(settings) => settings.check_scenario(assignment, shard)),+ }
            }

            /// See [`Method::curve_needs_snapshots`].
            pub fn curve_needs_snapshots(&self) -> bool {
                match self { $(Self::$variant(settings) => settings.curve_needs_snapshots()),+ }
            }

            fn rows_to_share(&self) -> Result<usize, String> {
                match self { $(Self::$variant(settings) => settings.rows_to_share()),+ }
            }

            /// See [`Method::check_reduce`].
            ///
            /// # Errors
            /// Why not.
            pub fn check_reduce(&self) -> Result<(), String> {
                match self { $(Self::$variant(settings) => settings.check_reduce()),+ }
            }

            /// The propagator with these settings.
            pub fn propagator(self) -> Box<dyn Propagator> {
                match self { $(Self::$variant(settings) => Box::new(settings.propagator())),+ }
            }

            /// Propagates scenario after scenario until asked to stop.
            ///
            /// # Errors
            /// [`Failure::Stopped`] is the normal end.
            pub fn serve(self, session: &Session) -> Result<(), Failure> {
                match self { $(Self::$variant(settings) => kit::serve(session, settings.propagator())),+ }
            }
        }
    };
}

// A method is registered here.
methods!(
    /// Monte Carlo.
    MonteCarlo(mc::Settings),
    /// Randomised quasi-Monte Carlo.
    QuasiMonteCarlo(qmc::Settings),
    /// The density evolution equation along characteristics.
    DensityEvolution(dee::Settings),
    /// A Gaussian mixture moved by the unscented transform.
    GaussianMixture(gmm_ut::Settings),
    /// The exact density.
    Exact(exact::Settings),
    /// Samples or characteristics that move by a flow map.
    FlowMap(flow_map::Settings),
);

impl BuiltIn {
    /// The settings as lines `key = value`: all that have an effect, also those that were not set.
    ///
    /// # Errors
    /// If they cannot be written as TOML, which no settings here cause.
    pub fn to_lines(&self) -> Result<Vec<String>, toml::ser::Error> {
        Ok(toml::to_string(&self.resolved())?.lines().filter(|line| !line.is_empty()).map(Into::into).collect())
    }

    /// Whether the case can run as so many shards.
    ///
    /// # Errors
    /// Why not.
    pub fn check_shards(&self, shards: u32) -> Result<(), String> {
        match self.rows_to_share()? {
            rows if rows >= shards as usize => Ok(()),
            rows => Err(format!("{shards} shards are too many for {rows} rows; every shard needs one")),
        }
    }
}
