//! The points of a map that have been computed so far, in a file: a map that was interrupted goes on with them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

use density::exact::Estimated;
use density::reliability::refinement::Known;
use nodes::files::map_file::MapFile;

/// The file, which is there until the map is finished.
const FILE: &str = "computed.csv";
const HEAD: &str = "x,y,number,value,error";
/// Copies of the map file and of its scenario file, by which a folder is known to belong to a map.
pub(super) const COPIES: [&str; 2] = ["map.toml", "scenario.toml"];

/// Makes room for a map in `folder`: a folder that is not there, or in which the same map was begun.
///
/// # Errors
/// Why the folder cannot be used.
pub fn prepare(map: &MapFile, folder: &Path) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("cannot write to {}: {e}", folder.display());
    if folder.exists() {
        let texts = COPIES.map(|name| fs::read_to_string(folder.join(name)).unwrap_or_default());
        if texts.map(|text| what_counts(&text)) != map.texts().map(what_counts) {
            return Err(format!(
                "{} exists already and holds something else; name another folder with --out",
                folder.display()
            ));
        }
        if !folder.join(FILE).exists() {
            return Err(format!(
                "{} holds this map already, complete; name another folder with --out",
                folder.display()
            ));
        }
    } else {
        fs::create_dir_all(folder).map_err(failed)?;
        fs::write(folder.join(FILE), format!("{HEAD}\n")).map_err(failed)?;
    }
    for (name, text) in COPIES.iter().zip(map.texts()) {
        let path = folder.join(name);
        if fs::read_to_string(&path).ok().as_deref() != Some(text) {
            fs::write(path, text).map_err(failed)?;
        }
    }
    Ok(())
}

/// A text without its table `[hosts]`, its comments and its empty lines, which have no effect on what is computed: a map may go on with other hosts, or
/// without them.
fn what_counts(text: &str) -> String {
    let mut is_within = false;
    let is_kept = |line: &&str| {
        let line = line.trim();
        if line.starts_with('[') {
            is_within = line.starts_with("[hosts]");
        }
        !is_within && !line.is_empty() && !line.starts_with('#')
    };
    text.lines().filter(is_kept).flat_map(|line| [line, "\n"]).collect()
}

/// The points so far.
#[derive(Debug)]
pub(super) struct Computed {
    path: PathBuf,
    file: File,
    known: Known,
}

impl Computed {
    /// Reads the points that are there.
    pub(super) fn open(folder: &Path) -> Result<Self, String> {
        let path = folder.join(FILE);
        let failed = |e: std::io::Error| format!("{}: {e}", path.display());
        let file = OpenOptions::new().append(true).open(&path).map_err(failed)?;
        // The lock is gone with the process.
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => {
                format!(
                    "another process computes this map in {}; wait for it, or name another folder with --out",
                    folder.display()
                )
            }
            TryLockError::Error(error) => failed(error),
        })?;
        let text = fs::read_to_string(&path).map_err(failed)?;
        let (known, whole) = read(&text);
        // A line that was being written when the map was interrupted is left out.
        file.set_len(whole as u64).map_err(failed)?;
        Ok(Self { path: path.clone(), file, known })
    }

    pub(super) fn known(&self) -> &Known {
        &self.known
    }

    /// Keeps the numbers of a point, or of the points that are computed together.
    pub(super) fn add(&mut self, (x, y): (usize, usize), numbers: &[Estimated]) -> Result<(), String> {
        let line = |(k, Estimated { value, error }): (usize, &Estimated)| format!("{x},{y},{k},{value:?},{error:?}\n");
        let lines: String = numbers.iter().enumerate().map(line).collect();
        // An empty line ends what belongs together.
        let written = self.file.write_all(format!("{lines}\n").as_bytes());
        written.map_err(|e| format!("{}: {e}", self.path.display()))
    }

    /// Removes the file: the map is finished.
    pub(super) fn remove(folder: &Path) -> Result<(), String> {
        let path = folder.join(FILE);
        fs::remove_file(&path).map_err(|e| format!("{}: {e}", path.display()))
    }
}

/// The points in a text, and the length of the part that is whole.
fn read(text: &str) -> (Known, usize) {
    let mut known = Known::new();
    let mut whole = (HEAD.len() + 1).min(text.len());
    while let Some(end) = text[whole..].find("\n\n") {
        let part = &text[whole..whole + end];
        let Some((at, numbers)) = point(part) else { break };
        known.insert(at, numbers);
        whole += end + 2;
    }
    (known, whole)
}

/// A point and its numbers.
fn point(part: &str) -> Option<((usize, usize), Vec<Estimated>)> {
    let mut at = None;
    let mut numbers = Vec::new();
    for line in part.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let &[x, y, number, value, error] = &fields[..] else { return None };
        at = Some((x.parse().ok()?, y.parse().ok()?));
        if number.parse() != Ok(numbers.len()) {
            return None;
        }
        numbers.push(Estimated { value: value.parse().ok()?, error: error.parse().ok()? });
    }
    Some((at?, numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_processes_do_not_compute_the_same_map() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), format!("{HEAD}\n")).unwrap();
        let first = Computed::open(folder.path()).unwrap();
        let why = Computed::open(folder.path()).unwrap_err();
        assert!(why.contains("another process computes this map"), "{why}");
        drop(first);
        Computed::open(folder.path()).unwrap();
    }

    #[test]
    fn the_hosts_of_a_map_are_no_part_of_what_is_asked() {
        let plain = "scenario = \"s\"\n[vary]\nx = [1, 2]\n";
        let with = "# with hosts\nscenario = \"s\"\n  [hosts] # mine\nnames = [\"a\"]\n[vary]\nx = [1, 2]\n\n";
        assert_eq!(what_counts(with), plain);
        assert_eq!(what_counts(&format!("{plain}[hosts]\nlisten = \"tcp/127.0.0.1:1\"\n")), plain);
        assert_ne!(what_counts(&plain.replace("[1, 2]", "[1, 3]")), plain);
    }

    #[test]
    fn what_was_kept_is_read_again_to_the_last_bit_and_half_a_line_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), format!("{HEAD}\n")).unwrap();
        let numbers = [(1.0 / 3.0, 1e-17), (f64::INFINITY, 0.0), (f64::NAN, f64::INFINITY)];
        let numbers: Vec<Estimated> = numbers.map(|(value, error)| Estimated { value, error }).to_vec();
        let mut kept = Computed::open(folder.path()).unwrap();
        kept.add((3, 0), &numbers).unwrap();
        kept.add((4, 7), &numbers[..1]).unwrap();
        kept.file.write_all(b"5,7,0,0.25,1e-").unwrap();
        drop(kept);
        let mut again = Computed::open(folder.path()).unwrap();
        assert_eq!(again.known().keys().copied().collect::<Vec<_>>(), [(3, 0), (4, 7)]);
        assert_eq!(again.known()[&(3, 0)][..2], numbers[..2]);
        assert!(again.known()[&(3, 0)][2].value.is_nan());
        again.add((5, 7), &numbers[..1]).unwrap();
        drop(again);
        assert_eq!(Computed::open(folder.path()).unwrap().known().len(), 3);
    }
}
