//! `moments.csv`, whose columns follow from the variables of the scenarios' models.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use serde::ser::{Serialize, SerializeTuple, Serializer};

use crate::error::FolderError;
use crate::rows::OfScenario;

/// The columns before the numbers.
const KEYS: [&str; 3] = ["scenario", "method", "t_yr"];

/// A row of `moments.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsRow {
    /// The scenario; empty in a table that has no such column.
    pub scenario: String,
    /// The case.
    pub method: String,
    /// Time \[yr\].
    pub t_yr: f64,
    /// The names of the numbers: `mean_phi_rad`.
    pub columns: Arc<[String]>,
    /// The numbers. `NaN` stands for a number that the method withholds, and for a standard error that it does not
    /// have.
    pub numbers: Vec<f64>,
}

impl MomentsRow {
    /// The number in a column; `NaN` if there is no such column.
    pub fn number(&self, column: &str) -> f64 {
        self.named().find(|(name, _)| *name == column).map_or(f64::NAN, |(_, number)| number)
    }

    /// The standard error of the number in a column; `NaN` if the method has none.
    pub fn standard_error(&self, column: &str) -> f64 {
        self.number(&standard_error(column))
    }

    /// The columns with their numbers.
    pub fn named(&self) -> impl Iterator<Item = (&str, f64)> {
        self.columns.iter().map(String::as_str).zip(self.numbers.iter().copied())
    }
}

impl OfScenario for MomentsRow {
    fn scenario(&self) -> &str {
        &self.scenario
    }
}

/// The column of the standard errors of a column.
pub fn standard_error(column: &str) -> String {
    format!("se_{column}")
}

/// The head of the table.
pub fn head(columns: &[String]) -> impl Iterator<Item = &str> {
    KEYS.into_iter().chain(columns.iter().map(String::as_str))
}

impl Serialize for MomentsRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_tuple(KEYS.len() + self.numbers.len())?;
        row.serialize_element(&self.scenario)?;
        row.serialize_element(&self.method)?;
        row.serialize_element(&self.t_yr)?;
        for number in &self.numbers {
            row.serialize_element(number)?;
        }
        row.end()
    }
}

/// All rows of the table at `path`.
///
/// # Errors
/// If the file is missing, or the first row that is not one of this table.
pub fn read(path: &Path) -> Result<Vec<MomentsRow>, FolderError> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| FolderError::new(path, e))?;
    rows(&mut reader).map_err(|problem| FolderError::new(path, problem))
}

/// All rows of a table in a text; the column of the scenario may be missing.
///
/// # Errors
/// The first row that is not one of this table.
pub fn from_text(text: &str) -> Result<Vec<MomentsRow>, String> {
    rows(&mut csv::Reader::from_reader(text.as_bytes()))
}

fn rows(table: &mut csv::Reader<impl Read>) -> Result<Vec<MomentsRow>, String> {
    let head = table.headers().map_err(|e| e.to_string())?.clone();
    let place = |key: &str| head.iter().position(|column| column == key);
    let (scenario, method, time) = (place(KEYS[0]), needed(place(KEYS[1]), KEYS[1])?, needed(place(KEYS[2]), KEYS[2])?);
    let is_number = |place: &usize| ![scenario, Some(method), Some(time)].contains(&Some(*place));
    let places: Vec<usize> = (0..head.len()).filter(is_number).collect();
    let columns: Arc<[String]> = places.iter().map(|&place| head[place].to_owned()).collect();
    let row = |record: csv::StringRecord| {
        let number = |place: usize| {
            let (cell, line) = (&record[place], record.position().map_or(0, csv::Position::line));
            cell.parse().map_err(|_| format!("line {line}: {} is \"{cell}\", it must be a number", &head[place]))
        };
        Ok(MomentsRow {
            scenario: scenario.map_or(String::new(), |place| record[place].to_owned()),
            method: record[method].to_owned(),
            t_yr: number(time)?,
            columns: columns.clone(),
            numbers: places.iter().map(|&place| number(place)).collect::<Result<_, String>>()?,
        })
    };
    table.records().map(|record| row(record.map_err(|e| e.to_string())?)).collect()
}

fn needed(place: Option<usize>, column: &str) -> Result<usize, String> {
    place.ok_or_else(|| format!("it has no column {column}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;

    #[test]
    fn rows_of_any_columns_are_read_as_they_were_written_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(crate::files::MOMENTS);
        let columns: Arc<[String]> = ["mean_psi_rad", "se_mean_psi_rad"].map(str::to_owned).into();
        let row = |t_yr: f64, numbers: [f64; 2]| MomentsRow {
            scenario: "turning".into(),
            method: "mc".into(),
            t_yr,
            columns: columns.clone(),
            numbers: numbers.to_vec(),
        };
        let written = [row(0.1 + 0.2, [1.0 / 3.0, 1e-300]), row(1.0, [f64::NAN, f64::INFINITY])];
        let mut table = Table::with_head(&path, head(&columns)).unwrap();
        table.write(&written).unwrap();
        table.finish().unwrap();
        let read = read(&path).unwrap();
        assert_eq!(read[0], written[0]);
        assert_eq!((read[0].number("mean_psi_rad"), read[0].standard_error("mean_psi_rad")), (1.0 / 3.0, 1e-300));
        assert!(read[1].number("mean_psi_rad").is_nan() && read[1].number("mean_r_m").is_nan());
    }

    #[test]
    fn a_cell_that_is_no_number_is_named_with_its_line_and_column() {
        let why = from_text("method,t_yr,mean_e\nmc,0,0.1\nmc,0.5,much\n").unwrap_err();
        assert_eq!(why, "line 3: mean_e is \"much\", it must be a number");
        assert_eq!(from_text("t_yr,mean_e\n0,0.1\n").unwrap_err(), "it has no column method");
    }
}
