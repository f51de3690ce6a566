//! `phasecloud check`: our own propagators pass, faulty ones fail for the right reason.
#![allow(missing_docs)]

mod common;

use common::examples::example;
use common::{Bench, text};

/// Far longer than a propagator needs to end, also on a loaded machine.
const GRACE: [&str; 2] = ["--grace", "30"];

/// The exit code, and the rules with their verdicts and what was seen.
fn check(bench: &Bench, options: &[&str], command: &[&str]) -> (Option<i32>, Vec<[String; 3]>) {
    let output = bench.phasecloud().args(["check", "--json"]).args(options).arg("--").args(command).output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| {
        panic!("{e}: {} {}", text(&output.stdout), text(&output.stderr));
    });
    assert_eq!(report["passed"].as_bool(), Some(output.status.success()));
    let field = |line: &serde_json::Value, name: &str| line[name].as_str().unwrap().to_owned();
    let lines = report["rules"].as_array().unwrap().iter();
    let lines = lines.map(|line| ["rule", "verdict", "seen"].map(|name| field(line, name))).collect();
    assert_eq!(bench.domains(), [""; 0], "nothing is left behind");
    (output.status.code(), lines)
}

fn rules<'a>(lines: &'a [[String; 3]], verdict: &str) -> Vec<&'a str> {
    lines.iter().filter(|line| line[1] == verdict).map(|line| line[0].as_str()).collect()
}

#[test]
fn our_own_propagators_and_the_examples_keep_all_rules() {
    let bench = Bench::new();
    let (stt, skeleton) = (example("stt-gaussian").display().to_string(), example("skeleton").display().to_string());
    let commands: [(&[&str], &[&str]); 7] = [
        (&["mc", "--set", "samples=1000"], &["carried density"]),
        (&["mc", "--set", "samples=1000", "--set", "draws=\"sobol\"", "--set", "replicates=10"], &["carried density"]),
        (&["dee", "--set", "samples=961"], &[]),
        (&["gmm-ut"], &["Hamiltonian", "carried density"]),
        (&["exact"], &["Hamiltonian", "carried density"]),
        (&[&stt], &["Hamiltonian", "carried density"]),
        (&[&skeleton], &["carried density"]),
    ];
    for (command, unjudged) in commands {
        let (code, lines) = check(&bench, &GRACE, command);
        assert_eq!((code, rules(&lines, "FAIL")), (Some(0), vec![]), "{command:?} {lines:?}");
        assert_eq!(rules(&lines, "-"), unjudged, "{command:?}");
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn propagators_of_scenarios_in_space_keep_all_rules_that_are_judged_there() {
    let bench = Bench::new();
    let cubature = example("cubature-in-space").display().to_string();
    let commands: [(&[&str], &[&str]); 3] = [
        (&["mc", "--set", "samples=1000"], &["Hamiltonian", "carried density"]),
        (&["gmm-ut", "--set", "sigma_points=600"], &["Hamiltonian", "carried density"]),
        (&[&cubature], &["Hamiltonian", "carried density"]),
    ];
    let options = [&GRACE[..], &["--model", "vectorial"]].concat();
    for (command, unjudged) in commands {
        let (code, lines) = check(&bench, &options, command);
        assert_eq!((code, rules(&lines, "FAIL")), (Some(0), vec![]), "{command:?} {lines:?}");
        assert_eq!(rules(&lines, "-"), unjudged, "{command:?}");
    }
}

#[test]
fn a_propagator_of_the_plane_refuses_scenarios_in_space_and_wrong_moments_there_are_found() {
    let bench = Bench::new();
    let stt = example("stt-gaussian").display().to_string();
    let options = [&GRACE[..], &["--model", "vectorial"]].concat();
    let (code, lines) = check(&bench, &options, &[&stt]);
    assert_eq!((code, rules(&lines, "FAIL").contains(&"first scenario")), (Some(1), true), "{lines:?}");
    // The orbits of a simpler model are not those that are asked for.
    let (code, lines) = check(&bench, &options, &["mc", "--set", "samples=1000", "--set", "model=\"planar\""]);
    assert_eq!((code, rules(&lines, "FAIL").contains(&"moments")), (Some(1), true), "{lines:?}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_faulty_propagator_fails_the_rule_that_it_breaks_and_no_other() {
    let bench = Bench::new();
    let program = example("faulty-propagator").display().to_string();
    let computing = "SIGTERM, computing";
    let faults: [(&str, &[&str], &[&str], &str); 22] = [
        ("none", &GRACE, &[], ""),
        ("counts", &GRACE, &["counts"], "check-1: 4 of 5"),
        ("nan", &GRACE, &["finite"], "check-1, snapshot 1: row 7 of column 0 is NaN"),
        (
            "order",
            &GRACE,
            &["order"],
            "check-1, snapshot 1: it comes out of order: it is number 2, but number 1 is due (from 0 to 4)",
        ),
        ("too-many", &GRACE, &["counts", "order"], ""),
        ("times", &GRACE, &["times"], "check-1, snapshot 1: its time is 0.301 yr instead of 0.3 yr"),
        ("shape", &GRACE, &["shape"], "it has 400 rows of 3 columns, its kind has 2"),
        ("eccentricity", &GRACE, &["eccentricity"], "row 7 has e = 1, outside [0, 1)"),
        ("energy", &GRACE, &["Hamiltonian"], "check-1: has changed by"),
        ("redrawn", &GRACE, &["Hamiltonian"], "has changed by"),
        ("redrawn", &["--grace", "30", "--redrawn"], &[], ""),
        ("moments", &GRACE, &["moments"], "check-1: mean phi at 0 yr is 2.20"),
        ("no-passage", &GRACE, &["first passage"], "check-1: no message on phasecloud/passage"),
        ("constant-curve", &GRACE, &["first passage"], "its first-passage curve begins with 0.3"),
        ("falling-curve", &GRACE, &["first passage"], "the probability falls from 0.5 at 0 yr"),
        ("crossed-interval", &GRACE, &["first passage"], "low is never above high"),
        ("impossible-curve", &GRACE, &["first passage"], "is 1.995; a probability lies between 0 and 1"),
        ("deaf", &["--grace", "0.4"], &["SIGTERM, waiting", computing], "after SIGTERM; it was killed"),
        ("never-ready", &["--patience", "2"], &["handshake"], "not ready: no sign of life for 2 s"),
        ("second-scenario", &GRACE, &["second scenario"], "its process ended: exit status: 101"),
        ("accepts", &GRACE, &["refusal"], "it sent 3 snapshots and reported done"),
        ("dies-unsaid", &GRACE, &["refusal"], "its process ended: exit status: 1"),
    ];
    for (fault, options, broken, words) in faults {
        // The limit after which our own nodes are ended must not come before the faulty one has used its time here.
        let (code, lines) = check(&bench, options, &["env", "PHASECLOUD_GRACE=600", &program, fault]);
        assert_eq!(rules(&lines, "FAIL"), broken, "{fault}: {lines:?}");
        assert_eq!(code, Some(i32::from(!broken.is_empty())));
        for line in lines.iter().filter(|line| line[1] == "FAIL") {
            assert!(line[2].contains(words), "{fault}: {line:?}");
        }
    }
}

#[test]
fn angles_in_degrees_break_the_rules_about_mass_and_moments() {
    let bench = Bench::new();
    let program = example("faulty-propagator").display().to_string();
    let (code, lines) = check(&bench, &GRACE, &[&program, "degrees"]);
    let broken = rules(&lines, "FAIL");
    assert!(code == Some(1) && broken.contains(&"mass") && broken.contains(&"moments"), "{lines:?}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_density_may_withhold_what_it_does_not_stand_behind_but_not_contradict_the_right_answer() {
    let bench = Bench::new();
    let program = example("lying-exact").display().to_string();
    for withheld in ["withholds-density", "withholds-all", "withholds-passage"] {
        let (code, lines) = check(&bench, &GRACE, &[&program, withheld]);
        assert_eq!((code, rules(&lines, "FAIL")), (Some(0), vec![]), "{withheld}: {lines:?}");
        let words = lines.iter().any(|line| line[2].contains("withheld"));
        assert_eq!(words, withheld != "withholds-passage", "{withheld}: {lines:?}");
    }
    for (lie, broken) in
        [("mean-e", "moments"), ("passage", "first passage"), ("mass", "mass"), ("mixes", "first scenario")]
    {
        let (code, lines) = check(&bench, &GRACE, &[&program, lie]);
        assert!(code == Some(1) && rules(&lines, "FAIL").contains(&broken), "{lie}: {lines:?}");
    }
}

#[test]
fn what_cannot_be_started_is_bad_input() {
    let bench = Bench::new();
    for (words, told) in [
        (["check", "--", "no-such-program"].as_slice(), "no-such-program cannot be started"),
        (&["check", "--grace", "0", "--", "true"], "must be a number of seconds greater than 0"),
        (
            &["check", "mc", "--set", "sample=1"],
            "check: --set sample: is unknown, did you mean `samples`? There may be `samples`",
        ),
        (
            &["check", "mc", "--set", "samples=1"],
            "check: --set samples: 1 is not enough for replicates = 1, it must be at least 2",
        ),
        (
            &["check", "mc", "--set", "samples=2000.0"],
            "--set samples: 2000.0 is not allowed, it must be a whole number",
        ),
        (&["check", "mc", "--sets", "samples=1"], "check: unexpected argument '--sets'"),
        (&["check"], "required arguments"),
    ] {
        let output = bench.phasecloud().args(words).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
        assert_eq!(bench.domains(), [""; 0]);
    }
}

#[test]
fn the_table_has_a_line_for_every_rule() {
    let bench = Bench::new();
    let output = bench.phasecloud().args(["check", "--grace", "30", "mc", "--set", "samples=300"]).output().unwrap();
    let table = text(&output.stdout);
    assert!(output.status.success(), "{table}");
    for words in ["handshake", "| refusal            | pass |", "passed: 17 rules kept, 1 not judged"] {
        assert!(table.contains(words), "{table}");
    }
}

#[test]
fn what_a_program_under_trial_says_is_passed_on_but_cannot_command_a_terminal() {
    let bench = Bench::new();
    let program = ["check", "--", "sh", "-c", "printf 'hello \\033[2J world\\n' >&2; exit 3"];
    let output = bench.phasecloud().args(program).output().unwrap();
    let errors = text(&output.stderr);
    assert!(errors.contains("hello \\u{1b}[2J world") && !errors.contains('\u{1b}'), "{errors:?}");
}
