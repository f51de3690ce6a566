//! What a scenario is about: `scenarios.jsonl`, which has one line per scenario.
//!
//! It describes the variables of the model, and says which column or array has which quantity of which variables, so
//! that a reader needs to know neither the model nor how columns are named.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::FolderError;
use crate::files::DESCRIPTIONS;

/// A scenario, and the names of its quantities in tables and archives.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
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
    /// The snapshot times \[yr\].
    pub times: Vec<f64>,
    /// The quantities of a cloud.
    pub quantities: Vec<Quantity>,
    /// The densities that are compared. The first of them is the one by which methods are judged.
    pub projections: Vec<Projection>,
}

/// A parameter of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name, for example `radiation`.
    pub name: String,
    /// Its symbol in equations, for example `C`.
    pub symbol: String,
    /// Its value.
    pub value: f64,
}

/// A variable of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// Its name, for example `solar angle`.
    pub name: String,
    /// Its symbol, for example `phi`.
    pub symbol: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// The bounds between which its values lie; none for an angle on the full circle \[rad\].
    pub bounds: Option<[f64; 2]>,
}

impl Variable {
    /// Whether it is an angle on the full circle.
    pub fn is_circle(&self) -> bool {
        self.bounds.is_none()
    }
}

/// What a quantity says of its variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// The mean of a variable; of an angle, on the branch around its circular mean.
    Mean,
    /// The standard deviation of a variable.
    Deviation,
    /// The covariance of two variables.
    Covariance,
    /// The probability that the re-entry variable exceeds its critical value at a snapshot.
    AboveCritical,
    /// The circular mean of an angle.
    CircularMean,
    /// The mean resultant length of an angle.
    ResultantLength,
}

/// A quantity of a cloud.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quantity {
    /// What it says of its variables.
    pub statistic: Statistic,
    /// The positions of its variables.
    pub variables: Vec<usize>,
    /// Its name in `errors.csv` and `verdicts.csv`: `mean_phi`.
    pub name: String,
    /// Its column in `moments.csv`: `mean_phi_rad`.
    pub column: String,
}

/// A density that is compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Projection {
    /// Its name in `distances.csv` and in `densities.npz`: `joint`.
    pub density: String,
    /// The positions of its variables, one or two; the first is outermost in the array.
    pub variables: Vec<usize>,
}

impl Description {
    /// The quantities of this statistic, in the order of their variables.
    pub fn of(&self, statistic: Statistic) -> impl Iterator<Item = &Quantity> {
        self.quantities.iter().filter(move |quantity| quantity.statistic == statistic)
    }

    /// The column of the probability that the re-entry variable exceeds its critical value.
    pub fn above_critical(&self) -> &str {
        self.of(Statistic::AboveCritical).next().map_or("", |quantity| quantity.column.as_str())
    }

    /// The variable that grows to its critical value when the satellite re-enters.
    pub fn reentry_variable(&self) -> Option<&Variable> {
        self.variables.get(self.reentry)
    }

    /// The density of two variables and their positions, for each projection on two variables.
    pub fn pairs(&self) -> impl Iterator<Item = (&str, [usize; 2])> {
        self.projections.iter().filter_map(|projection| match projection.variables[..] {
            [first, second] => Some((projection.density.as_str(), [first, second])),
            _ => None,
        })
    }

    /// The name of the density of one variable by itself, if it is compared.
    pub fn marginal(&self, variable: usize) -> Option<&str> {
        let found = self.projections.iter().find(|projection| projection.variables == [variable]);
        found.map(|projection| projection.density.as_str())
    }
}

/// Writes the description of a scenario into a folder.
///
/// # Errors
/// If it cannot be written.
pub fn write(folder: &Path, description: &Description) -> Result<(), FolderError> {
    let path = folder.join(DESCRIPTIONS);
    let line = serde_json::to_string(description).map_err(|e| FolderError::new(&path, e))?;
    std::fs::write(&path, line + "\n").map_err(|e| FolderError::new(&path, e))
}

/// The descriptions of all scenarios of a folder; none if it is of a version that did not write them.
///
/// # Errors
/// Which line is damaged.
pub fn read(folder: &Path) -> Result<Vec<Description>, FolderError> {
    let path = folder.join(DESCRIPTIONS);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).map_err(|e| FolderError::new(&path, e))?;
    let description = |(number, line): (usize, &str)| {
        let read: Description = serde_json::from_str(line)
            .map_err(|e| e.to_string())
            .and_then(checked)
            .map_err(|e| FolderError::new(&path, format!("line {}: {e}", number + 1)))?;
        Ok(read)
    };
    text.lines().enumerate().map(description).collect()
}

/// A description whose positions are those of variables that exist.
fn checked(description: Description) -> Result<Description, String> {
    let count = description.variables.len();
    match strange_position(&description) {
        Some(position) => Err(format!("there is no variable {position}, there are {count}")),
        None => Ok(description),
    }
}

/// The first position of which there is no variable.
fn strange_position(description: &Description) -> Option<usize> {
    let of_quantities = description.quantities.iter().flat_map(|quantity| &quantity.variables);
    let of_projections = description.projections.iter().flat_map(|projection| &projection.variables);
    let positions = of_quantities.chain(of_projections).chain([&description.reentry]);
    positions.copied().find(|position| *position >= description.variables.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description() -> Description {
        let variable =
            |symbol: &str, bounds| Variable { name: symbol.into(), symbol: symbol.into(), unit: String::new(), bounds };
        Description {
            name: "turning".into(),
            variables: vec![variable("psi", None), variable("z", Some([-100.0, 100.0]))],
            reentry: 1,
            critical: 0.1 + 0.2,
            times: vec![0.1 + 0.2, 1e-300, 1.0 / 3.0],
            projections: vec![Projection { density: "joint".into(), variables: vec![0, 1] }],
            ..Description::default()
        }
    }

    #[test]
    fn a_description_is_read_as_it_was_written_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read(folder.path()).unwrap(), []);
        write(folder.path(), &description()).unwrap();
        assert_eq!(read(folder.path()).unwrap(), [description()]);
    }

    #[test]
    fn a_position_without_a_variable_is_refused_with_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let projections = vec![Projection { density: "joint".into(), variables: vec![0, 2] }];
        write(folder.path(), &Description { projections, ..description() }).unwrap();
        let why = read(folder.path()).unwrap_err().to_string();
        assert!(why.ends_with("line 1: there is no variable 2, there are 2"), "{why}");
    }
}
