//! The `[hosts]` table of a launch file or a map file: which other hosts take part, and where they find this one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bridge::endpoint::{Access, End, Endpoint, Fault, Part, Tls};
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
    /// Where the file says each part of the way, as errors without a problem.
    places: Vec<(Part, InputError)>,
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
        let path = |path: &Option<Spanned<PathBuf>>| path.as_ref().map(|path| folder.join(path.get_ref()));
        let tls = Tls { authority: path(&raw.authority), certificate: path(&raw.certificate), key: path(&raw.key) };
        let names = raw.names.get_ref().iter().map(|name| name.get_ref().clone()).collect();
        let files = [(Part::Authority, &raw.authority), (Part::Certificate, &raw.certificate), (Part::Key, &raw.key)];
        let files = files.into_iter().filter_map(|(part, path)| Some((part, file.error(path.as_ref()?, ""))));
        let places = files.chain([(Part::Endpoint, file.error(&raw.listen, ""))]).collect();
        Ok(Self { access: Access { endpoint, tls, insecure: false }, names, places })
    }

    /// Checks the way to the hosts as [`Hosts::open`] does, as far as that is possible without opening anything.
    /// Returns what is to be said of a way that is only good with `--insecure`.
    ///
    /// # Errors
    /// What is missing or wrong, with file, line and key.
    pub fn look(&self) -> Result<Option<String>, String> {
        let access = Access { insecure: true, ..self.access.clone() };
        access.check(End::Listens).map_err(|fault| self.told(fault))?;
        let endpoint = &access.endpoint;
        Ok(endpoint.is_exposed().then(|| format!("{endpoint} is not encrypted, which needs --insecure")))
    }

    /// Lets hosts talk without encryption, if `insecure`, and checks whether they can talk at all.
    ///
    /// # Errors
    /// What is missing or wrong, with file, line and key.
    pub fn open(&mut self, insecure: bool) -> Result<(), String> {
        if !cfg!(feature = "hosts") {
            return Err(format!("hosts: {WITHOUT_HOSTS}"));
        }
        self.access.insecure = insecure;
        self.access.check(End::Listens).map_err(|fault| self.told(fault))?;
        self.access.endpoint.try_listening().map_err(|why| self.told(Fault::of(Part::Endpoint, why)))
    }

    /// A fault of the way, where the file says that part of it.
    fn told(&self, fault: Fault) -> String {
        match self.places.iter().find(|(part, _)| *part == fault.part) {
            Some((_, place)) => InputError { problem: fault.why, ..place.clone() }.to_string(),
            None => fault.why,
        }
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
