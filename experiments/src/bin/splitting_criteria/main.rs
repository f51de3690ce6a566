//! The splitting criteria of the literature beside the adaptive split: L1 error of the density against the number of
//! components, in the paper's three scenarios and in two inclined clouds.
//!
//! `cargo run --release -p phasecloud-experiments --bin splitting_criteria -- [plane|space] [FILE]`
//!
//! FILE takes what `benches/peers/pyest_splits.py` needs to do the same with PyEst. A split is made for each time by
//! itself, along the direction that the criterion prefers for that time. All splits take the splitting library that
//! keeps the variance, and sigma points with `n + zeta = n + 1`.

#[path = "../common/mod.rs"]
mod common;
mod plane;
mod room;
mod space;
#[path = "../../../../density/tests/space_support/mod.rs"]
#[allow(dead_code, reason = "the clouds are needed here, not all that is measured on them")]
mod space_support;

use density::mixture::library::{Library, Variance};

/// Components of the splits.
const COMPONENTS: [usize; 3] = [5, 15, 39];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let only = |part: &str| arguments.first().is_none_or(|first| first == part);
    let libraries = COMPONENTS.map(|count| Library::new(count, Variance::Kept).expect("the library converges"));
    let (_, ()) = timed(|| {
        if only("plane") {
            let of_criteria = plane::tables();
            if let Some(file) = arguments.get(1) {
                std::fs::write(file, room::written(&of_criteria, &libraries)).unwrap_or_else(|e| panic!("{file}: {e}"));
            }
        }
        if only("space") {
            space::tables(&libraries);
        }
    });
}

/// Does the work and prints the CPU time that it took.
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let (seconds, done) = common::cpu_of(work);
    println!("{seconds:.0} s of CPU time");
    (seconds, done)
}

/// One number of a table.
fn cell(l1: f64) -> String {
    match l1 < 0.01 {
        true => format!("{l1:.4}"),
        false => format!("{l1:.3}"),
    }
}

fn row(cells: &[String]) {
    println!("| {} |", cells.join(" | "));
}

/// The head of a table in which every time has its own columns.
fn head(times: &[f64], with_angle: bool) {
    let mut names = vec!["split".to_string()];
    for time in times {
        if with_angle {
            names.push(format!("{time} yr: angle"));
        }
        names
            .extend(COMPONENTS.map(|count| if with_angle { count.to_string() } else { format!("{time} yr: {count}") }));
    }
    row(&names);
    println!("|{}", "---|".repeat(names.len()));
}
