//! The results folder: which files it holds, which columns its tables have, and how both are written and read.
//!
//! The recorder writes with this crate; the figures, the report and the launcher read with it. [`Results::read`] reads
//! a whole folder. `docs/results.md` describes the files for readers in other languages.
//!
//! ```
//! use results::rows::DiagnosticRow;
//! use results::table::{Table, read};
//!
//! let path = std::env::temp_dir().join(format!("diagnostics-{}.csv", std::process::id()));
//! let row = DiagnosticRow {
//!     scenario: "scenario-1".into(),
//!     method: "dee".into(),
//!     t_yr: 0.5,
//!     diagnostic: "measure_defect".into(),
//!     value: 1.0e-3,
//! };
//! let mut table = Table::create::<DiagnosticRow>(&path)?;
//! table.write([&row])?;
//! table.finish()?;
//! assert_eq!(read::<DiagnosticRow>(&path)?, [row]);
//! # std::fs::remove_file(&path).unwrap();
//! # Ok::<(), results::FolderError>(())
//! ```

pub mod arrays;
pub mod description;
pub mod diagnostic_names;
mod error;
pub mod files;
mod folder;
pub mod join;
pub mod manifest;
pub mod moments;
pub mod notes;
pub mod parquet;
pub mod rows;
pub mod table;

pub use description::Description;
pub use error::FolderError;
pub use folder::Results;
pub use manifest::Manifest;
pub use moments::MomentsRow;
