//! The tables as Parquet files, for programs that read columns: pandas, polars, DuckDB, Spark.
//!
//! A column whose cells are all numbers is one of `DOUBLE`, with a withheld number as `NaN`; every other column is text
//! in UTF-8.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Stored};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::error::FolderError;
use crate::files::{DIAGNOSTICS, DISTANCES, EFFORT, ERRORS, FIRST_PASSAGE, GIVEN_RE_ENTRY, MOMENTS, NOTES, VERDICTS};
use crate::manifest::{self, Manifest};

/// The tables of a results folder.
const TABLES: [&str; 9] =
    [MOMENTS, ERRORS, DISTANCES, EFFORT, FIRST_PASSAGE, GIVEN_RE_ENTRY, DIAGNOSTICS, NOTES, VERDICTS];

/// The columns that are text, also in a table without rows.
const TEXTS: [&str; 15] = [
    "scenario",
    "method",
    "reference",
    "quantity",
    "density",
    "measure",
    "diagnostic",
    "note",
    "interval",
    "given",
    "errors",
    "verdict",
    "moments_quantity",
    "moments_judged_by",
    "density_judged_by",
];

/// Writes every table that is in the folder `from` into the folder `to`, under its name with the ending `parquet`. The
/// metadata of each file have the name of the run and the versions of the program under `phasecloud`, as JSON. Returns
/// the files.
///
/// # Errors
/// Which file cannot be read or written, and why.
pub fn write(from: &Path, to: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let about = about(from)?;
    let present = TABLES.iter().map(|name| from.join(name)).filter(|path| path.is_file());
    let convert = |table: PathBuf| {
        let path = to.join(table.file_name().unwrap_or_default()).with_extension("parquet");
        let columns = read(&table)?;
        write_file(&path, &columns, &about).map_err(|e| FolderError::new(&path, e)).map(|()| path)
    };
    present.map(convert).collect()
}

/// What the metadata of every file say of the run.
fn about(folder: &Path) -> Result<String, FolderError> {
    let manifest: Manifest = manifest::read(folder)?;
    Ok(serde_json::json!({ "run_id": manifest.run_id, "versions": manifest.versions }).to_string())
}

/// A column with its name.
struct Column {
    name: String,
    cells: Cells,
}

enum Cells {
    Numbers(Vec<f64>),
    Texts(Vec<ByteArray>),
}

fn read(table: &Path) -> Result<Vec<Column>, FolderError> {
    let failed = |e: csv::Error| FolderError::new(table, e);
    let mut reader = csv::Reader::from_path(table).map_err(failed)?;
    let head = reader.headers().map_err(failed)?.clone();
    let mut cells: Vec<Vec<String>> = vec![Vec::new(); head.len()];
    for row in reader.records() {
        for (column, cell) in cells.iter_mut().zip(&row.map_err(failed)?) {
            column.push(cell.into());
        }
    }
    Ok(head.iter().zip(cells).map(|(name, cells)| Column { name: name.into(), cells: typed(name, cells) }).collect())
}

fn typed(name: &str, cells: Vec<String>) -> Cells {
    let numbers = || cells.iter().map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>();
    let numbers = if TEXTS.contains(&name) { None } else { numbers() };
    numbers.map_or_else(|| Cells::Texts(cells.iter().map(|cell| cell.as_str().into()).collect()), Cells::Numbers)
}

fn write_file(path: &Path, columns: &[Column], about: &str) -> Result<(), ParquetError> {
    let fields = columns.iter().map(|column| column.field().map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("table").with_fields(fields).build()?;
    let about = KeyValue::new("phasecloud".into(), about.to_string());
    let properties = WriterProperties::builder().set_key_value_metadata(Some(vec![about])).build();
    let mut writer = SerializedFileWriter::new(File::create(path)?, Arc::new(schema), Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    for column in columns {
        let mut written = rows.next_column()?.ok_or_else(|| ParquetError::General("a column is missing".into()))?;
        match &column.cells {
            Cells::Numbers(cells) => written.typed::<DoubleType>().write_batch(cells, None, None)?,
            Cells::Texts(cells) => written.typed::<ByteArrayType>().write_batch(cells, None, None)?,
        };
        written.close()?;
    }
    rows.close()?;
    writer.close().map(|_| ())
}

impl Column {
    fn field(&self) -> Result<Type, ParquetError> {
        let (stored, meant) = match self.cells {
            Cells::Numbers(_) => (Stored::DOUBLE, None),
            Cells::Texts(_) => (Stored::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(&self.name, stored);
        builder.with_repetition(Repetition::REQUIRED).with_logical_type(meant).build()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    #[test]
    fn a_table_comes_back_with_its_types_and_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let rows = "scenario,method,t_yr,mean_e\n1,mc,0.1,0.30000000000000004\n1,\"a, b\",0.2,NaN\n";
        std::fs::write(folder.path().join(MOMENTS), rows).unwrap();
        std::fs::write(folder.path().join(NOTES), "scenario,method,t_yr,note\n").unwrap();
        std::fs::write(folder.path().join("manifest.json"), manifest()).unwrap();
        let out = tempfile::tempdir().unwrap();
        let files = write(folder.path(), out.path()).unwrap();
        assert_eq!(files, [out.path().join("moments.parquet"), out.path().join("notes.parquet")]);

        let reader = SerializedFileReader::new(File::open(&files[0]).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        let of = |row: usize| rows[row].get_column_iter().map(|(_, field)| field.clone()).collect::<Vec<_>>();
        let text = |text: &str| Field::Str(text.into());
        assert_eq!(of(0), [text("1"), text("mc"), Field::Double(0.1), Field::Double(0.1 + 0.2)]);
        assert_eq!(of(1)[1], text("a, b"));
        assert!(matches!(of(1)[3], Field::Double(value) if value.is_nan()));
        let about = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(
            about.iter().any(|pair| pair.key == "phasecloud" && pair.value.as_ref().unwrap().contains("\"run-7\""))
        );

        let empty = SerializedFileReader::new(File::open(&files[1]).unwrap()).unwrap();
        assert_eq!(empty.metadata().file_metadata().num_rows(), 0);
        assert_eq!(empty.metadata().file_metadata().schema_descr().num_columns(), 4);
    }

    #[test]
    fn a_folder_without_a_manifest_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let refused = write(folder.path(), folder.path()).unwrap_err().to_string();
        assert!(refused.contains("manifest.json") && refused.contains("phasecloud run"), "{refused}");
    }

    fn manifest() -> String {
        serde_json::to_string(&Manifest { run_id: "run-7".into(), ..Manifest::default() }).unwrap()
    }

    /// The Python module reads the same tables.
    #[test]
    fn python_has_the_same_columns_of_text() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/phasecloud/tables.py");
        let source = std::fs::read_to_string(file).unwrap();
        let list = source.split_once("TEXTS = {").and_then(|(_, rest)| rest.split_once('}')).unwrap().0;
        let mut names: Vec<&str> = list.split(',').map(|name| name.trim().trim_matches('"')).collect();
        names.retain(|name| !name.is_empty());
        assert_eq!(names, TEXTS);
    }
}
