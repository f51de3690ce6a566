//! The log of a run: the output of all processes becomes lines of `log.jsonl`, and some lines go to the terminal.

use std::fs::File;
use std::io::{BufRead, BufReader, PipeReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::plan::cases::LAUNCHER;
use crate::shown::{Logged, Shown};
use kit::log;
use kit::log::{Format, Line};
use messages::service::Service;
use tracing::Level;
use tracing::level_filters::LevelFilter;

/// The log's name in the results folder.
const NAME: &str = "log.jsonl";
/// Longest line; a longer one is cut into several \[bytes\].
const LONGEST_LINE: u64 = 1 << 16;
/// Most that is written of the output of one process \[bytes\].
const MOST_KEPT: usize = 16 << 20;
/// How long to wait at the end for orphaned processes that still hold our pipe open.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// What goes to the terminal.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// The lines up to this level.
    pub level: LevelFilter,
    /// The form of the lines.
    pub format: Format,
    /// Whether nothing but errors is shown.
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
    /// Why the log is not whole, if it is not.
    problem: Option<String>,
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
        let inner = Inner { file: Some(file), problem: None, printer, readers: Vec::new() };
        Ok(Self { run: format!("{run_id:012x}"), path, view, inner: Arc::new(Mutex::new(inner)) })
    }

    /// Path of the log file.
    #[cfg(feature = "hosts")]
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

    /// Records a line of one of phasecloud's own processes; returns how many bytes it takes in the log.
    pub fn record(&self, line: &Line) -> usize {
        let level = line.level.parse::<LevelFilter>().unwrap_or(LevelFilter::ERROR);
        self.write(line, level <= self.view.level)
    }

    /// Writes a line into the log, and to the terminal if `show`; returns how many bytes it takes in the log.
    fn write(&self, line: &Line, show: bool) -> usize {
        let text = line.to_text(Format::Json) + "\n";
        let mut inner = self.lock();
        let Inner { file, problem, printer, .. } = &mut *inner;
        if let Some(file) = file
            && problem.is_none()
            && let Err(error) = file.write_all(text.as_bytes())
        {
            *problem = Some(format!("{}: {error}; the log is not whole", self.path.display()));
        }
        if show {
            printer(&line.to_text(self.view.format));
        }
        text.len()
    }

    /// Records the output of a process line by line, until the process ends.
    ///
    /// # Errors
    /// If no thread can be started for it.
    pub fn follow(&self, node: &str, output: PipeReader) -> std::io::Result<()> {
        let (sink, name) = (self.clone(), node.to_owned());
        let reader = std::thread::Builder::new().name(format!("log of {node}"));
        let reader = reader.spawn(move || sink.read(&name, BufReader::new(output)))?;
        self.lock().readers.push(reader);
        Ok(())
    }

    fn read(&self, node: &str, mut output: impl BufRead) {
        // The bytes that are written count: even an empty line takes a hundred bytes of the log.
        let mut written = 0;
        let mut bytes = Vec::new();
        while matches!(output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes), Ok(1..)) {
            if written < MOST_KEPT {
                written += self.take(node, String::from_utf8_lossy(&bytes).trim_end_matches(['\r', '\n']));
                if written >= MOST_KEPT {
                    self.take(node, "says too much; the rest is not kept");
                }
            }
            bytes.clear();
        }
    }

    /// Records a line that has our own form as it is; anything else becomes a warning in the words of the program
    /// `node`.
    fn take(&self, node: &str, text: &str) -> usize {
        match serde_json::from_str::<Line>(text) {
            // The bridge passes on the lines of other hosts.
            Ok(line)
                if line.run == self.run
                    && (line.node == node || (Service::Bridge.is(node) && line.node.contains('@'))) =>
            {
                self.record(&line)
            }
            _ => {
                let line = Line { message: text.into(), ..Line::now(Level::WARN, &self.run, node) };
                self.write(&line, LevelFilter::WARN <= self.view.level || !self.view.quiet)
            }
        }
    }

    /// Waits for the last output of the processes, which have ended, and closes the file.
    ///
    /// # Errors
    /// If the log is not whole, because a line could not be written.
    pub fn close(&self) -> Result<(), String> {
        let readers = std::mem::take(&mut self.lock().readers);
        let deadline = Instant::now() + LAST_WORDS;
        while Instant::now() < deadline && !readers.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(Duration::from_millis(2));
        }
        let mut inner = self.lock();
        inner.file = None;
        inner.problem.take().map_or(Ok(()), Err)
    }
}

/// Opens the log in `folder`; the launcher's own lines go there too. The terminal shows errors unless more is asked
/// for.
///
/// # Errors
/// If the file cannot be created.
pub fn start_log(folder: &Path, run_id: u64, shown: Shown, logged: Logged) -> Result<LogSink, String> {
    let level = logged.log.unwrap_or(LevelFilter::ERROR);
    let sink =
        LogSink::open(folder, run_id, View { level, format: logged.log_format, quiet: shown.quiet || shown.json })?;
    let (level, own) = (sink.level(), sink.clone());
    log::start(LAUNCHER, run_id, level, move |line| {
        own.record(&line);
    });
    Ok(sink)
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: View = View { level: LevelFilter::ERROR, format: Format::Compact, quiet: true };

    #[test]
    fn the_bound_counts_what_is_written_not_what_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let sink = LogSink::open(folder.path(), 7, QUIET).unwrap();
        sink.read("mine", BufReader::new(&vec![b'\n'; 3_000_000][..]));
        sink.close().unwrap();
        let log = std::fs::read_to_string(&sink.path).unwrap();
        assert!((MOST_KEPT..MOST_KEPT + 1000).contains(&log.len()), "{}", log.len());
        assert!(log.ends_with("says too much; the rest is not kept\"}\n"), "{}", &log[log.len() - 300..]);
    }

    #[test]
    fn what_a_program_says_is_kept_as_it_is_and_cannot_command_a_terminal() {
        let folder = tempfile::tempdir().unwrap();
        let sink = LogSink::open(folder.path(), 7, View { quiet: false, ..QUIET }).unwrap();
        let shown = Arc::new(Mutex::new(String::new()));
        let screen = shown.clone();
        sink.print_with(Box::new(move |line| *screen.lock().unwrap() += line));
        let said = "a\u{1b}[2Jb\u{1b}]0;t\u{7}c\rd\u{8}e\u{9b}2Jf";
        sink.read("mine", BufReader::new(format!("{said}\r\n").as_bytes()));
        sink.close().unwrap();
        let log = std::fs::read_to_string(&sink.path).unwrap();
        assert_eq!(serde_json::from_str::<Line>(&log).unwrap().message, said);
        let shown = shown.lock().unwrap();
        assert!(shown.contains("a\\u{1b}[2Jb") && !shown.chars().any(char::is_control), "{shown:?}");
    }

    #[test]
    fn a_log_that_cannot_be_written_is_not_whole() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.path().join(NAME)).unwrap();
        let sink = LogSink::open(folder.path(), 7, QUIET).unwrap();
        sink.read("mine", BufReader::new(&b"hello\n"[..]));
        let problem = sink.close().unwrap_err();
        assert!(problem.contains("log.jsonl: No space left on device"), "{problem}");
    }
}
