//! What `phasecloud --version` says.

/// The version, the revision from which the program was built, and the features that it was built with.
pub(super) const LONG: &str = env!("PHASECLOUD_VERSION");
