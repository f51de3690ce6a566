//! Who sent a message: the label that the launcher gave the process, whatever the message itself says.

use crate::session::LABEL_VARIABLE;

/// The label in the environment of a process, which its children inherit; `None` for processes that are no propagators, that
/// are gone, or that nobody can look into.
pub fn label_of(process: u32) -> Option<String> {
    label_in(&std::fs::read(format!("/proc/{process}/environ")).ok()?)
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
