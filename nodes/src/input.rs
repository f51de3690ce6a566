//! Errors in the files that users write: where, what, and what would be right.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error};
use toml::Spanned;
use toml::de::DeTable;

/// An error in a user's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// The line, from 1; 0 for the file as a whole.
    pub line: usize,
    /// The key, with its table; empty for the file as a whole.
    pub key: String,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        if !self.key.is_empty() {
            write!(f, ": {}", self.key)?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for InputError {}

/// A TOML file that a user wrote.
#[derive(Debug, Clone)]
pub struct InputFile {
    path: PathBuf,
    text: String,
}

impl InputFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read as UTF-8 text.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        match std::fs::read_to_string(path) {
            Ok(text) => Ok(Self { path: path.into(), text }),
            Err(error) => Err(InputError {
                file: path.into(),
                line: 0,
                key: String::new(),
                problem: format!("cannot be read: {error}"),
            }),
        }
    }

    /// Text that stands for a file.
    pub fn from_text(path: &Path, text: &str) -> Self {
        Self { path: path.into(), text: text.into() }
    }

    /// The file's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file as a table of values that know where they stand.
    ///
    /// # Errors
    /// [`InputError`] if it is not TOML.
    pub fn table(&self) -> Result<Spanned<DeTable<'_>>, InputError> {
        DeTable::parse(&self.text).map_err(|error| self.toml_error(&error))
    }

    /// An error that the TOML reader found.
    pub fn toml_error(&self, error: &toml::de::Error) -> InputError {
        self.error_at(error.span(), error.message())
    }

    /// Parses the file.
    ///
    /// # Errors
    /// [`InputError`] with line and key.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        toml::from_str(&self.text).map_err(|error| self.toml_error(&error))
    }

    /// An error at a value.
    pub fn error<T>(&self, value: &Spanned<T>, problem: &str) -> InputError {
        self.error_at(Some(value.span()), problem)
    }

    /// An error of the file as a whole.
    pub fn error_in_whole(&self, problem: &str) -> InputError {
        self.error_at(None, problem)
    }

    fn error_at(&self, span: Option<Range<usize>>, problem: &str) -> InputError {
        let (line, key) = span.map_or((0, String::new()), |span| self.line_and_key(span.start));
        InputError { file: self.path.clone(), line, key, problem: problem.trim().replace('\n', "; ") }
    }

    /// The line that holds byte `offset`, and the key that is set there, with the table it stands in.
    fn line_and_key(&self, offset: usize) -> (usize, String) {
        let before = self.text.get(..offset).unwrap_or(&self.text);
        let line = before.matches('\n').count() + 1;
        let current = self.text.lines().nth(line - 1).unwrap_or("").trim();
        let table = before.lines().chain([current]).map(str::trim).rfind(|line| line.starts_with('['));
        let table = table.map_or("", |line| line.split(']').next().unwrap_or(line).trim_start_matches('[').trim());
        let key = match current.split_once('=') {
            Some((key, _)) if !current.starts_with('[') => key.trim(),
            _ => "",
        };
        let dot = if table.is_empty() || key.is_empty() { "" } else { "." };
        (line, format!("{table}{dot}{key}"))
    }
}

/// Whether a method runs corrected or as the paper printed it, flaws included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Corrected.
    #[default]
    Corrected,
    /// As the paper printed it.
    AsPrinted,
}

/// For serde: a whole number that is at least 1.
pub(crate) fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
    match i64::deserialize(deserializer)? {
        number @ 1.. => usize::try_from(number).map_err(D::Error::custom),
        number => Err(D::Error::custom(format!("{number} is not allowed, it must be at least 1"))),
    }
}

/// For serde: a whole number that is at least 1, where the key is there at all.
pub(crate) fn positive_option<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    positive(deserializer).map(Some)
}

/// Whether `name` can be a label or a name: it becomes part of file names, so it is short and plain.
pub fn is_plain_name(name: &str) -> bool {
    (1..=31).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b))
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
}

/// What [`is_plain_name`] asks for, in words.
pub const PLAIN_NAME: &str = "it must be 1 to 31 letters, digits, '-', '_' or '.', starting with a letter or digit";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_line_and_key() {
        let file = InputFile::from_text(Path::new("a.toml"), "top = 1\n[orbit]\nradiation = \"x\"\n");
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code)]
        struct Orbit {
            radiation: f64,
        }
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code)]
        struct All {
            top: u32,
            orbit: Orbit,
        }
        let error = file.parse::<All>().unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (3, "orbit.radiation"));
        assert!(error.to_string().starts_with("a.toml:3: orbit.radiation: invalid type: string \"x\""), "{error}");
    }

    #[test]
    fn names_cannot_leave_their_folder() {
        for bad in ["", "..", "a/b", ".hidden", "ä", "a\0", &"x".repeat(32)] {
            assert!(!is_plain_name(bad), "{bad}");
        }
        assert!(is_plain_name("dee-1e5"));
    }
}
