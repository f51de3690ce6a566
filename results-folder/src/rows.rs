//! The rows of the tables whose columns are the same for every scenario. The fields are the columns, in their order.
//!
//! A field that folders of earlier versions do not have is read as `NaN` or empty.

use serde::{Deserialize, Serialize};

/// A row that is about one scenario.
pub trait OfScenario {
    /// The scenario's name.
    fn scenario(&self) -> &str;
}

/// The rows about the scenario `name`.
pub fn of_scenario<'a, R: OfScenario>(rows: &'a [R], name: &str) -> Vec<&'a R> {
    rows.iter().filter(|row| row.scenario() == name).collect()
}

macro_rules! rows {
    ($($(#[$about:meta])* $name:ident { $($(#[$of_field:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        #[expect(missing_docs, reason = "the columns are described in docs/results.md")]
        #[allow(non_snake_case, reason = "the fields are the columns, which name C as the field does")]
        pub struct $name {
            $($(#[$of_field])* pub $field: $type,)*
        }

        impl OfScenario for $name {
            fn scenario(&self) -> &str {
                &self.scenario
            }
        }
    )*};
}

/// The event of a row of `given_re_entry.csv`: the satellite has re-entered.
pub const RE_ENTRY: &str = "re-entry";
/// The event of a row of `given_re_entry.csv`: the satellite has not re-entered.
pub const NONE: &str = "none";

fn not_a_number() -> f64 {
    f64::NAN
}

rows! {
    /// A row of `errors.csv`.
    ErrorRow {
        scenario: String,
        method: String,
        reference: String,
        t_yr: f64,
        quantity: String,
        value: f64,
        reference_value: f64,
        abs_error: f64,
        rel_error: f64,
    }

    /// A row of `distances.csv`.
    DistanceRow {
        scenario: String,
        method: String,
        reference: String,
        t_yr: f64,
        density: String,
        measure: String,
        value: f64,
    }

    /// A row of `effort.csv`. `ratio_to_baseline`, which earlier versions called `ratio_to_mc`, is `NaN` without a
    /// baseline. `trajectories` is `NaN` for a method that follows none.
    EffortRow {
        #[serde(default)]
        scenario: String,
        method: String,
        t_prop_s: f64,
        t_int_s: f64,
        t_cal_s: f64,
        #[serde(alias = "ratio_to_mc")]
        ratio_to_baseline: f64,
        #[serde(default = "not_a_number")]
        trajectories: f64,
    }

    /// A row of `first_passage.csv`: the probability that the re-entry variable has ever reached its critical value by
    /// `t_yr`, with an interval (`NaN` if there is none) and the type of this interval. A probability that is `NaN`
    /// between two ends is withheld.
    PassageRow {
        scenario: String,
        method: String,
        t_yr: f64,
        prob_reached_critical_e: f64,
        low: f64,
        high: f64,
        #[serde(default)]
        interval: String,
    }

    /// A row of `given_re_entry.csv`: mean and standard deviation of an uncertain radiation parameter `C`, given that
    /// the satellite has re-entered by `t_yr` (`given` is [`RE_ENTRY`]) or that it has not ([`NONE`]), and their
    /// errors, of which `errors` says the type.
    GivenRow {
        scenario: String,
        method: String,
        t_yr: f64,
        given: String,
        mean_C: f64,
        std_C: f64,
        error_mean_C: f64,
        error_std_C: f64,
        errors: String,
    }

    /// A row of `diagnostics.csv`.
    DiagnosticRow {
        scenario: String,
        method: String,
        t_yr: f64,
        diagnostic: String,
        value: f64,
    }

    /// A row of `notes.csv`; `t_yr` is `NaN` if the note is about the whole scenario.
    NoteRow {
        scenario: String,
        method: String,
        t_yr: f64,
        note: String,
    }

    /// A row of `verdicts.csv`.
    VerdictRow {
        scenario: String,
        method: String,
        verdict: String,
        tolerance: f64,
        moments_error: f64,
        moments_noise: f64,
        moments_quantity: String,
        moments_t_yr: f64,
        moments_judged_by: String,
        density_error: f64,
        density_noise: f64,
        density_t_yr: f64,
        density_judged_by: String,
    }
}
