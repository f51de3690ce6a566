//! The forces that act in a problem in space, and the problem with some of them alone.

use super::SpaceProblem;
use crate::model::sun_moon::SunMoon;

/// The names of all forces, and of the Earth's shadow, which is named beside them.
pub const ALL: [&str; 5] = ["srp", "j2", "sun", "moon", SHADOW];
/// The name of the Earth's shadow.
pub const SHADOW: &str = "shadow";

impl SpaceProblem {
    /// The forces whose parameters are not 0, and the shadow if there is one.
    pub fn acting(&self) -> Vec<&'static str> {
        let SunMoon { force, sun, moon } = self.model.forces();
        let shadow = if self.shadow { 1.0 } else { 0.0 };
        let values = [force.radiation, force.oblateness, sun, moon, shadow];
        ALL.into_iter().zip(values).filter(|(_, value)| *value != 0.0).map(|(name, _)| name).collect()
    }

    /// The same problem without one of its forces. Without radiation pressure there is nothing that a shadow or an
    /// uncertain radiation parameter could change.
    pub fn without(&self, force: &str) -> Self {
        let mut other = self.clone();
        let forces = other.model.forces_mut();
        match force {
            "srp" => {
                forces.force.radiation = 0.0;
                (other.spread, other.shadow) = (None, false);
            }
            "j2" => forces.force.oblateness = 0.0,
            "sun" => forces.sun = 0.0,
            "moon" => forces.moon = 0.0,
            SHADOW => other.shadow = false,
            _ => {}
        }
        other
    }

    /// The same problem with these of its forces alone.
    pub fn with_only(&self, forces: &[&str]) -> Self {
        self.acting()
            .into_iter()
            .filter(|force| !forces.contains(force))
            .fold(self.clone(), |problem, force| problem.without(force))
    }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;

    #[test]
    fn a_problem_keeps_the_forces_that_are_named_and_no_others() {
        let problem = SpaceProblem { shadow: true, ..example::problem() };
        assert_eq!(problem.acting(), ALL);
        let two = problem.with_only(&["srp", "j2"]);
        assert_eq!(two.acting(), ["srp", "j2"]);
        assert_eq!(two.model.forces().force, problem.model.forces().force);
        // Sunlight casts the shadow, and the radiation parameter is its.
        let without = problem.without("srp");
        assert_eq!((without.acting(), without.spread), (vec!["j2", "sun", "moon"], None));
    }
}
