//! Where the log of a run comes together: what the processes say becomes lines of `log.jsonl`, and some go to the terminal.

use std::fs::File;
use std::io::{BufRead, BufReader, PipeReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use nodes::log::{Format, Line};
use tracing::Level;
use tracing::level_filters::LevelFilter;

use crate::commands::BRIDGE;

/// The log's name in the results folder.
const NAME: &str = "log.jsonl";
/// Longest line; a longer one is cut into several \[bytes\].
const LONGEST_LINE: u64 = 1 << 16;
/// Most that is kept of what one process says \[bytes\].
const MOST_KEPT: usize = 16 << 20;
/// How long to wait at the end for processes that their parents have left behind with our pipe in hand.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// What goes to the terminal.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Lines up to this level.
    pub level: LevelFilter,
    /// In this form.
    pub format: Format,
    /// Nothing but errors.
    pub quiet: bool,
}

/// Writes a line to the terminal.
pub type Printer = Box<dyn Fn(&str) + Send>;

/// The log of a run; clones are the same log.
#[derive(Clone)]
pub struct LogSink {
    run: String,
    path: PathBuf,
    view: View,
    inner: Arc<Mutex<Inner>>,
}

struct Inner {
    file: Option<File>,
    printer: Printer,
    readers: Vec<JoinHandle<()>>,
}

impl LogSink {
    /// Opens the log in the results folder `folder`.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn open(folder: &Path, run_id: u64, view: View) -> Result<Self, String> {
        let path = folder.join(NAME);
        let file = File::create(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let printer: Printer = Box::new(|line| remark!("{line}"));
        let inner = Inner { file: Some(file), printer, readers: Vec::new() };
        Ok(Self { run: format!("{run_id:012x}"), path, view, inner: Arc::new(Mutex::new(inner)) })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on lines reach the terminal through `printer`.
    pub fn print_with(&self, printer: Printer) {
        self.lock().printer = printer;
    }

    /// The level that processes must log at.
    pub fn level(&self) -> LevelFilter {
        self.view.level.max(LevelFilter::INFO)
    }

    /// Takes in a line of one of phasecloud's own processes.
    pub fn record(&self, line: &Line) {
        let level = line.level.parse::<LevelFilter>().unwrap_or(LevelFilter::ERROR);
        self.write(line, level <= self.view.level);
    }

    fn write(&self, line: &Line, show: bool) {
        let mut inner = self.lock();
        if let Some(file) = &mut inner.file {
            // A disk that is full is told by the recorder, whose files matter.
            let _ = writeln!(file, "{}", line.to_text(Format::Json));
        }
        if show {
            (inner.printer)(&line.to_text(self.view.format));
        }
    }

    /// Takes in all that a process says, line by line, until it ends.
    ///
    /// # Errors
    /// If there is no thread to be had for it.
    pub fn follow(&self, node: &str, output: PipeReader) -> std::io::Result<()> {
        let (sink, name) = (self.clone(), node.to_owned());
        let reader = std::thread::Builder::new().name(format!("log of {node}"));
        let reader = reader.spawn(move || sink.read(&name, BufReader::new(output)))?;
        self.lock().readers.push(reader);
        Ok(())
    }

    fn read(&self, node: &str, mut output: impl BufRead) {
        let mut kept = 0;
        let mut bytes = Vec::new();
        while matches!(output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes), Ok(1..)) {
            kept += bytes.len();
            if kept <= MOST_KEPT {
                self.take(node, String::from_utf8_lossy(&bytes).trim_end());
            } else if kept - bytes.len() <= MOST_KEPT {
                self.take(node, "says too much; the rest is not kept");
            }
            bytes.clear();
        }
    }

    /// A line of our own form is taken as it is; anything else is a program's own words, said by `node`.
    fn take(&self, node: &str, text: &str) {
        match serde_json::from_str::<Line>(text) {
            // The bridge passes on what is said on other hosts.
            Ok(line) if line.run == self.run && (line.node == node || (node == BRIDGE && line.node.contains('@'))) => {
                self.record(&line);
            }
            _ => {
                let line = Line { message: text.into(), ..Line::now(Level::WARN, &self.run, node) };
                self.write(&line, LevelFilter::WARN <= self.view.level || !self.view.quiet);
            }
        }
    }

    /// Waits for the last words of the processes, which have ended, and closes the file.
    pub fn close(&self) {
        let readers = std::mem::take(&mut self.lock().readers);
        let deadline = Instant::now() + LAST_WORDS;
        while Instant::now() < deadline && !readers.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(Duration::from_millis(2));
        }
        self.lock().file = None;
    }
}
