//! The keys of a scenario file by which a problem that cannot be solved is explained.

use density::problem_error::{Field, ProblemError};

/// The key of a scenario file that states a field of a problem.
pub fn key(field: Field) -> String {
    match field {
        Field::Parameter(name) => format!("orbit.{name}"),
        Field::MeanPhi => "initial.phi".into(),
        Field::MeanE => "initial.e".into(),
        Field::DeltaPhi => "initial.delta_phi".into(),
        Field::DeltaE => "initial.delta_e".into(),
        Field::Correlation => "initial.correlation".into(),
        Field::SigmaRadiation => "initial.sigma_radiation".into(),
        Field::Times => "times.at".into(),
        Field::CriticalE => "disposal.critical_e".into(),
        Field::MeanInclination => "initial.inclination".into(),
        Field::MeanNode => "initial.node".into(),
        Field::Sigma(name) => format!("initial.{name}"),
        Field::CorrelationOf(pair) => format!("initial.correlation.{pair}"),
        Field::Correlations => "initial.correlation".into(),
        Field::Obliquity => "model.obliquity".into(),
        Field::SunLongitude => "epoch.sun_longitude".into(),
        Field::Model => "model.name".into(),
        Field::Shadow => "model.forces".into(),
        Field::ReentryAltitude => "disposal.altitude".into(),
    }
}

/// What is wrong with a problem, by the key that a scenario file has for it.
pub fn by_key(error: &ProblemError) -> String {
    format!("{}: {}", key(error.field), error.problem())
}
