//! The files of a sweep besides the results of its scenarios: the varied values of each, and a table and a page of all.

mod page;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nodes::files::sweep::Sweep;
use nodes::services::scenario::combination_name;
use results::table::Table;

pub use table::{Row, TABLE};

/// The file in each scenario's folder that says which values were varied.
pub const VARIED: &str = "varied.csv";

/// The problem of a combination that was not reached.
const NOT_DONE: &str = "not done: the sweep was stopped";

/// A scenario of a sweep that has been recorded.
#[derive(Debug)]
pub struct Done {
    /// Its number among the combinations.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// The name of its folder.
    pub folder: String,
    /// Why cases failed, by label.
    pub failures: BTreeMap<String, String>,
    /// What cannot be right in the results of cases that did not fail, by label.
    pub errors: BTreeMap<String, String>,
}

/// Writes a scenario's values of the keys that are varied into its folder.
///
/// # Errors
/// If the file cannot be written.
pub fn write_varied(sweep: &Sweep, index: usize, scenario: &str, folder: &Path) -> Result<(), String> {
    let mut table =
        Table::with_head(&folder.join(VARIED), ["scenario", "parameter", "value"]).map_err(|e| e.to_string())?;
    let values = sweep.values(index);
    let rows = sweep.keys().zip(&values).map(|(key, value)| [scenario.to_owned(), key.to_owned(), value.to_string()]);
    table.write(rows).and_then(|()| table.finish()).map_err(|e| e.to_string())
}

/// Writes the table and the page of what has been done of a sweep. `refused` says why combinations were refused, by
/// [`combination_name`]; a combination that was neither done nor refused had not been reached when the sweep was
/// stopped.
///
/// # Errors
/// Which file cannot be written, or read.
pub fn write(
    sweep: &Sweep,
    done: &[Done],
    refused: &BTreeMap<String, String>,
    cases: &[String],
    folder: &Path,
) -> Result<(), String> {
    let mut rows = Vec::new();
    for scenario in done {
        rows.extend(table::rows(sweep, scenario, cases, folder)?);
    }
    let recorded: BTreeSet<usize> = done.iter().map(|scenario| scenario.index).collect();
    for index in (0..sweep.len()).filter(|index| !recorded.contains(index)) {
        let why = refused.get(&combination_name(index)).map_or(NOT_DONE, String::as_str);
        rows.push(Row::refused(sweep, index, why));
    }
    rows.sort_by_key(|row| row.index);
    let keys: Vec<&str> = sweep.keys().collect();
    table::write(&keys, &rows, &folder.join(TABLE))?;
    page::write(&keys, &rows, sweep.len(), folder)
}
