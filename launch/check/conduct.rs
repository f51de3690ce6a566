//! Rules about how the process behaves: ready, two scenarios, refusal, the end.

use kit::kind;
use kit::snapshot_rules::breaches;
use messages::layout::SnapshotHeader;

use super::answer::{Answer, LABEL, Outcome, Ready, Received, Stop, is_from};
use super::verdict::{Findings, Rule};

/// Judges whether the process came up.
pub fn handshake(findings: &mut Findings, ready: &Ready) {
    for (run_id, report) in ready.heard.reports.iter().filter(|signed| !is_from(signed, ready.run_id)) {
        let node = &report.from;
        let right = format!("its label is \"{LABEL}\", the run {:012x}", ready.run_id);
        findings.problem(Rule::Handshake, format!("a report from \"{node}\" of run {run_id:012x}; {right}"));
    }
    if !ready.heard.snapshots.is_empty() {
        let count = ready.heard.snapshots.len();
        findings.problem(Rule::Handshake, format!("{count} snapshots before there was a scenario"));
    }
    match &ready.outcome {
        Outcome::Done => findings.good(Rule::Handshake, format!("ready after {:.2} s", ready.after.as_secs_f64())),
        other => findings.problem(Rule::Handshake, format!("not ready: {}", other.describe())),
    }
}

/// Judges whether the scenario was finished.
pub fn answered(findings: &mut Findings, rule: Rule, answer: &Answer) {
    match &answer.outcome {
        Outcome::Done => findings.good(rule, "done"),
        other => findings.problem(rule, other.describe()),
    }
}

/// Judges whether a scenario that has no answer was refused.
pub fn refused(findings: &mut Findings, answer: &Answer) {
    let snapshots = &answer.heard.snapshots;
    for (k, snapshot) in snapshots.iter().enumerate() {
        if let Some(breach) = breaches(&snapshot.header, &snapshot.items, &answer.assignment, k).first() {
            findings.problem(Rule::Refusal, format!("snapshot {k}: {breach}"));
        }
    }
    match &answer.outcome {
        Outcome::Failed(text) if !text.trim().is_empty() => findings.good(Rule::Refusal, answer.outcome.describe()),
        Outcome::Done if snapshots.last().is_some_and(withholds_all) => {
            findings.good(Rule::Refusal, "it withholds all that it cannot know");
        }
        Outcome::Done => {
            let seen = format!("it sent {} snapshots and reported done", snapshots.len());
            findings.problem(Rule::Refusal, seen);
        }
        other => findings.problem(Rule::Refusal, other.describe()),
    }
}

/// Whether a snapshot withholds every figure.
fn withholds_all(Received { header, items }: &Received<SnapshotHeader>) -> bool {
    header.content().is_ok_and(|content| kind::of(&content).withholds_all(items))
}

/// Notes that a rule could not be tried because the process, started once more, did not get that far.
pub fn not_reached(findings: &mut Findings, rule: Rule, outcome: &Outcome) {
    findings.problem(rule, format!("not reached, started once more: {}", outcome.describe()));
}

/// Judges whether the process ended when it was asked to.
pub fn stopped(findings: &mut Findings, rule: Rule, stop: &Stop) {
    let seconds = stop.after.as_secs_f64();
    match stop.status {
        None => return findings.problem(rule, format!("still running {seconds:.2} s after SIGTERM; it was killed")),
        Some(status) if !status.success() => findings.problem(rule, format!("ended with {status}, not exit status: 0")),
        Some(_) => findings.good(rule, format!("ended after {seconds:.2} s")),
    }
    if stop.left_others {
        findings.problem(rule, "processes that it had started are still running");
    }
    if let Some(first) = stop.files.first() {
        findings.problem(rule, format!("{} files left behind, such as {}", stop.files.len(), first.display()));
    }
}
