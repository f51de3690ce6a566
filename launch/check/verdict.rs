//! The rules, and what was found about each.

use std::collections::BTreeMap;

use comfy_table::{ContentArrangement, Table, presets};
use serde::Serialize;

/// Widest table \[characters\].
const WIDTH: u16 = 120;
/// Most problems of one rule that are printed.
const MOST_TOLD: usize = 3;

macro_rules! rules {
    ($($(#[$doc:meta])* $rule:ident $name:literal $right:literal,)*) => {
        /// A rule of the contract, in the order of the report.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Rule { $($(#[$doc])* $rule,)* }

        impl Rule {
            /// All rules.
            const ALL: &'static [Self] = &[$(Self::$rule,)*];

            /// Its name in the report.
            fn name(self) -> &'static str {
                match self { $(Self::$rule => $name,)* }
            }

            /// What would be right.
            fn right(self) -> &'static str {
                match self { $(Self::$rule => $right,)* }
            }
        }
    };
}

rules! {
    /// The process becomes ready.
    Handshake "handshake" "reports ready, under its label and run, and sends nothing before it has a scenario",
    /// It finishes a scenario.
    FirstScenario "first scenario" "reports done",
    /// It finishes another scenario.
    SecondScenario "second scenario" "the same process takes another scenario and reports done",
    /// Its messages name the run, scenario and case to which they belong.
    Identity "identity" "run, scenario and label of every message are those given",
    /// It sends one snapshot per time.
    Count "counts" "one snapshot for each time of the scenario",
    /// The snapshots come in order.
    Order "order" "snapshot 0 first, then 1, and so on",
    /// The snapshots are at the times asked for.
    Times "times" "the times of the scenario, to the last bit",
    /// The snapshots have the shape that their headers say.
    Shape "shape" "a known kind, rows x columns numbers, at least one row",
    /// The numbers are finite.
    Finite "finite" "no NaN, no infinity, but for what a density withholds",
    /// The eccentricities are from 0 up to 1, without 1.
    Eccentricity "eccentricity" "0 <= e < 1, also of a mixture's means",
    /// Trajectories keep their Hamiltonian.
    Hamiltonian "Hamiltonian" "every trajectory keeps H to 1e-6; with --redrawn samples are not judged",
    /// Characteristics carry the right density.
    CarriedDensity "carried density" "n starts as the initial Gaussian and grows by (e/s) / (e0/s0), to 1e-6",
    /// The mass is right.
    Mass "mass" "weights of a mixture sum to 1; the grid holds 0.9997 or more: samples to 5 standard errors, else to 0.01",
    /// The moments are right.
    Moments "moments" "samples: within 5 standard errors of the exact ones; else within 0.1 standard deviations",
    /// The first passages are right.
    FirstPassage "first passage" "one message: all times, probabilities from 0 to 1 that never fall, in their intervals, and right; or a reason",
    /// A scenario without an answer is refused.
    Refusal "refusal" "where all orbits leave e < 1 it reports a failure in words or withholds all, and sends nothing wrong before",
    /// It ends when it is asked to while it waits.
    StopWaiting "SIGTERM, waiting" "ends in time with exit code 0, leaves neither files nor processes",
    /// It ends when it is asked to while it computes.
    StopComputing "SIGTERM, computing" "ends in time with exit code 0, leaves neither files nor processes",
}

/// What has been found about a rule.
#[derive(Debug, Default)]
struct Finding {
    good: Vec<String>,
    problems: Vec<String>,
}

/// What has been found.
#[derive(Debug, Default)]
pub struct Findings(BTreeMap<Rule, Finding>);

/// A line of the report.
#[derive(Debug, Serialize)]
struct Line {
    rule: &'static str,
    verdict: &'static str,
    seen: String,
    right: &'static str,
}

/// The report.
#[derive(Debug, Serialize)]
struct Report<'a> {
    command: &'a [String],
    passed: bool,
    rules: Vec<Line>,
}

impl Findings {
    /// The rule was kept; `seen` says how well.
    pub fn good(&mut self, rule: Rule, seen: impl Into<String>) {
        self.0.entry(rule).or_default().good.push(seen.into());
    }

    /// The rule was broken.
    pub fn problem(&mut self, rule: Rule, seen: impl Into<String>) {
        self.0.entry(rule).or_default().problems.push(seen.into());
    }

    /// Adds one result.
    pub fn take(&mut self, rule: Rule, result: Result<String, String>) {
        match result {
            Ok(seen) => self.good(rule, seen),
            Err(seen) => self.problem(rule, seen),
        }
    }

    /// Whether no rule was broken.
    pub fn passed(&self) -> bool {
        self.0.values().all(|finding| finding.problems.is_empty())
    }

    /// Prints everything to standard output.
    pub fn print(&self, command: &[String], json: bool) {
        if json {
            let report = Report { command, passed: self.passed(), rules: self.lines().collect() };
            // Strings and a flag: they can always be written.
            say!("{}", serde_json::to_string_pretty(&report).unwrap_or_default());
            return;
        }
        let mut table = Table::new();
        table.load_style(presets::ASCII_MARKDOWN);
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
        table.set_header(["rule", "", "seen", "right"]);
        for line in self.lines() {
            table.add_row([line.rule, line.verdict, &line.seen, line.right]);
        }
        say!("{table}");
        let broken = self.lines().filter(|line| line.verdict == "FAIL").count();
        let unjudged = self.lines().filter(|line| line.verdict == "-").count();
        match broken {
            0 => say!("\npassed: {} rules kept, {unjudged} not judged", Rule::ALL.len() - unjudged),
            _ => say!("\nfailed: {broken} of {} rules broken, {unjudged} not judged", Rule::ALL.len()),
        }
    }

    fn lines(&self) -> impl Iterator<Item = Line> + '_ {
        Rule::ALL.iter().map(|rule| {
            let (verdict, seen) = match self.0.get(rule) {
                None => ("-", String::new()),
                Some(Finding { good, problems }) if problems.is_empty() => ("pass", good.join("; ")),
                Some(Finding { problems, .. }) => ("FAIL", told(problems)),
            };
            Line { rule: rule.name(), verdict, seen, right: rule.right() }
        })
    }
}

fn told(problems: &[String]) -> String {
    let mut told = problems.iter().take(MOST_TOLD).cloned().collect::<Vec<_>>().join("; ");
    if problems.len() > MOST_TOLD {
        told += &format!("; and {} more", problems.len() - MOST_TOLD);
    }
    told
}
