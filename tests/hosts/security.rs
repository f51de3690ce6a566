//! Which hosts may take part.

use std::path::{Path, PathBuf};
use std::process::Command;

use bridge::endpoint::{Access, End, Tls};
use bridge::greeting::{Hello, greet};
use bridge::zenoh::Wait;
use messages::topic::{Snapshot, Topic};
use rustix::process::Signal;

use crate::common::Bench;
use crate::site::{self, Site, end, end_well, wait_until};

const CASES: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 1_000\nhosts = [\"worker-a\"]\n";

/// An authority, and certificates for 127.0.0.1 that it has signed, made by openssl; `None` if there is no openssl.
pub struct Certificates(PathBuf);

impl Certificates {
    pub fn make(bench: &Bench, address: &str) -> Option<Self> {
        let required = std::env::var("PHASECLOUD_REQUIRE_OPENSSL").is_ok();
        if Command::new("openssl").arg("version").output().is_err() {
            assert!(!required, "openssl is required");
            println!("skipped: no openssl here");
            return None;
        }
        let folder = bench.path("tls");
        std::fs::create_dir(&folder).unwrap();
        let made = Self(folder);
        let subject = |name: &str| format!("/CN={name}");
        made.openssl(&[
            "req",
            "-x509",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-keyout",
            "ca-key.pem",
            "-out",
            "ca.pem",
            "-days",
            "2",
            "-subj",
            &subject("authority"),
        ]);
        std::fs::write(made.path("names"), format!("subjectAltName=IP:{address}\nbasicConstraints=CA:FALSE\n"))
            .unwrap();
        for host in ["home", "worker"] {
            let (key, request, certificate) = (format!("{host}-key.pem"), format!("{host}.csr"), format!("{host}.pem"));
            made.openssl(&[
                "req",
                "-newkey",
                "rsa:2048",
                "-nodes",
                "-keyout",
                &key,
                "-out",
                &request,
                "-subj",
                &subject(host),
            ]);
            made.openssl(&[
                "x509",
                "-req",
                "-in",
                &request,
                "-CA",
                "ca.pem",
                "-CAkey",
                "ca-key.pem",
                "-CAcreateserial",
                "-out",
                &certificate,
                "-days",
                "2",
                "-extfile",
                "names",
            ]);
        }
        Some(made)
    }

    fn openssl(&self, arguments: &[&str]) {
        let output = Command::new("openssl").args(arguments).current_dir(&self.0).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Lines for the `[hosts]` table.
    pub fn lines(&self) -> String {
        let line = |key: &str, name: &str| format!("{key} = \"{}\"\n", self.path(name).display());
        line("authority", "ca.pem") + &line("certificate", "home.pem") + &line("key", "home-key.pem")
    }

    /// Arguments of `phasecloud join`.
    pub fn arguments(&self) -> Vec<String> {
        let pair = |option: &str, name: &str| [option.to_owned(), self.path(name).display().to_string()];
        [pair("--authority", "ca.pem"), pair("--certificate", "worker.pem"), pair("--key", "worker-key.pem")].concat()
    }
}

/// The answer that a stranger with these files at this endpoint gets when it greets, and how many answers when it asks
/// for everything.
fn stranger(endpoint: &str, authority: Option<&Path>) -> (String, usize) {
    let tls = Tls { authority: authority.map(Path::to_owned), certificate: None, key: None };
    let access = Access { endpoint: endpoint.parse().unwrap(), tls, insecure: false };
    let Ok(zenoh) = bridge::session::open(&access, End::Connects) else { return ("no session".into(), 0) };
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let heard = match greet(&zenoh, &Hello::of("worker-a", 1)) {
        Ok(None) => "nothing".into(),
        Ok(Some(plan)) => format!("{plan:?}"),
        Err(failure) => failure.to_string(),
    };
    let answers = zenoh.get("phasecloud/**").wait().unwrap();
    (heard, answers.iter().count())
}

#[test]
fn a_peer_without_the_certificate_gets_nothing_in_and_nothing_out() {
    let site = Site::new(&["worker-a"]);
    let Some(certificates) = Certificates::make(&site.home, "127.0.0.1") else { return };
    let endpoint = format!("tls/127.0.0.1:{}", site.port);
    let launch = site.launch_file("tls", CASES, &certificates.lines());
    let text = std::fs::read_to_string(&launch).unwrap().replace("tcp/", "tls/");
    std::fs::write(&launch, text).unwrap();
    let run = site.run(&launch, &[]);
    Site::await_process(&site.home, "bridge");
    wait_until("home listens", || std::net::TcpStream::connect(("127.0.0.1", site.port)).is_ok());
    for (endpoint, authority) in
        [(endpoint.clone(), Some(certificates.path("ca.pem"))), (format!("tcp/127.0.0.1:{}", site.port), None)]
    {
        assert_eq!(stranger(&endpoint, authority.as_deref()), ("nothing".into(), 0), "at {endpoint}");
    }
    // A worker with a certificate may join.
    let mut command = site.workers[0].1.phasecloud();
    command.args(["join", "--connect", &endpoint, "--name", "worker-a"]).args(certificates.arguments());
    let worker = site::spawn(command);
    let said = end_well(run);
    end_well(worker);
    assert!(!said.contains("stranger"));
    assert_eq!(site.home.table("out/moments.csv").len(), 5);
    site.check_clean();
}

#[test]
fn plain_connections_beyond_loopback_need_an_explicit_word() {
    let site = Site::new(&["worker-a"]);
    let launch = site.launch_file("plain", CASES, "");
    let text = std::fs::read_to_string(&launch).unwrap().replace("tcp/127.0.0.1", "tcp/192.0.2.1");
    std::fs::write(&launch, text).unwrap();
    let (code, said) = end(site.run(&launch, &[]));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("not encrypted") && said.contains("--insecure"), "{said}");
    let mut command = site.workers[0].1.phasecloud();
    command.args(["join", "--connect", "tcp/192.0.2.1:7447"]);
    let (code, said) = end(site::spawn(command));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("--insecure"), "{said}");
}

#[test]
fn strange_versions_and_names_are_refused_by_name_and_the_run_goes_on() {
    let site = Site::new(&["worker-a"]);
    let launch = site.launch_file("versions", CASES, "");
    let run = site.run(&launch, &[]);
    let access = Access {
        endpoint: format!("tcp/127.0.0.1:{}", site.port).parse().unwrap(),
        tls: Tls::default(),
        insecure: false,
    };
    let zenoh = bridge::session::open(&access, End::Connects).unwrap();
    let refusal = |hello: &Hello| {
        let mut heard = None;
        wait_until("a refusal", || match greet(&zenoh, hello) {
            Ok(None) => false,
            Ok(Some(plan)) => panic!("it is let in: {plan:?}"),
            Err(why) => heard.replace(why.to_string()).is_none(),
        });
        heard.unwrap()
    };
    let own = Hello::of("worker-a", 1);
    let old = Hello {
        contract: own.contract.replace(Snapshot::NAME, "x").replace("SnapshotHeader/", "SnapshotHeader/0"),
        ..own
    };
    let why = refusal(&old);
    assert!(why.contains("worker-a") && why.contains("another version") && why.contains("SnapshotHeader/"), "{why}");
    let why = refusal(&Hello::of("worker-z", 1));
    assert!(why.contains("no host \"worker-z\"") && why.contains("worker-a"), "{why}");
    let worker = site.join(0, site.port);
    let said = end_well(run);
    end_well(worker);
    assert!(said.contains("worker-a") && said.contains("another version"), "{said}");
    site.check_clean();
}

#[test]
fn programs_of_homes_choice_need_the_workers_leave() {
    let site = Site::new(&["worker-a"]);
    let near = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 1_000\n";
    let mine = "[[propagator]]\nlabel = \"mine\"\ncommand = [\"true\"]\nhosts = [\"worker-a\"]\n";
    let launch = site.launch_file("programs", &format!("{near}{mine}"), "");
    let run = site.run(&launch, &[]);
    let (code, said) = end(site.join(0, site.port));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("mine") && said.contains("--allow-commands"), "{said}");
    site::signal(&run, Signal::INT);
    assert_eq!(end(run).0, Some(130));
    site.check_clean();
}

#[test]
fn files_and_names_that_cannot_be_right_are_refused_before_anything_is_awaited() {
    let site = Site::new(&["worker-a"]);
    let Some(certificates) = Certificates::make(&site.home, "127.0.0.1") else { return };
    let file = |name: &str| certificates.path(name).display().to_string();
    let refused = |endpoint: &str, more: &[&str], words: &str| {
        let mut command = site.workers[0].1.phasecloud();
        command.args(["join", "--connect", endpoint]).args(more);
        let (code, said) = end(site::spawn(command));
        assert!(code == Some(2) && said.contains(words), "{said}");
    };
    let (authority, certificate, key) = (file("ca.pem"), file("worker.pem"), file("worker-key.pem"));
    let (strange, junk) = (file("home-key.pem"), file("names"));
    let tls = |authority: &str, key: &str, words: &str| {
        let more = ["--authority", authority, "--certificate", &certificate, "--key", key];
        refused("tls/127.0.0.1:1", &more, words);
    };
    tls(&junk, &key, "--authority: ");
    tls(&authority, &junk, "no private key in it");
    tls(&authority, &strange, "is not the key of the certificate");
    refused("tcp/127.0.0.1:1", &["--authority", &authority], "--authority: has no effect");
    refused("tcp/127.0.0.1:1", &["--name", "a b"], "--name: \"a b\" is not allowed");
    refused("tcp/127.0.0.1:1", &["--name", "home"], "--name: \"home\" is the host to which");
}

#[test]
fn a_worker_that_nobody_answers_says_what_may_be_the_reason() {
    let site = Site::new(&["worker-a"]);
    // Another program at home's port, which takes connections and says nothing.
    let _mute = std::net::TcpListener::bind(("127.0.0.1", site.port)).unwrap();
    let said = site.home.path("said");
    let (name, bench) = &site.workers[0];
    let mut command = bench.phasecloud();
    command.args(["join", "--connect", &format!("tcp/127.0.0.1:{}", site.port), "--name", name]);
    command.stderr(std::fs::File::create(&said).unwrap());
    let mut worker = command.spawn().unwrap();
    let hint = "nothing has answered at tcp/127.0.0.1:";
    wait_until(hint, || std::fs::read_to_string(&said).unwrap().contains(hint));
    site::signal(&worker, Signal::INT);
    assert_eq!(worker.wait().unwrap().code(), Some(130));
    assert_eq!(std::fs::read_to_string(&said).unwrap().matches(hint).count(), 1);
}
