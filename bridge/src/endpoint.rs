//! Where hosts meet, and what keeps others out.
//!
//! Plain connections are for loopback alone. All others use TLS, unless the user allows insecure ones. TLS is mutual if
//! the home host has an authority against which it checks its workers.

use std::fmt;
use std::io::ErrorKind;
use std::net::{IpAddr, TcpListener};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

pub use crate::tls::{Fault, Part, Tls};

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

    /// Whether messages that pass there can be read by others on the way.
    pub fn is_exposed(&self) -> bool {
        !self.encrypted && !self.is_loopback()
    }

    /// Listens there for a moment, to see whether that is possible.
    ///
    /// # Errors
    /// Why it is not.
    pub fn try_listening(&self) -> Result<(), String> {
        match TcpListener::bind(format!("{}:{}", self.host, self.port)) {
            Ok(_) => Ok(()),
            Err(error) if error.kind() == ErrorKind::AddrInUse => {
                Err(format!("{self}: the port is taken: another program listens there"))
            }
            Err(error) => Err(format!("{self}: this host cannot listen there: {error}")),
        }
    }

    fn is_loopback(&self) -> bool {
        let address: Option<IpAddr> = self.host.trim_matches(['[', ']']).parse().ok();
        self.host == "localhost" || address.is_some_and(|address| address.is_loopback())
    }
}

/// Which end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The home host listens.
    Listens,
    /// A worker host connects.
    Connects,
}

impl Tls {
    fn check(&self, endpoint: &Endpoint, end: End) -> Result<(), Fault> {
        match (&self.certificate, &self.key) {
            (Some(_), None) => {
                return Err(Fault::of(Part::Certificate, "a certificate and its key go together; the key is missing"));
            }
            (None, Some(_)) => {
                return Err(Fault::of(Part::Key, "a key and its certificate go together; the certificate is missing"));
            }
            _ => {}
        }
        let missing = match end {
            End::Listens if self.certificate.is_none() => "certificate and key",
            End::Connects if self.authority.is_none() => "authority, whose signature the home host must show",
            _ => "",
        };
        if !missing.is_empty() {
            return Err(Fault::of(Part::Endpoint, format!("{endpoint} needs {missing}")));
        }
        for (part, file) in self.named() {
            let shown = file.display();
            std::fs::read(file).map_err(|e| Fault::of(part, format!("{shown} cannot be read: {e}")))?;
        }
        // Only a program that can talk to other hosts has what it takes to read certificates.
        #[cfg(feature = "zenoh")]
        crate::pem::check(self)?;
        Ok(())
    }
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
    pub fn check(&self, end: End) -> Result<(), Fault> {
        let Self { endpoint, tls, insecure } = self;
        if endpoint.encrypted {
            return tls.check(endpoint, end);
        }
        if endpoint.is_exposed() && !insecure {
            let why = format!("{endpoint} is not encrypted: take tls/... or, if you must, --insecure");
            return Err(Fault::of(Part::Endpoint, why));
        }
        match tls.named().next() {
            Some((part, _)) => {
                Err(Fault::of(part, format!("has no effect with {endpoint}; leave it out, or take tls/...")))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

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

    /// The fault of a way that has one.
    fn fault(endpoint: &str, tls: Tls, insecure: bool, end: End) -> (Part, String) {
        let Fault { part, why } = access(endpoint, tls, insecure).check(end).unwrap_err();
        (part, why)
    }

    #[test]
    fn plain_connections_are_for_loopback_unless_somebody_insists() {
        for end in [End::Listens, End::Connects] {
            for near in ["tcp/127.0.0.1:1", "tcp/127.8.9.1:1", "tcp/[::1]:1", "tcp/localhost:1"] {
                access(near, Tls::default(), false).check(end).unwrap();
            }
            for far in ["tcp/0.0.0.0:1", "tcp/10.0.0.1:1", "tcp/[::]:1", "tcp/localhost.example:1"] {
                let (part, why) = fault(far, Tls::default(), false, end);
                assert!(part == Part::Endpoint && why.contains("--insecure"), "{why}");
                access(far, Tls::default(), true).check(end).unwrap();
            }
        }
    }

    #[test]
    fn tls_without_its_files_is_refused() {
        let path = |name: &str| Some(PathBuf::from("/nowhere").join(name));
        let own = Tls { certificate: path("c.pem"), key: path("k.pem"), authority: None };
        let (part, why) = fault("tls/a:1", own.clone(), false, End::Connects);
        assert!(part == Part::Endpoint && why.contains("authority"), "{why}");
        let (part, why) = fault("tls/a:1", Tls::default(), true, End::Listens);
        assert!(part == Part::Endpoint && why.contains("certificate"), "{why}");
        let (part, why) = fault("tls/a:1", Tls { key: None, ..own.clone() }, false, End::Listens);
        assert!(part == Part::Certificate && why.contains("the key is missing"), "{why}");
        let (part, why) = fault("tls/a:1", Tls { certificate: None, ..own.clone() }, false, End::Listens);
        assert!(part == Part::Key && why.contains("the certificate is missing"), "{why}");
        let (part, why) = fault("tls/a:1", own, false, End::Listens);
        assert!(part == Part::Certificate && why.contains("/nowhere/c.pem cannot be read"), "{why}");
        let lost = Tls { authority: path("ca.pem"), ..Tls::default() };
        let (part, why) = fault("tls/a:1", lost, false, End::Connects);
        assert!(part == Part::Authority && why.contains("/nowhere/ca.pem cannot be read"), "{why}");
    }

    #[test]
    fn files_for_tls_have_no_effect_without_it() {
        let key = Tls { key: Some("k.pem".into()), ..Tls::default() };
        for end in [End::Listens, End::Connects] {
            let (part, why) = fault("tcp/127.0.0.1:1", key.clone(), false, end);
            assert!(part == Part::Key && why.contains("has no effect with tcp/127.0.0.1:1"), "{why}");
        }
        // What is more dangerous is told first.
        assert_eq!(fault("tcp/10.0.0.1:1", key, false, End::Listens).0, Part::Endpoint);
    }

    #[test]
    fn a_port_that_is_taken_and_an_address_of_another_host_are_told_from_one_that_is_free() {
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = taken.local_addr().unwrap().port();
        let tried = |endpoint: String| endpoint.parse::<Endpoint>().unwrap().try_listening();
        let why = tried(format!("tcp/127.0.0.1:{port}")).unwrap_err();
        assert!(why.starts_with(&format!("tcp/127.0.0.1:{port}: the port is taken")), "{why}");
        let why = tried(format!("tls/192.0.2.1:{port}")).unwrap_err();
        assert!(why.contains("this host cannot listen there: "), "{why}");
        drop(taken);
        tried(format!("tcp/127.0.0.1:{port}")).unwrap();
    }
}
