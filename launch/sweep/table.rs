//! `sweep.csv`: one row per scenario and method, with the values that were varied and the results at the last time.

use std::path::Path;

use nodes::files::sweep::Sweep;
use results::files;
use results::rows::PassageRow;
use results::table::{Table, read};

use super::Done;

/// The table's name.
pub const TABLE: &str = "sweep.csv";

/// The columns after those of the varied values.
pub(super) const NUMBERS: [&str; 10] = [
    "t_yr",
    "mean_phi_rad",
    "std_phi_rad",
    "mean_e",
    "std_e",
    "cov_phi_e",
    "prob_above_critical_e",
    "prob_reached_critical_e",
    "low",
    "high",
];

/// A row of the table.
#[derive(Debug, Clone)]
pub struct Row {
    /// Number of the combination.
    pub index: usize,
    /// The scenario's name.
    pub scenario: String,
    /// The case; empty if the combination was refused.
    pub method: String,
    /// The varied values.
    pub values: Vec<f64>,
    /// The results, in the order of [`NUMBERS`]; NaN where there is none.
    pub numbers: [f64; NUMBERS.len()],
    /// The scenario's folder; empty if there is none.
    pub folder: String,
    /// Why there are no numbers, or what cannot be right in them; empty if all is well.
    pub problem: String,
}

impl Row {
    /// The row of a combination that was refused, or not done.
    pub fn refused(sweep: &Sweep, index: usize, why: &str) -> Self {
        Self {
            index,
            scenario: sweep.name(index),
            method: String::new(),
            values: sweep.values(index),
            numbers: [f64::NAN; NUMBERS.len()],
            folder: String::new(),
            problem: why.into(),
        }
    }

    /// Whether it has any result.
    pub(super) fn has_numbers(&self) -> bool {
        self.numbers.iter().any(|number| !number.is_nan())
    }

    /// All cells of the row.
    fn cells(&self) -> Vec<String> {
        let names = [self.scenario.clone(), self.method.clone()];
        let numbers = self.values.iter().chain(&self.numbers).map(f64::to_string);
        names.into_iter().chain(numbers).chain([self.folder.clone(), self.problem.clone()]).collect()
    }
}

/// The rows of a scenario that has been recorded in its folder below `folder`.
pub(super) fn rows(sweep: &Sweep, done: &Done, cases: &[String], folder: &Path) -> Result<Vec<Row>, String> {
    let folder = folder.join(&done.folder);
    let moments = results::moments::read(&folder.join(files::MOMENTS)).map_err(|e| e.to_string())?;
    let passages: Vec<PassageRow> = read(&folder.join(files::FIRST_PASSAGE)).map_err(|e| e.to_string())?;
    let row = |case: &String| {
        let mut numbers = [f64::NAN; NUMBERS.len()];
        // The tables are in the order of time: the last row of a method is that of the end.
        if let Some(last) = moments.iter().rfind(|row| row.method == *case) {
            numbers = NUMBERS.map(|column| last.number(column));
            numbers[0] = last.t_yr;
        }
        if let Some(last) = passages.iter().rfind(|row| row.method == *case) {
            [numbers[7], numbers[8], numbers[9]] = [last.prob_reached_critical_e, last.low, last.high];
        }
        Row {
            index: done.index,
            scenario: done.name.clone(),
            method: case.clone(),
            values: sweep.values(done.index),
            numbers,
            folder: done.folder.clone(),
            problem: done.failures.get(case).or_else(|| done.errors.get(case)).cloned().unwrap_or_default(),
        }
    };
    Ok(cases.iter().map(row).collect())
}

/// Writes the table; its head is there also without rows.
pub(super) fn write(keys: &[&str], rows: &[Row], path: &Path) -> Result<(), String> {
    let head: Vec<&str> =
        ["scenario", "method"].iter().chain(keys).chain(&NUMBERS).chain(&["folder", "problem"]).copied().collect();
    let mut table = Table::with_head(path, head).map_err(|e| e.to_string())?;
    table.write(rows.iter().map(Row::cells)).and_then(|()| table.finish()).map_err(|e| e.to_string())
}
