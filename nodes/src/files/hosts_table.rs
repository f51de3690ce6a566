//! The table `[hosts]` of launch files and map files, as it stands there. What its values must be is checked by who
//! opens the way to the hosts.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// The other hosts, and where they find this one.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HostsTable {
    /// The names of the worker hosts.
    #[schemars(with = "Vec<String>")]
    pub names: Spanned<Vec<Spanned<String>>>,
    /// Where they find this host.
    #[schemars(with = "String")]
    pub listen: Spanned<String>,
    /// Certificate of the authority that has signed the certificates of the worker hosts.
    #[schemars(with = "Option<PathBuf>")]
    pub authority: Option<Spanned<PathBuf>>,
    /// Certificate of this host.
    #[schemars(with = "Option<PathBuf>")]
    pub certificate: Option<Spanned<PathBuf>>,
    /// Private key of the certificate.
    #[schemars(with = "Option<PathBuf>")]
    pub key: Option<Spanned<PathBuf>>,
}
