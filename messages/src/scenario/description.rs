//! A scenario message as a value.

use super::{
    MOST_PARAMETERS, MOST_PROJECTIONS, MOST_SNAPSHOTS, MOST_VARIABLES, ParameterEntry, ProjectionEntry, ScenarioHeader,
    VariableEntry, gaussian_numbers, range,
};
use crate::text::{pack, unpack};

/// Which values a variable takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// An angle on the full circle \[rad\].
    Circle,
    /// Numbers between two bounds, without the bounds themselves.
    Interval {
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
    },
}

/// A variable in which initial orbits and snapshots are given.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name, for example `solar angle`.
    pub name: String,
    /// Its symbol, for example `phi`.
    pub symbol: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Which values it takes.
    pub range: Range,
}

/// A parameter of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its key in a scenario file, for example `radiation`.
    pub name: String,
    /// Its symbol in equations, for example `C`.
    pub symbol: String,
    /// Its value.
    pub value: f64,
}

/// One or two variables in which densities are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Projection {
    /// The position of the first variable, and the number of bins of its axis.
    pub first: (usize, usize),
    /// The same for the second variable, if there is one.
    pub second: Option<(usize, usize)>,
}

impl Projection {
    /// Its axes: position of the variable and number of bins.
    pub fn axes(&self) -> impl Iterator<Item = (usize, usize)> {
        std::iter::once(self.first).chain(self.second)
    }
}

/// A snapshot that the scenario asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Its time \[yr\].
    pub time: f64,
    /// Lowest and highest value of every axis, projection after projection.
    pub ends: Vec<[f64; 2]>,
}

/// A scenario message as a value: every number is finite, and every position is that of an existing variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Names the run.
    pub run_id: u64,
    /// Position of the scenario in the run; in a request, the number of the request.
    pub scenario: u32,
    /// Scenarios in the run; 0 if the number is not known.
    pub scenarios: u32,
    /// The scenario's name.
    pub name: String,
    /// The model's name.
    pub model: String,
    /// The model's parameters.
    pub parameters: Vec<Parameter>,
    /// The model's variables.
    pub variables: Vec<Variable>,
    /// Position of the variable that grows to its critical value when the satellite re-enters.
    pub reentry: usize,
    /// The critical value of that variable.
    pub critical: f64,
    /// Mean of the initial Gaussian.
    pub mean: Vec<f64>,
    /// Upper triangle of its covariance, row by row.
    pub covariance: Vec<f64>,
    /// In which variables densities are compared; none in a request.
    pub projections: Vec<Projection>,
    /// The snapshots.
    pub snapshots: Vec<Moment>,
}

impl Description {
    /// Count of numbers in the payload of a scenario with these numbers of variables, of axes of all projections, and
    /// of snapshots.
    pub const fn numbers(variables: usize, axes: usize, snapshots: usize) -> usize {
        gaussian_numbers(variables) + snapshots * (1 + 2 * axes)
    }

    /// Reads a header and its items.
    ///
    /// # Errors
    /// Which field is wrong, and what would be right.
    pub fn decode(header: &ScenarioHeader, items: &[f64]) -> Result<Self, String> {
        let variables = entries("variables", header.variable_count, 1, &header.variables)?;
        let parameters = entries("parameters", header.parameter_count, 0, &header.parameters)?;
        let projections = entries("projections", header.projection_count, 0, &header.projections)?;
        let variables: Vec<Variable> = numbered("variable", variables, variable)?;
        let parameters: Vec<Parameter> = numbered("parameter", parameters, parameter)?;
        let projection = |entry: &ProjectionEntry| projection(entry, variables.len());
        let projections: Vec<Projection> = numbered("projection", projections, projection)?;
        let reentry = header.reentry as usize;
        if reentry >= variables.len() {
            return Err(format!("reentry: there is no variable {reentry}, there are {}", variables.len()));
        }
        if header.scenarios > 0 && header.scenario >= header.scenarios {
            return Err(format!("scenario: it is number {} of {}", header.scenario, header.scenarios));
        }
        let snapshots = header.snapshots as usize;
        let axes = projections.iter().flat_map(Projection::axes).count();
        let expected = Self::numbers(variables.len(), axes, snapshots);
        if !(1..=MOST_SNAPSHOTS).contains(&snapshots) || items.len() != expected {
            let numbers = items.len();
            return Err(format!(
                "snapshots: {numbers} numbers for {snapshots} snapshots, of which there may be 1 to {MOST_SNAPSHOTS}, with \
                 {axes} axes and {} variables each",
                variables.len()
            ));
        }
        if !items.iter().chain([&header.critical]).all(|value| value.is_finite()) {
            return Err("a number that is not finite".into());
        }
        let (gaussian, rows) = items.split_at(gaussian_numbers(variables.len()));
        let (mean, covariance) = gaussian.split_at(variables.len());
        let moment = |row: &[f64]| Moment { time: row[0], ends: row[1..].as_chunks().0.to_vec() };
        let snapshots: Vec<Moment> = rows.chunks_exact(1 + 2 * axes).map(moment).collect();
        if let Some(empty) = snapshots.iter().find(|moment| moment.ends.iter().any(|[low, high]| low >= high)) {
            return Err(format!("projections: a grid without extent at {} yr", empty.time));
        }
        Ok(Self {
            run_id: header.run_id,
            scenario: header.scenario,
            scenarios: header.scenarios,
            name: unpack(&header.name),
            model: unpack(&header.model),
            reentry,
            critical: header.critical,
            mean: mean.to_vec(),
            covariance: covariance.to_vec(),
            parameters,
            variables,
            projections,
            snapshots,
        })
    }

    /// The message's header and items.
    ///
    /// # Errors
    /// If there are more entries of one type than a message holds.
    pub fn encode(&self) -> Result<(ScenarioHeader, Vec<f64>), String> {
        let variables = self.variables.iter().map(|Variable { name, symbol, unit, range: values }| {
            let (range, low, high) = match *values {
                Range::Circle => (range::CIRCLE, 0.0, 0.0),
                Range::Interval { low, high } => (range::INTERVAL, low, high),
            };
            let (name, symbol, unit) = (pack(name), pack(symbol), pack(unit));
            VariableEntry { low, high, range, reserved: 0, name, symbol, unit }
        });
        let parameters = self.parameters.iter().map(|Parameter { name, symbol, value }| ParameterEntry {
            value: *value,
            name: pack(name),
            symbol: pack(symbol),
        });
        let projections = self.projections.iter().map(|&Projection { first, second }| {
            let (other, other_bins) = second.unwrap_or((0, 0));
            ProjectionEntry {
                dimensions: if second.is_some() { 2 } else { 1 },
                first: first.0 as u32,
                second: other as u32,
                first_bins: first.1 as u32,
                second_bins: other_bins as u32,
                reserved: 0,
            }
        });
        if self.snapshots.len() > MOST_SNAPSHOTS {
            return Err(format!("{} snapshots, a message holds {MOST_SNAPSHOTS}", self.snapshots.len()));
        }
        let header = ScenarioHeader {
            run_id: self.run_id,
            critical: self.critical,
            scenario: self.scenario,
            scenarios: self.scenarios,
            snapshots: self.snapshots.len() as u32,
            reentry: self.reentry as u32,
            variable_count: self.variables.len() as u32,
            parameter_count: self.parameters.len() as u32,
            projection_count: self.projections.len() as u32,
            reserved: 0,
            name: pack(&self.name),
            model: pack(&self.model),
            variables: filled::<_, MOST_VARIABLES>("variables", variables)?,
            parameters: filled::<_, MOST_PARAMETERS>("parameters", parameters)?,
            projections: filled::<_, MOST_PROJECTIONS>("projections", projections)?,
        };
        let mut items = self.mean.clone();
        items.extend(&self.covariance);
        for Moment { time, ends } in &self.snapshots {
            items.push(*time);
            items.extend(ends.as_flattened());
        }
        Ok((header, items))
    }
}

/// The first `count` entries, which are those in use; there must be at least `least` of them.
fn entries<'a, T>(what: &str, count: u32, least: usize, entries: &'a [T]) -> Result<&'a [T], String> {
    let most = entries.len();
    let used = entries.get(..count as usize).filter(|used| used.len() >= least);
    used.ok_or_else(|| format!("{what}: it has {count}, a message holds {least} to {most}"))
}

/// The value of each entry; an error names the position of its entry.
fn numbered<T, V>(what: &str, entries: &[T], read: impl Fn(&T) -> Result<V, String>) -> Result<Vec<V>, String> {
    let named = |(k, entry): (usize, &T)| read(entry).map_err(|why| format!("{what} {k}: {why}"));
    entries.iter().enumerate().map(named).collect()
}

fn variable(entry: &VariableEntry) -> Result<Variable, String> {
    let VariableEntry { low, high, range: code, .. } = *entry;
    let range = match code {
        range::CIRCLE => Range::Circle,
        range::INTERVAL if low < high => Range::Interval { low, high },
        range::INTERVAL => return Err(format!("its values lie between {low} and {high}, the first must be the lower")),
        other => return Err(format!("its range {other} is unknown to this version")),
    };
    let symbol = unpack(&entry.symbol);
    if symbol.is_empty() {
        return Err("it has no symbol".into());
    }
    Ok(Variable { name: unpack(&entry.name), symbol, unit: unpack(&entry.unit), range })
}

fn parameter(entry: &ParameterEntry) -> Result<Parameter, String> {
    let name = unpack(&entry.name);
    match entry.value.is_finite() {
        true if name.is_empty() => Err("it has no name".into()),
        true => Ok(Parameter { name, symbol: unpack(&entry.symbol), value: entry.value }),
        false => Err(format!("{name} is {}, it must be a finite number", entry.value)),
    }
}

fn projection(entry: &ProjectionEntry, variables: usize) -> Result<Projection, String> {
    let ProjectionEntry { dimensions, first, second, first_bins, second_bins, .. } = *entry;
    let axis = |variable: u32, bins: u32| match (variable as usize, bins as usize) {
        (variable, _) if variable >= variables => {
            Err(format!("there is no variable {variable}, there are {variables}"))
        }
        (variable, 0) => Err(format!("its axis of variable {variable} has no bins")),
        (variable, bins) => Ok((variable, bins)),
    };
    match dimensions {
        1 => Ok(Projection { first: axis(first, first_bins)?, second: None }),
        2 if first == second => Err(format!("both of its variables are variable {first}")),
        2 => Ok(Projection { first: axis(first, first_bins)?, second: Some(axis(second, second_bins)?) }),
        other => Err(format!("it has {other} variables, it must have 1 or 2")),
    }
}

fn filled<T: Default + Copy, const N: usize>(
    what: &str,
    entries: impl ExactSizeIterator<Item = T>,
) -> Result<[T; N], String> {
    if entries.len() > N {
        return Err(format!("{} {what}, a message holds {N}", entries.len()));
    }
    let mut all = [T::default(); N];
    all.iter_mut().zip(entries).for_each(|(place, entry)| *place = entry);
    Ok(all)
}
