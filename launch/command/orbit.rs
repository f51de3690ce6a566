//! `phasecloud orbit`: the mean orbit of a scenario in any model, as CSV; an unaveraged one also as an ephemeris.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use density::flow::{Escaped, Flow};
use density::model::elements::{Elements, Vectors};
use density::model::model_name::ModelName;
use density::model::osculating::kepler::Motion;
use density::model::osculating::mean::{MeanOrbit, mean_orbit};
use density::model::osculating::{self, Osculating};
use density::model::plane::{self, State as InPlane};
use density::model::registry::Planar;
use density::model::shadow::{ShadowedOsculating, ShadowedVectorial};
use density::model::space_registry::SpaceModel;
use density::model::vectorial::{self, Vectorial};
use density::model::{Model, Variable, earth};
use nodes::files::input::{InputError, InputFile};
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::{self, AnyScenario, Epoch, ScenarioInSpace};

use super::ephemeris::Ephemeris;
use crate::exit::BAD_INPUT;

/// Arguments of `phasecloud orbit`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud orbit launch/models/vectorial.toml\n  phasecloud orbit --step 0.05 my-scenario.toml > orbit.csv\n  \
    phasecloud orbit --oem --step 1e-5 my-scenario.toml > orbit.oem\n\n\
    Columns: the time, the variables of the model, the eccentricity vector e1, e2, e3 and the angular momentum vector h1, h2, h3 (of length \
    sqrt(1 - e²)) in equatorial axes, and the semi-major axis, which is empty where the scenario does not give it. In the planar model the \
    Sun is in the equator, at longitude 0 at first. Orbits of the model \"osculating\" are averaged over one revolution centred on the time, \
    unless --osculating is given. --oem prints the orbit of a scenario in that model, which must have [epoch] date, as an Orbit Ephemeris \
    Message (CCSDS 502.0): positions in km and velocities in km/s, in the mean equator and equinox of the epoch.\n\n\
    Exit codes: 0 printed; 1 the orbit cannot be followed to the end; 2 bad input."
)]
pub struct OrbitArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Print the orbit every so many years up to the last snapshot, not at the snapshots
    #[arg(long, value_name = "YEARS", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// Of an orbit in the model "osculating", print the osculating elements at the time itself
    #[arg(long)]
    pub osculating: bool,
    /// Print an orbit in the model "osculating" as an Orbit Ephemeris Message
    #[arg(long, conflicts_with = "osculating")]
    pub oem: bool,
}

/// What is printed of an unaveraged orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    /// Elements averaged over a revolution.
    Mean,
    /// Osculating elements.
    Osculating,
    /// Positions and velocities.
    Ephemeris,
}

/// Largest number of rows.
const MOST_ROWS: f64 = 1e6;

/// Prints the orbit.
pub fn run(arguments: &OrbitArguments) -> ExitCode {
    let OrbitArguments { scenario: path, step, osculating, oem } = arguments;
    let form = match (osculating, oem) {
        (_, true) => Form::Ephemeris,
        (true, false) => Form::Osculating,
        (false, false) => Form::Mean,
    };
    let scenario = match load(path) {
        Ok(scenario) => scenario,
        Err(error) => return refuse(&error.to_string()),
    };
    let times = scenario.times();
    let times = match step.map_or_else(|| Ok(times.to_vec()), |step| stepped(step, times)) {
        Ok(times) => times,
        Err(problem) => return refuse(&problem),
    };
    let is_unaveraged = matches!(&scenario, AnyScenario::InSpace(scenario) if !scenario.model.is_averaged());
    if !is_unaveraged && let Some(needed) = form.needed() {
        return refuse(&needed);
    }
    if has_no_place(&scenario) {
        return refuse(&format!(
            "{}: initial: must have mean_anomaly: without it the orbits of a cloud are spread evenly over the revolution, and none of them \
             stands for all",
            path.display()
        ));
    }
    let epoch = epoch(&scenario);
    if form == Form::Ephemeris && epoch.is_none() {
        return refuse(&format!(
            "{}: epoch: --oem needs the date at t = 0; write date = 2027-03-01 here",
            path.display()
        ));
    }
    let end = times.last().copied().unwrap_or(0.0);
    if form == Form::Ephemeris && epoch.is_some_and(|epoch| epoch.instant_after(end).is_none()) {
        return refuse(&format!(
            "{}: epoch.date: the orbit goes on after the year 9999; choose an earlier date",
            path.display()
        ));
    }
    match print(&scenario, &times, form) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Escaped { why, years, place, .. }) => {
            // An average over a revolution also looks back.
            let years = years.abs();
            remark!("error: {}: the orbit {why} within {years} yr of the state {place}", path.display());
            ExitCode::FAILURE
        }
    }
}

impl Form {
    /// What is said where the model has no such thing.
    fn needed(self) -> Option<String> {
        let unaveraged = ModelName::listed(|name| !name.is_averaged());
        let (option, what) = match self {
            Self::Mean => return None,
            Self::Osculating => ("--osculating", "has osculating elements"),
            Self::Ephemeris => ("--oem", "says where on its orbit the satellite is"),
        };
        Some(format!("{option}: only the model {unaveraged} {what}; leave it out"))
    }
}

fn load(path: &std::path::Path) -> Result<AnyScenario, InputError> {
    scenario_file::check_any(&InputFile::read(path)?)
}

fn refuse(problem: &str) -> ExitCode {
    remark!("error: {problem}");
    ExitCode::from(BAD_INPUT)
}

/// The multiples of a step up to the last snapshot.
fn stepped(step: f64, snapshots: &[f64]) -> Result<Vec<f64>, String> {
    let end = snapshots.last().copied().unwrap_or(0.0);
    let rows = (end / step * (1.0 + 1e-12)).floor() + 1.0;
    if !(step > 0.0 && step <= end && rows <= MOST_ROWS) {
        let [least, end] = [end / (MOST_ROWS - 1.0), end].map(plain);
        return Err(format!("--step: {} is not allowed, it must be between {least} and {end} yr", plain(step)));
    }
    // As a person would write them: three times 0.1 is 0.3.
    let written = |k: u32| format!("{:.11e}", f64::from(k) * step).parse().unwrap_or(f64::from(k) * step);
    Ok((0..rows as u32).map(written).collect())
}

fn print(scenario: &AnyScenario, times: &[f64], form: Form) -> Result<(), Escaped> {
    match scenario {
        AnyScenario::InPlane { scenario, semi_major_axis } => {
            let start = [scenario.problem.initial.mean_phi, scenario.problem.initial.mean_e];
            head(&plane::VARIABLES);
            follow(scenario.problem.model, start, times, |model: &Planar, time, state| {
                row(time, &model.read_out(time, state), in_plane(time, state), *semi_major_axis);
                Ok(())
            })
        }
        AnyScenario::InSpace(scenario) => match scenario.model {
            SpaceModel::Vectorial { model, axis } if scenario.shadow => {
                let ([phi, e, i, node], semi_major_axis) = (scenario.start, axis.unwrap_or(f64::NAN));
                let model = ShadowedVectorial { model, semi_major_axis, reentry_radius: None };
                head(&vectorial::VARIABLES);
                follow(model, [phi, e, i, node, semi_major_axis], times, |model: &ShadowedVectorial, time, state| {
                    let (variables, [e1, e2, e3, h1, h2, h3, _]) = (model.read_out(time, state), state);
                    row(time, &variables[..4], Vectors { e: [e1, e2, e3], h: [h1, h2, h3] }, Some(variables[4]));
                    Ok(())
                })
            }
            SpaceModel::Vectorial { model, axis } => {
                head(&vectorial::VARIABLES);
                follow(model, scenario.start, times, |model: &Vectorial, time, state| {
                    let (e, h) = vectorial::vectors(state);
                    row(time, &model.read_out(time, state), Vectors { e, h }, axis);
                    Ok(())
                })
            }
            SpaceModel::Osculating { model, mean_anomaly } => {
                let start = with_place(model, scenario.start, mean_anomaly);
                if scenario.shadow {
                    let shadowed = ShadowedOsculating { model, has_shadow: true, reentry_radius: None };
                    return unaveraged(shadowed, &model, start, scenario, times, form);
                }
                unaveraged(model, &model, start, scenario, times, form)
            }
        },
    }
}

/// Prints an unaveraged orbit.
fn unaveraged<M: Model<State<f64> = osculating::State, Variables = [f64; 6]>>(
    model: M,
    nominal: &Osculating,
    start: [f64; 6],
    scenario: &ScenarioInSpace,
    times: &[f64],
    form: Form,
) -> Result<(), Escaped> {
    let ephemeris = scenario.epoch.map(|epoch| Ephemeris { epoch, semi_major_axis: nominal.semi_major_axis });
    match (form, &ephemeris) {
        (Form::Mean, _) => head(&vectorial::VARIABLES),
        (Form::Osculating, _) => head(&osculating::VARIABLES[..5]),
        (Form::Ephemeris, ephemeris) => ephemeris.iter().for_each(|e| e.head(&scenario.name, times)),
    }
    follow(model, start, times, |model: &M, time, state| {
        match form {
            Form::Mean => {
                let MeanOrbit { vectors, semi_major_axis } = mean_orbit(&Flow::new(*model), nominal, time, state)?;
                row(time, &of_mean(nominal, time, vectors), vectors, Some(semi_major_axis));
            }
            Form::Osculating => {
                let [x, y, z, vx, vy, vz] = state;
                let Motion { vectors, .. } = Motion::of([x, y, z], [vx, vy, vz]);
                let variables = model.read_out(time, state);
                row(time, &variables[..5], vectors, Some(variables[5]));
            }
            Form::Ephemeris => ephemeris.iter().for_each(|ephemeris| ephemeris.row(time, state)),
        }
        Ok(())
    })
}

/// Whether it is not said where on its ellipse the satellite is at first.
fn has_no_place(scenario: &AnyScenario) -> bool {
    matches!(scenario, AnyScenario::InSpace(s) if !s.model.is_averaged() && s.model.mean_anomaly().is_none())
}

/// The date at `t = 0` of a scenario in space, if it has one.
fn epoch(scenario: &AnyScenario) -> Option<Epoch> {
    match scenario {
        AnyScenario::InSpace(scenario) => scenario.epoch,
        AnyScenario::InPlane { .. } => None,
    }
}

/// The variables of the unaveraged model.
fn with_place(model: Osculating, [phi, e, inclination, node]: [f64; 4], mean_anomaly: Option<f64>) -> [f64; 6] {
    [phi, e, inclination, node, mean_anomaly.unwrap_or(0.0), model.semi_major_axis]
}

/// Follows an orbit from time to time.
fn follow<M: Model>(
    model: M,
    start: M::Variables,
    times: &[f64],
    each: impl Fn(&M, f64, M::State<f64>) -> Result<(), Escaped>,
) -> Result<(), Escaped> {
    let flow = Flow::new(model);
    let (mut now, mut state) = (0.0, model.state(0.0, start));
    for &time in times {
        state = flow.carry_one(state, now, time)?;
        now = time;
        each(&model, time, state)?;
    }
    Ok(())
}

/// The vectors of a planar orbit: in the equator, with the Sun at longitude 0 at first.
fn in_plane(time: f64, state: InPlane) -> Vectors {
    let (sin, cos) = (state.solar_angle() + earth::SUN_MEAN_MOTION * time).sin_cos();
    let e = state.eccentricity();
    Vectors { e: [e * cos, e * sin, 0.0], h: [0.0, 0.0, state.s()] }
}

/// Solar angle, eccentricity, inclination and node of a mean orbit.
fn of_mean(model: &Osculating, time: f64, vectors: Vectors) -> [f64; 4] {
    let Elements { eccentricity, inclination, node, longitude_of_pericentre } = vectors.elements();
    [model.solar_angle(time, longitude_of_pericentre), eccentricity, inclination, node]
}

fn head(variables: &[Variable]) {
    let of_variable = |variable: &Variable| match variable.unit {
        "" => variable.symbol.to_owned(),
        unit => format!("{}_{unit}", variable.symbol),
    };
    let columns: Vec<String> = variables.iter().map(of_variable).collect();
    say!("t_yr,{},e1,e2,e3,h1,h2,h3,a_earth_radii", columns.join(","));
}

fn row(time: f64, variables: &[f64], Vectors { e, h }: Vectors, axis: Option<f64>) {
    let numbers: Vec<String> = [time].iter().chain(variables).chain(&e).chain(&h).map(|x| plain(*x)).collect();
    say!("{},{}", numbers.join(","), axis.map_or(String::new(), plain));
}
