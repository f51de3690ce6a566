//! Progress while a run lasts: a line a case on a terminal, plain lines otherwise.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::log_sink::Printer;

/// Shows how far the cases are.
pub struct Progress {
    quiet: bool,
    terminal: Option<MultiProgress>,
    bars: BTreeMap<String, ProgressBar>,
}

impl Progress {
    /// Progress for the cases `labels`.
    pub fn new<'a>(labels: impl Iterator<Item = &'a str>, quiet: bool) -> Self {
        let terminal = (!quiet && std::io::stderr().is_terminal()).then(MultiProgress::new);
        let bar = |label: &str| {
            let terminal = terminal.as_ref()?;
            let style = ProgressStyle::with_template("  {prefix:16} {bar:24} {pos}/{len} {msg}").ok()?;
            let bar = terminal.add(ProgressBar::new(0)).with_style(style).with_prefix(label.to_owned());
            bar.set_message("starting");
            Some((label.to_owned(), bar))
        };
        let bars = labels.filter_map(bar).collect();
        Self { quiet, terminal, bars }
    }

    /// A way to print a line without disturbing the bars.
    pub fn printer(&self) -> Printer {
        match self.terminal.clone() {
            Some(terminal) => Box::new(move |line| terminal.suspend(|| drop(writeln!(std::io::stderr(), "{line}")))),
            None => Box::new(|line| drop(writeln!(std::io::stderr(), "{line}"))),
        }
    }

    /// `label` has done `done` of `of` units of work in scenario `scenario`.
    pub fn working(&self, label: &str, scenario: &str, done: u64, of: u64) {
        if let Some(bar) = self.bars.get(label) {
            bar.set_length(of);
            bar.set_position(done);
            bar.set_message(scenario.to_owned());
        }
    }

    /// A case has failed, or something else is worth a line; failures are told even when quiet.
    pub fn error(&self, line: &str) {
        match &self.terminal {
            Some(terminal) => terminal.suspend(|| eprintln!("error: {line}")),
            None => eprintln!("error: {line}"),
        }
    }

    /// Something worth a line where there is no terminal to show bars on.
    pub fn note(&self, line: &str) {
        if !self.quiet && self.terminal.is_none() {
            eprintln!("{line}");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(terminal) = &self.terminal {
            let _ = terminal.clear();
        }
    }
}
