//! Translates messages of the TOML reader into the words of users: "a whole number", not `i64`.

use serde::de::value::{Error as WordsError, StrDeserializer};
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, Visitor};

/// Largest whole number of a TOML file.
const LARGEST: i64 = i64::MAX;

/// The message of a TOML reader in plain words; a message that is plain already stays as it is.
pub fn in_plain_words(message: &str) -> String {
    let told = about_value(message).or_else(|| about_choice(message)).or_else(|| about_length(message));
    told.unwrap_or_else(|| message.to_owned())
}

/// For a value of the wrong type, or outside its range.
fn about_value(message: &str) -> Option<String> {
    let rest = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "))?;
    // The value that was found may be a text that contains these words; the description of the expected value does
    // not.
    let (found, wanted) = rest.rsplit_once(", expected ")?;
    if let Some(integer) = found.strip_prefix("integer `").and_then(|rest| rest.split('`').next())
        && integer.parse::<i64>().is_err()
    {
        return Some(format!("{integer} is not allowed, whole numbers lie between -{LARGEST} and {LARGEST}"));
    }
    let (found, wanted) = (found_in_words(found), wanted_in_words(wanted));
    let hint = match found.parse::<f64>() {
        Ok(number) if wanted.starts_with(WHOLE) && found.contains('.') && is_whole(number) => {
            format!(", without a decimal point: {number}")
        }
        _ => String::new(),
    };
    Some(format!("{found} is not allowed, it must be {wanted}{hint}"))
}

const WHOLE: &str = "a whole number";

fn is_whole(number: f64) -> bool {
    number.fract() == 0.0 && number.abs() < LARGEST as f64
}

/// The value that was found, as it is written in the file.
fn found_in_words(found: &str) -> String {
    let quoted = ["integer", "floating point", "boolean", "character"].iter().find_map(|kind| {
        let rest = found.strip_prefix(kind)?.strip_prefix(" `")?;
        rest.strip_suffix('`').map(str::to_owned)
    });
    quoted.unwrap_or_else(|| match found {
        "sequence" => "a list".into(),
        "map" => "a table".into(),
        other => other.strip_prefix("string ").unwrap_or(other).into(),
    })
}

/// The description of the expected value.
fn wanted_in_words(wanted: &str) -> &str {
    match wanted {
        "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => WHOLE,
        "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => "a whole number, 0 or greater",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a string" | "string" | "path string" | "os string" | "a borrowed string" => "text, in quotation marks",
        "a TOML datetime" => "a date without quotation marks, as 2027-03-01",
        "a sequence" => "a list",
        "a map" => "a table",
        other if other.starts_with("struct ") => "a table",
        other => other,
    }
}

/// Names in quotation marks, for a sentence.
pub(crate) fn quoted<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// For a word that is not one of those that are allowed.
fn about_choice(message: &str) -> Option<String> {
    let (found, wanted) = message.strip_prefix("unknown variant `")?.rsplit_once("`, expected ")?;
    Some(format!("\"{found}\" is not allowed, it must be {}", wanted.replace('`', "\"")))
}

/// For a list of the wrong length.
fn about_length(message: &str) -> Option<String> {
    let (length, wanted) = message.strip_prefix("invalid length ")?.split_once(", expected ")?;
    Some(format!("has {length} values, it must be {wanted}"))
}

/// For serde: one of the words that `T` knows. Without this function the error about a value that is not text would
/// not name these words.
pub fn choice<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(Choice(std::marker::PhantomData))
}

/// Reads a word like [`choice`], for a key that may be absent.
pub(crate) fn choice_option<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    choice(deserializer).map(Some)
}

struct Choice<T>(std::marker::PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Choice<T> {
    type Value = T;

    /// The words are those in the error of `T` about an empty word.
    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let none: StrDeserializer<'_, WordsError> = "".into_deserializer();
        let answer = T::deserialize(none).err().map(|error| error.to_string()).unwrap_or_default();
        let words = answer.rsplit_once(", expected ").map_or("one of its words", |(_, words)| words);
        f.write_str(&words.replace('`', "\""))
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
        T::deserialize(word.into_deserializer())
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum When {
        Never,
        OnFailure,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Table {
        whole: i64,
        natural: u64,
        number: f64,
        flag: bool,
        text: String,
        path: PathBuf,
        list: Vec<f64>,
        #[serde(deserialize_with = "choice")]
        when: When,
        #[serde(deserialize_with = "choice_option")]
        perhaps: Option<When>,
    }

    impl Default for Table {
        fn default() -> Self {
            let (text, path, list) = (String::new(), PathBuf::new(), Vec::new());
            let (when, perhaps) = (When::Never, None);
            Self { whole: 0, natural: 0, number: 0.0, flag: false, text, path, list, when, perhaps }
        }
    }

    #[test]
    fn a_value_of_another_type_is_told_without_a_word_of_rust() {
        for (line, told) in [
            ("whole = 2000.0", "2000.0 is not allowed, it must be a whole number, without a decimal point: 2000"),
            ("whole = 2.5", "2.5 is not allowed, it must be a whole number"),
            ("whole = nan", "NaN is not allowed, it must be a whole number"),
            ("whole = \"2\"", "\"2\" is not allowed, it must be a whole number"),
            (
                "whole = 99999999999999999999",
                "99999999999999999999 is not allowed, whole numbers lie between -9223372036854775807 and 9223372036854775807",
            ),
            (
                "whole = 9223372036854775808",
                "9223372036854775808 is not allowed, whole numbers lie between -9223372036854775807 and 9223372036854775807",
            ),
            ("natural = -1", "-1 is not allowed, it must be a whole number, 0 or greater"),
            ("number = \"a, expected b\"", "\"a, expected b\" is not allowed, it must be a number"),
            ("number = [1]", "a list is not allowed, it must be a number"),
            ("flag = 1", "1 is not allowed, it must be true or false"),
            ("text = true", "true is not allowed, it must be text, in quotation marks"),
            ("path = 1", "1 is not allowed, it must be text, in quotation marks"),
            ("list = 0.1", "0.1 is not allowed, it must be a list"),
            ("list = { a = 1 }", "a table is not allowed, it must be a list"),
            ("when = \"ever\"", "\"ever\" is not allowed, it must be \"never\" or \"on-failure\""),
            ("when = true", "true is not allowed, it must be \"never\" or \"on-failure\""),
            ("when = { never = 1 }", "a table is not allowed, it must be \"never\" or \"on-failure\""),
            ("perhaps = 3", "3 is not allowed, it must be \"never\" or \"on-failure\""),
        ] {
            let error = toml::from_str::<Table>(line).unwrap_err();
            assert_eq!(in_plain_words(error.message()), told);
        }
        assert!(toml::from_str::<Table>("when = \"on-failure\"\nperhaps = \"never\"").is_ok());
    }

    #[test]
    fn words_that_are_plain_already_stay() {
        for plain in ["0 is not allowed, it must be at least 1", "string values must be quoted", ""] {
            assert_eq!(in_plain_words(plain), plain);
        }
    }
}
