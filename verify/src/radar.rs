//! Checks of the radar vectors.

use crate::Check;

/// The check for a file's stem.
#[must_use]
pub fn check_for(_stem: &str) -> Option<Check> {
    None
}
