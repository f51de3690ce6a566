//! What follows from a scenario before anything is computed: its parameters, whether re-entry is possible at all, and
//! how its mean orbit moves.

use density::disposal;
use density::model::PlanarHamiltonian;
use density::model::plane::State;
use density::model::registry::Planar;
use density::problem::Problem;
use density::uncertain::{Distribution, Spread};
use figures::sub_domains::{self, Motion};
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::ScenarioInSpace;
use serde_json::{Value, json};

/// What follows.
pub struct Derived {
    model: &'static str,
    parameters: Vec<(&'static str, &'static str, f64)>,
    critical_e: f64,
    /// The least radiation parameter with which a circular orbit re-enters, if there is one.
    required: Option<f64>,
    motion: Motion,
    /// Time after which the mean orbit is where it was \[yr\], if it is closed.
    period: Option<f64>,
}

/// What follows from a problem.
pub fn of(problem: &Problem<Planar>) -> Derived {
    let Problem { model, initial, critical_e, .. } = problem;
    let parameters = model.parameters().into_iter().map(|(parameter, value)| (parameter.name, parameter.symbol, value));
    let points = figures::hamiltonian::stationary_points(*model);
    Derived {
        model: model.name(),
        parameters: parameters.collect(),
        critical_e: *critical_e,
        required: disposal::required_radiation(model, *critical_e),
        motion: sub_domains::motion(*model, &points, initial.mean_phi, initial.mean_e),
        period: disposal::period(model, State::from_polar(initial.mean_phi, initial.mean_e)),
    }
}

impl Derived {
    /// In words, one line each.
    pub fn lines(&self) -> Vec<String> {
        let parameters = self.parameters.iter().map(|(_, symbol, value)| format!("{symbol} = {}", significant(*value)));
        let acts = self.parameters.iter().any(|(name, _, value)| *name == "radiation" && *value > 0.0);
        let required = match self.required {
            _ if !acts => String::new(),
            Some(required) => format!("; a circular orbit reaches it from C = {}", significant(required)),
            None => "; a circular orbit does not reach it with any C up to 100".into(),
        };
        let number = self.motion.number().map_or(String::new(), |number| format!(" (sub-domain {number})"));
        let period = match self.period {
            Some(period) => format!(", once in {} yr", significant(period)),
            None => String::new(),
        };
        vec![
            format!("model {}: {}", self.model, parameters.collect::<Vec<_>>().join(", ")),
            format!("critical eccentricity {}{required}", significant(self.critical_e)),
            format!("mean orbit: {}{number}{period}", self.motion.words()),
        ]
    }

    /// The same as a JSON object.
    pub fn json(&self) -> Value {
        let parameters: serde_json::Map<String, Value> =
            self.parameters.iter().map(|(name, _, value)| ((*name).to_owned(), json!(value))).collect();
        json!({
            "model": self.model,
            "parameters": parameters,
            "critical_e": self.critical_e,
            "required_radiation": self.required,
            "sub_domain": self.motion.number(),
            "period_yr": self.period,
        })
    }
}

/// How uncertain the radiation parameter is.
pub fn in_words(Spread { relative, distribution }: Spread) -> String {
    let distribution = match distribution {
        Distribution::Gaussian => "a Gaussian, cut at 0",
        Distribution::LogNormal => "log-normal",
    };
    format!("radiation parameter with a standard deviation of {} % ({distribution})", significant(100.0 * relative))
}

/// What follows from a scenario in space, in words, one line each.
pub fn lines_in_space(scenario: &ScenarioInSpace) -> Vec<String> {
    let ScenarioInSpace { model, critical_e, cloud, .. } = scenario;
    let parameters = model.force_parameters();
    let parameters =
        parameters.iter().map(|(parameter, value)| format!("{} = {}", parameter.symbol, significant(*value)));
    let mut lines = vec![
        format!("model {}: {}", model.name(), parameters.collect::<Vec<_>>().join(", ")),
        match cloud {
            Some(cloud) => {
                let symbols: Vec<&str> = cloud.variables().iter().map(|variable| variable.symbol).collect();
                format!("a cloud over {}", symbols.join(", "))
            }
            None => {
                "a single orbit, which `phasecloud orbit` prints: there is no sigma_phi and sigma_e in [initial]".into()
            }
        },
    ];
    lines.extend(critical_e.map(|e| format!("critical eccentricity {}", significant(e))));
    lines.extend(cloud.as_ref().and_then(|cloud| cloud.spread).map(in_words));
    lines
}

/// A number with six significant digits.
fn significant(value: f64) -> String {
    plain(format!("{value:.5e}").parse().unwrap_or(value))
}
