//! Joins the folders of the scenarios of a run into one results folder.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use zip::{ZipArchive, ZipWriter};

use crate::error::FolderError;
use crate::files::{SCENARIO, part};

/// Moves what the recorder has written of scenarios `0..scenarios` up into `folder`: tables one after the other,
/// descriptions line by line, archives entry by entry. The scenario files themselves are there already, as their
/// authors wrote them.
///
/// # Errors
/// If something cannot be read or written.
pub fn join(folder: &Path, scenarios: u32) -> Result<(), FolderError> {
    let parts: Vec<PathBuf> = (0..scenarios).map(|scenario| part(folder, scenario)).collect();
    for name in file_names(&parts)?.into_iter().filter(|name| name != SCENARIO) {
        let files: Vec<PathBuf> = parts.iter().map(|part| part.join(&name)).collect();
        let whole = folder.join(&name);
        let joined = match (&files[..], whole.extension().and_then(|e| e.to_str())) {
            ([only], _) => fs::rename(only, &whole),
            (several, Some("npz")) => join_archives(several, &whole),
            (several, Some("jsonl")) => join_lines(several, &whole),
            (several, _) => join_tables(several, &whole),
        };
        joined.map_err(|e| FolderError::new(&whole, e))?;
    }
    for part in &parts {
        fs::remove_dir_all(part).map_err(|e| FolderError::new(part, e))?;
    }
    Ok(())
}

/// Writes into `folder` the tables of all `parts`, one after the other.
///
/// # Errors
/// If something cannot be read or written.
pub fn join_all_tables(parts: &[PathBuf], folder: &Path) -> Result<(), FolderError> {
    for name in file_names(parts)?.into_iter().filter(|name| name.ends_with(".csv")) {
        let tables: Vec<PathBuf> = parts.iter().map(|part| part.join(&name)).collect();
        let whole = folder.join(&name);
        join_tables(&tables, &whole).map_err(|e| FolderError::new(&whole, e))?;
    }
    Ok(())
}

/// The names of the files that every part has.
fn file_names(parts: &[PathBuf]) -> Result<Vec<String>, FolderError> {
    let Some(first) = parts.first() else { return Ok(Vec::new()) };
    let entries = fs::read_dir(first).map_err(|e| FolderError::new(first, e))?;
    let names = entries.map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    names.collect::<Result<_, _>>().map_err(|e| FolderError::new(first, e))
}

/// Rows of all tables. Scenarios of different models have different columns: the joined table has those of all, with
/// `NaN` where a scenario has no such column.
fn join_tables(tables: &[PathBuf], whole: &Path) -> io::Result<()> {
    let heads: Vec<Vec<u8>> = tables.iter().map(|table| head_of(table)).collect::<Result<_, _>>()?;
    if heads.iter().any(|head| *head != heads[0]) {
        return join_by_columns(tables, whole).map_err(io::Error::other);
    }
    let mut joined = BufWriter::new(File::create(whole)?);
    for (position, table) in tables.iter().enumerate() {
        let mut rows = BufReader::new(File::open(table)?);
        let mut head = Vec::new();
        rows.read_until(b'\n', &mut head)?;
        if position == 0 {
            joined.write_all(&head)?;
        }
        io::copy(&mut rows, &mut joined)?;
    }
    joined.flush()
}

/// The first line of a table.
fn head_of(table: &Path) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    BufReader::new(File::open(table)?).read_until(b'\n', &mut head)?;
    Ok(head)
}

/// Rows of tables with different columns.
fn join_by_columns(tables: &[PathBuf], whole: &Path) -> Result<(), csv::Error> {
    let mut columns: Vec<String> = Vec::new();
    for table in tables {
        for column in csv::Reader::from_path(table)?.headers()? {
            if !columns.iter().any(|known| known == column) {
                columns.push(column.to_owned());
            }
        }
    }
    let mut joined = csv::Writer::from_path(whole)?;
    joined.write_record(&columns)?;
    for table in tables {
        let mut rows = csv::Reader::from_path(table)?;
        let head = rows.headers()?.clone();
        let places: Vec<Option<usize>> =
            columns.iter().map(|column| head.iter().position(|own| own == column)).collect();
        for row in rows.records() {
            let row = row?;
            joined.write_record(places.iter().map(|place| place.and_then(|place| row.get(place)).unwrap_or("NaN")))?;
        }
    }
    Ok(joined.flush()?)
}

/// All lines of all files.
fn join_lines(files: &[PathBuf], whole: &Path) -> io::Result<()> {
    let mut joined = BufWriter::new(File::create(whole)?);
    for file in files {
        io::copy(&mut File::open(file)?, &mut joined)?;
    }
    joined.flush()
}

/// All entries of all archives.
fn join_archives(archives: &[PathBuf], whole: &Path) -> io::Result<()> {
    // Not dropped if an entry cannot be copied: dropping it would then print a message to standard error.
    let mut joined = ManuallyDrop::new(ZipWriter::new(BufWriter::new(File::create(whole)?)));
    for archive in archives {
        let mut entries = ZipArchive::new(BufReader::new(File::open(archive)?))?;
        for index in 0..entries.len() {
            joined.raw_copy_file(entries.by_index_raw(index)?)?;
        }
    }
    ManuallyDrop::into_inner(joined).finish()?.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_with_different_columns_are_joined_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let table = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let tables = [table("a", "scenario,mean_e,p\na,1,2\n"), table("b", "scenario,mean_e,mean_C,p\nb,3,4,5\n")];
        let whole = folder.path().join("whole.csv");
        join_tables(&tables, &whole).unwrap();
        assert_eq!(fs::read_to_string(whole).unwrap(), "scenario,mean_e,p,mean_C\na,1,2,NaN\nb,3,5,4\n");
    }
}
