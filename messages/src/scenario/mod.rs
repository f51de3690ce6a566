//! The scenario message: a problem, with a description of its variables.
//!
//! The header names the model and its parameters, describes the variables in which initial orbits and snapshots are
//! given, and lists the one- and two-variable projections on which densities are compared. The payload has the mean
//! and the upper triangle of the covariance of the initial Gaussian, then one row per snapshot: its time, and the
//! ends of every projection's axes. A request is the same message without projections. A receiver decodes the message
//! once, to a [`Description`].

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::describe::{Described, Field, FieldType, codes, header};
use crate::payload::Shape;
use crate::text::{Label, unpack};

mod description;

pub use description::{Description, Moment, Parameter, Projection, Range, Variable};

/// The most snapshots that a scenario message holds.
pub const MOST_SNAPSHOTS: usize = 4096;
/// The most variables that a scenario message holds.
pub const MOST_VARIABLES: usize = 8;
/// The most parameters that a scenario message holds.
pub const MOST_PARAMETERS: usize = 16;
/// The most projections that a scenario message holds.
pub const MOST_PROJECTIONS: usize = 16;

codes! {
    /// Which values a variable takes.
    pub mod range {
        /// An angle on the full circle \[rad\]: values that differ by a full turn are the same.
        pub const CIRCLE: u32 = 1;
        /// Numbers between two bounds, without the bounds themselves.
        pub const INTERVAL: u32 = 2;
    }
}

header! {
    /// A variable in which initial orbits and snapshots are given.
    #[type_name("phasecloud/ScenarioHeader/2/Variable")]
    pub struct VariableEntry {
        /// Lower bound of an interval.
        pub low: f64,
        /// Upper bound of an interval.
        pub high: f64,
        /// Which values it takes, see [`range`].
        pub range: u32 [codes range::CODES],
        /// 0.
        pub reserved: u32,
        /// Its name, for example `solar angle`.
        pub name: Label,
        /// Its symbol, for example `phi`.
        pub symbol: [u8; 16],
        /// Its unit; empty for a pure number.
        pub unit: [u8; 16],
    }
}

header! {
    /// A parameter of the model.
    #[type_name("phasecloud/ScenarioHeader/2/Parameter")]
    pub struct ParameterEntry {
        /// Its value.
        pub value: f64,
        /// Its key in a scenario file, for example `radiation`.
        pub name: Label,
        /// Its symbol in equations, for example `C`.
        pub symbol: [u8; 16],
    }
}

header! {
    /// One or two variables in which densities are compared.
    #[type_name("phasecloud/ScenarioHeader/2/Projection")]
    pub struct ProjectionEntry {
        /// Number of variables: 1 or 2.
        pub dimensions: u32,
        /// Position of the first variable, which is outermost in arrays.
        pub first: u32,
        /// Position of the second variable, if there is one.
        pub second: u32,
        /// Bins of the first variable's axis.
        pub first_bins: u32,
        /// Bins of the second variable's axis, if there is one.
        pub second_bins: u32,
        /// 0.
        pub reserved: u32,
    }
}

header! {
    /// The problem. Payload: the mean of the initial Gaussian, one number per variable; the upper triangle of its
    /// covariance, row by row; then one row per snapshot: time \[yr\], and for every axis of every projection its
    /// lowest and highest value.
    #[type_name("phasecloud/ScenarioHeader/2")]
    pub struct ScenarioHeader {
        /// Names the run; every message carries it.
        pub run_id: u64,
        /// Value of the re-entry variable at which the satellite re-enters.
        pub critical: f64,
        /// Position of the scenario in the run, from 0; in a request, a number by which the sender recognizes the
        /// answer.
        pub scenario: u32,
        /// Scenarios in the run; 0 if the number is not known, as in a service.
        pub scenarios: u32,
        /// Snapshots in the scenario.
        pub snapshots: u32,
        /// Position of the variable that grows to its critical value when the satellite re-enters.
        pub reentry: u32,
        /// Variables of the model.
        pub variable_count: u32,
        /// Parameters of the model.
        pub parameter_count: u32,
        /// Projections on which densities are compared; 0 in a request.
        pub projection_count: u32,
        /// 0.
        pub reserved: u32,
        /// The scenario's name.
        pub name: Label,
        /// The model's name.
        pub model: Label,
        /// The variables, then zeros.
        pub variables: [VariableEntry; MOST_VARIABLES],
        /// The parameters, then zeros.
        pub parameters: [ParameterEntry; MOST_PARAMETERS],
        /// The projections, then zeros.
        pub projections: [ProjectionEntry; MOST_PROJECTIONS],
    }
}

/// Count of numbers in a mean and in the upper triangle of a covariance of `variables` variables.
pub const fn gaussian_numbers(variables: usize) -> usize {
    variables + variables * (variables + 1) / 2
}

/// The fields of one entry in use, under the names `LIST.NUMBER.FIELD`, with offsets from the beginning of the
/// header.
fn entry<T: Described>(list: &str, start: usize, number: usize) -> impl Iterator<Item = (String, Field)> {
    let start = start + number * size_of::<T>();
    let named = move |field: &Field| {
        (format!("{list}.{number}.{}", field.name), Field { offset: start + field.offset, ..*field })
    };
    T::FIELDS.iter().filter(|field| field.name != "reserved").map(named).collect::<Vec<_>>().into_iter()
}

/// The fields of all entries that a header uses.
pub(crate) fn fields(header: &ScenarioHeader) -> Vec<(String, Field)> {
    use std::mem::offset_of;
    let used = |count: u32, most: usize| 0..most.min(count as usize);
    let variables = used(header.variable_count, MOST_VARIABLES)
        .flat_map(|k| entry::<VariableEntry>("variables", offset_of!(ScenarioHeader, variables), k));
    let parameters = used(header.parameter_count, MOST_PARAMETERS)
        .flat_map(|k| entry::<ParameterEntry>("parameters", offset_of!(ScenarioHeader, parameters), k));
    let projections = used(header.projection_count, MOST_PROJECTIONS)
        .flat_map(|k| entry::<ProjectionEntry>("projections", offset_of!(ScenarioHeader, projections), k));
    variables.chain(parameters).chain(projections).collect()
}

/// The payload: the Gaussian, then a table whose columns follow from the projections.
pub(crate) fn shape(header: &ScenarioHeader) -> Shape {
    let variables = MOST_VARIABLES.min(header.variable_count as usize);
    let name = |position: u32| {
        let Some(variable) = header.variables.get(position as usize) else { return format!("variable {position}") };
        match (unpack(&variable.symbol), unpack(&variable.unit)) {
            (symbol, unit) if unit.is_empty() => symbol,
            (symbol, unit) => format!("{symbol} [{unit}]"),
        }
    };
    let mut columns = vec!["time [yr]".to_owned()];
    let count = MOST_PROJECTIONS.min(header.projection_count as usize);
    for ProjectionEntry { dimensions, first, second, .. } in &header.projections[..count] {
        for variable in [first, second].into_iter().take(*dimensions as usize) {
            columns.extend([format!("lowest {}", name(*variable)), format!("highest {}", name(*variable))]);
        }
    }
    Shape { head: gaussian_numbers(variables), columns, by_column: false }
}
