//! What the transport refuses.

use std::fmt::{self, Debug};

/// The transport refused something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortError {
    action: &'static str,
    object: String,
    cause: String,
}

impl PortError {
    /// `action` on `object` failed because of `cause`.
    pub fn new(action: &'static str, object: &str, cause: &dyn Debug) -> Self {
        Self { action, object: object.into(), cause: format!("{cause:?}") }
    }
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot {} {}: {}", self.action, self.object, self.cause)
    }
}

impl std::error::Error for PortError {}
