//! `phasecloud watch --web`: a page on this machine that shows a run under way, in a real browser where there is one.
#![allow(missing_docs)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Instant;

use common::browser::{Browser, Killed, WATCHDOG, chromium};
use common::{Bench, text};
use rustix::process::{Pid, Signal, kill_process};

/// A case whose densities arrive, and one that does not begin until the file `go` exists.
fn launch(bench: &Bench) -> std::path::PathBuf {
    let waits = "while ! [ -e go ]; do sleep 0.05; done; exec false";
    bench.launch_file(
        "web",
        &format!(
            "restart = \"never\"\nbins = [40, 40]\n[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n\n\
             [[propagator]]\nlabel = \"late\"\ncommand = [\"sh\", \"-c\", \"{waits}\"]\n"
        ),
    )
}

/// The answer to a request of the server at `address`, with this `Host`.
fn ask(address: &str, path: &str, host: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.0\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn interrupt(process: &Child) {
    kill_process(Pid::from_child(process), Signal::INT).unwrap();
}

/// A run, and a watcher of it with the address of its page.
fn watched(bench: &Bench) -> (Killed, Killed, BufReader<std::process::ChildStderr>, String) {
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch(bench)).args(["--out", "out", "--quiet"]);
    let run = Killed(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    let started = Instant::now();
    loop {
        let mut command = bench.phasecloud();
        command.args(["watch", "--web", "--quiet"]).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut watcher = Killed(command.spawn().unwrap());
        let mut lines = BufReader::new(watcher.0.stderr.take().unwrap());
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        if let Some((_, address)) = line.trim().trim_end_matches('/').split_once("http://") {
            return (run, watcher, lines, address.to_owned());
        }
        assert!(started.elapsed() < WATCHDOG, "the run did not start: {line}");
        watcher.0.wait().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[test]
fn a_page_shows_the_cases_that_have_arrived_and_at_the_end_the_whole_report() {
    let bench = Bench::new();
    let (mut run, mut watcher, mut lines, address) = watched(&bench);
    let started = Instant::now();
    while !ask(&address, "/report", &address).starts_with("HTTP/1.0 200") {
        assert!(started.elapsed() < WATCHDOG, "no report");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let report = ask(&address, "/report", &address);
    assert!(report.contains("1 of 2 cases have arrived") && report.contains("class=\"explorer\""), "{report:.3000}");
    let state = ask(&address, "/state", &address);
    assert!(state.contains("\"scenario\":\"scenario-1\"") && state.contains("\"name\":\"late\""), "{state}");

    let host = "elsewhere.example";
    assert!(ask(&address, "/report", host).starts_with("HTTP/1.0 403"), "another name for this machine is refused");
    assert!(ask(&address, "/other", &address).starts_with("HTTP/1.0 404"));

    if let Some(chromium) = chromium() {
        let mut browser = Browser::open(chromium, &bench.path("browser"), &format!("http://{address}/"), [1200, 900]);
        browser.wait_for("document.querySelector('iframe').contentDocument?.querySelector('.explorer canvas') != null");
        let inside = "document.querySelector('iframe').contentDocument.querySelector('.explorer output').textContent";
        browser.wait_for(&format!("{inside} === 't = 2 yr'"));
        assert!(browser.text("#nodes").contains("late"));
        bench.write("go", "");
        browser.wait_for("document.querySelector('#now').textContent === 'The run is over.'");
    } else {
        bench.write("go", "");
    }

    run.0.wait().unwrap();
    let mut line = String::new();
    while !line.contains("the report stays at") {
        line.clear();
        assert_ne!(lines.read_line(&mut line).unwrap(), 0, "the watcher stays");
    }
    assert!(ask(&address, "/state", &address).contains("\"over\":true"));
    let last = ask(&address, "/report", &address);
    assert!(last.ends_with(&text(&bench.read("out/report.html"))), "the last report is that of the results folder");
    interrupt(&watcher.0);
    assert_eq!(watcher.0.wait().unwrap().code(), Some(1), "as the run, of which a case has failed");
    assert!(TcpStream::connect(&address).is_err(), "nothing serves the page any more");
}

#[test]
fn a_port_that_is_taken_is_named() {
    let bench = Bench::new();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let mut run = bench.phasecloud();
    let mut run = Killed(run.arg("run").arg(launch(&bench)).args(["--out", "out", "--quiet"]).spawn().unwrap());
    let started = Instant::now();
    let errors = loop {
        let output = bench.phasecloud().args(["watch", "--web", "--port", &port]).output().unwrap();
        let errors = text(&output.stderr);
        if !errors.contains("no live run") {
            assert_eq!(output.status.code(), Some(2), "{errors}");
            break errors;
        }
        assert!(started.elapsed() < WATCHDOG, "{errors}");
        std::thread::sleep(std::time::Duration::from_millis(20));
    };
    assert!(errors.contains(&format!("port {port} of this machine cannot be had")), "{errors}");
    bench.write("go", "");
    run.0.wait().unwrap();
}
