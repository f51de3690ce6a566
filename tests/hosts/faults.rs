//! Links that are cut, processes and hosts that are killed.

use std::time::Duration;

use rustix::process::Signal;

use crate::common::processes::{of_runs_below, signal as kill};
use crate::common::{Bench, REPRODUCIBLE};
use crate::link::Link;
use crate::site::{self, CASES, Site, alone, end, end_well, wait_until};

/// Enough samples that their transfer takes some seconds over a slow link.
const LARGE: &str = r#"
[[propagator]]
label = "mc"
node = "mc"
samples = 400_000
accuracy = 1e-6
hosts = ["worker-a"]
"#;

fn same_bytes(site: &Site, one: &str) {
    for file in REPRODUCIBLE {
        assert!(site.home.read(&format!("out/{file}")) == site.home.read(&format!("{one}/{file}")), "{file} differs");
    }
}

/// Kills the process called `name` in a domain of `bench`.
fn kill_process(bench: &Bench, name: &str) {
    Site::await_process(bench, name);
    let processes = of_runs_below(&bench.path(""));
    kill(processes.iter().find(|process| process.label == name).unwrap(), Signal::KILL);
}

#[test]
fn a_link_that_is_cut_for_five_seconds_during_a_transfer_costs_no_byte() {
    let site = Site::new(&["worker-a"]);
    let launch = site.launch_file("cut", LARGE, "");
    site.home.run_well(&site.home.launch_file("one", &alone(LARGE)), "one");
    let link = Link::to(site.port);
    let run = site.run(&launch, &[]);
    let worker = site.join(0, link.port);
    wait_until("a transfer under way", || link.carried() > 3 << 20);
    link.cut();
    std::thread::sleep(Duration::from_secs(5));
    link.mend();
    end_well(run);
    end_well(worker);
    same_bytes(&site, "one");
    site.check_clean();
}

#[test]
fn killed_propagators_and_bridges_change_no_byte() {
    let site = Site::new(&["worker-a", "worker-b"]);
    let cases = CASES.replace("samples = 6_000", "samples = 60_000");
    let launch = site.launch_file("kills", &cases, "");
    site.home.run_well(&site.home.launch_file("one", &alone(&cases)), "one");
    let (run, workers) = (site.run(&launch, &[]), site.join_all());
    kill_process(&site.workers[0].1, "mc/0");
    kill_process(&site.workers[1].1, "bridge");
    kill_process(&site.home, "bridge");
    end_well(run);
    workers.into_iter().for_each(|worker| drop(end_well(worker)));
    same_bytes(&site, "one");
    site.check_clean();
}

#[test]
fn a_host_that_is_lost_for_good_is_named_with_its_cases_and_the_others_are_compared() {
    let site = Site::new(&["worker-a", "worker-b"]);
    let far = "[[propagator]]\nlabel = \"far\"\nnode = \"mc\"\nsamples = 20_000_000\nhosts = [\"worker-a\"]\n";
    let launch =
        site.launch_file("lost", &format!("{CASES}{far}").replace("\"worker-a\", \"worker-b\"", "\"worker-b\""), "");
    let run = site.run(&launch, &[]);
    let mut workers = site.join_all();
    Site::await_process(&site.workers[0].1, "far");
    let mut lost = workers.remove(0);
    // The whole host is lost: its launcher is killed first, and all its processes end with it.
    site::signal(&lost, Signal::KILL);
    lost.wait().unwrap();
    let (code, said) = end(run);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("far") && said.contains("worker-a"), "{said}");
    workers.into_iter().for_each(|worker| drop(end_well(worker)));
    let methods: std::collections::BTreeSet<String> =
        site.home.table("out/moments.csv").into_iter().map(|row| row["method"].clone()).collect();
    assert_eq!(methods.into_iter().collect::<Vec<_>>(), ["dee", "gmm-ut", "mc"]);
    assert!(site.workers[0].1.phasecloud().arg("clean").status().unwrap().success());
    site.check_clean();
}

#[test]
fn when_home_is_lost_workers_end_by_themselves() {
    let site = Site::new(&["worker-a"]);
    let cases = LARGE.replace("400_000", "20_000_000");
    let launch = site.launch_file("home", &cases, "");
    let mut run = site.run(&launch, &[]);
    let worker = site.join(0, site.port);
    Site::await_process(&site.workers[0].1, "mc");
    site::signal(&run, Signal::KILL);
    run.wait().unwrap();
    let (code, said) = end(worker);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("home host is lost"), "{said}");
    assert!(site.home.phasecloud().arg("clean").status().unwrap().success());
    site.check_clean();
}

#[test]
fn a_worker_that_is_interrupted_says_so_at_home() {
    let site = Site::new(&["worker-a"]);
    let near = "[[propagator]]\nlabel = \"near\"\nnode = \"mc\"\nsamples = 1_000\n";
    let launch = site.launch_file("left", &(LARGE.replace("400_000", "20_000_000") + near), "").to_owned();
    let run = site.run(&launch, &[]);
    let worker = site.join(0, site.port);
    Site::await_process(&site.workers[0].1, "mc");
    std::thread::sleep(Duration::from_millis(500));
    site::signal(&worker, Signal::INT);
    let (code, said) = end(worker);
    assert_eq!(code, Some(130), "{said}");
    let (code, said) = end(run);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("worker-a has left the run") && said.contains("mc"), "{said}");
    site.check_clean();
}
