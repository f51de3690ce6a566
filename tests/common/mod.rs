//! A fresh folder and a fresh place for shared memory for every test, and the program under test.
#![allow(dead_code, missing_docs, reason = "each test file uses its own part")]

pub mod browser;
pub mod examples;
pub mod processes;
pub mod service;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

pub const SCENARIO_1: &str = include_str!("../../launch/scenarios/scenario-1.toml");

/// Results that depend on the seeds of the cases alone.
pub const REPRODUCIBLE: [&str; 5] =
    ["moments.csv", "errors.csv", "distances.csv", "first_passage.csv", "densities.npz"];

/// A number from the environment, for tests that can repeat themselves more often.
pub fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().map_or(default, |text| text.parse().expect("a number"))
}

/// The paper's four cases with few samples.
pub const FOUR_CASES: &str = r#"
[[propagator]]
label = "mc"
node = "mc"
samples = 4_000
seed = 11

[[propagator]]
label = "dee-961"
node = "dee"
samples = 961

[[propagator]]
label = "dee-1e5"
node = "dee"
samples = 2_500

[[propagator]]
label = "gmm-ut"
node = "gmm-ut"
"#;

/// A place in which `phasecloud` runs without meeting anybody else.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.write("scenario-1.toml", SCENARIO_1);
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// A launch file on scenario 1 with these cases.
    pub fn launch_file(&self, name: &str, cases: &str) -> PathBuf {
        let head = "scenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\n";
        self.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{head}{cases}"))
    }

    /// The program, with its domains inside this bench's folder.
    pub fn phasecloud(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phasecloud"));
        command.current_dir(self.folder.path()).env("TMPDIR", self.folder.path()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, launch: &Path, out: &str) -> Output {
        self.phasecloud().arg("run").arg(launch).arg("--out").arg(self.path(out)).output().unwrap()
    }

    /// Runs and expects success.
    pub fn run_well(&self, launch: &Path, out: &str) -> Output {
        let output = self.run(launch, out);
        assert!(output.status.success(), "{}", text(&output.stderr));
        output
    }

    /// A launch file on scenario 1 and one like it, scenario 2, with `head` at its top level and these cases.
    pub fn two_scenarios(&self, name: &str, head: &str, cases: &str) -> PathBuf {
        self.write("scenario-2.toml", &SCENARIO_1.replace("scenario-1", "scenario-2").replace("0.145", "0.2"));
        let scenarios = "scenarios = [\"scenario-1.toml\", \"scenario-2.toml\"]\nreference = \"mc\"\n";
        self.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{scenarios}{head}{cases}"))
    }

    /// A case of the faulty propagator among the examples, with this fault.
    pub fn faulty(&self, label: &str, fault: &str) -> String {
        let program = examples::example("faulty-propagator");
        format!("[[propagator]]\nlabel = \"{label}\"\ncommand = [\"{}\", \"{fault}\"]\n", program.display())
    }

    /// A results folder's manifest.
    pub fn manifest(&self, folder: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(&format!("{folder}/manifest.json"))).unwrap()
    }

    /// The domains that exist at this moment.
    pub fn domains(&self) -> Vec<String> {
        let user = self.path(&format!("phasecloud-{}", rustix::process::getuid().as_raw()));
        let domains = std::fs::read_dir(user).into_iter().flatten().flatten();
        domains.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The rows of a table of the results as maps from column to text.
    pub fn table(&self, name: &str) -> Vec<std::collections::HashMap<String, String>> {
        csv::Reader::from_path(self.path(name)).unwrap().deserialize().map(Result::unwrap).collect()
    }
}

/// A test that fails ends the launchers that it has started: a service would go on for ever otherwise.
impl Drop for Bench {
    fn drop(&mut self) {
        if std::thread::panicking() {
            processes::end_launchers_of(self.folder.path());
        }
    }
}

/// Files in shared memory that belong to the domain of run `run_id`.
pub fn shared_memory_of(run_id: &str) -> Vec<String> {
    let names = std::fs::read_dir("/dev/shm").unwrap().flatten();
    names.map(|entry| entry.file_name().to_string_lossy().into_owned()).filter(|n| n.contains(run_id)).collect()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Width, height and colours (with how often each occurs) of a PNG file.
pub fn picture(file: &[u8]) -> (u32, u32, std::collections::HashMap<[u8; 3], usize>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    let mut colours = std::collections::HashMap::new();
    for pixel in pixels[..frame.buffer_size()].chunks_exact(frame.color_type.samples()) {
        *colours.entry([pixel[0], pixel[1], pixel[2]]).or_insert(0) += 1;
    }
    (frame.width, frame.height, colours)
}
