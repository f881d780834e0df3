//! Throughput over loopback.
fn main() {}
