//! The checksums of a results folder: written last into the manifest, and checked by `phasecloud verify`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use messages::text::printable;
use results::files::MANIFEST;
use results::manifest::{self, Contents, FileRecord};
use sha2::{Digest, Sha256};

/// A folder that a file system has from the start; it belongs to no results.
pub const LOST_AND_FOUND: &str = "lost+found";

/// Every file below `folder` except the manifest, by its path relative to `folder`. Folders in it that have a manifest
/// of their own are not looked into.
///
/// # Errors
/// Which file cannot be read.
pub fn of(folder: &Path) -> Result<BTreeMap<String, FileRecord>, String> {
    let mut files = BTreeMap::new();
    collect(folder, "", &mut files)?;
    files.remove(MANIFEST);
    Ok(files)
}

fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, FileRecord>) -> Result<(), String> {
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    for entry in std::fs::read_dir(folder).map_err(|e| failed(folder, e))? {
        let path = entry.map_err(|e| failed(folder, e))?.path();
        let name = format!("{prefix}{}", path.file_name().unwrap_or_default().to_string_lossy());
        if prefix.is_empty() && name == LOST_AND_FOUND {
            continue;
        }
        if prefix.is_empty() && is_sealed(&path) {
            continue;
        }
        if path.is_dir() {
            collect(&path, &format!("{name}/"), files)?;
        } else {
            files.insert(name, record(&path).map_err(|e| failed(&path, e))?);
        }
    }
    Ok(())
}

/// Whether a folder has a manifest.
pub fn is_sealed(folder: &Path) -> bool {
    folder.join(MANIFEST).is_file()
}

/// The names of the folders in `folder` that have a manifest of their own.
fn sealed_folders(folder: &Path) -> Result<BTreeSet<String>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let paths = entries.flatten().map(|entry| entry.path()).filter(|path| is_sealed(path));
    Ok(paths.filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect())
}

fn record(path: &Path) -> std::io::Result<FileRecord> {
    let content = std::fs::read(path)?;
    let bytes = content.len() as u64;
    let sha256 = Sha256::digest(&content).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(FileRecord { bytes, sha256 })
}

/// Compares a results folder with its manifest, and each results folder that the manifest lists with its own manifest.
/// Returns how many files there are, and what differs.
///
/// # Errors
/// If there is no manifest, or a file cannot be read.
pub fn verify(folder: &Path) -> Result<(usize, Vec<String>), String> {
    let manifest: Contents = manifest::read(folder).map_err(|e| e.to_string())?;
    let found = of(folder)?;
    let names = manifest.files.keys().chain(found.keys().filter(|name| !manifest.files.contains_key(*name)));
    let mut differ: Vec<String> = names
        .filter_map(|name| match (manifest.files.get(name), found.get(name)) {
            (Some(recorded), Some(file)) if recorded == file => None,
            (Some(_), Some(_)) => Some(format!("{} has been changed", printable(name))),
            (Some(_), None) => Some(format!("{} is missing", printable(name))),
            (None, _) => Some(format!("{} does not belong to the results", printable(name))),
        })
        .collect();
    let there = sealed_folders(folder)?;
    let missing = manifest.folders.difference(&there).map(|name| format!("{} is missing", printable(name)));
    let strange =
        there.difference(&manifest.folders).map(|name| format!("{} does not belong to the results", printable(name)));
    differ.extend(missing.chain(strange));
    let mut count = found.len();
    for name in manifest.folders.intersection(&there) {
        let (files, problems) = verify(&folder.join(name))?;
        count += files;
        differ.extend(problems.into_iter().map(|problem| format!("{}/{problem}", printable(name))));
    }
    Ok((count, differ))
}
