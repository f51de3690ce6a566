//! The files that users write: how they are read, and how a mistake is reported with file, line and key.

pub mod file_kind;
pub mod hosts_table;
pub mod input;
mod key_path;
pub mod map_file;
pub mod plain_number;
pub mod scenario_file;
pub mod schema;
pub mod sweep;
mod sweep_values;
pub mod toml_words;
pub mod unknown_key;
