//! zenoh, set up for one host that listens and others that connect to it; nothing is searched for by multicast.

use kit::failure::Failure;
use serde_json::{Value, json};
use zenoh::{Config, Session, Wait};

use crate::endpoint::{Access, End};

/// A link over which nothing has come for this time is closed and opened anew \[ms\]. The time is short, because a TCP
/// connection that has lost packets for five seconds tries again only after ten.
const LEASE: u64 = 3000;
/// Longest wait for the other side while a link is opened \[ms\].
const OPENING: u64 = 1000;
/// Longest pause between two attempts to connect \[ms\].
const PAUSE: u64 = 500;

/// Opens a session of zenoh. A host that connects goes on trying for as long as the session lives.
///
/// # Errors
/// [`Failure::Refused`] if the endpoint cannot be used.
pub fn open(access: &Access, end: End) -> Result<Session, Failure> {
    access.check(end).map_err(|fault| Failure::Refused(fault.why))?;
    let mut config = Config::default();
    for (key, value) in settings(access, end) {
        config.insert_json5(key, &value.to_string()).map_err(|e| refused(&format!("{key}: {e}")))?;
    }
    zenoh::open(config).wait().map_err(|e| refused(&format!("{}: {e}", access.endpoint)))
}

/// A refusal by zenoh.
pub(crate) fn refused(why: &dyn std::fmt::Display) -> Failure {
    Failure::Refused(format!("zenoh: {}", without_places(&why.to_string())))
}

/// A text of zenoh without the places in its source, ` at FILE.rs:LINE`, which name folders of the machine on which it
/// was built.
fn without_places(text: &str) -> String {
    let mut pieces = text.split(" at ");
    let mut kept = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let end = piece.find(|c: char| c.is_whitespace() || c == ']').unwrap_or(piece.len());
        let (place, rest) = piece.split_at(end);
        let line = place.trim_end_matches(['.', ',']).rsplit_once(".rs:").map(|(_, line)| line);
        if line.is_some_and(|line| !line.is_empty() && line.bytes().all(|byte| byte.is_ascii_digit())) {
            kept += rest;
        } else {
            kept = kept + " at " + piece;
        }
    }
    kept
}

fn settings(access: &Access, end: End) -> Vec<(&'static str, Value)> {
    let Access { endpoint, tls, .. } = access;
    let mut settings = vec![
        ("mode", json!("peer")),
        ("scouting/multicast/enabled", json!(false)),
        ("scouting/gossip/enabled", json!(false)),
        ("transport/link/tx/lease", json!(LEASE)),
        ("transport/unicast/open_timeout", json!(OPENING)),
        ("transport/unicast/accept_timeout", json!(OPENING)),
        ("transport/link/tx/queue/congestion_control/block/wait_before_close", json!(LEASE * 1000)),
    ];
    let protocol = if endpoint.is_encrypted() { "tls" } else { "tcp" };
    settings.push(("transport/link/protocols", json!([protocol])));
    match end {
        End::Listens => settings.push(("listen/endpoints", json!([endpoint]))),
        End::Connects => settings.extend([
            ("listen/endpoints", json!([])),
            ("connect/endpoints", json!([endpoint])),
            ("connect/timeout_ms", json!(-1)),
            ("connect/exit_on_failure", json!(false)),
            (
                "connect/retry",
                json!({"period_init_ms": PAUSE / 2, "period_max_ms": PAUSE, "period_increase_factor": 2}),
            ),
        ]),
    }
    if endpoint.is_encrypted() {
        let (certificate, key) = match end {
            End::Listens => ("transport/link/tls/listen_certificate", "transport/link/tls/listen_private_key"),
            End::Connects => ("transport/link/tls/connect_certificate", "transport/link/tls/connect_private_key"),
        };
        let mutual = tls.certificate.is_some() && tls.authority.is_some();
        settings.push(("transport/link/tls/enable_mtls", json!(mutual)));
        let files = [
            ("transport/link/tls/root_ca_certificate", &tls.authority),
            (certificate, &tls.certificate),
            (key, &tls.key),
        ];
        settings.extend(files.into_iter().filter_map(|(name, file)| Some((name, json!(file.as_ref()?)))));
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_source_are_left_out_of_what_zenoh_says() {
        let said = "can not bind at 127.0.0.1:1: [no (os error 98) at /home/me/.cargo/src/tcp.rs:61.] at /home/me/unicast.rs:338. - Caused by no at /a/b.rs:5";
        assert_eq!(without_places(said), "can not bind at 127.0.0.1:1: [no (os error 98)] - Caused by no");
    }
}
