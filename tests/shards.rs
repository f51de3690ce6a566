//! A case in shards: several processes share its work, and the results are the same bytes.
#![allow(missing_docs)]

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::processes::{Process, of_runs_below, signal};
use common::{Bench, REPRODUCIBLE, text};
use messages::recording::Recording;
use messages::topic::Snapshot;
use rustix::process::Signal;

/// Cases that can be split; the line `split` splits them.
fn cases(split: &str) -> String {
    let mc = |label: &str, settings: &str| {
        format!("[[propagator]]\nlabel = \"{label}\"\nnode = \"mc\"\nsamples = 4_001\nseed = 11\n{settings}\n{split}\n")
    };
    let dee = |label: &str, settings: &str| {
        format!("[[propagator]]\nlabel = \"{label}\"\nnode = \"dee\"\nsamples = 961\n{settings}\n{split}\n")
    };
    [
        mc("mc", ""),
        mc("antithetic", "draws = \"antithetic\"\nreplicates = 5"),
        mc("sobol", "draws = \"sobol\"\nreplicates = 8"),
        dee("dee", ""),
        dee("dee-hull", "mode = \"as-printed\"\nresolution = 100"),
    ]
    .concat()
}

fn launch_file(bench: &Bench, name: &str, cases: &str) -> std::path::PathBuf {
    let head = "scenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\nbins = [40, 40]\n";
    bench.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{head}{cases}"))
}

/// All files that depend on the seeds alone.
const FILES: [&str; 8] = [
    REPRODUCIBLE[0],
    REPRODUCIBLE[1],
    REPRODUCIBLE[2],
    REPRODUCIBLE[3],
    REPRODUCIBLE[4],
    "diagnostics.csv",
    "notes.csv",
    "verdicts.csv",
];

fn assert_same(bench: &Bench, out: &str, said: &str) {
    for file in FILES {
        let same = bench.read(&format!("{out}/{file}")) == bench.read(&format!("whole/{file}"));
        assert!(same, "{out}: {file} differs; {said}");
    }
}

/// A process of the run; waits until it has been started.
fn find(bench: &Bench, name: &str) -> Process {
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < Duration::from_secs(180), "{name} does not start");
        if let Some(found) = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == name) {
            return found;
        }
    }
}

#[test]
fn any_number_of_shards_gives_the_same_bytes() {
    let bench = Bench::new();
    bench.run_well(&launch_file(&bench, "whole", &cases("")), "whole");
    for shards in [1, 2, 3, 7] {
        let out = format!("in-{shards}");
        let launch = launch_file(&bench, &out, &cases(&format!("shards = {shards}")));
        let said = text(&bench.run_well(&launch, &out).stderr);
        assert_same(&bench, &out, &said);
        let manifest: serde_json::Value = serde_json::from_slice(&bench.read(&format!("{out}/manifest.json"))).unwrap();
        assert_eq!(manifest["nodes"].as_object().unwrap().len(), 4 + 5 * shards);
    }
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn samples_that_are_reduced_where_they_are_give_the_same_bytes() {
    let bench = Bench::new();
    let mc =
        |more: &str| format!("[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 20_003\nseed = 11\n{more}\n");
    bench.run_well(&launch_file(&bench, "whole", &mc("")), "whole");
    for shards in [1, 2, 3, 7] {
        let out = format!("reduced-in-{shards}");
        let launch = launch_file(&bench, &out, &mc(&format!("shards = {shards}\nreduce = true")));
        let said = text(&bench.run_well(&launch, &out).stderr);
        assert_same(&bench, &out, &said);
        let trajectories = |out: &str| bench.table(&format!("{out}/effort.csv"))[0]["trajectories"].clone();
        assert_eq!(trajectories(&out), trajectories("whole"));
    }
}

/// Number of bytes of the snapshots of a recorded run with a million samples.
fn snapshot_bytes(bench: &Bench, name: &str, more: &str) -> usize {
    let million = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 1_000_000\naccuracy = 1e-6\n";
    let head = "scenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\n";
    let launch = bench.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{head}{million}{more}"));
    let tape = format!("{name}.tape");
    let arguments = ["run", launch.to_str().unwrap(), "--record", &tape, "--no-report", "--quiet", "--out", name];
    let output = bench.phasecloud().args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let recording = Recording::open(&bench.path(&tape)).unwrap();
    let bytes = recording.messages::<Snapshot>().map(|(_, entry)| 8 * entry.items::<Snapshot>()).sum();
    std::fs::remove_file(bench.path(&tape)).unwrap();
    bytes
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn reduced_a_million_samples_are_a_hundredth_of_the_bytes() {
    let bench = Bench::new();
    let moved = snapshot_bytes(&bench, "whole", "");
    let reduced = snapshot_bytes(&bench, "reduced", "reduce = true\n");
    println!("1e6 samples, 5 snapshots: {moved} bytes, reduced {reduced}");
    assert_eq!(moved, 5 * 16_000_000);
    assert!(reduced * 100 < moved, "{reduced}");
    assert_same(&bench, "reduced", "");
}

#[test]
fn a_shard_that_is_killed_is_started_again_and_changes_no_byte() {
    let bench = Bench::new();
    let mc = |split: &str| {
        format!("[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 100_000\naccuracy = 1e-12\n{split}\n")
    };
    bench.run_well(&launch_file(&bench, "whole", &mc("")), "whole");
    let launch = launch_file(&bench, "killed", &mc("shards = 3"));
    for delay in [0, 40, 120, 250] {
        let out = format!("after-{delay}");
        let mut command = bench.phasecloud();
        command.arg("run").arg(&launch).args(["--quiet", "--out"]).arg(bench.path(&out));
        let run = command.stderr(Stdio::piped()).spawn().unwrap();
        // Without its estimator the run cannot end before the shard is killed.
        let estimator = find(&bench, "estimator");
        signal(&estimator, Signal::STOP);
        let victim = find(&bench, "mc/1");
        std::thread::sleep(Duration::from_millis(delay));
        signal(&victim, Signal::KILL);
        signal(&estimator, Signal::CONT);
        let output = run.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_same(&bench, &out, &said);
        let manifest = text(&bench.read(&format!("{out}/manifest.json")));
        assert!(manifest.contains("restarts: 1"), "{manifest}");
    }
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn a_shard_that_fails_for_good_fails_its_case_and_the_others_are_compared() {
    let bench = Bench::new();
    let broken = "[[propagator]]\nlabel = \"broken\"\nshards = 3\n\
        command = [\"sh\", \"-c\", \"[ $PHASECLOUD_SHARD = 1 ] && exit 3; exec sleep 600\"]\n";
    let mc = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\nshards = 2\n";
    let output = bench.run(&launch_file(&bench, "broken", &format!("{mc}{broken}")), "out");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("broken: broken/1: ended before the run did: exit status: 3, also after 3 restarts"),
        "{said}"
    );
    assert_eq!(bench.table("out/moments.csv").len(), 5);
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn after_a_scenario_that_one_shard_cannot_do_all_do_the_next() {
    let bench = Bench::new();
    bench.write("scenario-2.toml", &common::SCENARIO_1.replace("scenario-1", "scenario-2").replace("0.145", "0.2"));
    let program = common::examples::example("faulty-propagator");
    let launch = bench.write(
        "two.toml",
        &format!(
            "name = \"two\"\nscenarios = [\"scenario-1.toml\", \"scenario-2.toml\"]\nreference = \"mc\"\nbins = [40, 40]\n\
             [[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\nshards = 2\n\
             [[propagator]]\nlabel = \"mine\"\nshards = 3\ncommand = [\"{}\", \"first-scenario\"]\n",
            program.display()
        ),
    );
    let output = bench.run(&launch, "out");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("scenario-1, mine: mine/1: not this one"), "{said}");
    let rows = bench.table("out/moments.csv");
    let of = |scenario: &str, method: &str| {
        rows.iter().filter(|row| row["scenario"] == scenario && row["method"] == method).count()
    };
    assert_eq!([of("scenario-1", "mc"), of("scenario-2", "mc")], [5, 5], "{said}");
    assert_eq!([of("scenario-1", "mine"), of("scenario-2", "mine")], [0, 5], "{said}");
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn a_shard_with_the_wrong_rows_is_refused_by_name() {
    let bench = Bench::new();
    let program = common::examples::example("faulty-propagator");
    let mine = format!(
        "[[propagator]]\nlabel = \"mine\"\nshards = 2\ncommand = [\"{}\", \"unsplit\"]\n\
         [[propagator]]\nlabel = \"odd\"\nshards = 2\ncommand = [\"{0}\", \"range\"]\n",
        program.display()
    );
    let mc = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\nshards = 2\n";
    let output = bench.run(&launch_file(&bench, "wrong", &format!("{mc}{mine}")), "out");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("mine: snapshot 0: it says that it is shard 0 of 1, but the case has 2"), "{said}");
    assert!(said.contains("odd: snapshot 0: shard 0: it has 400 rows, but its range of 799 is 0..399"), "{said}");
    assert_eq!(bench.table("out/moments.csv").len(), 5);
}

#[test]
fn a_program_of_ones_own_that_cannot_be_split_says_so() {
    let bench = Bench::new();
    let program = common::examples::example("stt-gaussian");
    let mine = format!("[[propagator]]\nlabel = \"stt\"\nshards = 2\ncommand = [\"{}\"]\n", program.display());
    let mc = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n";
    let output = bench.run(&launch_file(&bench, "own", &format!("{mc}{mine}")), "out");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot be split into shards"), "{said}");
}

#[test]
fn a_recorded_run_in_shards_is_replayed_to_the_same_bytes() {
    let bench = Bench::new();
    let launch = launch_file(&bench, "taped", &cases("shards = 2"));
    let run = |arguments: &[&str]| {
        let output = bench.phasecloud().args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    run(&["run", launch.to_str().unwrap(), "--record", "run.tape", "--out", "whole"]);
    let said = run(&["replay", "run.tape", "--out", "played"]);
    assert_same(&bench, "played", &said);
    let said = run(&["replay", "run.tape", "--live", "mc", "--out", "live"]);
    assert_same(&bench, "live", &said);
}
