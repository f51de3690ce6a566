//! The settings that all sampling methods have, read in one place.

/// Declares the settings of a sampling method: those that all of them have, and its own after the seed and after the
/// replicates.
macro_rules! sampling_settings {
    (
        $(#[$about:meta])*
        after_seed { $($(#[$one:meta])* $first:ident: $first_type:ty,)* }
        after_replicates { $($(#[$other:meta])* $second:ident: $second_type:ty,)* }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Settings {
            /// Number of samples, of all replicates together.
            #[serde(deserialize_with = "crate::files::input::positive")]
            pub samples: usize,
            /// Seed of the draws.
            #[serde(deserialize_with = "crate::files::input::natural")]
            pub seed: u64,
            $($(#[$one])* pub $first: $first_type,)*
            /// Number of independent replicates, from whose spread the standard errors follow.
            #[serde(deserialize_with = "crate::files::input::positive")]
            pub replicates: usize,
            $($(#[$other])* pub $second: $second_type,)*
            /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub accuracy: Option<crate::methods::accuracy::AccuracySetting>,
            /// The model in which orbits move, if not in the scenario's: a simpler one.
            #[serde(
                skip_serializing_if = "Option::is_none",
                deserialize_with = "crate::files::toml_words::choice_option"
            )]
            pub model: Option<crate::methods::choices::ModelChoice>,
            /// The forces that act, if not all of the scenario's.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub forces: Option<crate::methods::choices::Forces>,
        }
    };
}

pub(super) use sampling_settings;
