//! The space of a scenario: its variables, its projections, and the quantities of a cloud in it.

use messages::scenario::{Projection, Range, Variable};

/// The variables of a scenario's model, and the projections on which densities are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    /// The variables in which initial orbits and snapshots are given.
    pub variables: Vec<Variable>,
    /// Position of the variable that grows to its critical value when the satellite re-enters.
    pub reentry: usize,
    /// The projections on which densities are compared; the density on the first of them is called the joint density.
    pub projections: Vec<Projection>,
}

/// A number that describes a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Mean of a variable, by its position; for an angle, on the branch around its circular mean.
    Mean(usize),
    /// Standard deviation of a variable.
    Deviation(usize),
    /// Covariance of two variables.
    Covariance(usize, usize),
    /// Probability that the re-entry variable exceeds its critical value at this instant.
    AboveCritical,
    /// Circular mean of an angle, in `[0, 2π)` \[rad\].
    CircularMean(usize),
    /// Mean resultant length of an angle.
    ResultantLength(usize),
}

impl Space {
    /// The quantities of a cloud in the order of a message: mean and standard deviation of each variable, the
    /// covariances of all pairs, the probability above the critical value, then circular mean and mean resultant
    /// length of each angle.
    pub fn quantities(&self) -> Vec<Quantity> {
        let circles = (0..self.variables.len()).filter(|&k| self.is_circle(k));
        self.moments()
            .into_iter()
            .chain(circles.flat_map(|k| [Quantity::CircularMean(k), Quantity::ResultantLength(k)]))
            .collect()
    }

    /// The quantities that have standard errors: all except the circular means and resultant lengths of angles.
    pub fn moments(&self) -> Vec<Quantity> {
        let count = self.variables.len();
        let single = (0..count).flat_map(|k| [Quantity::Mean(k), Quantity::Deviation(k)]);
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| Quantity::Covariance(a, b)));
        single.chain(pairs).chain([Quantity::AboveCritical]).collect()
    }

    /// The place of a quantity in the order of `quantities`.
    pub fn place(&self, quantity: Quantity) -> Option<usize> {
        self.quantities().iter().position(|known| *known == quantity)
    }

    /// Whether a variable is an angle on the full circle.
    pub fn is_circle(&self, variable: usize) -> bool {
        self.variables.get(variable).is_some_and(|variable| variable.range == Range::Circle)
    }

    /// The quantity's name in tables: `mean_phi`.
    pub fn name(&self, quantity: Quantity) -> String {
        let symbol = |k: usize| self.symbol(k);
        match quantity {
            Quantity::Mean(k) => format!("mean_{}", symbol(k)),
            Quantity::Deviation(k) => format!("std_{}", symbol(k)),
            Quantity::Covariance(a, b) => format!("cov_{}_{}", symbol(a), symbol(b)),
            Quantity::AboveCritical => format!("prob_above_critical_{}", symbol(self.reentry)),
            Quantity::CircularMean(k) => format!("circular_mean_{}", symbol(k)),
            Quantity::ResultantLength(_) if self.has_one_circle() => "resultant_length".into(),
            Quantity::ResultantLength(k) => format!("resultant_length_{}", symbol(k)),
        }
    }

    /// The quantity's name as a column's, with its unit: `mean_phi_rad`.
    pub fn column(&self, quantity: Quantity) -> String {
        let unit = match quantity {
            Quantity::Mean(k) | Quantity::Deviation(k) | Quantity::CircularMean(k) => self.variables[k].unit.as_str(),
            Quantity::Covariance(..) | Quantity::AboveCritical | Quantity::ResultantLength(_) => "",
        };
        match unit {
            "" => self.name(quantity),
            unit => format!("{}_{unit}", self.name(quantity)),
        }
    }

    /// The quantity in a sentence: `the mean of phi`.
    pub fn in_words(&self, quantity: Quantity) -> String {
        let symbol = |k: usize| self.symbol(k);
        match quantity {
            Quantity::Mean(k) => format!("the mean of {}", symbol(k)),
            Quantity::Deviation(k) => format!("the deviation of {}", symbol(k)),
            Quantity::Covariance(..) if self.variables.len() == 2 => "the covariance".into(),
            Quantity::Covariance(a, b) => format!("the covariance of {} and {}", symbol(a), symbol(b)),
            Quantity::AboveCritical => {
                format!("the probability above the critical {}", self.variables[self.reentry].name)
            }
            Quantity::CircularMean(k) => format!("the circular mean of {}", symbol(k)),
            Quantity::ResultantLength(k) => format!("the resultant length of {}", symbol(k)),
        }
    }

    /// Whether a quantity is an angle, so that its error is measured the short way round.
    pub fn is_angle(&self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Mean(k) => self.is_circle(k),
            Quantity::CircularMean(_) => true,
            Quantity::Deviation(_) | Quantity::Covariance(..) => false,
            Quantity::AboveCritical | Quantity::ResultantLength(_) => false,
        }
    }

    /// The name of the density on a projection: `joint` if it is of all variables, else `marginal_phi`.
    pub fn density_name(&self, projection: &Projection) -> String {
        let symbols: Vec<&str> = projection.axes().map(|(variable, _)| self.symbol(variable)).collect();
        match symbols.len() == self.variables.len() {
            true => "joint".into(),
            false => format!("marginal_{}", symbols.join("_")),
        }
    }

    /// The symbol of a variable.
    pub fn symbol(&self, variable: usize) -> &str {
        self.variables.get(variable).map_or("?", |variable| variable.symbol.as_str())
    }

    fn has_one_circle(&self) -> bool {
        (0..self.variables.len()).filter(|&k| self.is_circle(k)).count() == 1
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn quantities_of_the_plane_have_the_names_and_the_order_that_results_have_always_had() {
        let space = &crate::example::assignment().space;
        let names: Vec<String> = space.quantities().into_iter().map(|quantity| space.name(quantity)).collect();
        let expected = [
            "mean_phi",
            "std_phi",
            "mean_e",
            "std_e",
            "cov_phi_e",
            "prob_above_critical_e",
            "circular_mean_phi",
            "resultant_length",
        ];
        assert_eq!(names, expected);
        let columns: Vec<String> = space.quantities().into_iter().map(|quantity| space.column(quantity)).collect();
        assert_eq!(
            (columns[0].as_str(), columns[4].as_str(), columns[6].as_str()),
            ("mean_phi_rad", "cov_phi_e", "circular_mean_phi_rad")
        );
        let densities: Vec<String> =
            space.projections.iter().map(|projection| space.density_name(projection)).collect();
        assert_eq!(densities, ["joint", "marginal_phi", "marginal_e"]);
    }
}
