//! What a command says before work that may take long.

/// Says that an answer may take long.
pub(super) fn announce() {
    remark!("computing: a wide cloud or a long time may take a minute or more");
}
