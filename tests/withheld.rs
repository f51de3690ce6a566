//! Where a reference withholds a figure the next one takes its place, and this is printed first; impossible results are
//! errors.
#![allow(missing_docs)]

mod common;

use std::collections::HashMap;

use common::{Bench, text};

const MC: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 4_000\nseed = 11\n";
const DEE: &str = "[[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\nsamples = 961\n";

fn program(name: &str, words: &str) -> String {
    let path = common::examples::example(name);
    format!("command = [\"{}\", \"{words}\"]\n", path.display())
}

/// Runs `cases` on scenario 1; all are compared with `exact`, or with `mc` where `exact` withholds a figure. Returns
/// the exit code, standard output and standard error.
fn run(bench: &Bench, name: &str, cases: &str) -> (Option<i32>, String, String) {
    let head =
        "scenarios = [\"scenario-1.toml\"]\nreference = [\"exact\", \"mc\"]\nbins = [40, 40]\nrestart = \"never\"\n";
    let launch = bench.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{head}{cases}"));
    let output = bench.run(&launch, name);
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn liar(lie: &str) -> String {
    format!("[[propagator]]\nlabel = \"exact\"\n{}", program("lying-exact", lie))
}

/// The references that a table names in the rows of `method` after t = 0.
fn references(
    rows: &[HashMap<String, String>],
    method: &str,
    wanted: impl Fn(&HashMap<String, String>) -> bool,
) -> Vec<String> {
    let later = rows.iter().filter(|row| row["method"] == method && row["t_yr"] != "0.0").filter(|row| wanted(row));
    let mut references: Vec<String> = later.map(|row| row["reference"].clone()).collect();
    references.sort();
    references.dedup();
    references
}

#[test]
fn what_the_first_reference_withholds_is_compared_with_the_next_and_that_is_said_first() {
    let bench = Bench::new();
    let (code, out, errors) = run(&bench, "part", &format!("{}{MC}{DEE}", liar("withholds-density")));
    assert_eq!(code, Some(0), "{errors}");
    let (moments, distances) = (bench.table("part/errors.csv"), bench.table("part/distances.csv"));
    assert_eq!(references(&moments, "dee", |_| true), ["exact"]);
    assert_eq!(references(&distances, "dee", |_| true), ["mc"]);
    assert_eq!(references(&distances, "exact", |_| true), [""; 0], "what is withheld is not compared");
    let at_start = |row: &&HashMap<String, String>| row["method"] == "dee" && row["t_yr"] == "0.0";
    assert!(distances.iter().filter(at_start).all(|row| row["reference"] == "exact"));
    let first = bench.table("part/notes.csv").remove(0);
    let words = "fallback: the reference exact withholds the joint density (error estimate 3.0e-1): that is above what it stands \
        behind; mc is the reference there";
    assert_eq!((first["note"].as_str(), first["t_yr"].as_str()), (words, "0.5"));
    let said = "scenario-1: at t = 0.5, 1, 1.5 and 2 yr the reference exact withholds the joint density";
    let (place, table) = (out.find(said), out.find("mean and standard deviation"));
    assert!(place.is_some() && place < table, "{out}");
    let page = text(&bench.read("part/report.html"));
    let place = page.find("the reference exact withholds the joint density");
    assert!(place.is_some() && place < page.find("This run propagated"));
    let verdicts = bench.table("part/verdicts.csv");
    let verdict =
        |method: &str, column: &str| verdicts.iter().find(|row| row["method"] == method).unwrap()[column].clone();
    assert_eq!(verdict("exact", "verdict"), "good for moments, not for the density");
    assert_eq!(verdict("exact", "density_judged_by"), "withheld");
    assert_eq!(verdict("dee", "moments_judged_by"), "exact");
    assert_eq!(verdict("dee", "density_judged_by"), "mc");
    assert!(verdict("mc", "verdict").contains("as good as the sampling error of"), "{}", verdict("mc", "verdict"));
}

#[test]
fn a_reference_that_withholds_everything_is_printed_in_words_and_nothing_of_it_is_compared() {
    let bench = Bench::new();
    let (code, out, errors) = run(&bench, "all", &format!("{}{MC}{DEE}", liar("withholds-all")));
    assert_eq!(code, Some(0), "{errors}");
    assert_eq!(references(&bench.table("all/errors.csv"), "dee", |_| true), ["mc"]);
    assert_eq!(references(&bench.table("all/errors.csv"), "exact", |_| true), [""; 0]);
    let exact = out.lines().find(|line| line.starts_with("| exact")).unwrap();
    assert_eq!(exact.matches("withheld").count(), 4, "{exact}");
    assert!(out.contains("0.00000 to 1.00000 (bounds)"), "the bounds of a withheld first passage: {out}");
    let words = "the probability of having reached the critical eccentricity at 65 of 65 times from 0 to 2 yr (in the end strictly \
        between 0.00000 and 1.00000)";
    let notes = bench.table("all/notes.csv");
    for beginning in ["fallback: the reference exact withholds ", "withheld: "] {
        let says = |row: &HashMap<String, String>| row["note"].starts_with(&format!("{beginning}{words}"));
        assert!(notes.iter().any(says), "{beginning}: {notes:?}");
    }
    assert!(out.contains(&format!("the reference exact withholds {words}; mc is the reference there")), "{out}");
    let passages = bench.table("all/first_passage.csv");
    let last = passages.iter().rfind(|row| row["method"] == "exact").unwrap();
    assert_eq!([&last["prob_reached_critical_e"], &last["low"], &last["high"]], ["NaN", "0.0", "1.0"]);
    assert_eq!(last["interval"], "bounds");
    assert!(passages.iter().any(|row| row["method"] == "mc" && row["interval"] == "95 %"));
    assert!(passages.iter().any(|row| row["method"] == "dee" && row["interval"] == "error estimate"));
}

#[test]
fn a_reference_that_has_failed_is_replaced_by_the_next() {
    let bench = Bench::new();
    let (code, out, errors) = run(&bench, "failed", &format!("{}{MC}{DEE}", liar("mixes")));
    assert_eq!(code, Some(1), "{errors}");
    assert!(errors.contains("a joint density is withheld as a whole or not at all"), "{errors}");
    assert_eq!(references(&bench.table("failed/errors.csv"), "dee", |_| true), ["mc"]);
    let notes = bench.table("failed/notes.csv");
    let why = "a joint density is withheld as a whole or not at all";
    for (beginning, end) in
        [("lost: ", ""), ("fallback: the reference exact is missing: ", "; mc is the reference there")]
    {
        let says = |row: &HashMap<String, String>| {
            row["note"].starts_with(beginning) && row["note"].contains(why) && row["note"].ends_with(end)
        };
        assert!(notes.iter().any(says), "{beginning}: {notes:?}");
    }
    assert!(out.contains("the reference exact is missing: "), "{out}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn an_exact_method_that_lies_is_contradicted_by_the_samples_of_the_same_run_or_by_itself() {
    let bench = Bench::new();
    let lies = [
        ("mean-e", "exact and mc disagree: the mean of e is"),
        ("std-phi", "exact and mc disagree: the deviation of phi is"),
        ("circular-mean", "exact and mc disagree: the circular mean of phi"),
        ("probability", "exact and mc disagree: the probability above the critical eccentricity is"),
        ("mass", "exact contradicts itself: its joint density has a mass of"),
        ("passage", "exact and mc disagree: the probability of having reached the critical eccentricity is"),
    ];
    for (lie, words) in lies {
        let samples = MC.replace("4_000", "20_000");
        let (code, out, errors) = run(&bench, lie, &format!("{}{samples}", liar(lie)));
        assert_eq!(code, Some(1), "{lie}: {errors}");
        assert!(errors.contains("error: scenario-1, exact: at t = ") && errors.contains(words), "{lie}: {errors}");
        assert!(out.contains(&format!("error: {words}")), "{lie}: {out}");
        let notes = bench.table(&format!("{lie}/notes.csv"));
        assert!(notes[0]["note"].starts_with("error: "), "{lie}: {notes:?}");
        assert!(notes.iter().any(|row| row["note"].starts_with(&format!("error: {words}"))), "{lie}: {notes:?}");
        assert!(text(&bench.read(&format!("{lie}/report.html"))).contains(words), "{lie}");
    }
    let (code, _, errors) = run(&bench, "truth", &format!("{}{MC}", liar("none")));
    assert_eq!(code, Some(0), "who does not lie is not accused: {errors}");
}

#[test]
fn what_a_stranger_sends_that_cannot_be_right_draws_a_word() {
    let bench = Bench::new();
    let cases = [
        ("constant-curve", 0, "warning: its first-passage curve begins with 0.3, but 0.00000 of the initial cloud"),
        (
            "falling-curve",
            1,
            "error: its first-passage curve is not used, it cannot be right: the probability falls from 0.5",
        ),
        (
            "crossed-interval",
            1,
            "error: its first-passage curve is not used, it cannot be right: the probability at 0 yr has an \
            interval from 0.2 to 0.1",
        ),
        ("impossible-curve", 1, "the probability at 0 yr is 1.995"),
        ("eager-curve", 0, "warning: its first-passage curve has 0.99000 by "),
        ("degrees", 0, "of its probability is on the comparison grid"),
    ];
    for (fault, exit_code, words) in cases {
        let faulty = format!("[[propagator]]\nlabel = \"stranger\"\n{}", program("faulty-propagator", fault));
        let head = "scenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\nbins = [40, 40]\n";
        let launch = bench.write(&format!("{fault}.toml"), &format!("name = \"{fault}\"\n{head}{MC}{faulty}"));
        let output = bench.run(&launch, fault);
        assert_eq!(output.status.code(), Some(exit_code), "{fault}: {}", text(&output.stderr));
        let notes = bench.table(&format!("{fault}/notes.csv"));
        let words_of = |row: &HashMap<String, String>| row["method"] == "stranger" && row["note"].contains(words);
        assert!(notes.iter().any(words_of), "{fault}: {notes:?}");
        let curve = bench.table(&format!("{fault}/first_passage.csv"));
        let is_used = curve.iter().any(|row| row["method"] == "stranger");
        assert_eq!(is_used, ["constant-curve", "eager-curve"].contains(&fault), "{fault}");
        assert!(
            bench.table(&format!("{fault}/moments.csv")).iter().any(|row| row["method"] == "stranger"),
            "its moments stay"
        );
    }
}
