//! Errors in the files that users write: where, what, and what would be right.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use messages::text;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error};
use toml::Spanned;
use toml::de::DeTable;

use crate::files::file_kind::FileKind;
use crate::files::key_path::key_at;
use crate::files::toml_words::in_plain_words;
use crate::files::unknown_key::UnknownKey;

/// Longest file that is read \[bytes\]; a launch file with all its cases is about a hundredth of it.
const LONGEST: u64 = 1 << 20;
/// Longest text of a file that an error repeats \[characters\].
const LONGEST_QUOTE: usize = 300;
/// Tables that a file has as a list.
const LISTS: [&str; 1] = ["propagator"];

/// An error in a user's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// The line, from 1; 0 if the file cannot be read at all.
    pub line: usize,
    /// The key, with its table; empty where the text is not TOML and no key can be made out.
    pub key: String,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.file.to_string_lossy()))?;
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
    /// If it cannot be read, is longer than any file of these kinds, or is not UTF-8 text.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let unreadable = |problem: String| InputError { file: path.into(), line: 0, key: String::new(), problem };
        let mut bytes = Vec::new();
        File::open(path)
            .and_then(|file| file.take(LONGEST + 1).read_to_end(&mut bytes))
            .map_err(|e| unreadable(format!("cannot be read: {e}")))?;
        if bytes.len() as u64 > LONGEST {
            return Err(unreadable(format!("is longer than {LONGEST} bytes, which no such file is")));
        }
        Self::from_bytes(path, bytes)
    }

    /// Takes bytes as if they were the content of the file `path`.
    ///
    /// # Errors
    /// If they are not UTF-8 text.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        String::from_utf8(bytes).map(|text| Self { path: path.into(), text }).map_err(|error| {
            let good = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes().get(..good).unwrap_or_default()).into_owned();
            let file = Self { path: path.into(), text };
            file.error_at(Some(good..good), "is not UTF-8 text from here on")
        })
    }

    /// Takes a text as if it were the content of the file `path`.
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

    /// The file as a table of values that know their places in the text.
    ///
    /// # Errors
    /// [`InputError`] if it is not TOML.
    pub fn table(&self) -> Result<Spanned<DeTable<'_>>, InputError> {
        DeTable::parse(&self.text).map_err(|error| match error.message() {
            "duplicate key" => self.duplicate(error.span()),
            message => self.error_at(error.span(), &format!("is not TOML: {message}")),
        })
    }

    /// An error about a key that is in its table twice, or about a list of tables that is written without double
    /// brackets.
    fn duplicate(&self, span: Option<Range<usize>>) -> InputError {
        let told = self.error_at(span, "stands in its table for the second time; leave out one of the two");
        let line = self.text.lines().nth(told.line.saturating_sub(1)).unwrap_or("");
        let is_one = LISTS.contains(&told.key.as_str()) && line.trim_start().starts_with('[');
        if !is_one {
            return told;
        }
        let problem = format!("there may be several of these: write [[{}]] above each, in double brackets", told.key);
        InputError { problem, ..told }
    }

    /// An error that the TOML reader found in a table's keys or values.
    pub fn toml_error(&self, error: &toml::de::Error) -> InputError {
        if let Some(unknown) = UnknownKey::told_by(error.message()) {
            return self.error_at(error.span(), &unknown.problem());
        }
        let told = self.error_at(error.span(), &in_plain_words(error.message()));
        let Some(missing) = error.message().strip_prefix("missing field `").and_then(|rest| rest.split('`').next())
        else {
            return told;
        };
        let (key, table) = match told.key.as_str() {
            "" => (missing.to_owned(), self.kind_in_words()),
            table => (format!("{table}.{missing}"), format!("the table `{table}`")),
        };
        InputError { key, problem: format!("{table} lacks the key `{missing}`"), ..told }
    }

    /// The kind of the file in words, as its keys show it.
    fn kind_in_words(&self) -> String {
        self.kind().map_or("the file".into(), |kind| format!("the {}", kind.words().trim_start_matches("a ")))
    }

    /// The kind of file that it is by most of its keys.
    pub fn kind(&self) -> Option<FileKind> {
        FileKind::told_by(self.table().ok()?.get_ref()).map(|(kind, _)| kind)
    }

    /// Refuses a file of another kind.
    ///
    /// # Errors
    /// Which kind it is, and what to do with it.
    pub fn expect(&self, kind: FileKind) -> Result<(), InputError> {
        let Ok(table) = self.table() else { return Ok(()) }; // the reader says what is wrong
        match FileKind::told_by(table.get_ref()) {
            Some((found, key)) if found != kind => Err(self.error(key, &kind.instead_of(found, &self.path))),
            _ => Ok(()),
        }
    }

    /// Parses the file.
    ///
    /// # Errors
    /// [`InputError`] with line and key.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        T::deserialize(toml::de::Deserializer::from(self.table()?)).map_err(|error| self.toml_error(&error))
    }

    /// An error at a value.
    pub fn error<T>(&self, value: &Spanned<T>, problem: &str) -> InputError {
        self.error_at(Some(value.span()), problem)
    }

    /// An error about a key that is missing.
    pub fn error_in_whole(&self, key: &str, problem: &str) -> InputError {
        InputError { key: key.into(), ..self.error_at(None, problem) }
    }

    fn error_at(&self, span: Option<Range<usize>>, problem: &str) -> InputError {
        // The TOML reader reports a key that is missing from the whole file at all of its bytes, or at none.
        let whole = [0..self.text.len(), 0..0];
        let start = span.filter(|span| !whole.contains(span)).map(|span| span.start);
        let before = start.and_then(|start| self.text.get(..start)).unwrap_or("");
        let key = start.map_or(String::new(), |start| key_at(&self.text, start));
        InputError {
            file: self.path.clone(),
            line: before.matches('\n').count() + 1,
            key: printable(&key),
            problem: printable(&problem.trim().replace('\n', "; ")),
        }
    }
}

/// Text from a file as an error may repeat it: cut in the middle if it is too long, and without codes that a terminal
/// would obey.
fn printable(quoted: &str) -> String {
    let length = quoted.chars().count();
    if length <= LONGEST_QUOTE {
        return text::printable(quoted);
    }
    let half = LONGEST_QUOTE / 2;
    let (head, tail): (String, String) =
        (quoted.chars().take(half).collect(), quoted.chars().skip(length - half).collect());
    format!("{}…{}", text::printable(&head), text::printable(&tail))
}

/// Whether a method runs corrected or as the paper printed it, flaws included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, serde::Deserialize, JsonSchema)]
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
    at_least::<1, D>(deserializer)
}

/// For serde: a whole number that is at least `LEAST`.
pub(crate) fn at_least<'de, const LEAST: usize, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
    let number = i64::deserialize(deserializer)?;
    let fits = usize::try_from(number).ok().filter(|number| *number >= LEAST);
    fits.ok_or_else(|| D::Error::custom(format!("{number} is not allowed, it must be at least {LEAST}")))
}

/// For serde: a whole number that is at least 1, if the key is present.
pub(crate) fn positive_option<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    positive(deserializer).map(Some)
}

/// For serde: a whole number that is at least 0. A number that is too large for a TOML file is refused, since it
/// could not be passed on.
pub(crate) fn natural<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    let number = i64::deserialize(deserializer)?;
    u64::try_from(number).map_err(|_| D::Error::custom(format!("{number} is not allowed, it must be at least 0")))
}

/// For serde: a whole number that is at least 0, if the key is present.
pub(crate) fn natural_option<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    natural(deserializer).map(Some)
}

/// Whether `name` can be a label or a name: it becomes part of file names, so it is short and plain.
pub fn is_plain_name(name: &str) -> bool {
    (1..=LONGEST_PLAIN_NAME).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b))
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
}

/// Longest name that [`is_plain_name`] allows \[characters\].
pub const LONGEST_PLAIN_NAME: usize = 31;

/// What [`is_plain_name`] asks for, in words.
pub const PLAIN_NAME: &str = "it must be 1 to 31 letters, digits, '-', '_' or '.', starting with a letter or digit";

#[cfg(test)]
mod of_the_kind;
#[cfg(test)]
mod tests;
