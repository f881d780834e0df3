//! The viewer-logger's process: to be wired.

use super::federate_commands::ViewerArgs;
use scenarios::Scene;
use std::sync::Arc;

/// Runs the viewer-logger.
///
/// # Errors
/// If it fails.
pub fn run(_args: &ViewerArgs, _scene: Arc<Scene>) -> anyhow::Result<u8> {
    anyhow::bail!("the viewer-logger is not built into this executable")
}
