//! A small Monte Carlo with a fault of choice, for the tests of `phasecloud check` and of runs. It does not use the
//! kit, which would not let most of these faults happen.

use std::process::ExitCode;
use std::time::Duration;

use density::flow::Flow;
use density::orbits::Orbits;
use density::sampling::{Draws, SamplingPlan};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::session::Session;
use messages::content::Samples;
use messages::layout::{PASSAGE_COLUMNS, PASSAGE_TIMES, PassageHeader, SnapshotHeader};
use messages::port::Outlet;
use messages::text::pack;
use messages::topic::{Passage, Scenario, Snapshot};
use messages::wait::Awaited;

const SAMPLES: usize = 400;

fn main() -> ExitCode {
    let fault = std::env::args().nth(1).unwrap_or_default();
    match Session::from_environment().and_then(|session| serve(&session, &fault)) {
        Ok(()) | Err(Failure::Stopped) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

fn serve(session: &Session, fault: &str) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let passages = session.domain.outlet::<Passage>(PASSAGE_TIMES * PASSAGE_COLUMNS)?;
    if fault != "never-ready" {
        session.ready()?;
    }
    let mut outlet = None;
    loop {
        while let Some(message) = scenarios.receive()? {
            let assignment = Assignment::read(&message)?;
            drop(message);
            drop(outlet.take());
            if fault != "no-passage" {
                let (run_id, scenario) = (assignment.description.run_id, assignment.scenario());
                let (label, reason) = (pack(&session.label), pack("it does not look"));
                let header = PassageHeader { run_id, scenario, label, reason, ..PassageHeader::default() };
                let curve = curve(fault, scenario, &assignment.passage_times());
                let rows = (curve.len() / PASSAGE_COLUMNS) as u32;
                let reason = if rows > 0 { pack("") } else { header.reason };
                passages.send_items(PassageHeader { rows, reason, ..header }, &curve)?;
            }
            match answer(session, &assignment, fault) {
                Ok(sent) => outlet = Some(sent),
                Err(failure) if fault == "dies-unsaid" => return Err(failure),
                Err(failure) => {
                    session.failed(assignment.scenario(), &failure.to_string())?;
                    return Err(failure);
                }
            }
        }
        let mut ports: Vec<&dyn Awaited> = vec![&scenarios, &passages];
        ports.extend(outlet.iter().map(|outlet| outlet as &dyn Awaited));
        match session.wait(&ports) {
            Err(Failure::Stopped) if fault == "deaf" => std::thread::sleep(Duration::from_millis(50)),
            other => other?,
        }
    }
}

fn answer(session: &Session, assignment: &Assignment, fault: &str) -> Result<Outlet<Snapshot>, Failure> {
    if fault == "second-scenario" && assignment.scenario() == 1 {
        std::process::exit(101);
    }
    if fault == "first-scenario" && assignment.scenario() == 0 && session.shard.index == 1 {
        return Err(Failure::Refused("not this one".into()));
    }
    let stuck = match fault {
        "stuck-in-the-first" => Some(0),
        "stuck-in-the-second" => Some(1),
        _ => None,
    };
    if stuck == Some(assignment.scenario()) {
        std::thread::sleep(Duration::from_secs(3600));
    }
    // A propagator with another fault does not use shards.
    let total = match fault {
        "range" => 2 * SAMPLES as u64 - 1,
        "first-scenario" => SAMPLES as u64 * u64::from(session.shard.count),
        _ => 0,
    };
    let problem = &assignment.plane()?.problem;
    let mut initial = problem.initial;
    if fault == "moments" {
        initial.mean_phi += 0.5 * initial.sigma_phi;
    }
    let drawn = |seed: u64| {
        let plan = SamplingPlan { draws: Draws::Independent, seed, replicates: std::num::NonZeroUsize::MIN };
        let (x1, x2) = plan.draw(&initial, SAMPLES);
        Orbits::new(Flow::new(problem.model), x1, x2)
    };
    let mut orbits = drawn(5);
    let outlet = session.domain.outlet::<Snapshot>(2 * SAMPLES)?;
    let mut indices: Vec<usize> = (0..problem.times.len()).collect();
    match fault {
        "order" => indices.swap(1, 2),
        "counts" => indices.truncate(problem.times.len() - 1),
        "too-many" => indices.push(problem.times.len() - 1),
        _ => {}
    }
    for index in indices {
        match fault {
            "silent" if index == 2 => std::thread::sleep(Duration::from_secs(3600)),
            "late" if index == 2 => std::thread::sleep(Duration::from_secs(2)),
            "crashes" if index == 2 => std::process::abort(),
            _ => {}
        }
        if fault == "redrawn" {
            orbits = drawn(100 + index as u64);
        }
        let before = orbits.clone();
        if let Err(lost) = orbits.advance_to(problem.times[index]) {
            if fault != "accepts" {
                return Err(lost.into());
            }
            orbits = before;
        }
        let mut draft = outlet.draft(2 * SAMPLES)?;
        let (phi, e) = draft.items_mut().split_at_mut(SAMPLES);
        orbits.read_out(phi, e);
        spoil(fault, index, problem.times[index], phi, e);
        let late = if fault == "times" && index > 0 { 0.001 } else { 0.0 };
        let header = SnapshotHeader {
            run_id: assignment.description.run_id,
            time: problem.times[index] + late,
            scenario: assignment.scenario(),
            index: index as u32,
            count: problem.times.len() as u32,
            rows: SAMPLES as u32,
            attempt: session.attempt,
            total,
            shard: if total > 0 { session.shard.index } else { 0 },
            shards: if total > 0 { session.shard.count } else { 0 },
            label: pack(&session.label),
            ..SnapshotHeader::default()
        };
        let header = header.with(Samples::INDEPENDENT);
        let columns = if fault == "shape" && index > 0 { 3 } else { header.columns };
        outlet.send(draft, SnapshotHeader { columns, ..header })?;
        match session.check_stop() {
            Err(Failure::Stopped) if fault == "deaf" => {}
            other => other?,
        }
    }
    session.done(assignment.scenario())?;
    Ok(outlet)
}

/// A first-passage curve that cannot be right; empty for faults that concern something else.
fn curve(fault: &str, scenario: u32, times: &[f64]) -> Vec<f64> {
    if fault == "unreadable-passage" && scenario == 1 {
        return vec![f64::NAN, 0.0, 0.0, 1.0];
    }
    let last = (times.len().max(2) - 1) as f64;
    let row = |(k, &time): (usize, &f64)| {
        let (rise, nan) = (k as f64 / last, f64::NAN);
        match fault {
            "constant-curve" => Some([time, 0.3, nan, nan]),
            "eager-curve" => Some([time, if time > 0.0 { 0.99 } else { 0.0 }, nan, nan]),
            "falling-curve" => Some([time, 0.5 * (1.0 - rise), nan, nan]),
            "crossed-interval" => Some([time, 0.0, 0.2, 0.1]),
            "impossible-curve" => Some([time, 1.995, nan, nan]),
            _ => None,
        }
    };
    times.iter().enumerate().filter_map(row).flatten().collect()
}

/// Makes numbers wrong, from the second snapshot on.
fn spoil(fault: &str, index: usize, time: f64, phi: &mut [f64], e: &mut [f64]) {
    match fault {
        "nan" if index > 0 => phi[7] = f64::NAN,
        "eccentricity" if index > 0 => e[7] = 1.0,
        // This fault also spoils the initial cloud.
        "degrees" => phi.iter_mut().for_each(|phi| *phi = phi.to_degrees()),
        "energy" => e.iter_mut().for_each(|e| *e *= 1.0 + 1e-5 * time),
        _ => {}
    }
}
