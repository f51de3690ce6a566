//! The same bytes on one host and on several.

use crate::common::REPRODUCIBLE;
use crate::site::{CASES, Site, alone, end_well};

#[test]
fn three_hosts_give_the_bytes_of_one_and_their_logs_come_home() {
    let site = Site::new(&["worker-a", "worker-b"]);
    let launch = site.launch_file("three", CASES, "");
    let one = site.home.launch_file("one", &alone(CASES));
    site.home.run_well(&one, "one");
    let workers = site.join_all();
    let said = end_well(site.run(&launch, &[]));
    for worker in workers {
        assert!(end_well(worker).contains("the run at home has ended"));
    }
    for file in REPRODUCIBLE {
        assert!(site.home.read(&format!("out/{file}")) == site.home.read(&format!("one/{file}")), "{file} differs");
    }
    for member in ["mc/0@worker-a", "mc/1@worker-b", "dee@worker-b"] {
        assert!(said.contains(member), "{member} is not shown in {said}");
        let log = String::from_utf8(site.home.read("out/log.jsonl")).unwrap();
        assert!(log.contains(&format!("\"node\":\"{member}\"")), "{member} is not in the log");
    }
    site.check_clean();
}

#[test]
fn workers_may_come_before_or_after_home() {
    let site = Site::new(&["worker-a"]);
    let cases = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 1_000\nhosts = [\"worker-a\"]\n";
    let launch = site.launch_file("early", cases, "");
    let worker = site.join(0, site.port);
    std::thread::sleep(std::time::Duration::from_millis(1500));
    end_well(site.run(&launch, &[]));
    end_well(worker);
    std::fs::rename(site.home.path("out"), site.home.path("early")).unwrap();
    let run = site.run(&launch, &[]);
    Site::await_process(&site.home, "bridge");
    let worker = site.join(0, site.port);
    end_well(run);
    end_well(worker);
    assert!(site.home.read("out/moments.csv") == site.home.read("early/moments.csv"));
    site.check_clean();
}
