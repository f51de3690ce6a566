//! Looking into a live run with `topics`, `echo` and `hz`, which must not disturb it.
#![allow(missing_docs)]

mod common;

use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{Bench, FOUR_CASES, text};
use messages::content::Samples;
use messages::domain::{HeldDomain, Place};
use messages::layout::SnapshotHeader;
use messages::port::Outlet;
use messages::text::pack;
use messages::topic::{Capacity, Snapshot};
use rustix::process::{Pid, Signal, kill_process};

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(120);

/// A domain that the test itself holds.
struct Own {
    place: Place,
    _held: HeldDomain,
    outlet: Outlet<Snapshot>,
}

impl Own {
    fn new(bench: &Bench, name: &str) -> Self {
        let place = Place { root: bench.path("domain"), prefix: format!("pc{name}{}-", std::process::id()) };
        let held = HeldDomain::create(&place, &Capacity { propagators: 1, cases: 1, snapshots: 3, hosts: 0 }).unwrap();
        let outlet = held.domain.outlet::<Snapshot>(8).unwrap();
        Self { place, _held: held, outlet }
    }

    fn domain(&self) -> String {
        format!("{}:{}", self.place.root.display(), self.place.prefix)
    }

    fn send(&self, index: u32) {
        let header = SnapshotHeader {
            run_id: 0xabc,
            time: 0.5,
            index,
            rows: 4,
            label: pack("mine"),
            ..SnapshotHeader::default()
        };
        let header = header.with(Samples::INDEPENDENT);
        // The kit reports an error if a required reader is missing; this test has observers only.
        let _ = self.outlet.send_items(header, &[1.0, 2.0, 3.0, 4.0, 0.1, 0.2, 0.3, 0.4]);
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        let _ = self.place.remove();
    }
}

fn echo(bench: &Bench, own: &Own, more: &[&str]) -> Command {
    let mut command = bench.phasecloud();
    command.args(["echo", "snapshot", "--domain", &own.domain()]).args(more);
    command
}

/// Waits for a line of `topics` to end with this number of observers.
fn wait_for_observers(bench: &Bench, arguments: &[&str], topic: &str, count: usize) {
    let started = Instant::now();
    loop {
        let output = bench.phasecloud().arg("topics").args(arguments).output().unwrap();
        let listed = text(&output.stdout);
        if listed.lines().any(|line| line.contains(topic) && line.ends_with(&format!(" {count} |"))) {
            return;
        }
        assert!(started.elapsed() < WATCHDOG, "{listed}{}", text(&output.stderr));
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits for the end of an observer, while the test goes on delivering messages to observers that join.
fn serve_until_end(own: &Own, mut child: Child) -> Output {
    let signals = messages::wait::Signals::catch(&[]).unwrap();
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < WATCHDOG, "the observer did not end");
        signals.wait(&[&own.outlet], Duration::from_millis(50)).unwrap();
    }
    child.wait_with_output().unwrap()
}

#[test]
fn echo_shows_fields_by_name_with_units_codes_and_the_first_rows_also_of_what_was_sent_before() {
    let bench = Bench::new();
    let own = Own::new(&bench, "echo");
    own.send(0);
    let shown = |more: &[&str]| {
        let child = echo(&bench, &own, more).stdout(Stdio::piped()).spawn().unwrap();
        let output = serve_until_end(&own, child);
        assert!(output.status.success());
        text(&output.stdout)
    };
    let block = shown(&["--count", "1"]);
    for line in [
        "phasecloud/snapshot",
        "  run_id               000000000abc",
        "  time                 0.5 yr",
        "  kind                 1 (SAMPLES)",
        "  label                mine",
        "  payload              8 items: phi [rad], e",
        "    1  0.1\n    2  0.2\n    3  0.3\n",
    ] {
        assert!(block.contains(line), "{line}: {block}");
    }
    let object: serde_json::Value = serde_json::from_str(shown(&["--count", "1", "--json", "--full"]).trim()).unwrap();
    assert_eq!(object["header"]["time"], 0.5);
    assert_eq!(object["payload"]["rows"], serde_json::json!([[1.0, 0.1], [2.0, 0.2], [3.0, 0.3], [4.0, 0.4]]));
}

#[test]
fn killed_observers_leave_room_for_others() {
    let bench = Bench::new();
    let own = Own::new(&bench, "kill");
    let domain = own.domain();
    // More observers than there is room for if their remains stayed.
    for _ in 0..25 {
        let mut child = echo(&bench, &own, &[]).stdout(Stdio::null()).spawn().unwrap();
        wait_for_observers(&bench, &["--domain", &domain], "phasecloud/snapshot", 1);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    wait_for_observers(&bench, &["--domain", &domain], "phasecloud/snapshot", 0);
}

#[test]
fn hz_counts_messages_and_bytes() {
    let bench = Bench::new();
    let own = Own::new(&bench, "hz");
    let mut command = bench.phasecloud();
    let child = command.args(["hz", "snapshot", "--domain", &own.domain()]).stdout(Stdio::piped()).spawn().unwrap();
    wait_for_observers(&bench, &["--domain", &own.domain()], "phasecloud/snapshot", 1);
    for index in 0..3 {
        own.send(index);
    }
    std::thread::sleep(Duration::from_millis(1500)); // hz prints once per second
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = serve_until_end(&own, child);
    assert_eq!(output.status.code(), Some(130));
    let printed = text(&output.stdout);
    assert!(printed.lines().last().unwrap().starts_with("in all: 3 messages in "), "{printed}");
    assert!(printed.contains("messages/s") && printed.contains("bytes/s"), "{printed}");
}

#[test]
fn a_stopped_observer_does_not_disturb_a_run_that_sends_more_than_it_can_hold() {
    let bench = Bench::new();
    // Five scenarios of 61 snapshots: every node sends more than 256 reports, which is what a reader's buffer holds.
    let names: Vec<String> = (1..=5).map(|k| format!("s{k}")).collect();
    for name in &names {
        let scenario = common::SCENARIO_1.replace("scenario-1", name).replace("end = 2.0", "end = 6.0");
        bench.write(&format!("{name}.toml"), &scenario.replace("step = 0.5", "step = 0.1"));
    }
    let files: Vec<String> = names.iter().map(|name| format!("{name}.toml")).collect();
    let head = format!("name = \"many\"\nscenarios = {files:?}\nreference = \"mc\"\nbins = [4, 4]\n");
    let late = format!(
        "[[propagator]]\nlabel = \"late\"\ncommand = [\"sh\", \"-c\", \"until test -e go; do sleep 0.02; done; \
         exec {} node mc --set samples=20 --label late\"]\n",
        env!("CARGO_BIN_EXE_phasecloud")
    );
    let case = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 20\n";
    bench.write("many.toml", &format!("{head}{case}{late}"));
    let mut run = bench.phasecloud();
    run.args(["run", "many.toml", "--out", "observed", "--quiet"]).stderr(Stdio::piped());
    let run = run.spawn().unwrap();
    let started = Instant::now();
    while !text(&bench.phasecloud().arg("topics").output().unwrap().stdout).contains("phasecloud/roster") {
        assert!(started.elapsed() < WATCHDOG, "the run did not start");
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut observer = bench.phasecloud().args(["echo", "status"]).stdout(Stdio::null()).spawn().unwrap();
    wait_for_observers(&bench, &[], "phasecloud/status", 1);
    kill_process(Pid::from_child(&observer), Signal::STOP).unwrap();
    bench.write("go", "");
    let output = run.wait_with_output().unwrap();
    observer.kill().unwrap();
    observer.wait().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(bench.table("observed/moments.csv").len(), 2 * 5 * 61);
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("observed/manifest.json")).unwrap();
    assert_eq!(common::shared_memory_of(manifest["run_id"].as_str().unwrap()), [""; 0]);
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn without_a_live_run_or_with_a_wrong_name_there_is_a_clear_word() {
    let bench = Bench::new();
    let own = Own::new(&bench, "word");
    let domain = own.domain();
    for (arguments, words) in [
        (&["echo", "snapshot"][..], "there is no live run"),
        (&["hz", "snapshot", "--domain", "/nowhere:pcx-"], "no run lives in /nowhere:pcx-"),
        (&["watch", "--run", "12"], "there is no live run"),
        (&["echo", "snapshots", "--domain", &domain], "no topic \"snapshots\"; there are phasecloud/scenario, "),
    ] {
        let output = bench.phasecloud().args(arguments).output().unwrap();
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}{}", text(&output.stdout));
        assert!(errors.contains(words), "{errors}");
    }
}

#[test]
fn a_graph_has_every_case_and_topic() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let output = bench.phasecloud().arg("graph").arg(launch).output().unwrap();
    let graph = text(&output.stdout);
    assert!(graph.starts_with("flowchart LR\n"), "{graph}");
    for words in ["mc<br>mc<br>reference", "gmm-ut<br>gmm-ut", "-- scenario -->", "-- snapshot --> estimator"] {
        assert!(graph.contains(words), "{words}: {graph}");
    }
    for topic in ["passage", "density", "comparison", "roster", "status"] {
        assert!(graph.contains(&format!("-- {topic} -->")), "{topic}: {graph}");
    }
}
