//! The guard of a program that is not ours: it ends the program, and whatever that has started, when the launcher dies.

use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitCode, ExitStatus};
use std::time::{Duration, Instant};

use kit::session::{Session, end_with_launcher, has_launcher};
use messages::wait::Signals;
use rustix::process::{Signal, kill_current_process_group};

/// How long the program may take to end after it was asked to.
const GRACE: Duration = Duration::from_secs(1);
/// How long the program has to act on the launcher's own signal, which goes to the whole group, before it gets a second
/// one: that may reach an interpreter that has already removed its handlers.
const PAUSE: Duration = Duration::from_millis(500);

/// Runs a program in this process's group until it ends by itself or on request, and ends in the same way as the
/// program.
pub fn run(words: &[String]) -> ExitCode {
    match guard(words) {
        Ok(status) => end_like(status),
        Err(problem) => {
            if let Ok(session) = Session::from_environment() {
                session.last_words(&problem);
            }
            remark!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn guard(words: &[String]) -> Result<ExitStatus, String> {
    let (program, arguments) = words.split_first().ok_or("which program? Give it after --")?;
    let signals = Signals::catch(&[signal_hook::consts::SIGCHLD]).map_err(|e| format!("cannot catch signals: {e}"))?;
    end_with_launcher().map_err(|e| e.to_string())?;
    let mut child =
        Command::new(program).args(arguments).spawn().map_err(|e| format!("{program} cannot be started: {e}"))?;
    let mut asked: Option<Instant> = None;
    let mut is_told = false;
    loop {
        if let Some(status) = look(&mut child)? {
            return Ok(status);
        }
        if signals.stop_requested() {
            let asked = *asked.get_or_insert_with(Instant::now);
            if !is_told && (!has_launcher() || asked.elapsed() > PAUSE) {
                let _ = kill_current_process_group(Signal::TERM);
                is_told = true;
            }
            if asked.elapsed() > GRACE {
                let _ = kill_current_process_group(Signal::KILL);
            }
            std::thread::sleep(Duration::from_millis(5));
        } else {
            signals.wait(&[], Duration::from_secs(1)).map_err(|e| e.to_string())?;
        }
    }
}

fn look(child: &mut Child) -> Result<Option<ExitStatus>, String> {
    child.try_wait().map_err(|e| format!("the program cannot be watched: {e}"))
}

fn end_like(status: ExitStatus) -> ExitCode {
    if let Some(signal) = status.signal() {
        let _ = signal_hook::low_level::emulate_default_handler(signal);
    }
    ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
}
