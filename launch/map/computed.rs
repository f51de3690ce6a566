//! The points of a map that have been computed so far, in a file: a map that was interrupted goes on with them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use density::exact::Estimated;
use density::reliability::refinement::Known;

/// The first line of the file.
const HEAD: &str = "x,y,number,value,error\n";
/// Copies of the map file and of its scenario file, by which a folder is known to belong to a map.
pub(super) const COPIES: [&str; 2] = ["map.toml", "scenario.toml"];

/// What a folder keeps of a map that was begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// There is no file for it.
    Absent,
    /// The file is there, without a point.
    Nothing,
    /// There are points, or the beginning of one.
    Points,
    /// A file of that name is there that is something else.
    Foreign,
}

/// The points so far.
#[derive(Debug)]
pub(super) struct Computed {
    path: PathBuf,
    file: File,
    known: Known,
}

impl Computed {
    /// The name of the file, which is there until the map is finished.
    pub(super) const FILE: &str = "computed.csv";

    /// What there is in a folder.
    pub(super) fn look(folder: &Path) -> Kept {
        match fs::read_to_string(folder.join(Self::FILE)) {
            Ok(text) if HEAD.starts_with(&text) => Kept::Nothing,
            Ok(text) if text.starts_with(HEAD) => Kept::Points,
            Err(error) if error.kind() == ErrorKind::NotFound => Kept::Absent,
            Ok(_) | Err(_) => Kept::Foreign,
        }
    }

    /// Makes the file if it is not there. Who opens it writes its first line, since nobody else does so at the same
    /// time.
    pub(super) fn begin(folder: &Path) -> Result<(), String> {
        let path = folder.join(Self::FILE);
        let made = OpenOptions::new().create(true).append(true).open(&path);
        made.map(drop).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Reads the points that are there.
    pub(super) fn open(folder: &Path) -> Result<Self, String> {
        let path = folder.join(Self::FILE);
        let failed = |e: std::io::Error| format!("{}: {e}", path.display());
        let mut file = OpenOptions::new().append(true).open(&path).map_err(failed)?;
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
        let mut text = fs::read_to_string(&path).map_err(failed)?;
        if !text.starts_with(HEAD) {
            file.set_len(0).and_then(|()| file.write_all(HEAD.as_bytes())).map_err(failed)?;
            text = HEAD.into();
        }
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
        let path = folder.join(Self::FILE);
        fs::remove_file(&path).map_err(|e| format!("{}: {e}", path.display()))
    }
}

/// The points in a text, and the length of the part that is whole.
fn read(text: &str) -> (Known, usize) {
    let mut known = Known::new();
    let mut whole = HEAD.len().min(text.len());
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
        Computed::begin(folder.path()).unwrap();
        let first = Computed::open(folder.path()).unwrap();
        let why = Computed::open(folder.path()).unwrap_err();
        assert!(why.contains("another process computes this map"), "{why}");
        drop(first);
        Computed::open(folder.path()).unwrap();
    }

    #[test]
    fn what_was_kept_is_read_again_to_the_last_bit_and_half_a_line_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        Computed::begin(folder.path()).unwrap();
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
