//! Federates.
