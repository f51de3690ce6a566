//! Where hosts meet, and what keeps others out.
//!
//! Plain connections are for loopback alone. All others use TLS, unless the user allows insecure ones. TLS is mutual if
//! the home host has an authority against which it checks its workers.

use std::fmt;
use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// `tcp/HOST:PORT` or `tls/HOST:PORT`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Endpoint {
    host: String,
    port: u16,
    encrypted: bool,
}

impl FromStr for Endpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("\"{text}\" is not an endpoint; it must be like tcp/127.0.0.1:7447 or tls/host:7447");
        let (protocol, address) = text.split_once('/').ok_or_else(refused)?;
        let encrypted = match protocol {
            "tcp" => false,
            "tls" => true,
            _ => return Err(refused()),
        };
        let (host, port) = address.rsplit_once(':').ok_or_else(refused)?;
        let port = port.parse().ok().filter(|&port| port > 0).ok_or_else(refused)?;
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b".-_[]:".contains(&byte);
        if host.is_empty() || !host.bytes().all(is_plain) {
            return Err(refused());
        }
        Ok(Self { host: host.into(), port, encrypted })
    }
}

impl TryFrom<String> for Endpoint {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Endpoint> for String {
    fn from(endpoint: Endpoint) -> Self {
        endpoint.to_string()
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}:{}", if self.encrypted { "tls" } else { "tcp" }, self.host, self.port)
    }
}

impl Endpoint {
    /// Whether messages that pass there are encrypted.
    pub fn is_encrypted(&self) -> bool {
        self.encrypted
    }

    fn is_loopback(&self) -> bool {
        let address: Option<IpAddr> = self.host.trim_matches(['[', ']']).parse().ok();
        self.host == "localhost" || address.is_some_and(|address| address.is_loopback())
    }
}

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

/// Which end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The home host listens.
    Listens,
    /// A worker host connects.
    Connects,
}

/// A way to the other hosts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Access {
    /// Where the hosts meet.
    pub endpoint: Endpoint,
    /// The files for TLS.
    pub tls: Tls,
    /// Whether plain connections may leave this host.
    pub insecure: bool,
}

impl Access {
    /// Checks that the way is safe and that nothing is missing for it.
    ///
    /// # Errors
    /// What is missing.
    pub fn check(&self, end: End) -> Result<(), String> {
        let Self { endpoint, tls, insecure } = self;
        if !endpoint.encrypted {
            return match endpoint.is_loopback() || *insecure {
                true => Ok(()),
                false => Err(format!("{endpoint} is not encrypted: take tls/... or, if you must, --insecure")),
            };
        }
        if tls.certificate.is_some() != tls.key.is_some() {
            return Err("a certificate and its key go together; one of them is missing".into());
        }
        let missing = match end {
            End::Listens if tls.certificate.is_none() => "certificate and key",
            End::Connects if tls.authority.is_none() => "authority, whose signature the home host must show",
            _ => "",
        };
        if !missing.is_empty() {
            return Err(format!("{endpoint} needs {missing}"));
        }
        let files = [&tls.authority, &tls.certificate, &tls.key];
        match files.into_iter().flatten().find(|file| std::fs::File::open(file).is_err()) {
            Some(file) => Err(format!("{} cannot be read", file.display())),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access(endpoint: &str, tls: Tls, insecure: bool) -> Access {
        Access { endpoint: endpoint.parse().unwrap(), tls, insecure }
    }

    #[test]
    fn an_endpoint_is_a_protocol_a_host_and_a_port() {
        for good in ["tcp/127.0.0.1:7447", "tls/home.example:1", "tcp/[::1]:80"] {
            assert_eq!(good.parse::<Endpoint>().unwrap().to_string(), good);
        }
        for bad in ["", "tcp", "udp/127.0.0.1:1", "tcp/127.0.0.1", "tcp/:1", "tcp/a:0", "tcp/a:99999", "tcp/a#b:1"] {
            assert!(bad.parse::<Endpoint>().unwrap_err().contains("must be like"), "{bad}");
        }
    }

    #[test]
    fn plain_connections_are_for_loopback_unless_somebody_insists() {
        for end in [End::Listens, End::Connects] {
            for near in ["tcp/127.0.0.1:1", "tcp/127.8.9.1:1", "tcp/[::1]:1", "tcp/localhost:1"] {
                access(near, Tls::default(), false).check(end).unwrap();
            }
            for far in ["tcp/0.0.0.0:1", "tcp/10.0.0.1:1", "tcp/[::]:1", "tcp/localhost.example:1"] {
                assert!(access(far, Tls::default(), false).check(end).unwrap_err().contains("--insecure"));
                access(far, Tls::default(), true).check(end).unwrap();
            }
        }
    }

    #[test]
    fn tls_without_its_files_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let path = Some(file.path().to_owned());
        let own = Tls { certificate: path.clone(), key: path.clone(), authority: None };
        access("tls/a:1", own.clone(), false).check(End::Listens).unwrap();
        assert!(access("tls/a:1", own.clone(), false).check(End::Connects).unwrap_err().contains("authority"));
        assert!(access("tls/a:1", Tls::default(), true).check(End::Listens).unwrap_err().contains("certificate"));
        let half = Tls { key: None, ..own.clone() };
        assert!(access("tls/a:1", half, false).check(End::Listens).unwrap_err().contains("go together"));
        let lost = Tls { authority: Some("/nowhere/ca.pem".into()), ..own };
        assert!(access("tls/a:1", lost, false).check(End::Connects).unwrap_err().contains("/nowhere/ca.pem"));
    }
}
