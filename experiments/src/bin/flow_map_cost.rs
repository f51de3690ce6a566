//! What samples cost that move by a flow map, and what the map is made of, beside direct propagation.
//!
//! `cargo run --release -p phasecloud-experiments --bin flow_map_cost -- --samples 10000000` prints one row per
//! problem: orbits, cells and coefficients of the map, the estimate of its error and the largest error of 20,000 random
//! starts, the share of samples that it leaves to direct propagation, and wall seconds, with CPU seconds of all threads
//! in brackets behind the sum: to make the map, to draw the samples and sort them into cells, to move all samples to
//! all snapshots and reduce them there to bins and sums for the moments, to count their first passages; and to do the
//! same directly with `--direct` samples, scaled. `--problem NAME` does one row only, `--threads` sets the threads, and
//! `--by action-angle` takes the map by action and angle.

mod common;

use std::error::Error;
use std::time::Instant;

use common::{cpu, paper};
use density::first_passage::curve_times;
use density::first_passage::empirical::point;
use density::flow::{Flow, Passages};
use density::flow_map::{AngleMap, AngleOrbits, FlowMap, MappedOrbits, Settings, Summary};
use density::grid::{Grid, comparison_grids};
use density::model::plane::State;
use density::orbits::Orbits;
use density::problem::Problem;
use density::sample_sums::SampleSums;
use density::sampling::{Draws, SamplingPlan};

/// Starts at which the map is compared with orbits.
const COMPARED: usize = 20_000;
/// Times of a first-passage curve.
const CURVE: usize = 65;

fn problems() -> Vec<(String, Problem)> {
    let half_years = |count: u32| (0..count).map(|k| 0.5 * f64::from(k)).collect::<Vec<_>>();
    let over_thirty = || vec![0.0, 5.0, 10.0, 20.0, 30.0];
    let short = [(1, 5), (2, 7), (3, 5)].map(|(n, count)| (format!("scenario-{n}"), paper(n, half_years(count))));
    let long = [1, 2, 3].map(|n| (format!("scenario-{n}-30yr"), paper(n, over_thirty())));
    let longest = [1, 2, 3].map(|n| (format!("scenario-{n}-100yr"), paper(n, vec![0.0, 25.0, 50.0, 75.0, 100.0])));
    short.into_iter().chain(long).chain(longest).collect()
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let done = work();
    (start.elapsed().as_secs_f64(), done)
}

/// What a map costs, and how good it is.
struct Cost {
    summary: Summary,
    /// The largest error of a coordinate of a state among random starts.
    off: f64,
    /// Orbits that it leaves to direct propagation.
    direct: usize,
    /// Wall seconds: for the map, the draws, the snapshots, the passages.
    seconds: [f64; 4],
    /// CPU seconds for all of them.
    cpu: f64,
}

/// What is asked of a map.
struct Wanted<'a> {
    problem: &'a Problem,
    grids: &'a [Grid],
    samples: usize,
    settings: Settings,
}

fn plan() -> SamplingPlan {
    SamplingPlan { draws: Draws::Independent, seed: 1, replicates: std::num::NonZeroUsize::MIN }
}

/// The passage times of a curve.
fn curve(problem: &Problem) -> Vec<f64> {
    curve_times(problem.times[problem.times.len() - 1], CURVE)
}

fn by_cells(wanted: &Wanted<'_>) -> Result<Cost, Box<dyn Error>> {
    let Wanted { problem, grids, samples, settings } = wanted;
    let (critical, begun) = (problem.critical_e, cpu());
    let flow = Flow::new(problem.model);
    let made = seconds(|| FlowMap::new(flow, problem.initial.into(), &problem.times, Some(critical), settings));
    let (map_seconds, map) = (made.0, made.1?);
    let (map_cpu, polar) = (cpu() - begun, plan().polar(&problem.initial));
    let off = largest_error(problem, &polar, |start, index| map.state(start, index))?;
    let (begun, summary) = (cpu(), *map.summary());
    let (draw_seconds, mut orbits) =
        seconds(|| MappedOrbits::new(map, 0..*samples, Box::new(plan().starts(&problem.initial))));
    let (move_seconds, reduced) = seconds(|| -> Result<(), Box<dyn Error>> {
        grids.iter().enumerate().try_for_each(|(index, grid)| {
            orbits.advance_watching(index, critical)?;
            orbits.reduce(grid, critical)?;
            Ok(())
        })
    });
    reduced?;
    let (passage_seconds, _) = seconds(|| orbits.passage_counts(&curve(problem)));
    let seconds = [map_seconds, draw_seconds, move_seconds, passage_seconds];
    Ok(Cost { summary, off, direct: orbits.direct(), seconds, cpu: map_cpu + cpu() - begun })
}

fn by_angle(wanted: &Wanted<'_>) -> Result<Cost, Box<dyn Error>> {
    let Wanted { problem, grids, samples, settings } = wanted;
    let (critical, begun) = (problem.critical_e, cpu());
    let flow = Flow::new(problem.model);
    let made = seconds(|| AngleMap::new(flow, &problem.initial, &problem.times, Some(critical), settings));
    let (map_seconds, map) = (made.0, made.1?);
    let (map_cpu, polar) = (cpu() - begun, plan().polar(&problem.initial));
    let off = largest_error(problem, &polar, |&[phi, e], index| {
        map.state(State::from_polar(phi, e), problem.times[index]).map(|(state, _)| state)
    })?;
    let (begun, summary) = (cpu(), *map.summary());
    let (draw_seconds, mut orbits) =
        seconds(|| AngleOrbits::new(map, 0..*samples, Box::new(plan().starts(&problem.initial))));
    let (move_seconds, reduced) = seconds(|| -> Result<(), Box<dyn Error>> {
        grids.iter().enumerate().try_for_each(|(index, grid)| {
            orbits.advance_watching(index, critical)?;
            orbits.reduce(grid, critical)?;
            Ok(())
        })
    });
    reduced?;
    let (passage_seconds, _) = seconds(|| orbits.passage_counts(&curve(problem)));
    let seconds = [map_seconds, draw_seconds, move_seconds, passage_seconds];
    Ok(Cost { summary, off, direct: orbits.direct(), seconds, cpu: map_cpu + cpu() - begun })
}

fn row(name: &str, problem: &Problem, samples: usize, direct: usize, is_by_angle: bool) -> Result<(), Box<dyn Error>> {
    let grids = comparison_grids(problem, &Flow::new(problem.model), 100, 100)?;
    let settings = Settings {
        smallest_share: 1000.0 / samples as f64,
        most_orbits: (samples / 4).clamp(20_000, 1_000_000),
        ..Settings::default()
    };
    let wanted = Wanted { problem, grids: &grids, samples, settings };
    let cost = match if is_by_angle { by_angle(&wanted) } else { by_cells(&wanted) } {
        Ok(cost) => cost,
        Err(refused) => {
            println!("{name}: {refused}");
            return Ok(());
        }
    };
    let Cost { summary, off, direct: left, seconds: [map, draw, moves, passages], cpu: total_cpu } = cost;
    let (share, total) = (left as f64 / samples as f64, map + draw + moves + passages);
    let begun = cpu();
    let scale = samples as f64 / direct as f64;
    let direct_seconds = directly(problem, &grids, direct)? * scale;
    let direct_cpu = (cpu() - begun) * scale;
    println!(
        "| {name} | {} | {} | {} | {:.1e} | {off:.1e} | {share:.1e} | {map:.3} | {draw:.3} | {moves:.3} | {passages:.3} | **{total:.2}** \
         ({total_cpu:.2}) | {direct_seconds:.1} ({direct_cpu:.1}) | {:.1} |",
        summary.orbits,
        summary.cells,
        summary.coefficients,
        summary.error,
        direct_cpu / total_cpu
    );
    Ok(())
}

/// The largest error of a coordinate of a state among random starts.
fn largest_error(
    problem: &Problem,
    polar: &impl Fn(usize) -> (f64, f64),
    by_map: impl Fn(&[f64; 2], usize) -> Option<State>,
) -> Result<f64, Box<dyn Error>> {
    let starts: Vec<[f64; 2]> = (0..COMPARED).map(|i| polar(i).into()).collect();
    let (phi, e): (Vec<f64>, Vec<f64>) = starts.iter().map(|start| (start[0], start[1])).unzip();
    let mut orbits = Orbits::from_polar(Flow::new(problem.model), &phi, &e);
    let mut worst = 0.0f64;
    for (index, &time) in problem.times.iter().enumerate() {
        orbits.advance_to(time)?;
        for (i, start) in starts.iter().enumerate() {
            let Some(state) = by_map(start, index) else { continue };
            worst = worst.max((state.x1 - orbits.x1()[i]).abs()).max((state.x2 - orbits.x2()[i]).abs());
        }
    }
    Ok(worst)
}

/// Seconds that the same takes directly.
fn directly(problem: &Problem, grids: &[density::Grid], samples: usize) -> Result<f64, Box<dyn Error>> {
    let times = curve(problem);
    let (taken, result) = seconds(|| -> Result<(), Box<dyn Error>> {
        let (x1, x2) = plan().draw(&problem.initial, samples);
        let mut orbits = Orbits::new(Flow::new(problem.model), x1, x2);
        let (mut phi, mut e) = (vec![0.0; samples], vec![0.0; samples]);
        let mut passages = vec![u8::MAX; samples];
        for (&time, grid) in problem.times.iter().zip(grids) {
            let note = |passage| point(passage, &times) as u8;
            let passages = Passages { passages: &mut passages, pending: u8::MAX, note: &note };
            orbits.advance_watching(time, problem.critical_e, passages)?;
            orbits.read_out(&mut phi, &mut e);
            SampleSums::reduce(&phi, &e, grid, problem.critical_e)?;
        }
        Ok(())
    });
    result.map(|()| taken)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut samples, mut direct, mut only, mut threads, mut by) = (1_000_000, 100_000, None, 0, "cells".to_string());
    let mut arguments = std::env::args().skip(1);
    while let Some(key) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{key} needs a value"))?;
        match key.as_str() {
            "--samples" => samples = value.parse()?,
            "--direct" => direct = value.parse()?,
            "--problem" => only = Some(value),
            "--threads" => threads = value.parse()?,
            "--by" if ["cells", "action-angle"].contains(&value.as_str()) => by = value,
            "--by" => return Err(format!("--by {value} is unknown; there are cells and action-angle").into()),
            _ => {
                return Err(
                    format!("{key} is unknown; --samples, --direct, --problem, --threads and --by are known").into()
                );
            }
        }
    }
    println!(
        "| problem | orbits | cells | coefficients | estimate | error | directly | map, s | draw, s | move and reduce, s | passages, s \
         | together, s (CPU) | direct, s (CPU) | ratio of CPU |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    for (name, problem) in problems().iter().filter(|(name, _)| only.as_ref().is_none_or(|only| only == name)) {
        pool.install(|| row(name, problem, samples, direct, by == "action-angle").map_err(|why| why.to_string()))?;
    }
    Ok(())
}
