//! `docs/by-hand.md`: its commands, each in a process of its own, give what `phasecloud run` gives.
#![allow(missing_docs)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use common::{Bench, text};
use rustix::process::{Pid, Signal, kill_process};

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(120);

const CASES: &str = "[[propagator]]\nlabel = \"exact\"\nnode = \"exact\"\n[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n";

/// A terminal with a command in it.
struct Terminal {
    command: String,
    process: Child,
    /// The lines that it prints on either output.
    lines: Receiver<String>,
}

impl Terminal {
    /// Replaces the shell by the command, so that Ctrl-C reaches it.
    fn open(bench: &Bench, command: &str) -> Self {
        let programs = Path::new(env!("CARGO_BIN_EXE_phasecloud")).parent().unwrap().display().to_string();
        let path = format!("{programs}:{}", std::env::var("PATH").unwrap());
        let (exports, program) = command.rsplit_once('\n').unwrap_or(("", command));
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(format!("{exports}\nexec {program}")).current_dir(bench.path("."));
        shell.env("PATH", path).env("TMPDIR", bench.path(".")).stdin(Stdio::null());
        let mut process = shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = channel();
        let (out, errors) = (process.stdout.take().unwrap(), process.stderr.take().unwrap());
        for output in [Box::new(out) as Box<dyn std::io::Read + Send>, Box::new(errors)] {
            let sender = sender.clone();
            std::thread::spawn(move || {
                BufReader::new(output).lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
            });
        }
        Self { command: command.into(), process, lines }
    }

    fn wait_for(&self, start: &str) -> String {
        let mut seen = Vec::new();
        loop {
            match self.lines.recv_timeout(WATCHDOG) {
                Ok(line) if line.starts_with(start) => return line,
                Ok(line) => seen.push(line),
                Err(why) => panic!("{}: no line \"{start}\" ({why}): {seen:?}", self.command),
            }
        }
    }

    fn control_c(mut self) {
        kill_process(Pid::from_child(&self.process), Signal::INT).unwrap();
        let asked = Instant::now();
        let status = loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                break status;
            }
            assert!(asked.elapsed() < WATCHDOG, "{} did not end", self.command);
            std::thread::sleep(Duration::from_millis(5));
        };
        let said: Vec<String> = self.lines.iter().collect();
        assert!(status.success(), "{}: {status}: {said:?}", self.command);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The commands of the document that run `phasecloud`, in order.
fn commands() -> Vec<&'static str> {
    let document = include_str!("../docs/by-hand.md");
    let blocks = document.split("```sh\n").skip(1).map(|block| block.split("\n```").next().unwrap());
    blocks.filter(|block| block.starts_with("phasecloud")).collect()
}

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("launch/scenarios")).unwrap();
    bench.write("launch/scenarios/scenario-1.toml", common::SCENARIO_1);
    bench
}

fn reference(bench: &Bench, cases: &str) -> Vec<u8> {
    let launch = bench.launch_file("by-launcher", cases);
    let launcher = std::fs::read_to_string(&launch).unwrap().replace("reference = \"mc\"", "reference = \"exact\"");
    bench.run_well(&bench.write("by-launcher.toml", &launcher), "by-launcher");
    bench.read("by-launcher/moments.csv")
}

#[test]
fn the_documents_commands_give_the_bytes_of_a_run() {
    let bench = bench();
    let commands = commands();
    assert_eq!(commands.len(), 7, "{commands:?}");
    let holder = Terminal::open(&bench, commands[0]);
    holder.wait_for("domain demo: held");
    let nodes: Vec<Terminal> = commands[1..]
        .iter()
        .map(|command| {
            let terminal = Terminal::open(&bench, command);
            let kind = command.split(' ').nth(2).unwrap();
            holder.wait_for(&format!("{kind}: ready"));
            terminal
        })
        .collect();
    holder.wait_for("recorder: scenario 0 done");
    nodes.into_iter().for_each(Terminal::control_c);
    holder.control_c();
    assert_eq!(bench.domains(), [""; 0]);
    assert!(bench.read("results/by-hand/part-000000/moments.csv") == reference(&bench, CASES));
}

#[test]
fn a_case_in_shards_gives_the_bytes_of_a_run() {
    let bench = bench();
    let in_shards = |command: &&str| -> Vec<String> {
        let command = command.replace("demo exact mc", "demo exact mc/2").replace("demo", "shards");
        match command.starts_with("phasecloud node mc") {
            true => (0..2).map(|shard| format!("{command} --shard {shard} --shards 2")).collect(),
            false => vec![command],
        }
    };
    let commands: Vec<String> = commands().iter().flat_map(in_shards).collect();
    let holder = Terminal::open(&bench, &commands[0]);
    holder.wait_for("domain shards: held");
    let nodes: Vec<Terminal> = commands[1..].iter().map(|command| Terminal::open(&bench, command)).collect();
    holder.wait_for("recorder: scenario 0 done");
    nodes.into_iter().for_each(Terminal::control_c);
    holder.control_c();
    assert!(bench.read("results/by-hand/part-000000/moments.csv") == reference(&bench, CASES));
}

#[test]
fn a_program_of_ones_own_needs_the_line_that_the_domain_prints() {
    let bench = bench();
    let holder = Terminal::open(&bench, &commands()[0].replace("demo exact mc", "mine1 exact mine"));
    let export = holder.wait_for("export ");
    let own = common::examples::example("stt-gaussian").display().to_string();
    let mut terminals: Vec<Terminal> = Vec::new();
    for command in &commands()[1..] {
        let command = command.replace("demo", "mine1");
        let command = if command.starts_with("phasecloud node mc") {
            format!("{export}\nexport PHASECLOUD_LABEL=mine\n{own}")
        } else {
            command
        };
        let reporter = if command.contains("LABEL=mine") { "mine" } else { command.split(' ').nth(2).unwrap() };
        let ready = format!("{reporter}: ready");
        terminals.push(Terminal::open(&bench, &command));
        holder.wait_for(&ready);
    }
    holder.wait_for("recorder: scenario 0 done");
    terminals.into_iter().for_each(Terminal::control_c);
    holder.control_c();
    let rows = bench.table("results/by-hand/part-000000/moments.csv");
    assert_eq!(rows.iter().filter(|row| row["method"] == "mine").count(), 5);
}

#[test]
fn a_domain_is_held_once_and_a_killed_holders_remains_are_no_obstacle() {
    let bench = bench();
    let command = commands()[0].replace("demo", "twice");
    let mut holder = Terminal::open(&bench, &command);
    holder.wait_for("domain twice: held");
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    let second = bench.phasecloud().args(&words).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("another process holds the domain"), "{}", text(&second.stderr));
    holder.process.kill().unwrap();
    holder.process.wait().unwrap();
    let again = Terminal::open(&bench, &command);
    again.wait_for("domain twice: held");
    again.control_c();
    assert_eq!(bench.domains(), [""; 0]);
    for (from, to, told) in [
        ("twice", "a-b", "1 to 16 letters or digits"),
        ("exact mc", "mc mc", "labels must differ"),
        ("scenario-1", "scenario-9", "cannot be read"),
    ] {
        let command = command.replace(from, to);
        let output = bench.phasecloud().args(command.split(' ').skip(1)).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
    }
}
