//! The folder of a map: whether it may be used, and the copies by which it is known to belong to this map.
//!
//! The copies are written before anything is computed, each to a name of its own that is then changed to the right one,
//! so that a set-up that is interrupted leaves either none or a whole one.

use std::fs::{self, File};
use std::io::{Error, Write};
use std::path::Path;

use nodes::files::map_file::MapFile;

use super::computed::{COPIES, Computed, Kept};
use super::output::TABLE;

/// The ending of a copy's name while it is being written.
const DRAFT: &str = ".draft";
const ANOTHER: &str = "name another folder with --out";

/// Makes room for a map in `folder`: a folder that is not there or empty, or in which the same map was begun.
///
/// # Errors
/// Why the folder cannot be used.
pub fn prepare(map: &MapFile, folder: &Path) -> Result<(), String> {
    set_up(map.texts(), folder)
}

/// Makes room for the map with these texts of its map file and its scenario file.
fn set_up(texts: [&str; 2], folder: &Path) -> Result<(), String> {
    let failed = |e: Error| format!("cannot write to {}: {e}", folder.display());
    if folder.exists() {
        check(texts, folder)?;
    } else {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    for (name, text) in COPIES.iter().zip(texts) {
        if fs::read_to_string(folder.join(name)).ok().as_deref() != Some(text) {
            write_whole(folder, name, text).map_err(failed)?;
        }
    }
    Computed::begin(folder)
}

fn write_whole(folder: &Path, name: &str, text: &str) -> Result<(), Error> {
    let draft = folder.join(format!("{name}{DRAFT}"));
    let mut file = File::create(&draft)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    fs::rename(draft, folder.join(name))
}

/// What a copy in a folder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Copied {
    /// It is not there, or empty.
    Missing,
    /// It is that of this map, apart from what has no effect.
    Same,
    /// It is that of another map.
    Other,
}

/// Refuses a folder that is there and is neither empty nor that of this map, and one in which the map is complete.
fn check(texts: [&str; 2], folder: &Path) -> Result<(), String> {
    let shown = folder.display();
    let names = names_in(folder)?;
    let kept = Computed::look(folder);
    let copies = [0, 1].map(|k| copied(&folder.join(COPIES[k]), texts[k]));
    let is_there = |name: &str| names.iter().any(|there| there == name);
    let is_map = COPIES.iter().all(|name| is_there(name)) || !matches!(kept, Kept::Absent | Kept::Foreign);
    let others = || COPIES.iter().zip(copies).filter(|(_, copy)| *copy == Copied::Other).map(|(name, _)| *name);
    let others: Vec<&str> = others().collect();
    if is_map && !others.is_empty() {
        let differ = if others.len() == 1 { "differs" } else { "differ" };
        let named = others.join(" and ");
        return Err(format!("{shown} holds another map: {named} there {differ} from that of this map; {ANOTHER}"));
    }
    let is_same = copies == [Copied::Same; 2];
    match kept {
        Kept::Points | Kept::Nothing if is_same => return Ok(()),
        Kept::Points => {
            return Err(format!("{shown} holds points of a map, but not the files that say of which map; {ANOTHER}"));
        }
        Kept::Absent if is_same && is_there(TABLE) => {
            return Err(format!("{shown} holds this map already, complete; {ANOTHER}"));
        }
        Kept::Absent | Kept::Nothing | Kept::Foreign => {}
    }
    match names.iter().find(|name| !is_of_set_up(name, kept) || others.contains(&name.as_str())) {
        Some(name) => Err(format!("{shown} exists already and holds something else, {name}; {ANOTHER}")),
        None => Ok(()),
    }
}

/// Whether a file of this name is left by a set-up.
fn is_of_set_up(name: &str, kept: Kept) -> bool {
    let is_points = name == Computed::FILE && kept != Kept::Foreign;
    is_points || COPIES.contains(&name.strip_suffix(DRAFT).unwrap_or(name))
}

/// The names of all that is in a folder, in order.
fn names_in(folder: &Path) -> Result<Vec<String>, String> {
    let failed = |e: Error| format!("{} cannot be used as a folder: {e}", folder.display());
    let entries = fs::read_dir(folder).map_err(failed)?;
    let name = |entry: Result<fs::DirEntry, Error>| Ok(entry?.file_name().to_string_lossy().into_owned());
    let mut names = entries.map(name).collect::<Result<Vec<String>, Error>>().map_err(failed)?;
    names.sort();
    Ok(names)
}

fn copied(path: &Path, text: &str) -> Copied {
    match fs::read_to_string(path) {
        Ok(there) if there.is_empty() => Copied::Missing,
        Ok(there) if what_counts(&there) == what_counts(text) => Copied::Same,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Copied::Missing,
        Ok(_) | Err(_) => Copied::Other,
    }
}

/// A text without its table `[hosts]`, its comments and its empty lines, which have no effect on what is computed: a
/// map may go on with other hosts, or without them.
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

#[cfg(test)]
mod tests {
    use super::*;

    const TEXTS: [&str; 2] = ["scenario = \"s.toml\"\n[vary]\nx = [1, 2]\n", "name = \"s\"\n"];
    const HEAD: &str = "x,y,number,value,error\n";
    const POINTS: &str = "x,y,number,value,error\n0,0,0,0.5,0.0\n\n";

    /// A folder with these files; `None` stands for a file that is not there.
    fn folder(files: &[(&str, Option<&str>)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files.iter().filter_map(|(name, text)| Some((name, (*text)?))) {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    fn refused(files: &[(&str, Option<&str>)], words: &str) {
        let folder = folder(files);
        let why = set_up(TEXTS, folder.path()).unwrap_err();
        assert!(why.contains(words) && why.contains("--out"), "{files:?}: {why}");
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, files.iter().filter(|(_, text)| text.is_some()).count(), "{files:?}: something was written");
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
    fn a_set_up_that_was_interrupted_anywhere_is_done_anew() {
        for computed in [None, Some(""), Some("x,y,num"), Some(HEAD)] {
            for map in [None, Some(""), Some(TEXTS[0])] {
                for scenario in [None, Some(""), Some(TEXTS[1])] {
                    for draft in [None, Some("scen")] {
                        let files = [("computed.csv", computed), ("map.toml", map), ("scenario.toml", scenario)];
                        let folder = folder(&[&files[..], &[("map.toml.draft", draft)]].concat());
                        let done = set_up(TEXTS, folder.path());
                        assert_eq!(done, Ok(()), "{files:?}");
                        let there = COPIES.map(|name| fs::read_to_string(folder.path().join(name)).unwrap());
                        assert_eq!(there, TEXTS, "{files:?}");
                        assert!(Computed::open(folder.path()).unwrap().known().is_empty());
                        assert_eq!(fs::read_to_string(folder.path().join("computed.csv")).unwrap(), HEAD);
                    }
                }
            }
        }
    }

    #[test]
    fn a_folder_that_is_not_there_is_made_and_points_of_the_same_map_are_kept() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("a/b");
        set_up(TEXTS, &folder).unwrap();
        fs::write(folder.join("computed.csv"), POINTS).unwrap();
        let with_hosts = format!("{}[hosts]\nnames = [\"a\"]\n", TEXTS[0]);
        set_up([&with_hosts, TEXTS[1]], &folder).unwrap();
        assert_eq!(fs::read_to_string(folder.join("computed.csv")).unwrap(), POINTS);
        assert_eq!(fs::read_to_string(folder.join("map.toml")).unwrap(), with_hosts);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 3, "no draft is left");
    }

    #[test]
    fn another_map_is_refused_and_the_file_that_differs_is_named() {
        let (map, scenario) = (("map.toml", Some(TEXTS[0])), ("scenario.toml", Some(TEXTS[1])));
        let (other_map, other_scenario) = (("map.toml", Some("x = 1\n")), ("scenario.toml", Some("y = 1\n")));
        for computed in [None, Some(HEAD), Some(POINTS)].map(|text| ("computed.csv", text)) {
            refused(&[computed, other_map, scenario], "another map: map.toml there differs from");
            refused(&[computed, map, other_scenario], "another map: scenario.toml there differs from");
            refused(&[computed, other_map, other_scenario], "map.toml and scenario.toml there differ from");
        }
        refused(&[("computed.csv", Some(HEAD)), other_map], "another map: map.toml there differs from");
    }

    #[test]
    fn what_is_complete_or_no_map_at_all_is_left_alone() {
        let (map, scenario) = (("map.toml", Some(TEXTS[0])), ("scenario.toml", Some(TEXTS[1])));
        refused(&[map, scenario, ("map.csv", Some("x"))], "holds this map already, complete");
        refused(&[map, ("computed.csv", Some(POINTS))], "holds points of a map, but not the files that say of which");
        refused(&[("scenario.toml", Some("mine"))], "holds something else, scenario.toml");
        refused(&[("map.csv", Some("mine"))], "holds something else, map.csv");
        refused(&[map, scenario, ("thesis.txt", Some("mine"))], "holds something else, thesis.txt");
        refused(&[map, scenario, ("computed.csv", Some("a,b\n1,2\n"))], "holds something else, computed.csv");
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(set_up(TEXTS, file.path()).unwrap_err().contains("cannot be used as a folder"));
    }
}
