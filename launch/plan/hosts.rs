//! The `[hosts]` table of a launch file or a map file: which other hosts take part, and where they find this one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bridge::endpoint::{Access, End, Endpoint, Tls};
use bridge::plan::HOME;
use nodes::files::hosts_table::HostsTable;
use nodes::files::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use toml::Spanned;

/// The feature `hosts` is compiled only on request, because it takes longer than all the rest.
pub const WITHOUT_HOSTS: &str =
    "this phasecloud was built for one host; build it with `cargo build --release --features hosts`";

/// Most worker hosts of a run.
const MOST_HOSTS: usize = 64;

/// The other hosts of a run or of a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hosts {
    /// Where they find this host.
    pub access: Access,
    /// Their names.
    pub names: Vec<String>,
}

impl Hosts {
    /// Checks the table; the files that it names are relative to `folder`.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check(file: &InputFile, raw: &HostsTable, folder: &Path) -> Result<Self, InputError> {
        let endpoint: Endpoint = raw.listen.get_ref().parse().map_err(|why: String| file.error(&raw.listen, &why))?;
        let mut names = BTreeSet::new();
        for name in raw.names.get_ref() {
            let text = name.get_ref();
            if !is_plain_name(text) {
                return Err(file.error(name, &format!("\"{text}\" is not allowed, {PLAIN_NAME}")));
            }
            if text == HOME {
                return Err(file.error(name, "\"home\" is the host on which all is started; it need not be named"));
            }
            if !names.insert(text) {
                return Err(file.error(name, &format!("a second host with the name \"{text}\"; names must differ")));
            }
        }
        if names.is_empty() || names.len() > MOST_HOSTS {
            let problem = format!("names {} hosts, it must be 1 to {MOST_HOSTS}", names.len());
            return Err(file.error(&raw.names, &problem));
        }
        let path = |path: &Option<PathBuf>| path.as_ref().map(|path| folder.join(path));
        let tls = Tls { authority: path(&raw.authority), certificate: path(&raw.certificate), key: path(&raw.key) };
        let names = raw.names.get_ref().iter().map(|name| name.get_ref().clone()).collect();
        Ok(Self { access: Access { endpoint, tls, insecure: false }, names })
    }

    /// Lets hosts talk without encryption, if `insecure`, and checks whether they can talk at all.
    ///
    /// # Errors
    /// What is missing.
    pub fn open(&mut self, insecure: bool) -> Result<(), String> {
        if !cfg!(feature = "hosts") {
            return Err(format!("hosts: {WITHOUT_HOSTS}"));
        }
        self.access.insecure = insecure;
        self.access.check(End::Listens).map_err(|why| format!("hosts.listen: {why}"))
    }
}

/// The hosts to which the processes of a case are given in turn.
///
/// # Errors
/// [`InputError`] if one of them is not named in the `[hosts]` table.
pub fn placement(
    file: &InputFile,
    named: &Spanned<Vec<Spanned<String>>>,
    hosts: Option<&Hosts>,
) -> Result<Vec<String>, InputError> {
    let known: Vec<&str> =
        std::iter::once(HOME).chain(hosts.iter().flat_map(|hosts| hosts.names.iter().map(String::as_str))).collect();
    if named.get_ref().is_empty() {
        return Err(file.error(named, "names no host; leave it out for home"));
    }
    if let Some(unknown) = named.get_ref().iter().find(|name| !known.contains(&name.get_ref().as_str())) {
        let problem =
            format!("\"{}\" is no host of this run; there are {} (see [hosts])", unknown.get_ref(), known.join(", "));
        return Err(file.error(unknown, &problem));
    }
    Ok(named.get_ref().iter().map(|name| name.get_ref().clone()).collect())
}
