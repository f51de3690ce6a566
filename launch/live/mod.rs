//! A run as it goes: one line per node on a terminal, plain lines otherwise, or one JSON object per line.
//!
//! `phasecloud run` and `phasecloud watch` show the same: both feed a [`View`] with what arrives on the status topic.

pub mod json;
pub mod progress;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use messages::report::Report;
use messages::reporter::Reporter;

use crate::crew::log_sink::Printer;
use crate::shown::Shown;
use progress::{NodeState, Phase, Progress};

/// Shortest time between two lines about the progress of one node, if there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(1);

/// Shows how far a run is.
pub struct View {
    progress: Progress,
    face: Face,
}

/// How it is shown.
enum Face {
    Quiet,
    Lines(BTreeMap<Reporter, (Instant, Phase)>),
    Json,
    Terminal(MultiProgress, Vec<ProgressBar>),
}

impl Face {
    /// One line per node where lines can be rewritten, else plain lines.
    fn for_people(progress: &Progress) -> Self {
        let terminal = MultiProgress::new();
        if terminal.is_hidden() || !can_move_its_cursor(std::env::var_os("TERM").as_deref()) {
            return Self::Lines(BTreeMap::new());
        }
        let bar = |node: &NodeState| {
            let bar = terminal.add(ProgressBar::new(0)).with_prefix(node.shown());
            match ProgressStyle::with_template("  {prefix:16} {bar:20} {wide_msg}") {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        };
        let bars = progress.nodes().iter().map(bar).collect();
        Self::Terminal(terminal, bars)
    }
}

impl View {
    /// Shows `progress` on standard error, or as JSON on standard output.
    pub fn new(progress: Progress, shown: Shown) -> Self {
        let face = match shown {
            Shown { quiet: true, .. } => Face::Quiet,
            Shown { json: true, .. } => Face::Json,
            _ => Face::for_people(&progress),
        };
        let mut view = Self { progress, face };
        view.refresh();
        view
    }

    /// Makes a printer that writes lines to the terminal without disturbing what is shown there.
    pub fn printer(&self) -> Printer {
        match &self.face {
            Face::Terminal(terminal, _) => {
                let terminal = terminal.clone();
                Box::new(move |line| above(&terminal, line))
            }
            _ => Box::new(|line| remark!("{line}")),
        }
    }

    /// What is shown.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// What is shown, to be changed.
    pub fn progress_mut(&mut self) -> &mut Progress {
        &mut self.progress
    }

    /// Takes in a report; see [`Progress::report`] for `history`.
    pub fn report(&mut self, report: &Report, history: bool) {
        let now = Instant::now();
        if let Some(node) = self.progress.report(report, history, now).cloned() {
            self.show(&node, now);
        }
        for node in self.progress.end_scenario(report) {
            self.show(&node, now);
        }
        self.refresh();
    }

    /// Shows that a case has failed, even when quiet.
    pub fn fail(&mut self, of: &Reporter, why: &str) {
        self.progress.fail(of);
        let name = of.to_string();
        match &self.face {
            Face::Json => json::failure(&name, why),
            Face::Terminal(terminal, _) => above(terminal, &format!("error: {name}: {why}")),
            _ => remark!("error: {name}: {why}"),
        }
        self.refresh();
    }

    /// Shows an error that is not the failure of a case, even when quiet.
    pub fn error(&self, what: &str) {
        match &self.face {
            Face::Terminal(terminal, _) => above(terminal, &format!("error: {what}")),
            _ => remark!("error: {what}"),
        }
    }

    /// Shows a line that the user should know, but not when quiet and not among JSON.
    pub fn announce(&self, line: &str) {
        match &self.face {
            Face::Terminal(terminal, _) => above(terminal, line),
            Face::Lines(_) => remark!("{line}"),
            Face::Quiet | Face::Json => {}
        }
    }

    /// Prints a line if the run is shown as plain lines.
    pub fn note(&self, line: &str) {
        if let Face::Lines(_) = self.face {
            remark!("{line}");
        }
    }

    fn show(&mut self, node: &NodeState, now: Instant) {
        let scenario = self.progress.stage_name(node.scenario);
        match &mut self.face {
            Face::Json => json::progress(node, scenario, now),
            Face::Lines(last) if matches!(node.phase, Phase::Working | Phase::Done) => {
                let due = last.get(&node.who).is_none_or(|(told, phase)| {
                    *phase != node.phase || now.saturating_duration_since(*told) >= LINE_INTERVAL
                });
                if due {
                    remark!("{}: {}", node.shown(), describe(node, scenario, now));
                    last.insert(node.who.clone(), (now, node.phase));
                }
            }
            _ => {}
        }
    }

    /// Draws the bars of a terminal anew: the times in them change even without reports.
    pub fn refresh(&mut self) {
        let Face::Terminal(_, bars) = &self.face else { return };
        let now = Instant::now();
        for (node, bar) in self.progress.nodes().iter().zip(bars) {
            bar.set_length(node.of.max(1));
            bar.set_position(node.done);
            bar.set_message(describe(node, self.progress.stage_name(node.scenario), now));
        }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        if let Face::Terminal(terminal, _) = &self.face {
            let _ = terminal.clear();
        }
    }
}

/// Whether a terminal of this kind can draw lines anew in their places; one that cannot, or does not say, gets plain
/// lines.
fn can_move_its_cursor(kind: Option<&OsStr>) -> bool {
    kind.is_some_and(|kind| !kind.is_empty() && kind != "dumb")
}

/// Writes lines above the bars of a terminal, or plainly if the terminal is gone.
fn above(terminal: &MultiProgress, lines: &str) {
    if terminal.println(lines).is_err() {
        remark!("{lines}");
    }
}

/// Phase, scenario, progress, rate and time left of a node, in words.
fn describe(node: &NodeState, scenario: &str, now: Instant) -> String {
    let mut text = node.phase.word().to_owned();
    if matches!(node.phase, Phase::Working | Phase::Done) {
        text += &match node.of {
            // Nobody knows how many requests there will be.
            0 => format!(" {scenario} {}", node.done),
            of => format!(" {scenario} {}/{of}", node.done),
        };
    }
    if let (Some(rate), Some(left)) = (node.per_second(now), node.seconds_left(now)) {
        let left = humantime::format_duration(Duration::from_secs(left.min(1e9).ceil() as u64));
        text += &format!(", {rate:.1}/s, {left} left");
    }
    text
}
