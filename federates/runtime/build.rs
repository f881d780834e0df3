//! Which build this is: what `--version` says, and what a member tells the federation it wants to join.

/// Version, commit and sources, for `--version`: `0.1.0 (commit 1a2b3c4d5e, sources 0123456789abcdef)`.
pub const VERSION: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    " (commit ",
    env!("SEEDS_COMMIT"),
    ", sources ",
    env!("SEEDS_SOURCES"),
    ")"
);

/// What two members must have in common to give the same bits: version, and a hash over the sources of
/// everything that decides results (`build.rs` of the package has the list).
pub const IDENTITY: &str = concat!(env!("CARGO_PKG_VERSION"), "-", env!("SEEDS_SOURCES"));
