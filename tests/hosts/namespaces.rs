//! Three hosts in network namespaces of their own, joined by cables that can be pulled; encrypted.
//!
//! The kernel's netem makes the cables slow and lossy if the kernel has it; if not, the test prints so, and `link.rs`
//! has a stand-in.

use std::process::Command;
use std::time::Duration;

use crate::common::REPRODUCIBLE;
use crate::common::processes::of_runs_below;
use crate::security::Certificates;
use crate::site::{self, CASES, Site, alone, end_well, wait_until};

/// The address of the home host on all cables.
const HOME: &str = "10.99.0.1";

/// Namespaces of the network: one for home, one for each worker.
struct Network {
    names: Vec<String>,
}

fn ip(arguments: &[&str]) -> bool {
    Command::new("ip").args(arguments).output().is_ok_and(|output| output.status.success())
}

impl Network {
    /// `None` where that is not allowed; prints so.
    fn new(workers: usize) -> Option<Self> {
        let own = std::process::id();
        let names: Vec<String> = (0..=workers).map(|index| format!("pcn{own}-{index}")).collect();
        let network = Self { names };
        if !network.names.iter().all(|name| ip(&["netns", "add", name])) {
            assert!(std::env::var("PHASECLOUD_REQUIRE_NAMESPACES").is_err(), "network namespaces are required");
            println!("skipped: no network namespaces here");
            return None;
        }
        network.connect(workers);
        Some(network)
    }

    /// Home is a bridge to which every worker has a cable.
    fn connect(&self, workers: usize) {
        let home = &self.names[0];
        let well = |arguments: &[&str]| assert!(ip(arguments), "ip {arguments:?}");
        well(&["-n", home, "link", "set", "lo", "up"]);
        well(&["-n", home, "link", "add", "hub", "type", "bridge"]);
        well(&["-n", home, "addr", "add", &format!("{HOME}/24"), "dev", "hub"]);
        well(&["-n", home, "link", "set", "hub", "up"]);
        for index in 1..=workers {
            let (worker, near) = (&self.names[index], format!("cable{index}"));
            well(&["link", "add", &near, "netns", home, "type", "veth", "peer", "name", "cable", "netns", worker]);
            well(&["-n", home, "link", "set", &near, "master", "hub", "up"]);
            well(&["-n", worker, "addr", "add", &format!("10.99.0.{}/24", index + 1), "dev", "cable"]);
            well(&["-n", worker, "link", "set", "cable", "up"]);
            well(&["-n", worker, "link", "set", "lo", "up"]);
        }
    }

    /// Makes all cables slow and lossy; `false` where the kernel cannot.
    fn impair(&self, workers: usize) -> bool {
        let netem = |name: &str, device: &str| {
            let words = ["-n", name, "qdisc", "add", "dev", device, "root", "netem", "delay", "50ms", "loss", "1%"];
            Command::new("tc").args(words).output().is_ok_and(|output| output.status.success())
        };
        (1..=workers).all(|index| netem(&self.names[index], "cable") && netem(&self.names[0], &format!("cable{index}")))
    }

    fn pull(&self, worker: usize) {
        assert!(ip(&["-n", &self.names[0], "link", "set", &format!("cable{worker}"), "down"]));
    }

    fn plug(&self, worker: usize) {
        assert!(ip(&["-n", &self.names[0], "link", "set", &format!("cable{worker}"), "up"]));
    }

    fn inside(&self, index: usize, command: &Command) -> Command {
        let mut inside = Command::new("ip");
        inside.args(["netns", "exec", &self.names[index]]).arg(command.get_program()).args(command.get_args());
        inside.current_dir(command.get_current_dir().unwrap());
        inside.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
        inside
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        for name in &self.names {
            ip(&["netns", "del", name]);
        }
    }
}

#[test]
fn three_hosts_in_namespaces_give_the_same_bytes_though_a_cable_is_pulled() {
    let site = Site::new(&["worker-a", "worker-b"]);
    let Some(network) = Network::new(2) else { return };
    let Some(certificates) = Certificates::make(&site.home, HOME) else { return };
    println!("netem: {}", if network.impair(2) { "50 ms, 1 % loss" } else { "not in this kernel" });
    let cases = CASES.replace("samples = 6_000", "samples = 200_000");
    let launch = site.launch_file("namespaces", &cases, &certificates.lines());
    let text = std::fs::read_to_string(&launch).unwrap();
    std::fs::write(&launch, text.replace("tcp/127.0.0.1", &format!("tls/{HOME}"))).unwrap();
    site.home.run_well(&site.home.launch_file("one", &alone(&cases)), "one");
    let mut command = site.home.phasecloud();
    command.arg("run").arg(&launch).arg("--no-report").arg("--out").arg(site.home.path("out"));
    let run = site::spawn(network.inside(0, &command));
    let join = |(index, (name, bench)): (usize, &(String, crate::common::Bench))| {
        let mut command = bench.phasecloud();
        command.args(["join", "--connect", &format!("tls/{HOME}:{}", site.port), "--name", name]);
        command.args(certificates.arguments());
        site::spawn(network.inside(index + 1, &command))
    };
    let workers: Vec<_> = site.workers.iter().enumerate().map(join).collect();
    wait_until("work at worker-a", || {
        of_runs_below(&site.workers[0].1.path("")).iter().any(|process| process.label == "mc/0")
    });
    network.pull(1);
    std::thread::sleep(Duration::from_secs(5));
    network.plug(1);
    end_well(run);
    workers.into_iter().for_each(|worker| drop(end_well(worker)));
    for file in REPRODUCIBLE {
        assert!(site.home.read(&format!("out/{file}")) == site.home.read(&format!("one/{file}")), "{file} differs");
    }
    site.check_clean();
}
