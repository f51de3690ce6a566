//! Who sent a message: the label that the launcher gave the process, whatever the message itself says.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use crate::session::LABEL_VARIABLE;

/// What was found when the senders lived: some messages are read when their sender is gone.
static SEEN: Mutex<BTreeMap<u32, Option<String>>> = Mutex::new(BTreeMap::new());

/// The label in the environment of a process, which its children inherit; `None` for processes that are no propagators, that
/// nobody can look into, or that were gone before anybody did.
pub fn label_of(process: u32) -> Option<String> {
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    match std::fs::read(format!("/proc/{process}/environ")) {
        // What has ended and is not yet reaped has no environment any more.
        Ok(environment) if !environment.is_empty() => {
            let label = label_in(&environment);
            seen.insert(process, label.clone());
            label
        }
        _ => seen.get(&process).cloned().flatten(),
    }
}

fn label_in(environment: &[u8]) -> Option<String> {
    let variables = environment.split(|&byte| byte == 0);
    let mut labels = variables.filter_map(|v| v.strip_prefix(LABEL_VARIABLE.as_bytes())?.strip_prefix(b"="));
    labels.next().map(|label| String::from_utf8_lossy(label).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_label_is_found_among_other_variables() {
        assert_eq!(label_in(b"A=1\0PHASECLOUD_LABEL=mc\0B=2\0"), Some("mc".into()));
        assert_eq!(label_in(b"PHASECLOUD_LABELS=mc\0"), None);
        assert_eq!(label_in(b""), None);
    }
}
