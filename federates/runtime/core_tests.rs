//! Conductor, member, views and streams by hand: one message at a time, also those that no member of ours would send.

mod conductor;
mod member;
mod streams;

const MS: u64 = 1_000_000;
const S: u64 = 1_000 * MS;
const WORLD: &str = "external-world";
const SMDFM: &str = "smdfm";
