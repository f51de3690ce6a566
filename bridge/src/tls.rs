//! The files that TLS needs, and what may be wrong with a way to the other hosts.

use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The files that TLS needs, in PEM.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tls {
    /// Certificate of the authority that has signed the other side's certificate.
    pub authority: Option<PathBuf>,
    /// Own certificate.
    pub certificate: Option<PathBuf>,
    /// Its private key.
    pub key: Option<PathBuf>,
}

/// What is to be changed about a way that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Where the hosts meet.
    Endpoint,
    /// See [`Tls::authority`].
    Authority,
    /// See [`Tls::certificate`].
    Certificate,
    /// See [`Tls::key`].
    Key,
}

/// Why a way to the other hosts cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// What is to be changed.
    pub part: Part,
    /// What is wrong with it.
    pub why: String,
}

impl Fault {
    /// This is wrong with that part.
    pub fn of(part: Part, why: impl Into<String>) -> Self {
        Self { part, why: why.into() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}

impl Tls {
    /// The files that are named.
    pub(crate) fn named(&self) -> impl Iterator<Item = (Part, &PathBuf)> {
        let files =
            [(Part::Authority, &self.authority), (Part::Certificate, &self.certificate), (Part::Key, &self.key)];
        files.into_iter().filter_map(|(part, file)| Some((part, file.as_ref()?)))
    }
}
