//! Whether the files for TLS are what they should be, as far as this side can tell: whether the other side accepts them
//! is its own affair.

use std::path::Path;

use rustls::crypto::ring::default_provider;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::ParsedCertificate;
use rustls::sign::CertifiedKey;
use rustls::{Error, InconsistentKeys, RootCertStore};

use crate::tls::{Fault, Part, Tls};

/// Checks that every file holds what it is named for, and that the key is that of the certificate.
///
/// # Errors
/// Which file is not what it should be, and why.
pub fn check(tls: &Tls) -> Result<(), Fault> {
    if let Some(path) = &tls.authority {
        let mut roots = RootCertStore::empty();
        for certificate in certificates(Part::Authority, path)? {
            roots.add(certificate).map_err(|e| unusable(Part::Authority, path, &e))?;
        }
    }
    match (&tls.certificate, &tls.key) {
        (Some(certificate), Some(key)) => check_pair(certificate, key),
        _ => Ok(()),
    }
}

fn check_pair(certificate: &Path, key: &Path) -> Result<(), Fault> {
    let chain = certificates(Part::Certificate, certificate)?;
    for link in &chain {
        ParsedCertificate::try_from(link).map_err(|e| unusable(Part::Certificate, certificate, &e))?;
    }
    let read = private_key(key)?;
    CertifiedKey::from_der(chain, read, &default_provider()).map(drop).map_err(|error| match error {
        Error::InconsistentKeys(InconsistentKeys::KeyMismatch) => {
            let why = format!("{} is not the key of the certificate {}", key.display(), certificate.display());
            Fault::of(Part::Key, why)
        }
        error => unusable(Part::Key, key, &error),
    })
}

/// The certificates in a file, of which there is at least one.
fn certificates(part: Part, path: &Path) -> Result<Vec<CertificateDer<'static>>, Fault> {
    let text = read(part, path)?;
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    match found {
        Ok(found) if found.is_empty() => Err(Fault::of(part, format!("{}: no certificate in it", path.display()))),
        Ok(found) => Ok(found),
        Err(error) => Err(Fault::of(part, format!("{}: is no PEM file: {error}", path.display()))),
    }
}

fn private_key(path: &Path) -> Result<PrivateKeyDer<'static>, Fault> {
    let text = read(Part::Key, path)?;
    let of_file = |why: &str| Fault::of(Part::Key, format!("{}: {why}", path.display()));
    let is_encrypted = text.windows(ENCRYPTED.len()).any(|words| words == ENCRYPTED);
    match PrivateKeyDer::pem_slice_iter(&text).next() {
        Some(Ok(key)) => Ok(key),
        Some(Err(error)) => Err(of_file(&format!("is no PEM file: {error}"))),
        None if is_encrypted => Err(of_file("the private key in it is encrypted, and nobody asks for its password")),
        None => Err(of_file("no private key in it")),
    }
}

/// How a private key begins that only a password opens.
const ENCRYPTED: &[u8] = b"BEGIN ENCRYPTED PRIVATE KEY";

fn read(part: Part, path: &Path) -> Result<Vec<u8>, Fault> {
    std::fs::read(path).map_err(|e| Fault::of(part, format!("{} cannot be read: {e}", path.display())))
}

fn unusable(part: Part, path: &Path, why: &Error) -> Fault {
    let what = if part == Part::Key { "private key" } else { "certificate" };
    Fault::of(part, format!("{}: the {what} in it cannot be used: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    // Made for these tests by `openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes`; nobody
    // trusts them.
    const CERTIFICATE: &str = "-----BEGIN CERTIFICATE-----
MIIBczCCARmgAwIBAgIUFwe8dpNZLQtd5bjtSGa/YESayU0wCgYIKoZIzj0EAwIw
DjEMMAoGA1UEAwwDb25lMCAXDTI2MTEyOTAwNTIzNFoYDzIxMjYxMTA1MDA1MjM0
WjAOMQwwCgYDVQQDDANvbmUwWTATBgcqhkjOPQIBBggqhkjOPQMBBwNCAAT1UGCv
XFsknFHwqEKlwTuLFCxOlIdRdB6B8PQsTE4MMOYuDzMT5WwDzBFc7kQD8cZgHJJV
ECCyiAgUS4FBRZwHo1MwUTAdBgNVHQ4EFgQUSDXpZsWHrvIrFspvdLIrNOR/am0w
HwYDVR0jBBgwFoAUSDXpZsWHrvIrFspvdLIrNOR/am0wDwYDVR0TAQH/BAUwAwEB
/zAKBggqhkjOPQQDAgNIADBFAiB39HuYWGfA+b3fBymXW6hbcrfEMsU7Ko+nulFD
vZvUUAIhAK9z2/Ml3pyeTilBiOgOGtXP4BVraiP8Kk9cT35CsAiI
-----END CERTIFICATE-----
";
    const KEY: &str = "-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQgRzfakOq9qmM1/Wx0
MdXDBHqSR/Di+6qOnICJfq5QMGahRANCAAT1UGCvXFsknFHwqEKlwTuLFCxOlIdR
dB6B8PQsTE4MMOYuDzMT5WwDzBFc7kQD8cZgHJJVECCyiAgUS4FBRZwH
-----END PRIVATE KEY-----
";
    const ANOTHER_KEY: &str = "-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQgEvDnuXCNfo7d5o0m
EP6tjVUWX9cbJfSRTUryibU658ShRANCAASsq5U9RTqi3gT7tKSyUUVUuFVeeP2R
GgElUjt8jYLBCvJaTSsvJB6ZEhb4R0qqbgDWsFQrKhDT/Dp1NjaYqnyo
-----END PRIVATE KEY-----
";

    /// What is wrong with files of these contents.
    fn told(authority: &str, certificate: &str, key: &str) -> Result<(), (Part, String)> {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            Some(path)
        };
        let tls = Tls {
            authority: file("ca.pem", authority),
            certificate: file("c.pem", certificate),
            key: file("k.pem", key),
        };
        check(&tls).map_err(|fault| (fault.part, fault.why))
    }

    #[test]
    fn good_files_are_taken_and_each_kind_of_bad_one_is_named() {
        assert_eq!(told(CERTIFICATE, CERTIFICATE, KEY), Ok(()));
        let junk = "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n";
        let junk_key = junk.replace("CERTIFICATE", "PRIVATE KEY");
        let encrypted = junk.replace("CERTIFICATE", "ENCRYPTED PRIVATE KEY");
        let cut = &CERTIFICATE[..200];
        let cases = [
            (told("junk", CERTIFICATE, KEY), Part::Authority, "ca.pem: no certificate in it"),
            (told(junk, CERTIFICATE, KEY), Part::Authority, "ca.pem: the certificate in it cannot be used"),
            (told(cut, CERTIFICATE, KEY), Part::Authority, "ca.pem: is no PEM file"),
            (told(CERTIFICATE, KEY, KEY), Part::Certificate, "c.pem: no certificate in it"),
            (told(CERTIFICATE, junk, KEY), Part::Certificate, "c.pem: the certificate in it cannot be used"),
            (told(CERTIFICATE, CERTIFICATE, ""), Part::Key, "k.pem: no private key in it"),
            (told(CERTIFICATE, CERTIFICATE, &encrypted), Part::Key, "k.pem: the private key in it is encrypted"),
            (told(CERTIFICATE, CERTIFICATE, &junk_key), Part::Key, "k.pem: the private key in it cannot be used"),
            (told(CERTIFICATE, CERTIFICATE, ANOTHER_KEY), Part::Key, "k.pem is not the key of the certificate"),
        ];
        for (told, part, words) in cases {
            let (found, why) = told.unwrap_err();
            assert!(found == part && why.contains(words), "{why}, but {words}");
        }
    }
}
