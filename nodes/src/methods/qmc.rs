//! Randomised quasi-Monte Carlo: independent replicates of a scrambled Sobol sequence, each orbit propagated on its
//! own.
//!
//! It is Monte Carlo ([`super::mc`]) whose draws fill the initial Gaussian evenly. For smooth figures its error falls
//! almost as `1/n^(3/2)` and not as `1/sqrt(n)`; what it is follows from the spread of the replicates, which are
//! independent of one another (Owen, Ann. Statist. 25, 1997; L'Ecuyer & Lemieux in *Modeling Uncertainty*, 2002). So it
//! is the reference where there is no exact density.

use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::shard::Shard;

use crate::methods::accuracy::AccuracySetting;
use crate::methods::choices::check_forces;
use crate::methods::mc::{self, DrawsChoice, MonteCarlo};
use crate::methods::sampling_settings::sampling_settings;
use crate::methods::{Method, Misfit};

sampling_settings! {
    /// Settings of a case of quasi-Monte Carlo. Each replicate has a power of two samples.
    after_seed {}
    after_replicates {}
}

impl Default for Settings {
    fn default() -> Self {
        Self { samples: 65_536, seed: 1, replicates: 16, accuracy: None, model: None, forces: None }
    }
}

/// Fewest replicates: with fewer, Student's quantile is so large that an interval says nothing.
const FEWEST: usize = 4;

impl Settings {
    /// The same as a case of Monte Carlo.
    fn into_monte_carlo(self) -> mc::Settings {
        let Self { samples, seed, replicates, accuracy, model, forces } = self;
        let draws = DrawsChoice::Sobol;
        mc::Settings { samples, seed, replicates, accuracy, model, forces, draws, ..mc::Settings::default() }
    }
}

impl Method for Settings {
    const NAME: &'static str = "qmc";
    type Propagator = MonteCarlo;

    fn propagator(self) -> MonteCarlo {
        MonteCarlo::with_interval_of_replicates(self.into_monte_carlo())
    }

    fn check_scenario(&self, assignment: &Assignment, shard: Shard) -> Result<(), Failure> {
        self.clone().into_monte_carlo().check_scenario(assignment, shard)
    }

    fn check(&self) -> Result<(), Misfit> {
        check_forces(self.forces.as_ref())?;
        let Self { samples, replicates, .. } = *self;
        if replicates < FEWEST {
            let problem =
                format!("{replicates} is not enough, it must be at least {FEWEST}: errors follow from their spread");
            return Err(Misfit::new("replicates", problem));
        }
        let each = samples / replicates;
        if samples % replicates != 0 || !each.is_power_of_two() || each < 2 {
            let right = replicates.saturating_mul(each.max(2).next_power_of_two());
            let problem = format!(
                "{samples} is not allowed, each of the replicates = {replicates} must have a power of two of them, at least 2: {right}, \
                 for example"
            );
            return Err(Misfit::new("samples", problem));
        }
        Ok(())
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize), variables: usize) -> usize {
        self.samples.saturating_mul(variables)
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Err("qmc cannot be split into shards: its intervals need all replicates together; leave out shards, it uses all cores".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_that_are_no_power_of_two_for_each_replicate_are_refused_with_a_number_that_is() {
        let refused = |settings: Settings, key: &str, words: &str| {
            let Misfit { key: found, problem } = settings.check().unwrap_err();
            assert!(found == key && problem.contains(words), "{found}: {problem}");
        };
        assert!(Settings::default().check().is_ok());
        let usual = Settings::default;
        refused(Settings { samples: 50_000, ..usual() }, "samples", "65536, for example");
        refused(Settings { samples: 16, ..usual() }, "samples", "32, for example");
        refused(Settings { replicates: 1, ..usual() }, "replicates", "at least 4");
    }
}
