//! The accuracy with which a case propagates orbits, as a launch file gives it: the largest error.

use std::borrow::Cow;

use density::flow::{Accuracy, Flow};
use density::model::registry::Planar;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `accuracy = 1e-12` or 1e-9 or 1e-6: the largest error of `x1` or `x2` after two years in the paper's scenarios.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AccuracySetting(pub Accuracy);

impl AccuracySetting {
    /// The flow of `model` at the accuracy set, or at the default one.
    pub(crate) fn flow(setting: Option<Self>, model: Planar) -> Flow<Planar> {
        Flow { model, accuracy: setting.unwrap_or_default().0 }
    }
}

impl Serialize for AccuracySetting {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0.largest_error())
    }
}

impl<'de> Deserialize<'de> for AccuracySetting {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let error = f64::deserialize(deserializer)?;
        let level = Accuracy::ALL.into_iter().find(|level| level.largest_error() == error);
        level
            .map(Self)
            .ok_or_else(|| D::Error::custom(format!("{error:e} is not allowed, it must be 1e-6, 1e-9 or 1e-12")))
    }
}

impl JsonSchema for AccuracySetting {
    fn schema_name() -> Cow<'static, str> {
        "Accuracy".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": Accuracy::ALL.map(Accuracy::largest_error) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Table {
        accuracy: AccuracySetting,
    }

    #[test]
    fn every_level_survives_the_way_through_a_file() {
        for level in Accuracy::ALL {
            let table = Table { accuracy: AccuracySetting(level) };
            assert_eq!(toml::from_str::<Table>(&toml::to_string(&table).unwrap()).unwrap(), table);
        }
    }

    #[test]
    fn other_levels_are_refused_with_those_there_are() {
        let error = toml::from_str::<Table>("accuracy = 1e-7").unwrap_err();
        assert_eq!(error.message(), "1e-7 is not allowed, it must be 1e-6, 1e-9 or 1e-12");
    }
}
