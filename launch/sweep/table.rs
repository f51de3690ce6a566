//! `sweep.csv`: one row per scenario and method, with the values that were varied and the results at the last time.

use std::path::Path;

use nodes::files::sweep::Sweep;
use results::description::{self, Quantity, Statistic};
use results::files;
use results::rows::PassageRow;
use results::table::{Table, read};

use super::Done;

/// The table's name.
pub const TABLE: &str = "sweep.csv";

/// The columns of the first passages, after those of the moments.
const PASSAGES: [&str; 3] = ["prob_reached_critical_e", "low", "high"];

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
    /// The results, each with its column; none if the combination was refused. NaN stands for what a method does not
    /// say.
    pub numbers: Vec<(String, f64)>,
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
            numbers: Vec::new(),
            folder: String::new(),
            problem: why.into(),
        }
    }

    /// Whether it has any result.
    pub(super) fn has_numbers(&self) -> bool {
        self.numbers.iter().any(|(_, number)| !number.is_nan())
    }

    /// The number in a column; NaN if it has none there.
    pub(super) fn number(&self, column: &str) -> f64 {
        self.numbers.iter().find(|(name, _)| name == column).map_or(f64::NAN, |(_, number)| *number)
    }

    /// All cells of the row, with its numbers in these columns.
    fn cells(&self, columns: &[String]) -> Vec<String> {
        let names = [self.scenario.clone(), self.method.clone()];
        let numbers = self.values.iter().map(f64::to_string).chain(columns.iter().map(|c| self.number(c).to_string()));
        names.into_iter().chain(numbers).chain([self.folder.clone(), self.problem.clone()]).collect()
    }
}

/// The columns of the numbers of all rows, in the order in which they come. Scenarios of one model have the same.
pub(super) fn columns(rows: &[Row]) -> Vec<String> {
    let mut columns: Vec<String> = Vec::new();
    for (column, _) in rows.iter().flat_map(|row| &row.numbers) {
        if !columns.contains(column) {
            columns.push(column.clone());
        }
    }
    columns
}

/// The rows of a scenario that has been recorded in its folder below `folder`.
pub(super) fn rows(sweep: &Sweep, done: &Done, cases: &[String], folder: &Path) -> Result<Vec<Row>, String> {
    let folder = folder.join(&done.folder);
    let moments = results::moments::read(&folder.join(files::MOMENTS)).map_err(|e| e.to_string())?;
    let passages: Vec<PassageRow> = read(&folder.join(files::FIRST_PASSAGE)).map_err(|e| e.to_string())?;
    let described = description::read(&folder).map_err(|e| e.to_string())?;
    let is_shown =
        |quantity: &&Quantity| !matches!(quantity.statistic, Statistic::CircularMean | Statistic::ResultantLength);
    let quantities = || described.iter().flat_map(|scenario| &scenario.quantities).filter(is_shown);
    let row = |case: &String| {
        // The tables are in the order of time: the last row of a method is that of the end.
        let moments = moments.iter().rfind(|row| row.method == *case);
        let passage = passages.iter().rfind(|row| row.method == *case);
        let passage = passage.map_or([f64::NAN; 3], |last| [last.prob_reached_critical_e, last.low, last.high]);
        let number = |column: &str| moments.map_or(f64::NAN, |last| last.number(column));
        let time = ("t_yr".to_owned(), moments.map_or(f64::NAN, |last| last.t_yr));
        let numbers = [time]
            .into_iter()
            .chain(quantities().map(|quantity| (quantity.column.clone(), number(&quantity.column))))
            .chain(PASSAGES.map(String::from).into_iter().zip(passage))
            .collect();
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
    let columns = columns(rows);
    let names = columns.iter().map(String::as_str);
    let head: Vec<&str> = ["scenario", "method"]
        .into_iter()
        .chain(keys.iter().copied())
        .chain(names)
        .chain(["folder", "problem"])
        .collect();
    let mut table = Table::with_head(path, head).map_err(|e| e.to_string())?;
    table.write(rows.iter().map(|row| row.cells(&columns))).and_then(|()| table.finish()).map_err(|e| e.to_string())
}
