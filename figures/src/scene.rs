//! The common parts of the figures of one scenario: its cases in their order with their pens, and its snapshots.

use std::ops::Range;

use density::model::registry::Planar;
use density::problem::Problem;

use crate::branch;
use crate::densities::{Densities, Density};
use crate::draw_error::DrawError;
use crate::palette::Pen;
use results::description::{Description, Variable};
use results::diagnostic_names::OF_A_STATED_DENSITY;
use results::rows::{DiagnosticRow, EffortRow, GivenRow, PassageRow};
use results::{MomentsRow, Results};

/// A scenario of the run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its variables, and the names of its quantities.
    pub description: Description,
    /// Its problem, if its model is one in the plane.
    pub plane: Option<Problem<Planar>>,
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
        let is_sampled =
            |row: &&MomentsRow| row.named().any(|(column, se)| column.starts_with("se_mean_") && se.is_finite());
        let has_errors = self.moments.first().is_some_and(is_sampled);
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
    /// Its variables, and the names of its quantities.
    pub description: &'a Description,
    /// Its problem, if its model is one in the plane.
    pub plane: Option<&'a Problem<Planar>>,
    /// The positions of the two variables whose density is shown; none if no density of two variables is compared.
    pub pair: Option<[usize; 2]>,
    /// All cases that have results here.
    pub methods: Vec<Method<'a>>,
    /// Label of the case with which all others are compared.
    pub reference: &'a str,
    /// Label of a case that states its density itself, with estimates of its errors, as the exact method does.
    pub exact: Option<&'a str>,
    /// Snapshot times \[yr\].
    pub times: Vec<f64>,
    /// All results of the run.
    pub results: &'a Results,
}

impl<'a> Scene<'a> {
    /// The scene of `scenario` and its pair of variables number `pair`. The names of its figures begin with the
    /// scenario's name if the run has `several` scenarios.
    pub fn new(
        scenario: &'a Scenario,
        results: &'a Results,
        densities: &'a Densities,
        pair: usize,
        several: bool,
    ) -> Self {
        let description = &scenario.description;
        let name = description.name.as_str();
        let reference = results.manifest.reference.as_str();
        let mut labels: Vec<&str> = Vec::new();
        for row in results.moments.iter().filter(|row| row.scenario == name) {
            if !labels.contains(&row.method.as_str()) {
                labels.push(&row.method);
            }
        }
        let of_scenario = densities.get(&(name.to_owned(), pair));
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
        // A case that states its density, instead of samples or parts from which one is estimated, says how far off
        // that is.
        let states =
            |row: &&DiagnosticRow| row.scenario == name && OF_A_STATED_DENSITY.contains(&row.diagnostic.as_str());
        let states_it: Vec<&str> = results.diagnostics.iter().filter(states).map(|row| row.method.as_str()).collect();
        Self {
            name,
            prefix: if several { format!("{name}-") } else { String::new() },
            description,
            plane: scenario.plane.as_ref(),
            pair: description.pairs().nth(pair).map(|(_, pair)| pair),
            reference,
            exact: labels.iter().find(|label| states_it.contains(label)).copied(),
            times: description.times.clone(),
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

    /// What a case says of an uncertain radiation parameter given re-entry.
    pub fn given(&self, method: &Method<'_>) -> Vec<&'a GivenRow> {
        self.results.given.iter().filter(|row| row.scenario == self.name && row.method == method.label).collect()
    }

    /// Whether any case says that.
    pub fn has_given(&self) -> bool {
        self.results.given.iter().any(|row| row.scenario == self.name)
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

    /// The variables of the pair.
    ///
    /// # Errors
    /// If no density of two variables is compared.
    pub fn variables(&self) -> Result<[&'a Variable; 2], DrawError> {
        let variables = self.pair.map(|pair| pair.map(|position| &self.description.variables[position]));
        variables.ok_or_else(|| DrawError("no density of two variables is compared".into()))
    }

    /// The symbols of the pair of variables; none if these are all variables of the model, so that no figure needs to
    /// name them.
    pub fn pair_name(&self) -> Option<String> {
        let symbols = |[x, y]: [&Variable; 2]| format!("{}, {}", x.symbol, y.symbol);
        self.variables().ok().filter(|_| self.description.variables.len() > 2).map(symbols)
    }

    /// The name of a figure of the density of the pair of variables.
    pub fn density_figure_name(&self, name: &str) -> String {
        let pair = self.pair_name().map_or(String::new(), |pair| format!("{}-", pair.replace(", ", "-")));
        self.figure_name(&format!("{pair}{name}"))
    }

    /// The problem of a scenario in the plane.
    ///
    /// # Errors
    /// If its model is another one.
    pub fn problem(&self) -> Result<&'a Problem<Planar>, DrawError> {
        self.plane.ok_or_else(|| DrawError(format!("the model {} is not one in the plane", self.description.model)))
    }

    /// The range of the first variable in which all clouds are whole; of an angle, the branch on which they are.
    pub fn x_range(&self) -> Range<f64> {
        let clouds: Vec<Range<f64>> = self.clouds().into_iter().flatten().map(|cloud| cloud.x).collect();
        let is_circle = |[x, _]: [&Variable; 2]| x.is_circle();
        if self.variables().is_ok_and(is_circle) {
            return branch::common(&clouds);
        }
        let ends = clouds.into_iter().reduce(|all, one| all.start.min(one.start)..all.end.max(one.end));
        ends.unwrap_or(0.0..1.0)
    }

    /// The range of the second variable in which all clouds are seen, and the critical value if it is the re-entry
    /// variable. A variable that is not negative is shown from 0 on.
    pub fn y_range(&self) -> Range<f64> {
        let bounds = self.variables().ok().and_then(|[_, y]| y.bounds);
        let grids = self.yardstick().map_or(&[][..], |yardstick| yardstick.densities).iter();
        let grids =
            grids.filter(|density| !density.is_withheld()).map(|density| density.grid.y.low..density.grid.y.high);
        let critical = self.description.critical;
        let margin = 0.05 * critical.abs();
        let critical = self.is_reentry(1).then_some(critical - margin..critical + margin);
        let clouds = self.clouds().into_iter().flatten().map(|cloud| cloud.y);
        let all = grids.chain(clouds).chain(critical);
        let all = all.reduce(|all, one| all.start.min(one.start)..all.end.max(one.end)).unwrap_or(0.0..1.0);
        match bounds {
            Some([0.0, high]) => 0.0..all.end.min(high),
            Some([low, high]) => all.start.max(low)..all.end.min(high),
            None => all,
        }
    }

    /// Whether the first (0) or the second (1) variable of the pair is the one that grows to its critical value.
    pub fn is_reentry(&self, place: usize) -> bool {
        self.pair.is_some_and(|pair| pair[place] == self.description.reentry)
    }
}

/// Where a cloud is visible.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// The values of the first variable.
    pub x: Range<f64>,
    /// The values of the second variable.
    pub y: Range<f64>,
}

impl Cloud {
    /// How far the cloud is moved to lie on `axis`: by whole turns if its first variable is an angle.
    pub fn shift_onto(&self, axis: &Range<f64>, is_circle: bool) -> f64 {
        if is_circle { branch::shift_into(axis, &self.x) } else { 0.0 }
    }

    /// The visible part of a density.
    pub fn of(density: &Density) -> Self {
        let along_x = if density.grid.is_circle { branch::visible_angle } else { branch::visible };
        Self {
            x: along_x(&density.grid.x, &density.marginal_x),
            y: branch::visible(&density.grid.y, &density.marginal_y),
        }
    }
}
