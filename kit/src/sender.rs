//! The sender of a message: the label that the launcher gave the process, whatever label the message itself has.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use crate::environment::LABEL_VARIABLE;

/// The labels that were found, by process id: some messages are read when their sender has already ended.
static SEEN: Mutex<BTreeMap<u32, String>> = Mutex::new(BTreeMap::new());

/// The label in the environment of a process, which its children inherit; `None` for processes that are no
/// propagators, whose environment cannot be read, or that had ended before it was read.
pub fn label_of(process: u32) -> Option<String> {
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    // A process that has ended and is not yet reaped has no environment any more, and a part of the environment may
    // be missing if its pages are not in memory. So a label that was found once is kept.
    match std::fs::read(format!("/proc/{process}/environ")).ok().as_deref().and_then(label_in) {
        Some(label) => {
            seen.insert(process, label.clone());
            Some(label)
        }
        None => seen.get(&process).cloned(),
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
