//! What samples say of an uncertain radiation parameter.

use density::first_passage::given::{Given, of_sample};
use density::in_space::cloud::Cloud;
use density::model::uncertain_radiation::{Linear, Logarithmic, Scale};
use kit::space::Space;

/// Which variable of a cloud the radiation parameter is, or follows from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radiation {
    position: usize,
    /// Number of variables.
    variables: usize,
    /// The parameter at a value of the variable.
    of_variable: fn(f64) -> f64,
}

impl Radiation {
    /// Looks for it among the variables of a space.
    pub(super) fn find(space: &Space) -> Option<Self> {
        fn of<S: Scale>(space: &Space) -> Option<Radiation> {
            let variables = space.variables.len();
            let position = (0..variables).find(|&k| space.symbol(k) == S::VARIABLE.symbol)?;
            Some(Radiation { position, variables, of_variable: S::radiation })
        }
        of::<Linear>(space).or_else(|| of::<Logarithmic>(space))
    }

    /// What re-entry, and none, says of the parameter by each of `times` times. `points` has the position of the time
    /// by which each orbit has passed.
    pub(super) fn given_re_entry(&self, cloud: &dyn Cloud, points: &[u8], times: usize) -> Vec<[Given; 2]> {
        let Self { position, variables, of_variable } = *self;
        let mut columns = vec![0.0; variables * points.len()];
        cloud.read_out(&mut columns);
        let values = columns[position * points.len()..].iter().map(|&value| of_variable(value));
        of_sample(values.zip(points.iter().map(|&point| usize::from(point))), times)
    }
}
