//! Maps that several hosts compute: the same bytes as on one host, whoever comes, leaves or is killed.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;

use bridge::dealing::{Answer, Asker, Brought};
use bridge::endpoint::{Access, End, Tls};
use bridge::greeting::{Hello, greet};
use bridge::plan::{MapPlan, Work};
use bridge::zenoh::Session;
use rustix::process::Signal;

use crate::common::{Bench, text};
use crate::site::{self, Site, end, end_well, wait_until};

const SAIL: &str = "name = \"inclined\"\n[model]\nname = \"vectorial\"\nforces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n[epoch]\n\
     sun_longitude = 0.0\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 3.1\ne = 0.02\n\
     inclination = 0.3\nnode = 0.0\nsigma_phi = 0.3\nsigma_e = 0.005\nsigma_inclination = 0.01\nsigma_node = 0.1\n\
     sigma_radiation = 0.05\n[times]\nat = [0.0, 2.0]\n[disposal]\naltitude = \"120 km\"\n";
/// A map of points that take long, so that there is something to do until workers have come, however fast the machine
/// is.
const MAP: &str = "scenario = \"sail.toml\"\ntolerance = 0.004\n[quantity]\nname = \"reentry\"\nwithin = 2\n[vary]\n\
     \"initial.inclination\" = { from = \"0 deg\", to = \"20 deg\", count = 9 }\n\
     \"orbit.area_to_mass\" = { from = 6, to = 16, count = 31 }\n";
const FILES: [&str; 4] = ["map.csv", "map.npz", "map.svg", "report.html"];

/// The files of the map as one host computes it alone.
static ALONE: LazyLock<BTreeMap<&str, Vec<u8>>> = LazyLock::new(|| {
    let bench = Bench::new();
    bench.write("sail.toml", SAIL);
    bench.write("map.toml", MAP);
    let output = bench.phasecloud().args(["map", "map.toml", "--out", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    FILES.into_iter().map(|file| (file, bench.read(&format!("out/{file}")))).collect()
});

/// Home and the hosts that its map file names.
struct Atlas {
    site: Site,
}

impl Atlas {
    fn new(workers: &[&str]) -> Self {
        let site = Site::new(workers);
        let hosts = format!("[hosts]\nnames = {workers:?}\nlisten = \"tcp/127.0.0.1:{}\"\n", site.port);
        site.home.write("sail.toml", SAIL);
        site.home.write("map.toml", &format!("{MAP}{hosts}"));
        Self { site }
    }

    fn said(&self) -> PathBuf {
        self.site.home.path("said")
    }

    /// Starts `phasecloud map` at home with one thread; what it says goes into a file.
    fn home(&self) -> Child {
        let mut command = self.site.home.phasecloud();
        command.args(["map", "map.toml", "--out", "out"]).env("RAYON_NUM_THREADS", "1");
        let said = std::fs::File::create(self.said()).unwrap();
        command.stdout(Stdio::null()).stderr(said).spawn().unwrap()
    }

    fn join(&self, index: usize) -> Child {
        site::spawn(self.join_command(index))
    }

    fn join_command(&self, index: usize) -> Command {
        let (name, bench) = &self.site.workers[index];
        let mut command = bench.phasecloud();
        command.args(["join", "--connect", &format!("tcp/127.0.0.1:{}", self.site.port), "--name", name]);
        command.env("RAYON_NUM_THREADS", "1");
        command
    }

    /// Waits until home has said this.
    fn await_words(&self, words: &str) {
        wait_until(words, || std::fs::read_to_string(self.said()).unwrap_or_default().contains(words));
    }

    /// Waits for the end of home; returns its exit code and what it has said.
    fn end(&self, mut home: Child) -> (Option<i32>, String) {
        wait_until("the end of the map", || home.try_wait().unwrap().is_some());
        (home.wait().unwrap().code(), std::fs::read_to_string(self.said()).unwrap())
    }

    /// Waits for the end of home, and checks that the map is complete and that of one host.
    fn end_well(&self, home: Child) -> String {
        let (code, said) = self.end(home);
        assert_eq!(code, Some(0), "{said}");
        for (file, bytes) in &*ALONE {
            assert!(self.site.home.read(&format!("out/{file}")) == *bytes, "{file} differs");
        }
        assert!(!self.site.home.path("out/computed.csv").exists());
        said
    }

    /// A process that joins as `name` but is moved by the test, its number, and the map that it gets.
    fn puppet(&self, name: &str) -> (Session, u64, MapPlan) {
        let endpoint = format!("tcp/127.0.0.1:{}", self.site.port).parse().unwrap();
        let zenoh = bridge::session::open(&Access { endpoint, tls: Tls::default(), insecure: false }, End::Connects);
        let (zenoh, process, mut plan) = (zenoh.unwrap(), 77, None);
        wait_until("the map", || {
            plan = greet(&zenoh, &Hello::of(name, process)).unwrap();
            plan.is_some()
        });
        let Some(Work::Map(plan)) = plan else { panic!("no map: {plan:?}") };
        (zenoh, process, plan)
    }
}

/// How many parts of the map came from other hosts, as home says at the end.
fn from_away(said: &str) -> usize {
    let (before, _) = said.split_once(" of them on other hosts").unwrap_or_else(|| panic!("{said}"));
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

#[test]
fn a_map_by_three_hosts_is_that_of_one_byte_for_byte() {
    let atlas = Atlas::new(&["worker-a", "worker-b"]);
    let early = atlas.join(0);
    let home = atlas.home();
    atlas.await_words("worker-a has joined");
    let late = atlas.join(1);
    let said = atlas.end_well(home);
    assert!(said.contains("worker-a, worker-b may join at tcp/127.0.0.1:"), "{said}");
    assert!(from_away(&said) > 0, "{said}");
    let said = end_well(early);
    assert!(said.contains("joined the map map.toml as worker-a") && said.contains("the map at home is complete"));
    // The late one may have been too late, where the machine is fast.
    site::signal(&late, Signal::INT);
    assert!(matches!(end(late).0, Some(0 | 130)));
    atlas.site.check_clean();
}

#[test]
fn workers_that_are_killed_or_leave_cost_no_byte_and_may_come_back() {
    let atlas = Atlas::new(&["worker-a", "worker-b", "puppet"]);
    let home = atlas.home();
    let (zenoh, process, plan) = atlas.puppet("puppet");
    // It holds a part, and so the map cannot be completed before it is given up.
    let asker = Asker::new(&zenoh, plan.map_id, process);
    wait_until("a part", || matches!(asker.ask(&[], true).unwrap(), Some(Answer::Compute(_))));
    let mut killed = atlas.join(0);
    let leaving = atlas.join(1);
    let still_holding = |words: &str| {
        wait_until(words, || {
            asker.ask(&[], false).unwrap();
            std::fs::read_to_string(atlas.said()).unwrap().contains(words)
        });
    };
    still_holding("worker-a has joined");
    still_holding("worker-b has joined");
    site::signal(&killed, Signal::KILL);
    killed.wait().unwrap();
    site::signal(&leaving, Signal::INT);
    let (code, said) = end(leaving);
    assert!(code == Some(130) && said.contains("worker-b has left the map"), "{said}");
    still_holding("worker-b is gone");
    let back = atlas.join(1);
    // The one that was killed is missed only after a while.
    still_holding("worker-a is gone");
    // From now on the puppet is silent, like a host that has crashed.
    let said = atlas.end_well(home);
    assert!(said.contains("puppet is gone"), "{said}");
    end_well(back);
    atlas.site.check_clean();
}

#[test]
fn a_worker_of_another_name_or_version_is_refused_and_the_map_goes_on() {
    let atlas = Atlas::new(&["worker-a", "puppet"]);
    let home = atlas.home();
    let (zenoh, process, plan) = atlas.puppet("puppet");
    let asker = Asker::new(&zenoh, plan.map_id, process);
    let mut strange = atlas.site.workers[0].1.phasecloud();
    strange.args(["join", "--connect", &format!("tcp/127.0.0.1:{}", atlas.site.port), "--name", "worker-z"]);
    let (code, said) = end(site::spawn(strange));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("names no host \"worker-z\"; there are puppet, worker-a"), "{said}");
    let own = Hello::of("worker-a", 5);
    let old = Hello { contract: own.contract.replace("wire/", "wire/0"), version: "0.0.9".into(), ..own };
    let why = greet(&zenoh, &old).unwrap_err().to_string();
    assert!(why.contains("host worker-a (phasecloud 0.0.9) speaks another version") && why.contains("wire/"), "{why}");
    let another = Asker::new(&zenoh, plan.map_id, process + 1);
    assert_eq!(another.ask(&[], true).unwrap(), Some(Answer::Stranger), "it has not greeted");
    asker.leave(&[]);
    let said = atlas.end_well(home);
    assert!(said.contains("a host was refused: [hosts] at home names no host \"worker-z\""), "{said}");
    assert!(said.contains("a host was refused: host worker-a (phasecloud 0.0.9)"), "{said}");
    atlas.site.check_clean();
}

#[test]
fn home_that_is_interrupted_goes_on_with_what_it_has_and_workers_join_again() {
    let atlas = Atlas::new(&["worker-a", "puppet"]);
    let home = atlas.home();
    let (_zenoh, _, _) = atlas.puppet("puppet");
    let worker = atlas.join(0);
    atlas.await_words("worker-a has joined");
    let kept = || std::fs::read_to_string(atlas.site.home.path("out/computed.csv")).unwrap_or_default();
    wait_until("something is kept", || kept().lines().count() > 10);
    site::signal(&home, Signal::INT);
    let (code, said) = atlas.end(home);
    assert!(code == Some(130) && said.contains("the same command goes on with them"), "{said}");
    let (code, said) = end(worker);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("home was interrupted"), "{said}");
    // Other hosts make no other map.
    let file = String::from_utf8(atlas.site.home.read("map.toml")).unwrap();
    atlas.site.home.write("map.toml", &file.replace("\"worker-a\"", "\"worker-c\", \"worker-a\""));
    let home = atlas.home();
    let worker = atlas.join(0);
    atlas.await_words("worker-a has joined");
    let said = atlas.end_well(home);
    assert!(said.contains("the map was begun before"), "{said}");
    assert!(String::from_utf8(atlas.site.home.read("out/map.toml")).unwrap().contains("worker-c"));
    end_well(worker);
    atlas.site.check_clean();
}

#[test]
fn a_port_that_is_taken_is_told_by_file_line_and_key_and_no_folder_is_made() {
    let atlas = Atlas::new(&["worker-a"]);
    let _taken = std::net::TcpListener::bind(("127.0.0.1", atlas.site.port)).unwrap();
    let (code, said) = atlas.end(atlas.home());
    assert_eq!(code, Some(2), "{said}");
    let place = format!("hosts.listen: tcp/127.0.0.1:{}: the port is taken", atlas.site.port);
    assert!(said.starts_with("error: map.toml:") && said.contains(&place) && !said.contains(".rs"), "{said}");
    assert!(!atlas.site.home.path("out").exists());
}

#[test]
fn a_mistake_at_a_point_that_a_worker_has_ends_the_map_with_its_words() {
    let atlas = Atlas::new(&["worker-a", "puppet"]);
    let home = atlas.home();
    let (zenoh, process, plan) = atlas.puppet("puppet");
    assert!(plan.text.contains("[hosts]") && plan.scenario == SAIL);
    let asker = Asker::new(&zenoh, plan.map_id, process);
    let mut place = None;
    wait_until("a part", || match asker.ask(&[], true).unwrap() {
        Some(Answer::Compute(places)) => place.replace(places[0]).is_none(),
        _ => false,
    });
    let worker = atlas.join(0);
    let is_there = || std::fs::read_to_string(atlas.said()).unwrap().contains("worker-a has joined");
    wait_until("worker-a", || asker.ask(&[], false).unwrap().is_some() && is_there());
    let brought = Brought { place: place.unwrap(), found: Err("inclined-7: no such orbit".into()) };
    let answer = asker.ask(&[brought], false).unwrap();
    assert_eq!(answer, Some(Answer::Failed("inclined-7: no such orbit".into())));
    let (code, said) = atlas.end(home);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.ends_with("error: inclined-7: no such orbit\n"), "{said}");
    let (code, said) = end(worker);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("the map at home has failed: inclined-7: no such orbit"), "{said}");
    assert!(atlas.site.home.path("out/computed.csv").exists());
    atlas.site.check_clean();
}
