//! Which model a scenario file names.

use serde::Deserialize;
use toml::Spanned;

use crate::files::input::{InputError, InputFile};

/// The planar model, which a file has that names none.
const IN_PLANE: &str = "planar";
/// The averaged model in space.
pub(super) const VECTORIAL: &str = "vectorial";
/// The unaveraged model.
pub(super) const OSCULATING: &str = "osculating";

/// As much of a file as names its model.
#[derive(Debug, Deserialize)]
struct File {
    model: Option<Table>,
}

#[derive(Debug, Deserialize)]
struct Table {
    name: Option<Spanned<String>>,
}

/// The name that the file gives, if it gives one.
fn named(file: &InputFile) -> Result<Option<Spanned<String>>, InputError> {
    let named = file.parse::<File>()?.model.and_then(|model| model.name);
    match named.as_ref().map(|name| name.get_ref().as_str()) {
        None | Some(IN_PLANE | VECTORIAL | OSCULATING) => Ok(named),
        Some(other) => {
            let problem =
                format!("\"{other}\" is no model, there are \"{IN_PLANE}\", \"{VECTORIAL}\", \"{OSCULATING}\"");
            Err(named.as_ref().map_or_else(|| file.error_in_whole("model.name", &problem), |n| file.error(n, &problem)))
        }
    }
}

/// Whether the file names a model in space.
pub(super) fn is_in_space(file: &InputFile) -> Result<bool, InputError> {
    Ok(named(file)?.is_some_and(|name| name.get_ref() != IN_PLANE))
}

/// Refuses a model in space where clouds are propagated.
pub(super) fn expect_plane(file: &InputFile) -> Result<(), InputError> {
    match named(file)? {
        Some(name) if name.get_ref() != IN_PLANE => {
            let problem = format!(
                "\"{}\" is a model in space, for which only `phasecloud orbit` and `phasecloud validate` are made so far; all else needs \
                 \"{IN_PLANE}\"",
                name.get_ref()
            );
            Err(file.error(&name, &problem))
        }
        _ => Ok(()),
    }
}
