//! The forces that act in a problem in space, and the problem with some of them alone.

use super::SpaceProblem;
use crate::model::parameter::Named;
use crate::model::planar::RADIATION;
use crate::model::sun_moon::SunMoon;

/// The name of the Earth's shadow.
pub const SHADOW: &str = "shadow";

/// The names of all forces, and of the Earth's shadow, which is named beside them.
pub fn all() -> Vec<&'static str> {
    SunMoon::PARAMETERS.iter().map(|parameter| parameter.force).chain([SHADOW]).collect()
}

impl SpaceProblem {
    /// The forces whose parameters are not 0, and the shadow if there is one.
    pub fn acting(&self) -> Vec<&'static str> {
        let parameters = self.model.force_parameters().into_iter().filter(|(_, value)| *value != 0.0);
        parameters.map(|(parameter, _)| parameter.force).chain(self.shadow.then_some(SHADOW)).collect()
    }

    /// The same problem without one of its forces.
    pub fn without(&self, force: &str) -> Self {
        let others: Vec<&str> = self.acting().into_iter().filter(|other| *other != force).collect();
        self.with_only(&others)
    }

    /// The same problem with these of its forces alone. Without radiation pressure there is nothing that a shadow or an
    /// uncertain radiation parameter could change.
    pub fn with_only(&self, forces: &[&str]) -> Self {
        let acts = |force: &str| forces.contains(&force);
        let mut other = self.clone();
        let parameters = other.model.forces_mut();
        *parameters = parameters.only(acts);
        other.shadow &= acts(SHADOW);
        if !acts(RADIATION.force) {
            (other.spread, other.shadow) = (None, false);
        }
        other
    }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;

    #[test]
    fn a_problem_keeps_the_forces_that_are_named_and_no_others() {
        let problem = SpaceProblem { shadow: true, ..example::problem() };
        assert_eq!(problem.acting(), all());
        let two = problem.with_only(&["srp", "j2"]);
        assert_eq!(two.acting(), ["srp", "j2"]);
        assert_eq!(two.model.forces().force, problem.model.forces().force);
        // Sunlight casts the shadow, and the radiation parameter is its.
        let without = problem.without("srp");
        assert_eq!((without.acting(), without.spread), (vec!["j2", "sun", "moon"], None));
    }
}
