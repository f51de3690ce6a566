//! What methods do with a cloud in space that place points in its Gaussian: the averaged model and the Gaussian, in 4
//! or 5 variables.

use super::{NARROWEST, SpaceProblem, VARIABLES, contradiction};
use crate::gaussian::Gaussian;
use crate::model::irradiated::WithRadiation;
use crate::model::model_name::ModelName;
use crate::model::uncertain_radiation::{Linear, Logarithmic};
use crate::model::unfolded::{InSpace, Unfolded};
use crate::problem_error::{Field, ProblemError};

/// Something that is done with the averaged model and the Gaussian of a cloud, whichever variables it has.
pub trait SpaceTask {
    /// The result.
    type Output;

    /// Does the task. The Gaussian is that before the cut.
    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) -> Self::Output;
}

impl SpaceProblem {
    /// Does a task with the model and the Gaussian of this problem, in which a certain variable has the narrowest
    /// deviation that a variable can have.
    ///
    /// # Errors
    /// [`ProblemError`] if the model is not averaged, or has the Earth's shadow, in which the semi-major axis is one
    /// more variable.
    pub fn perform<T: SpaceTask>(&self, task: T) -> Result<T::Output, ProblemError> {
        let Some(model) = self.model.if_averaged() else {
            let name = self.model.name();
            let problem = format!(
                "\"{name}\" is not averaged, and an orbit's place in its revolution is no variable of the cloud; the methods for it are \
                 mc and qmc, and this one takes {}",
                ModelName::listed(ModelName::is_averaged)
            );
            return Err(ProblemError::misfit(Field::Model, problem));
        };
        if self.shadow {
            let problem = "\"shadow\" makes the semi-major axis a variable that is not one of the cloud; the methods for it are mc and qmc";
            return Err(ProblemError::misfit(Field::Shadow, problem));
        }
        match (self.spread.is_some(), self.is_logarithmic()) {
            (false, _) => Ok(task.with(Unfolded(model), self.gaussian()?)),
            (_, false) => Ok(task.with(Unfolded(WithRadiation::<_, Linear>::new(model)), self.gaussian()?)),
            (_, true) => Ok(task.with(Unfolded(WithRadiation::<_, Logarithmic>::new(model)), self.gaussian()?)),
        }
    }

    /// Checks that tasks can be done with this problem.
    ///
    /// # Errors
    /// As [`SpaceProblem::perform`].
    pub fn check_task(&self) -> Result<(), ProblemError> {
        struct Nothing;
        impl SpaceTask for Nothing {
            type Output = ();

            fn with<M: InSpace<N>, const N: usize>(self, _: Unfolded<M, N>, _: Gaussian<N>) {}
        }
        self.perform(Nothing)
    }

    /// The Gaussian over the first `N` variables.
    fn gaussian<const N: usize>(&self) -> Result<Gaussian<N>, ProblemError> {
        let (means, covariance) = self.moments();
        let entry = |a: usize, b: usize| match a == b && a < VARIABLES.len() {
            true => covariance[a][a].max(NARROWEST * NARROWEST),
            false => covariance[a][b],
        };
        let covariance = std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)));
        Gaussian::new(std::array::from_fn(|k| means[k]), covariance).map_err(|_| contradiction())
    }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;
    use crate::model::Model;
    use crate::model::osculating::Osculating;
    use crate::model::space_registry::SpaceModel;
    use crate::model::vectorial::Vectorial;

    struct Deviations;

    impl SpaceTask for Deviations {
        type Output = Vec<f64>;

        fn with<M: InSpace<N>, const N: usize>(self, _: Unfolded<M, N>, initial: Gaussian<N>) -> Vec<f64> {
            assert_eq!(Unfolded::<M, N>::VARIABLES.len(), N);
            (0..N).map(|k| initial.deviation(k)).collect()
        }
    }

    #[test]
    fn the_gaussian_has_the_deviations_of_the_cloud_and_a_certain_variable_the_narrowest() {
        let problem = example::problem();
        let found = problem.perform(Deviations).unwrap();
        assert!(found.iter().zip([0.1, 0.02, 0.02, 0.1, 0.0075]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        let mut certain = SpaceProblem { spread: None, ..problem };
        (certain.initial.sigma[3], certain.initial.correlation) = (0.0, [0.0; 6]);
        assert_eq!(certain.perform(Deviations).unwrap(), [0.1, 0.02, 0.02, NARROWEST]);
    }

    #[test]
    fn the_earths_shadow_is_refused_by_name() {
        let error = SpaceProblem { shadow: true, ..example::problem() }.perform(Deviations).unwrap_err();
        assert!(error.field == Field::Shadow && error.problem().contains("mc and qmc"), "{error}");
    }

    #[test]
    fn an_unaveraged_model_is_refused_by_name() {
        let Vectorial { forces, obliquity, sun_longitude } = example::problem().model.averaged();
        let model = Osculating { semi_major_axis: 2.5, forces, obliquity, sun_longitude, moon_longitude: 0.0 };
        let model = SpaceModel::Osculating { model, mean_anomaly: None };
        let error = SpaceProblem { model, ..example::problem() }.perform(Deviations).unwrap_err();
        assert!(error.field == Field::Model && error.problem().contains("\"osculating\" is not averaged"), "{error}");
    }
}
