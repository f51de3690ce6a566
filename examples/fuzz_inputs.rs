//! Feeds the readers of scenario and launch files with hostile texts; prints how many, and how long the slowest took.
//!
//! `cargo run --release --example fuzz_inputs -- 1000000`

#[path = "../fuzz/inputs.rs"]
mod inputs;
#[path = "../fuzz/strategies.rs"]
mod strategies;

use std::cell::Cell;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use proptest::test_runner::{Config, RngSeed, TestRunner};

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(|_| ())); // a text that fails is printed once, when it is as short as possible
    let cases = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1_000_000);
    let seed = std::env::args().nth(2).and_then(|text| text.parse().ok()).unwrap_or(1);
    let good = feed("scenario files", cases / 2, seed, &strategies::SCENARIO_FILES, inputs::scenario_file)
        & feed("launch files", cases - cases / 2, seed, &strategies::LAUNCH_FILES, inputs::launch_file);
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Tries `cases` texts; a text that makes the reader fail is made as short as possible and printed.
fn feed(what: &str, cases: u32, seed: u64, files: &'static [&'static str], read: fn(&[u8])) -> bool {
    let (started, slowest) = (Instant::now(), Cell::new(Duration::ZERO));
    let config = Config { cases, rng_seed: RngSeed::Fixed(seed), failure_persistence: None, ..Config::default() };
    let result = TestRunner::new(config).run(&strategies::texts(files), |bytes| {
        let begin = Instant::now();
        read(&bytes.0);
        slowest.set(slowest.get().max(begin.elapsed()));
        Ok(())
    });
    let seconds = started.elapsed().as_secs_f64();
    println!("{cases} {what}, seed {seed}: {seconds:.0} s, slowest {:.1} ms", slowest.get().as_secs_f64() * 1e3);
    if let Err(error) = &result {
        println!("{error}");
    }
    result.is_ok()
}
