//! The common parts of the figures of one scenario: its cases in their order with their pens, and its snapshots.

use std::ops::Range;

use density::model::registry::Planar;
use density::problem::Problem;

use crate::branch;
use crate::densities::{Densities, Density};
use crate::palette::Pen;
use results::rows::{EffortRow, PassageRow};
use results::{MomentsRow, Results};

/// A scenario of the run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// Its science.
    pub problem: Problem<Planar>,
}

/// A case in a scenario.
#[derive(Debug, Clone)]
pub struct Method<'a> {
    /// Its label.
    pub label: &'a str,
    /// How it is drawn.
    pub pen: Pen,
    /// Its moments, one row per snapshot.
    pub moments: Vec<&'a MomentsRow>,
    /// Its densities, one per snapshot.
    pub densities: &'a [Density],
    /// Its first-passage curve; empty if it has none.
    pub passage: Vec<&'a PassageRow>,
    /// Its effort.
    pub effort: Option<&'a EffortRow>,
}

impl Method<'_> {
    /// Times \[yr\] at which the case withholds its density.
    pub fn withheld(&self, times: &[f64]) -> Vec<f64> {
        let snapshots = self.densities.iter().zip(times);
        snapshots.filter(|(density, _)| density.is_withheld()).map(|(_, &t)| t).collect()
    }

    /// Number of samples, if it is a Monte Carlo method; such a method gives standard errors of its moments.
    pub fn samples(&self) -> Option<f64> {
        let has_errors = self.moments.first().is_some_and(|row| row.standard_error("mean_e").is_finite());
        self.effort.filter(|_| has_errors).map(|row| row.trajectories).filter(|n| *n >= 1.0)
    }
}

/// A scenario with its results.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    /// Its name.
    pub name: &'a str,
    /// Prefix of the names of its figures.
    pub prefix: String,
    /// Its science.
    pub problem: &'a Problem<Planar>,
    /// All cases that have results here.
    pub methods: Vec<Method<'a>>,
    /// Label of the case with which all others are compared.
    pub reference: &'a str,
    /// Label of a case that ran the exact method.
    pub exact: Option<&'a str>,
    /// Snapshot times \[yr\].
    pub times: Vec<f64>,
    /// All results of the run.
    pub results: &'a Results,
}

impl<'a> Scene<'a> {
    /// The scene of `scenario`. The names of its figures begin with the scenario's name if the run has `several`
    /// scenarios.
    pub fn new(scenario: &'a Scenario, results: &'a Results, densities: &'a Densities, several: bool) -> Self {
        let name = scenario.name.as_str();
        let reference = results.manifest.reference.as_str();
        let mut labels: Vec<&str> = Vec::new();
        for row in results.moments.iter().filter(|row| row.scenario == name) {
            if !labels.contains(&row.method.as_str()) {
                labels.push(&row.method);
            }
        }
        let of_scenario = densities.get(name);
        let mut series = 0;
        let mut pen = |label: &str| {
            if label == reference {
                return Pen::REFERENCE;
            }
            series += 1;
            Pen::of(series - 1)
        };
        let method = |label: &'a str| Method {
            label,
            pen: pen(label),
            moments: results.moments.iter().filter(|row| row.scenario == name && row.method == label).collect(),
            densities: of_scenario.and_then(|methods| methods.get(label)).map_or(&[], Vec::as_slice),
            passage: results.passages.iter().filter(|row| row.scenario == name && row.method == label).collect(),
            effort: results.effort.iter().find(|row| row.scenario == name && row.method == label),
        };
        let is_exact = |label: &&&str| results.manifest.cases.get(**label).is_some_and(|case| case.runs == ["exact"]);
        Self {
            name,
            prefix: if several { format!("{name}-") } else { String::new() },
            problem: &scenario.problem,
            reference,
            exact: labels.iter().find(is_exact).copied(),
            times: scenario.problem.times.clone(),
            methods: labels.into_iter().map(method).collect(),
            results,
        }
    }

    /// The full name of a figure.
    pub fn figure_name(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// The case with this label.
    pub fn method(&self, label: &str) -> Option<&Method<'a>> {
        self.methods.iter().find(|method| method.label == label)
    }

    /// The case whose densities bound the clouds: the reference, or the first case if the reference has failed.
    pub fn yardstick(&self) -> Option<&Method<'a>> {
        self.method(self.reference).or(self.methods.first())
    }

    /// The case with which the others are compared at a snapshot: the first reference that gives its density there, or
    /// else any case that does.
    pub fn yardstick_at(&self, index: usize) -> Option<&Method<'a>> {
        let states = |method: &&Method<'a>| method.densities.get(index).is_some_and(|density| !density.is_withheld());
        let references = self.results.manifest.references.iter().filter_map(|label| self.method(label));
        references.chain(self.method(self.reference)).find(states).or_else(|| self.methods.iter().find(states))
    }

    /// The densities of [`Scene::yardstick_at`], for the snapshots that have one.
    pub fn yardstick_densities(&self) -> impl Iterator<Item = &'a Density> {
        let any = |index| self.yardstick_at(index).or_else(|| self.yardstick());
        (0..self.times.len()).filter_map(move |index| any(index)?.densities.get(index))
    }

    /// All cases but the reference.
    pub fn others(&self) -> impl Iterator<Item = &Method<'a>> {
        self.methods.iter().filter(|method| method.label != self.reference)
    }

    /// The first Monte Carlo case, with its number of samples.
    pub fn monte_carlo(&self) -> Option<(&Method<'a>, f64)> {
        self.methods.iter().find_map(|method| Some((method, method.samples()?)))
    }

    /// Where the cloud is visible at each snapshot, by the density of the yardstick or of the first case that gives
    /// one; `None` where every case withholds it.
    pub fn clouds(&self) -> Vec<Option<Cloud>> {
        let cases = || self.yardstick().into_iter().chain(&self.methods);
        let density = |index: usize| cases().filter_map(|m| m.densities.get(index)).find(|d| !d.is_withheld());
        (0..self.times.len()).map(|index| density(index).map(Cloud::of)).collect()
    }

    /// The branch of the solar angle on which all clouds are whole.
    pub fn phi_range(&self) -> Range<f64> {
        branch::common(&self.clouds().into_iter().flatten().map(|cloud| cloud.phi).collect::<Vec<_>>())
    }
}

/// Where a cloud is visible.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// Its solar angles \[rad\].
    pub phi: Range<f64>,
    /// Its eccentricities.
    pub e: Range<f64>,
}

impl Cloud {
    /// The visible part of a density.
    pub fn of(density: &Density) -> Self {
        Self {
            phi: branch::visible_angle(&density.grid.phi, &density.marginal_phi),
            e: branch::visible(&density.grid.e, &density.marginal_e),
        }
    }
}
